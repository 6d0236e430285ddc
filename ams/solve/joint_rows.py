"""What the rows of all mountings are for a joint fit: the means of their points, and what the table does to each."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray, IntArray
from ams.frames import specific_force
from ams.solve.extension import angles_of_points, without_drift
from ams.solve.layout import layout_of
from ams.solve.table_errors import Mounting, Nuisances, seat_effects


@dataclass(frozen=True)
class JointRows:
    """Point means of all mountings, one below the other."""

    mount: IntArray
    excited: NDArray[np.intp]
    """Places of the components of the specific force that any row excites, of 0 to 2."""
    force: FloatArray
    """(N, c) excited components in package axes at the commanded angles."""
    effects: FloatArray
    """(N, c, q) of one radian of each nuisance, package axes."""
    output_v: FloatArray
    """(N, A)"""
    precision_v2: FloatArray
    """(N, A) variance of each mean from the replications; 0 where there is one."""
    readings: FloatArray
    """(N,) of each mean."""
    departures: FloatArray
    """(groups, N, A) what each replication of each mounting, alone in differing from the others, adds to the means."""
    spread_factor: FloatArray
    """(groups,) of the squares of what they do, for the variance of the mean."""
    spread_dof: int


def joint_rows(mountings: Sequence[Mounting], axes: tuple[str, ...], nuisances: Nuisances) -> JointRows:
    """Return the means of the points of every mounting, with what one radian of every error does to them."""
    excited = _excited(mountings)
    parts = [_part(number, mounting, axes, nuisances, excited) for number, mounting in enumerate(mountings)]
    return JointRows(
        np.concatenate([p.mount for p in parts]),
        excited,
        np.concatenate([p.force for p in parts]),
        np.concatenate([p.effects for p in parts]),
        np.concatenate([p.output_v for p in parts]),
        np.concatenate([p.precision_v2 for p in parts]),
        np.concatenate([p.readings for p in parts]),
        _beneath([p.departures for p in parts]),
        np.concatenate([p.spread_factor for p in parts]),
        sum(p.spread_dof for p in parts),
    )


def _beneath(parts: Sequence[FloatArray]) -> FloatArray:
    """Return (groups, N, A): the groups of each mounting touch its own points only."""
    groups, points = (sum(part.shape[axis] for part in parts) for axis in (0, 1))
    whole = np.zeros((groups, points, parts[0].shape[2]))
    group = point = 0
    for part in parts:
        whole[group : group + part.shape[0], point : point + part.shape[1]] = part
        group, point = group + part.shape[0], point + part.shape[1]
    return whole


def _excited(mountings: Sequence[Mounting]) -> NDArray[np.intp]:
    largest = np.zeros(3)
    for mounting in mountings:
        force = specific_force(mounting.observations.pitch_rad, mounting.observations.roll_rad)
        largest = np.maximum(largest, np.abs(force @ np.asarray(mounting.package_from_table).T).max(axis=0))
    return np.flatnonzero(largest > 1e-9)


def _part(
    number: int, mounting: Mounting, axes: tuple[str, ...], nuisances: Nuisances, excited: NDArray[np.intp]
) -> JointRows:
    observations, M = mounting.observations, np.asarray(mounting.package_from_table, dtype=float)
    layout = layout_of(observations)
    pitch, roll = angles_of_points(observations, layout)
    readings = layout.sum_by_point(np.ones(layout.rows))
    rows_force = specific_force(observations.pitch_rad, observations.roll_rad) @ M.T
    basis = np.column_stack([np.ones(layout.rows), rows_force[:, excited]])
    means, precision, departures = [], [], []
    for axis in axes:
        steady, variance, _ = without_drift(basis, observations.outputs[axis], layout, readings)
        means.append(layout.sum_by_point(steady) / readings)
        precision.append(variance / readings)
        left = observations.outputs[axis] - means[-1][layout.point]
        by_group = left[:, None] * np.eye(layout.replications)[layout.replication]
        departures.append(layout.sum_by_point(by_group).T / readings)
    force = specific_force(pitch, roll) @ M.T
    effects = np.einsum("ij,njq->niq", M, nuisances.effects(number, pitch, roll))
    effects = effects + seat_effects(force, nuisances.names, number)
    return JointRows(
        np.full(layout.points, number),
        excited,
        force[:, excited],
        effects[:, excited],
        np.stack(means, 1),
        np.stack(precision, 1),
        readings,
        np.stack(departures, -1) if layout.replications > 1 else np.zeros((0, layout.points, len(axes))),
        np.full(layout.replications, layout.replications / (layout.replications - 1.0))
        if layout.replications > 1
        else np.zeros(0),
        layout.replications - 1,
    )
