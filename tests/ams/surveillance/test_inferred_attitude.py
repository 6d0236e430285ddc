"""Errors as found hold their uncertainty at every attitude, however much the set has changed, or are not stated.

Truth is what the set tells of clean outputs, by other ways of solving than the product's. Two axes read more than one
g on their side where the gain of the set is too small: no attitude is told there, and an error of none is stated.
"""

import numpy as np
import pytest
from changed_sets import changed
from inferred_by_sets import inferred_errors_deg
from packages_on_tables import K_V_PER_G, SLACK, Rig, outputs_v

from ams.inputs.request import select_rows
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet
from ams.sets.coefficients import from_document as set_from_document
from ams.surveillance.adjustment import Acceptance, adjust, from_document, to_document
from ams.surveillance.attitude_errors import AngleErrors, errors_of

PITCH_DEG = (-90, -89.6, -86, -75, -60, -45, -30, -15, 0, 15, 30, 45, 60, 75, 85, 89, 90)
ROLL_DEG = (0, 0.3, 3, 30, 60, 80, 86, 89, 89.8, 90, 90.4, 95, 120, 180, 240, 270, 274, 330)
GRID = np.deg2rad([(float(p), float(r)) for p in PITCH_DEG for r in ROLL_DEG])
SIZES = (0.0, 2e-5, 2e-4, 2e-3, 2e-2)


def with_errors(applied: CoefficientSet, gains: np.ndarray, offsets_g: np.ndarray) -> CoefficientSet:
    """The set of a package whose sensitivities and offsets were others."""

    def change(document: dict) -> None:
        for axis, gain, offset in zip(document["axes"], gains, offsets_g, strict=True):
            values = document["axes"][axis]["primary"]["values"]
            values.update({name: value * (1.0 + gain) for name, value in values.items() if name.startswith("k_")})
            values["offset_v"] += offset * float(np.linalg.norm(K_V_PER_G[axis]))

    return set_from_document(changed(applied, change), "changed since")


def held(errors: AngleErrors, truth_deg: np.ndarray) -> list[bool]:
    """Whether each error stated holds the truth, by either attitude that may be meant."""
    at = {(round(p, 6), round(r, 6)): row for (p, r), row in zip(np.rad2deg(GRID), truth_deg, strict=True)}
    truths = [at[round(p, 6), round(r, 6)] for p, r in zip(errors.pitch_deg, errors.roll_deg, strict=True)]
    return [
        bool((np.abs(truth - error) <= expanded).all())
        for error, expanded, truth in zip(errors.error_deg, errors.expanded_deg, truths, strict=True)
    ]


def shares_held(axes: str, campaigns: int, seed: int) -> dict[tuple[float, str], list[bool]]:
    """Size and angle to whether each stated error is held; of every size as many sets read too much as too little."""
    chance, rig = np.random.default_rng(seed), Rig(tilt_limit_arcsec=1.0)
    found: dict[tuple[float, str], list[bool]] = {(size, angle): [] for size in SIZES for angle in ("pitch", "roll")}
    clean = outputs_v(axes, *GRID.T, np.zeros(3), 1.0)
    for _ in range(campaigns):
        rows = rig.observe(axes, 3, chance, grid=GRID)
        new = rig.solved(rows)
        for size, sign in [(size, sign) for size in SIZES for sign in (1.0, -1.0)]:
            gains = sign * size * chance.uniform(0.3, 1.0, len(axes))
            applied = with_errors(new, gains, size * chance.uniform(-0.5, 0.5, len(axes)))
            truth = inferred_errors_deg(applied, clean, *GRID.T, SLACK)
            for angle, errors in errors_of(applied, new, rows, None, rig.reference).items():
                found[size, angle] += held(errors, truth[angle])
    return found


@pytest.mark.parametrize("axes", ["x", "xy", "xyz"])
def test_what_is_stated_is_held_at_every_attitude_whatever_the_set_is_wrong_by(axes: str) -> None:
    for cell, inside in shares_held(axes, 1, 41).items():
        assert len(inside) > 150 or (axes, cell[1]) == ("x", "roll"), cell
        assert not inside or np.mean(inside) >= 0.93, (cell, np.mean(inside))


@pytest.mark.thorough
@pytest.mark.timeout(600)
@pytest.mark.parametrize("axes", ["x", "xy", "xz", "yz", "xyz"])
def test_it_is_held_over_many_campaigns(axes: str) -> None:
    for cell, inside in shares_held(axes, 30, 45).items():
        assert not inside or np.mean(inside) >= 0.93, (cell, np.mean(inside))


def at_roll(axes: str, roll_deg: float, gain: float) -> tuple[CoefficientSet, CoefficientSet, Observations]:
    """A set whose sensitivities are off, the new one, and rows of the new run at one roll and its opposite alone."""
    chance, rig = np.random.default_rng(42), Rig()
    rows = rig.observe(axes, 3, chance)
    new = rig.solved(rows)
    is_there = np.isclose(np.abs(np.sin(rows.roll_rad - np.deg2rad(roll_deg))), 0.0)
    none = np.zeros(len(axes))
    return with_errors(new, none + gain, none), new, select_rows(rows, is_there)


@pytest.mark.parametrize(("axes", "roll_deg"), [("xy", 90.0), ("xz", 0.0)])
def test_outputs_beyond_one_g_by_the_old_set_have_neither_number_nor_pass(axes: str, roll_deg: float) -> None:
    old, new, rows = at_roll(axes, roll_deg, -2e-3)
    limits = Acceptance({"pitch": 1.0, "roll": 5.0})
    found = adjust(old, new, rows, limits, (-60.0, 60.0))
    assert found.as_found is not None
    assert (found.as_found.errors, found.as_found.verdict) == ({}, "conditional")
    assert found.as_found.undetermined == ("pitch", "roll")
    assert found.as_left.undetermined == ("roll",)
    assert [judged.verdict for judged in found.as_left.judgements] == ["pass", "conditional"]
    assert "determine it at no attitude" in found.as_left.judgements[1].sentence
    back = from_document(to_document(found))
    assert to_document(back) == to_document(found)
    assert back.as_found is not None
    assert [judged.sentence for judged in back.as_found.judgements] == [
        judged.sentence for judged in found.as_found.judgements
    ]


def test_a_judgement_says_at_how_many_attitudes_its_angle_is_not_determined() -> None:
    chance, rig = np.random.default_rng(43), Rig()
    rows = rig.observe("xyz", 2, chance)
    judged = adjust(None, rig.solved(rows), rows, Acceptance({"pitch": 1.0, "roll": 5.0})).as_left.judgements
    assert "not determined" not in judged[0].sentence
    assert judged[1].sentence.endswith("; not determined at 24 of 156 attitudes")


def test_next_to_the_vertical_pitch_is_off_by_the_whole_lean_of_the_offsets() -> None:
    """0.01 g across the meridian of the table is 0.573° from the vertical, though along the meridian it is nothing."""
    chance, rig = np.random.default_rng(44), Rig()
    rows = rig.observe("xyz", 3, chance)
    new = rig.solved(rows)
    old = with_errors(new, np.zeros(3), np.array([0.0, 0.01, 0.0]))
    errors = errors_of(old, new, rows, (89.0, 91.0), rig.reference)["pitch"]
    assert errors.error_deg == pytest.approx(np.full(12, -np.rad2deg(0.01)), rel=0.01)
