"""Angles of packages of three axes, with an eye on which axis the rows together hold to be wrong.

A row that disagrees is flagged at once. Evenly spaced rows are kept, however many come, and judged together whenever
their number has doubled, and at the end: from then on a flagged row has the name of the axis that all of them give, and
none where they say that all outputs are wrong alike. Where one cause explains all rows they are wrong in every one of
them, also where the length of what is sensed does not show it: these are flagged as well. A fault that came later, or
went, is looked for in the stretches in which rows are flagged too often for chance. Of two packages all rows are judged
whether any is flagged or not: one that sits turned against the other shows in none by itself.

What is proven by later rows can be told of earlier ones once all have come (:class:`ReflaggedAxes`,
:func:`answered_at_once`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.inference.gyros.monitored import MonitoredAngles
from ams.inference.inference import Inference, Package
from ams.inference.rows.angle_stream import AngleStream, Answer
from ams.inference.rows.kept_rows import KeptRows
from ams.inference.rows.possible_rows import possible_readings
from ams.inference.watch.faulty_axis import LEAST_ROWS, STANDS_SD, Cause, Judgement, PackageRows, judge
from ams.inference.watch.flagged_stretches import FlaggedStretch, FlaggedStretches
from ams.inference.watch.turned_package import Turn, turn_of

MOST_ROWS: Final = 1024
"""That are kept of all."""
LARGEST_SHARE_BY_CHANCE: Final = 0.01
"""Of flagged rows: a good package has one in a thousand, and hardly a calibration that is wrong has ten times that."""
LARGEST_SHARE_OF_TWO: Final = 0.5
"""Of flagged rows in a stretch over which two packages disagree, each of which agrees with itself: calibrations that
are as wrong as they may be flag no more."""
MOST_STRETCHES: Final = 100
"""That are judged one by one; a file with more is wrong all over."""
_EXPLAINS_ALL: Final = (Cause.AXIS, Cause.ALIKE, Cause.SEVERAL, Cause.UNMOVED)
_EVERY_SUSPECT: Final = sum((*flag_codes.SUSPECTS, *flag_codes.MODEL_SUSPECTS))


@dataclass(frozen=True)
class Judged:
    """What rows tell together."""

    judgements: tuple[Judgement, ...]
    """One a package."""
    turn: Turn | None = None
    """Of the second package against the first."""

    @property
    def agree_each(self) -> bool:
        """Whether each package agrees with itself."""
        return all(judgement.cause is Cause.NOTHING for judgement in self.judgements)

    @property
    def is_turned(self) -> bool:
        """Whether two packages, each of which agrees with itself, are turned against each other."""
        return self.agree_each and self.turn is not None and self.turn.is_proven

    @property
    def explains_all(self) -> bool:
        """Whether what is proven explains every row that was judged."""
        causes = [judgement.cause for judgement in self.judgements]
        return self.is_turned or (any(cause in _EXPLAINS_ALL for cause in causes) and Cause.UNEXPLAINED not in causes)


@dataclass(frozen=True)
class Stretch:
    """Rows from ``first`` to before ``end`` that are told of together."""

    first: int
    end: int
    judged: Judged

    @property
    def is_proven(self) -> bool:
        """Whether rows that agree are wrong as well; else those that do not have a name alone."""
        return any(judgement.is_proven for judgement in self.judged.judgements) or self.is_of_two

    @property
    def is_of_two(self) -> bool:
        """Whether two packages contradict each other, each of which agrees with itself."""
        return self.judged.agree_each


def can_be_watched(package: Package) -> bool:
    """Return whether a package has three accelerometers, whose outputs test one another."""
    axes = package.coefficients.axes.values()
    return len(package.columns) == 3 and all(axis.form.unit == "g" and axis.model_output is None for axis in axes)


class _Around:
    """What an inference that is looked after has in common with the inference."""

    def __init__(self, inference: Inference) -> None:
        self._inference = inference
        second = inference.model_package
        self.packages = (inference.package, *([] if second is None else [second]))

    @property
    def needed(self) -> tuple[str, ...]:
        return self._inference.needed

    @property
    def optional(self) -> tuple[str, ...]:
        return self._inference.optional

    @property
    def answers(self) -> tuple[str, ...]:
        return self._inference.answers

    @property
    def answers_at_once(self) -> bool:
        return self._inference.answers_at_once


class WatchedAxes(_Around):
    """An inference whose packages are judged by all rows together."""

    def __init__(self, inference: Inference) -> None:
        super().__init__(inference)
        self._judged = Judged(tuple(Judgement(Cause.NOTHING, 0) for _ in self.packages))
        self._kept: KeptRows | None = None
        self._flagged_stretches: FlaggedStretches | None = None
        self._ended: list[tuple[FlaggedStretch, Judged]] = []
        self._open_judged: tuple[FlaggedStretch | None, int, Judged] = (None, 0, self._judged)
        self._flagged = 0
        self._judged_at = 0
        self.flagged_rows: list[tuple[int, int]] = []
        """Rows, from one to before another, that were answered as wrong by what others proved."""

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of further rows, flagged with what all rows up to them prove."""
        found = self._inference.answer(readings)
        first = 0 if self._kept is None else self._kept.seen
        self.take(found, readings)
        proven = self._proven_so_far(first, first + found.codes.size)
        for stretch in (stretch for stretch in proven if stretch.is_proven):
            self._note_flagged(max(first, stretch.first), stretch.end)
        return replace(found, codes=marked(self._inference, self.packages, found.codes, first, readings, proven))

    def take(self, found: Answer, readings: Mapping[str, FloatArray]) -> None:
        """Take further rows with their answer, to be judged."""
        readings = possible_readings(readings, self.packages)
        if self._kept is None or self._flagged_stretches is None:
            names = (*self.needed, *(name for name in self.optional if name in readings))
            columns = tuple(dict.fromkeys(names))
            self._kept, self._flagged_stretches = KeptRows(columns, MOST_ROWS), FlaggedStretches(columns)
        self._kept.take(readings)
        disagree = np.flatnonzero(found.codes & flag_codes.REDUNDANCY)
        self._flagged += disagree.size
        for stretch in self._flagged_stretches.take(disagree, readings):
            self._end(stretch)
        if (disagree.size or self._is_of_two) and self._kept.seen >= max(2 * self._judged_at, LEAST_ROWS):
            self._judge()

    def finish(self) -> Answer:
        """Return nothing, every row being answered at once."""
        if self._kept is not None and (self._flagged or self._is_of_two) and self._kept.seen > self._judged_at:
            self._judge()
        if self._flagged_stretches is not None:
            for stretch in self._flagged_stretches.finish():
                self._end(stretch)
        return self._inference.finish()

    @property
    def rows(self) -> int:
        """How many have come."""
        return 0 if self._kept is None else self._kept.seen

    @property
    def inference(self) -> Inference:
        return self._inference

    def kept_readings(self) -> Mapping[str, FloatArray]:
        """Return the rows evenly spaced over all that were kept, those that are numbers, by column; one and more."""
        assert self._kept is not None
        return self._kept.finite()

    def judged(self) -> Judged:
        """Return what all rows say of the packages."""
        return self._judged

    @property
    def _is_of_two(self) -> bool:
        return len(self.packages) > 1

    def proven(self) -> tuple[Stretch, ...]:
        """Return the stretches in which packages are found wrong, once all rows have come."""
        whole = Stretch(0, self.rows, self._judged)
        if whole.is_proven and self._judged.explains_all:
            return (whole,)
        wrong = [(stretch, judged) for stretch, judged in self._ended if _are_wrong(stretch, judged)]
        if not wrong:
            return (whole,) if self._judged.explains_all else ()
        for end in dict.fromkeys((self.rows, wrong[-1][0].ends()[1] + 1)):
            judged = self._judged_between(wrong[0][0].ends()[0], end)
            hull = Stretch(wrong[0][0].reach(self.rows)[0], end, judged)
            if hull.is_proven and judged.explains_all:
                return (hull,)
        found: list[Stretch] = []
        for stretch, judged in wrong:
            first, end = stretch.reach(self.rows)
            found.append(Stretch(max(first, found[-1].end) if found else first, end, judged))
        return tuple(found)

    def _proven_so_far(self, first: int, rows: int) -> tuple[Stretch, ...]:
        """Return what is proven by so many rows, of those from ``first`` on."""
        if self._judged.explains_all:
            return (Stretch(0, rows, self._judged),)
        ended = [(s.reach(rows), judged) for s, judged in self._ended if _are_wrong(s, judged)]
        found = [Stretch(*reach, judged) for reach, judged in ended if reach[1] > first]
        assert self._flagged_stretches is not None
        running = self._flagged_stretches.open
        if running is None or not running.is_many or running.rows < LEAST_ROWS:
            return tuple(found)
        stretch, at, judged = self._open_judged
        if stretch is not running or running.kept.seen >= 2 * at:
            judged = self._judged_by(running.finite())
            self._open_judged = (running, running.kept.seen, judged)
        if _are_wrong(running, judged):
            found.append(Stretch(running.reach(rows)[0], rows, judged))
        return tuple(found)

    def _note_flagged(self, first: int, end: int) -> None:
        if self.flagged_rows and self.flagged_rows[-1][1] == first:
            self.flagged_rows[-1] = (self.flagged_rows[-1][0], end)
        else:
            self.flagged_rows.append((first, end))

    def _end(self, stretch: FlaggedStretch) -> None:
        """Judge a stretch, or add it to the one before where both are one."""
        if stretch.rows < LEAST_ROWS:
            return
        last = self._ended[-1] if self._ended else None
        if last is not None and (len(self._ended) >= MOST_STRETCHES or last[0].joins(stretch)):
            both = replace(last[0], flagged=last[0].flagged + stretch.flagged - stretch.outermost.size)
            both.extended(stretch.outermost)
            self._ended[-1] = both, last[1] if _are_wrong(*last) else self._judged_by(stretch.finite())
            return
        self._ended.append((stretch, self._judged_by(stretch.finite())))

    def _judge(self) -> None:
        assert self._kept is not None
        self._judged_at = self._kept.seen
        if self._flagged > LARGEST_SHARE_BY_CHANCE * self._kept.seen:
            self._judged = self._judged_by(self._kept.finite())
            return
        nothing = tuple(Judgement(Cause.NOTHING, 0) for _ in self.packages)
        self._judged = Judged(nothing, turn_of(self._inference, self._kept.finite()) if self._is_of_two else None)

    def _judged_between(self, first: int, end: int) -> Judged:
        assert self._kept is not None
        return self._judged_by(self._kept.finite(first, end))

    def _judged_by(self, readings: Mapping[str, FloatArray]) -> Judged:
        found = []
        for package in self.packages:
            sensors = package.sensors(readings, self._inference.reading_sd_v)
            rows = PackageRows(sensors, package.together(sensors), package.outputs_v(sensors, readings))
            found.append(judge(rows))
        turn = turn_of(self._inference, readings)
        if turn is not None and turn.is_proven and not any(judgement.is_proven for judgement in found):
            # It explains all rows; what chance leaves of one package by itself is no cause beside it.
            found = [Judgement(Cause.NOTHING, judgement.rows) for judgement in found]
        return Judged(tuple(found), turn)


class ReflaggedAxes(_Around):
    """An inference over rows that were judged before: what was proven of them is told of each."""

    def __init__(self, inference: Inference, stretches: Sequence[Stretch]) -> None:
        super().__init__(inference)
        self._stretches, self._seen = stretches, 0

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of further rows with what all rows prove of them."""
        found = self._inference.answer(readings)
        first, self._seen = self._seen, self._seen + found.codes.size
        return replace(
            found, codes=marked(self._inference, self.packages, found.codes, first, readings, self._stretches)
        )

    def finish(self) -> Answer:
        """Return nothing, every row being answered at once."""
        return self._inference.finish()


def answered_at_once(inference: Inference, readings: Mapping[str, FloatArray]) -> Answer:
    """Answer (N,) readings that are all there are: rows are flagged with what all of them prove.

    Raises: as :meth:`ams.inference.inference.Inference.answer`.
    """
    found = inference.answer(readings)
    watched = watched_axes(inference)
    if not isinstance(watched, WatchedAxes):
        return found
    if len(watched.packages) == 1 and not np.any(found.codes & flag_codes.REDUNDANCY):
        return found
    watched.take(found, readings)
    watched.finish()
    return replace(found, codes=marked(inference, watched.packages, found.codes, 0, readings, watched.proven()))


def watched_axes(
    inference: Inference, proven: Sequence[Stretch] | None = None
) -> Inference | WatchedAxes | ReflaggedAxes:
    """Return the inference with an eye on its axes, or with what was ``proven`` of its rows before.

    Only where every package has three axes.
    """
    packages = [inference.package, *([inference.model_package] if inference.model_package else [])]
    if not all(can_be_watched(package) for package in packages):
        return inference
    return WatchedAxes(inference) if proven is None else ReflaggedAxes(inference, proven)


def watch_of(angles: AngleStream) -> WatchedAxes | None:
    """Return the watch that stands in a stream of angles."""
    watched = angles.packages if isinstance(angles, MonitoredAngles) else angles
    return watched if isinstance(watched, WatchedAxes) else None


def marked(
    inference: Inference,
    packages: Sequence[Package],
    codes: flag_codes.AnswerCodes,
    first: int,
    readings: Mapping[str, FloatArray],
    stretches: Sequence[Stretch],
) -> flag_codes.AnswerCodes:
    """Return the codes of rows from ``first`` on with what is proven in the stretches.

    A row that disagrees has the name that all rows give, in the order of the axes of the set; a row that does not is
    flagged by what is proven, unless the axis stands still in some rows alone and not in this one.
    """
    met = [stretch for stretch in stretches if stretch.first < first + codes.size and stretch.end > first]
    if not met:
        return codes
    codes = codes.astype(np.uint64)
    for stretch in met:
        rows = slice(max(stretch.first - first, 0), stretch.end - first)
        there = {name: values[rows] for name, values in readings.items()}
        among = codes[rows]
        is_wrong = np.zeros(among.size, dtype=bool)
        for package, judgement in zip(packages, stretch.judged.judgements, strict=True):
            is_wrong |= _is_wrong(package, judgement, there, inference.reading_sd_v)
        if stretch.is_of_two:
            is_wrong[:] = True
        named = np.uint64(_named_bits(packages, stretch.judged.judgements))
        disagree = (among & np.uint64(flag_codes.REDUNDANCY)) != 0
        if any(judgement.cause in (Cause.AXIS, Cause.ALIKE) for judgement in stretch.judged.judgements):
            among[disagree] = (among[disagree] & ~np.uint64(_EVERY_SUSPECT)) | named
        is_wrong &= ~disagree & ((among & np.uint64(flag_codes.LOST)) == 0)
        both = flag_codes.TWO_PACKAGES if len(packages) > 1 else 0
        among[is_wrong] |= np.uint64(flag_codes.FAULTY | both) | named
    return codes


def _named_bits(packages: Sequence[Package], judgements: Sequence[Judgement]) -> int:
    bits = 0
    suspects = (flag_codes.SUSPECTS, flag_codes.MODEL_SUSPECTS)
    for of_package, package, judgement in zip(suspects, packages, judgements, strict=False):
        if judgement.axis is not None:
            axis = tuple(package.columns)[judgement.axis]
            bits |= of_package["xyz".index(package.coefficients.axes[axis].nominal_axis)]
    return bits


def _is_wrong(
    package: Package, judgement: Judgement, readings: Mapping[str, FloatArray], reading_sd_v: float | None
) -> BoolArray:
    """Return which rows a package is wrong in by what is proven of it."""
    rows = next(iter(readings.values())).size
    found = np.zeros(rows, dtype=bool)
    if not judgement.is_proven:
        return found
    if not judgement.possible or any(not 0 < fault.standing < judgement.rows for fault in judgement.possible):
        return ~found
    sensors = package.sensors(readings, reading_sd_v)
    read_v = package.outputs_v(sensors, readings)
    for fault in judgement.possible:
        assert fault.axis is not None
        near_v = STANDS_SD * np.sqrt(sensors[fault.axis].reading_variance_v2(np.zeros((rows, 3))))
        for stands_v in fault.stands_at_v:
            with np.errstate(invalid="ignore"):
                found |= np.abs(read_v[:, fault.axis] - stands_v) <= near_v
    return found


def _are_wrong(stretch: FlaggedStretch, judged: Judged) -> bool:
    """Return whether the rows of a stretch prove a package wrong, or two against each other."""
    if judged.is_turned or any(judgement.is_proven for judgement in judged.judgements):
        return True
    return len(judged.judgements) > 1 and stretch.flagged > LARGEST_SHARE_OF_TWO * stretch.rows
