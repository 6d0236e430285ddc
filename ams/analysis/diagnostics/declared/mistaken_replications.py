"""Whether the readings of a replication stand under other outputs, or at other attitudes, than they were taken at.

Two cables that change places after a break, and rows that slip by one dwell, leave a replication that contradicts the
others by volts, from its first dwell on or from another one. Where a replication departs from the others by far, every
two outputs are exchanged, and every reading is held against the attitude of the dwell before and after it, over the
stretch of its dwells that this explains best. One that leaves what the other replications differ by is the cause.

The replication that the others are held against is the one that reads along the declared axes and that most agree with.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.declared.declared_axis import KIND, component_indices
from ams.analysis.diagnostics.declared.declared_signs import Package, is_of_attitudes, is_plainly_less, sized
from ams.analysis.diagnostics.dwell_words import dwell_words
from ams.analysis.diagnostics.take_back import redo_command
from ams.arrays import BoolArray, FloatArray, IntArray
from ams.findings import Finding
from ams.frames import AXES
from ams.observations import Observations
from ams.solve.dwell_order import rows_in_time, turns_in_replication

OUTPUTS_EXCHANGED: Final = "outputs exchanged"
READINGS_SHIFTED: Final = "readings shifted by a dwell"
TRIED_FROM: Final = 1e-3
"""Of the sensitivity: the scatter about the fit beyond which anything is tried, three minutes of arc near level."""
_FAR: Final = 10.0
"""Times what two replications differ by that agree: a replication that differs by more departs from the others."""
_NEARLY_ALL: Final = 1e4
"""Of the squares: what explains as much is the cause, though drift is left."""
_NOTHING: Final = 1e-12
"""Of the squares of a difference that is far: less is left of readings without noise."""
_LEAST_DWELLS: Final = 3
"""Fewer are single dwells that are wrong."""


@dataclass(frozen=True)
class MistakenReplication:
    """Readings of one replication that belong to other outputs or attitudes."""

    finding: Finding
    labels: tuple[str, ...]
    """Of the outputs that it is a finding of."""
    put_right: Callable[[Observations], tuple[Observations, BoolArray]]
    """Return all rows with these readings at their place, and (N,) which of them have a reading then."""


class _Stretch(NamedTuple):
    """What one explanation leaves of one replication."""

    outputs: tuple[int, ...]
    """The two that are exchanged; none where rows are shifted."""
    by: int
    """Dwells from a row to the attitude that its reading belongs to; 0 where outputs are exchanged."""
    judged: BoolArray
    """(D,) dwells that both ways are held against."""
    concerned: BoolArray
    """(D,) those that it explains."""
    left: FloatArray
    """(D, m) squares of what is left then, in sensitivities."""
    as_read: FloatArray
    """(D, m) the same of the readings as they stand."""

    @property
    def mean_square(self) -> float:
        return float(self.left[self.judged].mean())


class _Replications:
    """The readings of a package, replication by replication, in their sensitivities."""

    def __init__(self, package: Package) -> None:
        rows, layout, labels, models, declared = package
        self.package = package
        outputs = np.stack([rows.outputs[label] for label in labels], axis=1)
        in_time = rows_in_time(rows.time_s, layout.rows)
        self.turn = turns_in_replication(in_time, layout.replication, layout.replications)[0]
        basis = models[0].basis(rows)
        at = component_indices(models[0].primary_names)
        components = [at[axis] for axis in AXES]
        self.astray: list[int] = []
        """(n) how many axes of each replication by itself lie along another one than declared."""
        self.by_itself: list[float] = []
        """(n) root mean square of what each leaves by itself, in sensitivities."""
        lengths = []
        for index in range(layout.replications):
            here = layout.replication == index
            found = np.linalg.lstsq(basis[here], outputs[here], rcond=None)[0]
            k = found[components]
            length = np.maximum(np.linalg.norm(k, axis=0), np.finfo(float).tiny)
            along = np.argmax(np.abs(k), axis=0).tolist()
            lengths.append(length)
            self.astray.append(sum(axis != entry.index for axis, entry in zip(along, declared, strict=True)))
            self.by_itself.append(float(np.sqrt(np.mean(((outputs[here] - basis[here] @ found) / length) ** 2))))
        self.length = np.median(np.array(lengths), axis=0)
        self.grid = np.full((layout.replications, layout.points, len(labels)), np.nan)
        self.grid[layout.replication, layout.point] = outputs / self.length

    def apart(self) -> FloatArray:
        """Return the (n, n) root mean squares that every two replications differ by."""
        squares = (self.grid[:, None] - self.grid[None]) ** 2
        is_seen = np.isfinite(squares)
        shared = np.maximum(np.count_nonzero(is_seen, axis=(2, 3)), 1)
        return np.asarray(np.sqrt(np.where(is_seen, squares, 0.0).sum(axis=(2, 3)) / shared))

    def rows_of(self, index: int) -> IntArray:
        """Return the rows of one replication in the order of measurement."""
        here = np.flatnonzero(self.package.layout.replication == index)
        return here[np.argsort(self.turn[here])]


def mistaken_replications(package: Package) -> Iterator[MistakenReplication]:
    """Yield every replication whose readings fit the others under exchanged outputs or at their neighbours' attitudes.

    The scatter about the fit is large already where this is asked: nothing is tried of data that fit.
    """
    if package.layout.replications < 2 or not is_of_attitudes(package):
        return
    every = _Replications(package)
    apart = every.apart()
    several = apart[~np.eye(len(apart), dtype=bool)]
    alike = min([2.0**0.5 * min(every.by_itself), *(several.tolist() if len(apart) > 2 else [])])
    far = max(_FAR * alike, TRIED_FROM)
    departing = apart > far
    standard = min(
        range(len(apart)),
        key=lambda index: (every.astray[index], int(departing[index].sum()), every.by_itself[index]),
    )
    for index in np.flatnonzero(departing[standard]).tolist():
        stretch = _explained(every, standard, index, far)
        if stretch is not None:
            yield _named(every, index, stretch)


def _explained(every: _Replications, standard: int, index: int, far: float) -> _Stretch | None:
    """Return what explains nearly all of what a replication departs by; None where nothing does."""
    rows, reference = every.rows_of(index), every.grid[standard]
    points = every.package.layout.point[rows]
    readings, expected = every.grid[index][points], reference[points]
    as_read = (readings - expected) ** 2
    is_known = np.isfinite(as_read).all(axis=1)
    best = None
    for outputs, by, other in _ways(readings, expected, every.length):
        left = (other - expected) ** 2 if by == 0 else (readings - other) ** 2
        judged = is_known & np.isfinite(left).all(axis=1)
        gain = np.where(judged, (as_read - left).sum(axis=1), 0.0)
        concerned = _best_stretch(gain)
        left = np.where(concerned[:, None], left, as_read)
        if np.count_nonzero(concerned) < _LEAST_DWELLS:
            continue
        found = _Stretch(outputs, by, judged, concerned, left, as_read)
        if best is None or found.mean_square < best.mean_square:
            best = found
    if best is None:
        return None
    before, after = float(as_read[best.judged].mean()), max(best.mean_square, _NOTHING * far**2)
    is_near = after <= far**2 or _NEARLY_ALL * after < before
    return best if is_near and is_plainly_less(after, before, as_read[best.judged].size) else None


def _ways(
    readings: FloatArray, expected: FloatArray, length: FloatArray
) -> Iterator[tuple[tuple[int, ...], int, FloatArray]]:
    """Yield the outputs exchanged, or the dwells shifted by, and (D, m) the readings or what is expected then."""
    for first, second in combinations(range(readings.shape[1]), 2):
        exchanged = readings.copy()
        exchanged[:, first] = readings[:, second] * length[second] / length[first]
        exchanged[:, second] = readings[:, first] * length[first] / length[second]
        yield (first, second), 0, exchanged
    for by in (-1, 1):
        neighbour = np.full_like(expected, np.nan)
        if by < 0:
            neighbour[1:] = expected[:-1]
        else:
            neighbour[:-1] = expected[1:]
        yield (), by, neighbour


def _best_stretch(gain: FloatArray) -> BoolArray:
    """Return the dwells from one to another of which the sum is largest."""
    sums = np.concatenate([[0.0], np.cumsum(gain)])
    first = np.maximum.accumulate(np.where(sums == np.minimum.accumulate(sums), np.arange(sums.size), 0))
    end = int(np.argmax(sums - sums[first]))
    found = np.zeros(gain.size, dtype=bool)
    found[first[end] : end] = True
    return found


def _named(every: _Replications, index: int, stretch: _Stretch) -> MistakenReplication:
    rows, layout, labels, models, _ = every.package
    here, concerned = every.rows_of(index), np.flatnonzero(stretch.concerned)
    label, in_doubt = layout.replication_labels[index], here[concerned]
    exchanged = tuple(labels[output] for output in stretch.outputs)
    outputs = stretch.outputs or tuple(range(len(labels)))
    worst = max(outputs, key=lambda output: float(stretch.as_read[stretch.judged, output].sum()))
    sizes_v = [
        float(every.length[worst] * np.sqrt(squares[stretch.judged, worst].mean()))
        for squares in (stretch.left, stretch.as_read)
    ]
    fits_to, stands_to = (sized(size_v, every.length[worst], models[0]) for size_v in sizes_v)
    what = (
        f"outputs {' and '.join(exchanged)} exchanged"
        if exchanged
        else f"each reading at the attitude of the dwell {'before' if stretch.by < 0 else 'after'} it"
    )
    fact = (
        f"the readings of replication {label} fit the other replication{'s' if layout.replications > 2 else ''} with "
        f"{what}{_where(rows, here, concerned)} to {fits_to}, as they stand to {stands_to} (axis {labels[worst]}, "
        f"standard deviation of a dwell); offset and sensitivities are a mixture of both, which the stated "
        "uncertainties do not hold: the result is not usable and there is no coefficient set; all other tests are made "
        "with these readings put right"
    )
    steps = () if rows.step is None else tuple(int(step) for step in rows.step[in_doubt])
    details: dict[str, float | str | None] = {
        "test": OUTPUTS_EXCHANGED if exchanged else READINGS_SHIFTED,
        "replication": float(label),
        "dwells": float(concerned.size),
        "fits_to_v": sizes_v[0],
        "as_read_to_v": sizes_v[1],
    }
    what_to_do = _what_to_do(rows, label, exchanged)
    finding = Finding(KIND, fact, True, None, steps, details, is_held=False, what_to_do=what_to_do)

    def put_right(rows: Observations) -> tuple[Observations, BoolArray]:
        return _exchanged(rows, in_doubt, exchanged) if exchanged else _shifted(rows, here, concerned, stretch.by)

    return MistakenReplication(finding, tuple(labels[output] for output in outputs), put_right)


def _where(rows: Observations, here: IntArray, concerned: IntArray) -> str:
    """Return from which dwell to which, in words; nothing of a whole replication, up to the dwells at its ends."""
    first, last = (dwell_words(rows, int(here[at])) for at in concerned[[0, -1]])
    is_from_start, is_to_end = concerned[0] <= 1, concerned[-1] >= here.size - 2
    if is_from_start and is_to_end:
        return ""
    begins = "from its start" if is_from_start else f"from {first}"
    return f", {begins} {'on' if is_to_end else f'to {last}'},"


def _what_to_do(rows: Observations, label: int, exchanged: Sequence[str]) -> str:
    if rows.step is not None:
        cause = "where the channels were exchanged" if exchanged else "what shifted the readings"
        return f"find {cause}, and measure the replication again ({redo_command(label, rows.run)})"
    columns = f"the columns of {' and '.join(exchanged)}" if exchanged else "the attitudes"
    return f"correct {columns} in the rows of replication {label} of {rows.source}, or leave them out, and solve again"


def _exchanged(rows: Observations, at: IntArray, labels: Sequence[str]) -> tuple[Observations, BoolArray]:
    first, second = (rows.outputs[label].copy() for label in labels)
    first[at], second[at] = second[at], first[at]
    put_right = {**rows.outputs, labels[0]: first, labels[1]: second}
    return replace(rows, outputs=put_right), np.ones(rows.rows, dtype=bool)


def _shifted(rows: Observations, here: IntArray, concerned: IntArray, by: int) -> tuple[Observations, BoolArray]:
    """Return each reading at its attitude; a dwell whose reading is nowhere is left out."""
    kept = np.ones(rows.rows, dtype=bool)
    kept[here[concerned]] = False
    kept[here[concerned + by]] = True
    outputs = {label: values.copy() for label, values in rows.outputs.items()}
    for label, values in outputs.items():
        values[here[concerned + by]] = rows.outputs[label][here[concerned]]
    return replace(rows, outputs=outputs), kept
