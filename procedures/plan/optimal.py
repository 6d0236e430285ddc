"""``kind = "optimal"``: as many points of a lattice as there is time for, those that determine the sensor best."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator

from ams.arrays import FloatArray
from ams.frames import specific_force
from ams.models.extended import quadratic_basis
from procedures.description.described_designs import SETS
from procedures.description.procedure_file import Angle
from procedures.description.procedure_file import Design as DesignTable
from procedures.errors import PlanError
from procedures.plan.design_kind import DesignKind, Wanted
from procedures.plan.designs import Design, DesignPoint
from procedures.plan.exchange import exchanged
from rig.toml_file import as_tuple

_PITCHES, _ROLLS = 24, 24
"""Attitudes an axis at which the region of use is looked at."""


class OptimalTable(DesignTable):
    """``[design]`` with the keys of this kind; ``pitch_deg`` and ``roll_deg`` are the lattice."""

    points: Annotated[int, Field(ge=4, le=10_000)] = 72
    criterion: Literal["D", "I"] = "I"
    """D: the parameters; I: predictions over the usage range."""
    terms: Literal["linear", "extended"] = "extended"
    """What is to be determined: offset and sensitivities, or the terms of second and third order too."""
    keep_deg: tuple[tuple[Angle, Angle], ...] = ()
    """[pitch, roll] of points of the lattice that stand in the design whatever the criterion says."""

    @field_validator("keep_deg", mode="before")
    @classmethod
    def _pairs_are_tuples(cls, value: object) -> object:
        return tuple(as_tuple(pair) for pair in value) if isinstance(value, list) else value


def _optimal(wanted: Wanted) -> Design:
    table = wanted.table
    assert isinstance(table, OptimalTable)
    pitch_deg, roll_deg = wanted.pitch_deg, wanted.roll_deg
    lattice = [(pitch, roll) for pitch in sorted(set(pitch_deg)) for roll in sorted(set(roll_deg))]
    if table.points > len(lattice):
        raise PlanError(
            f"optimal design: {table.points} points asked for, the lattice has {len(lattice)}; no design was made; "
            "give fewer points or more angles"
        )
    kept = [_nearest(lattice, pair) for pair in table.keep_deg]
    if len(set(kept)) != len(kept) or len(kept) > table.points:
        raise PlanError("optimal design: keep_deg names a point twice, or more than points; no design was made")
    columns = terms(np.deg2rad(np.array(lattice)), table.terms, with_roll=wanted.with_roll)
    region = _region(table, pitch_deg, with_roll=wanted.with_roll) if table.criterion == "I" else None
    chosen = exchanged(columns, table.points, np.random.default_rng(table.seed), region, kept)
    points = tuple(DesignPoint(label, *lattice[index]) for label, index in enumerate(chosen, start=1))
    return Design(
        "optimal",
        points,
        tuple(sorted({point.pitch_deg for point in points})),
        tuple(sorted({point.roll_deg for point in points})),
    )


def _nearest(lattice: list[tuple[float, float]], pair: tuple[float, float]) -> int:
    if pair not in lattice:
        nearest = min(lattice, key=lambda point: abs(point[0] - pair[0]) + abs(point[1] - pair[1]))
        raise PlanError(
            f"optimal design: keep_deg: pitch {pair[0]:g}°, roll {pair[1]:g}° is no point of the lattice, nearest is "
            f"pitch {nearest[0]:g}°, roll {nearest[1]:g}°; no design was made; add its angles to pitch_deg and roll_deg"
        )
    return lattice.index(pair)


def terms(angles_rad: FloatArray, order: Literal["linear", "extended"], *, with_roll: bool) -> FloatArray:
    """Return (N, P) the terms of a package at (N, 2) pitch and roll: of all its axes together."""
    pitch, roll = angles_rad.T
    if not with_roll:
        columns = [np.ones_like(pitch), np.sin(pitch), np.cos(pitch)]
        columns += [np.sin(2.0 * pitch), np.cos(2.0 * pitch)] if order == "extended" else []
        return np.stack(columns, axis=1)
    force = specific_force(pitch, roll)
    linear = np.concatenate([np.ones((len(pitch), 1)), force], axis=1)
    return linear if order == "linear" else np.concatenate([linear, quadratic_basis(force), force**3], axis=1)


def _region(table: OptimalTable, pitch_deg: tuple[float, ...], *, with_roll: bool) -> FloatArray:
    """Return the mean of xxᵀ over the usage range, else over the pitch range of the lattice, and every roll."""
    low, high = np.deg2rad(table.usage_pitch_deg or (min(pitch_deg), max(pitch_deg)))
    pitch = low + (high - low) * (np.arange(_PITCHES) + 0.5) / _PITCHES
    roll = 2.0 * np.pi * (np.arange(_ROLLS) + 0.5) / _ROLLS if with_roll else np.zeros(1)
    grid = np.stack([angle.ravel() for angle in np.meshgrid(pitch, roll, indexing="ij")], axis=1)
    rows = terms(grid, table.terms, with_roll=with_roll)
    return np.asarray(rows.T @ rows / len(rows))


OPTIMAL = DesignKind(
    name="optimal",
    takes=SETS | {"repeat_roll"},
    table=OptimalTable,
    is_thinned=True,
    is_on_command_line=False,
    make=_optimal,
)
