"""What a check sensor's calibrations are read as: what all axes did alike, the rotation, and what is left of each axis.

A component's scatter may be learned from others too, where they are of one sort: the same axis' part of other sensors,
what meter and run do to all of them, and the parts of the other axes of the check sensor itself. What all axes do alike
is never learned from what they do apart: a meter is no axis.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.surveillance.between_runs import MEAN_EFFICIENCY, Scatter, scatter_of
from ams.surveillance.characteristics import Characteristics, PackageNumbers
from ams.surveillance.series import Population

METER_GAIN, METER_OFFSET = "meter gain", "meter offset"
TILT = "tilt"


@dataclass(frozen=True)
class Component:
    """One component of the check sensor over n runs."""

    name: str
    family: str
    """Components of one family may scatter alike: the rotations, the parts of the axes of one sort."""
    family_rank: int
    """How many components of the family are independent: parts that sum to zero are one fewer."""
    values: FloatArray
    """(n,) radians."""
    stated: FloatArray
    """(n,) variance by the certificates."""
    prior: Scatter
    """By the other sensors, one column."""


def components_of(population: Population, sensor: str, rows: slice) -> tuple[Component, ...]:
    """Return the components of a check sensor, whose calibrations are the rows, in the order of its charts."""
    parts, kinds = _parts(population)
    prior = scatter_of(population, np.stack(list(parts.values()), axis=1), kinds, leave_out=sensor)
    found = population.characteristics
    stated = {family: variance[rows] for family, variance in variance_of_families(population.numbers, found).items()}
    made = []
    for column, (name, values) in enumerate(parts.items()):
        kind = kinds[column]
        most = _runs_dof(population) if kind in (METER_GAIN, METER_OFFSET) else np.inf
        scatter = _column(prior, column, most)
        rank = kinds.count(kind) - (kind in ("gain", "offset"))
        made.append(Component(name, kind, rank, values[rows] - values[rows.start], stated[kind], scatter))
    return (*made[:2], *_tilts(population, rows, stated[TILT]), *made[2:])


def is_gain(population: Population) -> BoolArray:
    """Return (p,) which characteristics are sensitivities."""
    return np.array([kind.startswith("sensitivity") for kind in population.kinds], dtype=bool)


def is_offset(population: Population) -> BoolArray:
    """Return (p,) which characteristics are offsets."""
    return np.array([kind.startswith("offset") for kind in population.kinds], dtype=bool)


def alike(population: Population) -> dict[str, FloatArray]:
    """Return (N,) radians of what all sensitivities and all offsets of each calibration do alike."""
    values = _relative(population)
    return {
        METER_GAIN: values[:, is_gain(population)].mean(axis=1),
        METER_OFFSET: values[:, is_offset(population)].mean(axis=1),
    }


def _relative(population: Population) -> FloatArray:
    """Return (N, p) radians; a sensitivity that is negative grows with the gain of the meter as well."""
    values, gain = population.coordinates.copy(), is_gain(population)
    values[:, gain] *= np.sign(population.numbers.sensitivity)
    return values


def _parts(population: Population) -> tuple[Mapping[str, FloatArray], list[str]]:
    """Return (N,) radians by name, the meter's first, and the kind of each."""
    values, names = _relative(population), population.characteristics.names
    gain, offset = is_gain(population), is_offset(population)
    parts, kinds = alike(population), [METER_GAIN, METER_OFFSET]
    for kind, columns, mean in (
        ("offset", offset, parts[METER_OFFSET]),
        ("gain", gain, parts[METER_GAIN]),
        ("angle", ~(gain | offset), 0.0),
    ):
        where = np.flatnonzero(columns)
        if kind != "angle" and where.size < 2:
            continue  # one axis does nothing apart from the others
        parts |= {f"sensor {names[int(column)]}": values[:, column] - mean for column in where}
        kinds += [kind] * where.size
    return parts, kinds


def variance_of_families(numbers: PackageNumbers, found: Characteristics) -> dict[str, FloatArray]:
    """Return the (n,) variance, rad², of a component of each family by the part that is drawn anew in every run.

    ``found``: the characteristics of the numbers, n calibrations or n parts of one.
    """
    variance = (found.scatter / found.scale) ** 2
    kinds = np.array([name.partition(".")[0] for name in found.names])
    gain, offset = np.char.startswith(kinds, "sensitivity"), np.char.startswith(kinds, "offset")
    angle, axes = ~(gain | offset), int(gain.sum())
    of_gain, of_offset = variance[:, gain].mean(axis=1), variance[:, offset].mean(axis=1)
    return {
        METER_GAIN: of_gain / axes,
        METER_OFFSET: of_offset / axes,
        "gain": of_gain * (1.0 - 1.0 / axes),
        "offset": of_offset * (1.0 - 1.0 / axes),
        "angle": variance[:, angle].mean(axis=1) if angle.any() else np.zeros(len(variance)),
        TILT: _across_variance(numbers),
    }


def _column(prior: Scatter, column: int, most_dof: float) -> Scatter:
    dof = np.minimum(prior.prior_dof[column : column + 1], most_dof)
    return Scatter(prior.variance[column : column + 1], dof, dof)


def _runs_dof(population: Population) -> float:
    """Return what the other sensors' runs count for of what a run does to all its sensors: runs, not calibrations."""
    labels = (label for label in population.labels if not label.is_check)
    return MEAN_EFFICIENCY * len({label.run_id or label.sha256 for label in labels})


def _tilts(population: Population, rows: slice, stated: FloatArray) -> tuple[Component, ...]:
    tilt = np.radians(population.rotation_deg(rows))
    nothing = Scatter(np.zeros(1), np.zeros(1), np.zeros(1))
    return tuple(
        Component(f"table tilt {axis}", TILT, 3, tilt[:, index], stated, nothing) for index, axis in enumerate("xyz")
    )


def _across_variance(numbers: PackageNumbers) -> FloatArray:
    """Return the (n,) variance of a rotation by the certificates: that of directions, over the axes that tell it."""
    k, covariance = numbers.k, numbers.scatter[..., 1:, 1:]
    size = np.linalg.norm(k, axis=-1)
    unit = k / size[..., None]
    along = np.einsum("nai,naij,naj->na", unit, covariance, unit)
    across = (np.trace(covariance, axis1=-2, axis2=-1) - along) / (2.0 * size**2)
    return np.asarray(across.mean(axis=1) / max(k.shape[1] - 1, 1))
