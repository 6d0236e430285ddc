"""What the newest calibration of a sensor changed beyond what it and an earlier one state of themselves.

Asked while few calibrations tell how far a sensor scatters between runs (:mod:`ams.surveillance.control_chart`). Each
change is held against Student's t of the degrees of freedom that the sets state for their parts: two or three
replications tell a scatter by one or two, and the normal factor then calls a quarter to a half of sound second
calibrations changed. Bonferroni over the characteristics and the earlier calibrations.

Degrees of freedom of a difference: Welch and Satterthwaite's, those of the parts that were estimated never above twice
the fewest of them: two equal parts have no more, and where two replications are held against six the formula jumps to
five whenever the two happen to agree, which is too generous so far out. (Student's factors averaged, as in
:func:`ams.statistics.intervals.combined_dof`, are right at 95 %; at a level of one in two hundred they ring in 0.1 to
0.2 % instead of five and see a third of what can be seen.) Certificates' parts are known.

What the next run repeats (:data:`ams.surveillance.characteristics.REPEATED`) is in no difference, and neither is the
error of standards where both sets name the same ones with the same certificates: it is one error, alike in both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.errors import SetError
from ams.parameter_words import words_of_characteristic
from ams.sets.axis_section import axis_numbers
from ams.sets.canonical import Document, listed, table
from ams.sets.sensed_quantity import FIELDS
from ams.statistics.intervals import t_quantile
from ams.surveillance.characteristics import PackageNumbers, characteristics_of, placed_rows, scatter_rows
from ams.surveillance.check_components import variance_of_families
from ams.surveillance.series import Population

FEW_DOF = 6.0
"""Below this limits are so wide that what the certificates do not explain is told beside them."""
STATED_LEVEL = 0.95
_OF_STANDARDS = ("multimeter ", "load resistor", "thermometer", "rate of the table", "scale of ", "direction of field ")
"""Beginnings of the names of parts that are errors of standards."""


@dataclass(frozen=True)
class StatedScatter:
    """What a set states that the next run draws anew, c parts of p characteristics."""

    variance_rad2: FloatArray
    """(c, p) as small angles."""
    dof: FloatArray
    """(c,) infinite for what a certificate states."""
    is_of_standards: BoolArray
    """(c,)"""
    certificates: tuple[tuple[str, str, str], ...]
    """Name, serial and certificate of every standard; empty where any lacks one."""


@dataclass(frozen=True)
class StatedChange:
    """What the newest calibration changed beyond what is stated."""

    sentence: str
    """Empty for nothing."""
    explained_deg: float
    """The largest change, as an angle, that what is stated explains."""


def stated_scatter(document: Document, sensor: str) -> StatedScatter:
    """Return what the checked document of a set states. Raises: SetError for a model that is not installed here."""
    numbers, names, dof = _parts_of(document, sensor)
    found = characteristics_of(numbers)
    return _stated(document, (found.scatter / found.scale) ** 2, names, dof)


def stated_families(document: Document, sensor: str) -> tuple[tuple[str, ...], StatedScatter]:
    """Return the families of a check sensor's components, and what a set states of each as ``stated_scatter`` does.

    Raises: SetError for a model that is not installed here.
    """
    numbers, names, dof = _parts_of(document, sensor)
    variance = variance_of_families(numbers, characteristics_of(numbers))
    return tuple(variance), _stated(document, np.stack(list(variance.values()), axis=1), names, dof)


def _stated(document: Document, variance: FloatArray, names: Sequence[str], dof: Sequence[float]) -> StatedScatter:
    of_standards = np.array([name.startswith(_OF_STANDARDS) for name in names], dtype=bool)
    return StatedScatter(variance, np.array(dof), of_standards, _certificates(document))


def _parts_of(document: Document, sensor: str) -> tuple[PackageNumbers, list[str], list[float]]:
    """Return b and k with the covariance of each part by itself, n parts, and their names and degrees of freedom."""
    vectors, of_axis, covariances, names, dof = [], [], [], [], []
    for index, (axis, section) in enumerate(table(document["axes"]).items()):
        numbers = axis_numbers(axis, table(section))
        if numbers.model not in FIELDS:
            raise SetError(
                f"{sensor}: axis {axis}: model {numbers.model!r}: is not installed here; install its package"
            )
        vectors.append(placed_rows(table(section), numbers.form))
        for name, covariance, part_dof in scatter_rows(table(section), numbers.form):
            of_axis.append(index)
            covariances.append(covariance)
            names.append(name)
            dof.append(part_dof)
    nominal = tuple(str(table(section)["nominal_axis"]) for section in table(document["axes"]).values())
    whole = np.zeros((len(names), len(nominal), 4, 4))
    for row, (axis_index, covariance) in enumerate(zip(of_axis, covariances, strict=True)):
        whole[row, axis_index] = covariance
    return PackageNumbers(nominal, np.tile(vectors, (len(names), 1, 1)), whole, whole), names, dof


def stated_change(population: Population, sensor: str, stated: Sequence[StatedScatter]) -> StatedChange:
    """Return what the sensor's newest calibration is off from an earlier one; ``stated``: of all, in their order."""
    rows = population.rows_of(sensor)
    coordinates, names = population.coordinates[rows], population.characteristics.names
    change = np.abs(coordinates[-1] - coordinates[:-1])
    limit = np.array([explained_rad([before], stated[-1], change.size) for before in stated[:-1]])
    farthest = np.argmax(change - limit, axis=0)
    changes = [
        f"{words_of_characteristic(names[column])} by {np.degrees(change[at, column]):.4f}° since "
        f"{population.labels[rows][at].created_utc:%Y-%m-%d} ({np.degrees(limit[at, column]):.4f}°)"
        for column, at in enumerate(farthest.tolist())
        if change[at, column] > limit[at, column]
    ]
    sentence = (
        f"more than the two calibrations' own uncertainties explain (in brackets) changed {', '.join(changes)}: the "
        "sensor changed, or it scatters more between runs than these few calibrations tell"
    )
    return StatedChange(sentence if changes else "", float(np.degrees(limit.max())))


def explained_rad(before: Sequence[StatedScatter], newest: StatedScatter, tests: int) -> FloatArray:
    """Return (p,) how far a calibration of an unchanged sensor is off the mean of those before it at most, radians.

    ``tests``: how many such questions are asked at once.
    """
    is_same = bool(newest.certificates) and all(part.certificates == newest.certificates for part in before)
    counted = [(newest, 1.0), *((part, float(len(before)) ** -2) for part in before)]
    parts = [part.variance_rad2[~(part.is_of_standards & is_same)] * weight for part, weight in counted]
    dof = [part.dof[~(part.is_of_standards & is_same)] for part, _ in counted]
    variance = np.concatenate(parts)
    level = 1.0 - (1.0 - STATED_LEVEL) / tests
    factor = t_quantile(level, difference_dof(variance, np.concatenate(dof)))
    return np.asarray(factor * np.sqrt(variance.sum(axis=0)))


def difference_dof(variance: FloatArray, dof: FloatArray) -> FloatArray:
    """Return (p,) the degrees of freedom of sums of (c, p) variances with (c,), for factors far out."""
    of_part = np.broadcast_to(dof[:, None], variance.shape)
    is_estimated = np.isfinite(of_part) & (variance > 0.0)
    total, estimated = variance.sum(axis=0), np.where(is_estimated, variance, 0.0)
    fewest = np.where(is_estimated, of_part, np.inf).min(axis=0, initial=np.inf)
    spread = (estimated**2 / np.where(is_estimated, of_part, 1.0)).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        of_estimated = np.minimum(estimated.sum(axis=0) ** 2 / spread, 2.0 * fewest)
        share = total / estimated.sum(axis=0)
        return np.where(spread > 0.0, share**2 * of_estimated, np.inf)


def _certificates(document: Document) -> tuple[tuple[str, str, str], ...]:
    """Return what names the standards; nothing where one of them cannot be told from another of its kind."""
    standards = [table(entry) for entry in listed(table(document["provenance"])["standards"])]
    named = [(entry["name"], entry.get("serial"), entry.get("certificate")) for entry in standards]
    return tuple((str(a), str(b), str(c)) for a, b, c in named) if all(b and c for _, b, c in named) else ()
