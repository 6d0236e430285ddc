"""Outputs of one or two accelerometers that stand at their zero: not connected, or level.

Three outputs have a length that has to be g. One or two have an attitude for every number that they give: one that is
not connected, and reads its offset or 0 V, reads as level. But the sensitive axis of a sensor is never quite that of
the package: where the package moves about a level axis, its output takes the share k_j f_j of the other directions, and
the calibration knows k_j. An output that stands at its zero, and has no more than a twentieth of the variation that
this makes, senses nothing: those rows are flagged. Rows that could not show the share, because the package rests, or
the share is lost in noise, look as those of a level package do: they are named after the last row, and no flag is made
of them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.inference.inference import Inference, Package
from ams.inference.package.calibrated import CalibratedSensor
from ams.inference.rows.angle_stream import AngleStream, Answer
from ams.inference.rows.possible_rows import possible_readings
from ams.inference.watch.frozen_outputs import LEAST_ROWS
from ams.inference.watch.standing_run import LEAST_NOISE_G, StandingRun
from ams.inference.watch.standing_share import Rows, share_v, share_variance_v2

MOST_LISTED: Final = 3
"""Stretches of an output that are told one by one."""
_NEAR_SD: Final = 5.0
_PIECE: Final = 16
"""Rows whose differences tell a noise."""
_MOST_NOISE_G: Final = 5e-4


def can_stand(package: Package) -> bool:
    """Return whether a package has one or two accelerometers of the form v = b + k·f, which nothing else tests."""
    axes = package.coefficients.axes.values()
    is_plain = all(axis.form.unit == "g" and axis.model_output is None for axis in axes)
    return is_plain and len(package.columns) <= 2 and not package.is_of_sting


class _Around:
    """Angles that are looked after, with what they are in common."""

    def __init__(self, angles: AngleStream) -> None:
        self._angles = angles

    @property
    def needed(self) -> tuple[str, ...]:
        return self._angles.needed

    @property
    def optional(self) -> tuple[str, ...]:
        return self._angles.optional

    @property
    def answers(self) -> tuple[str, ...]:
        return self._angles.answers

    @property
    def answers_at_once(self) -> bool:
        return self._angles.answers_at_once

    def finish(self) -> Answer:
        """Return the angles that are still due."""
        return self._angles.finish()


class StandingOutputs(_Around):
    """Angles of one or two accelerometers, row by row, with an eye on outputs that stand at their zero."""

    def __init__(self, angles: Inference) -> None:
        super().__init__(angles)
        self._inference, self.package = angles, angles.package
        self.rows = 0
        self._columns = tuple(self.package.columns.values())
        self._quietest_v = np.full(len(self._columns), np.inf)
        self._open: dict[tuple[int, bool], StandingRun] = {}
        self._closed: list[StandingRun] = []

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of further rows, flagged from where an output is known to sense nothing."""
        found = self._angles.answer(readings)
        taken = self.take(readings)
        return marked(found, taken, self.package, self.rows - found.codes.size)

    def take(self, readings: Mapping[str, FloatArray]) -> list[StandingRun]:
        """Take further rows; return the runs among them that are known to be dead."""
        readings = possible_readings(readings, (self.package,))
        outputs = np.stack([readings[column] for column in self._columns])
        rows, first = outputs.shape[1], self.rows
        self.rows += rows
        if not rows:
            return []
        is_whole: BoolArray = np.logical_and.reduce(np.isfinite(outputs))
        sensors = self.package.sensors(readings, self._inference.reading_sd_v)
        roll_deg = readings.get("roll_deg") if len(sensors) == 1 and self.package.states_roll else None
        upright, right_wing_down = self._inference.upright, self._inference.right_wing_down
        known = Rows(sensors, self.package.outputs_v(sensors, readings).T, roll_deg, upright, right_wing_down)
        for axis, output_v in enumerate(known.outputs_v):
            self._quietest_v[axis] = min(self._quietest_v[axis], _quietest(output_v))
        return [
            run
            for axis, sensor in enumerate(sensors)
            for is_offset, zero_v in self._zeros(sensor, axis)
            for run in self._runs(known, axis, is_offset, zero_v, is_whole, first)
        ]

    def _noise_v(self, sensor: CalibratedSensor, axis: int) -> float:
        """Return the standard deviation of an output about its zero: as stated, or as it shows itself where larger."""
        names = list(sensor.names)
        at = names.index("offset_v") if "offset_v" in names else None
        of_offset = 0.0 if at is None else np.sqrt(max(sensor.covariance[at, at], 0))
        stated = float(np.hypot(np.min(sensor.reading_sd_v), of_offset))
        most = _MOST_NOISE_G * float(np.linalg.norm(sensor.k_v_per_g))
        shown = self._quietest_v[axis]
        least = LEAST_NOISE_G * float(np.linalg.norm(sensor.k_v_per_g))
        return max(stated, float(shown) if shown <= most else 0.0, least)

    def _zeros(self, sensor: CalibratedSensor, axis: int) -> Iterator[tuple[bool, float]]:
        yield True, sensor.offset_v
        if abs(sensor.offset_v) > 2.0 * _NEAR_SD * self._noise_v(sensor, axis):
            yield False, 0.0

    def _runs(
        self, known: Rows, axis: int, is_offset: bool, zero_v: float, is_whole: BoolArray, first: int
    ) -> Iterator[StandingRun]:
        """Yield the runs of one output at one zero that are dead, in so far as these rows go."""
        sensor, key = known.sensors[axis], (axis, is_offset)
        noise_v = self._noise_v(sensor, axis)
        deviation_v = known.outputs_v[axis] - zero_v
        with np.errstate(invalid="ignore"):
            is_near = is_whole & (np.abs(deviation_v) <= _NEAR_SD * noise_v)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], is_near, [False]])))
        if key in self._open and not is_near[0]:
            self._close(key)
        for start, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            goes_on, run = end == is_near.size, self._open.get(key)
            if not goes_on and end - start + (0 if run is None else run.rows) < LEAST_ROWS:
                self._open.pop(key, None)
                continue
            if run is None:
                variance_v2 = share_variance_v2(sensor)
                size_v = float(np.linalg.norm(sensor.k_v_per_g))
                run = StandingRun(axis, is_offset, first + start, noise_v, size_v, variance_v2)
                self._open[key] = run
            run.take(deviation_v[start:end], *share_v(known.part(start, end), axis, zero_v))
            if run.is_dead:
                run.flagged_from = first + start if run.flagged_from is None else run.flagged_from
                yield run
            if not goes_on:
                self._close(key)

    def _close(self, key: tuple[int, bool]) -> None:
        run = self._open.pop(key)
        if run.stands:
            self._closed.append(run)

    def finish(self) -> Answer:
        """Return the angles that are still due."""
        for key in tuple(self._open):
            self._close(key)
        return super().finish()

    def runs(self) -> tuple[StandingRun, ...]:
        """Return the runs that ended, in the order of their first rows."""
        return tuple(sorted(self._closed, key=lambda run: run.first))

    def again(self) -> "ReflaggedOutputs | None":
        """Return the angles of the same rows with what all of them tell; None where nothing is dead."""
        dead = [run for run in self.runs() if run.is_dead]
        was_flagged = any(run.flagged_from is not None for run in self._closed)
        return ReflaggedOutputs(self._angles, self.package, dead) if dead or was_flagged else None

    def doubts(self, *, is_flagged_throughout: bool) -> tuple[str, ...]:
        """Name the outputs that lay at their zero in some rows or in all."""
        said = []
        for axis, column in enumerate(self._columns):
            runs = [run for run in self.runs() if run.axis == axis and (run.is_dead or not run.is_level)]
            said += [
                self._in_words(column, run, is_flagged_throughout=is_flagged_throughout) for run in runs[:MOST_LISTED]
            ]
            if len(runs) > MOST_LISTED:
                said.append(f"{column}: {len(runs) - MOST_LISTED} more such stretches")
        return tuple(said)

    def _in_words(self, column: str, run: StandingRun, *, is_flagged_throughout: bool) -> str:
        zero = "its offset" if run.is_offset else "0 V"
        where = f"all {run.rows} rows" if run.rows == self.rows else f"rows {run.first + 1} to {run.end}"
        looks = "a dead axis, a broken wire or an input that reads nothing"
        if not run.is_dead:
            return (
                f"{column} lies at {zero} in {where}: {looks} looks like that, and so does a package that rests with "
                "that axis level; these rows do not tell which; look before the angles are used"
            )
        since = run.end if run.flagged_from is None else run.flagged_from
        flagged = (
            "the rows are flagged"
            if is_flagged_throughout or since == run.first
            else f"rows {run.first + 1} to {since} were answered before that was known and have no flag"
        )
        return (
            f"{column} lies at {zero} in {where} and has nothing of what the moving package makes of a sensor there: "
            f"{looks}; the angles are wrong; {flagged}"
        )


class ReflaggedOutputs(_Around):
    """Angles of rows that were read before, with the runs that are known to be dead."""

    def __init__(self, angles: AngleStream, package: Package, dead: Sequence[StandingRun]) -> None:
        super().__init__(angles)
        self._package, self._dead, self._seen = package, dead, 0

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of further rows, flagged where an output senses nothing."""
        found = self._angles.answer(readings)
        first, self._seen = self._seen, self._seen + found.codes.size
        return marked(found, self._dead, self._package, first)


def marked(found: Answer, dead: Sequence[StandingRun], package: Package, first: int) -> Answer:
    """Return an answer to the rows from ``first`` on with a flag where an output senses nothing."""
    reasons = {**found.reasons, **flag_codes.STANDING_WORDS}
    rows, axes = found.codes.size, tuple(package.columns)
    met = [run for run in dead if run.first < first + rows and run.end > first]
    if not met:
        return replace(found, reasons=reasons)
    codes = found.codes.astype(np.uint64)
    for run in met:
        nominal = package.coefficients.axes[axes[run.axis]].nominal_axis
        codes[max(run.first - first, 0) : run.end - first] |= np.uint64(flag_codes.STANDS["xyz".index(nominal)])
    return replace(found, codes=codes, reasons=reasons)


def _quietest(read_v: FloatArray) -> float:
    """Return the least standard deviation that differences of neighbours show in any piece of (n,) rows."""
    pieces = read_v[: read_v.size // _PIECE * _PIECE].reshape(-1, _PIECE)
    steps = np.sqrt(np.mean(np.diff(pieces, axis=1) ** 2, axis=1) / 2.0)
    steps = steps[np.isfinite(steps) & (steps > 0.0)]
    return float(steps.min()) if steps.size else np.inf
