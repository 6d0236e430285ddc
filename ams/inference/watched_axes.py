"""Angles of packages of three axes, with an eye on which axis the rows together hold to be wrong.

A row that disagrees is flagged at once. Evenly spaced rows are kept, however many come, and judged together whenever
their number has doubled, and at the end: from then on a flagged row has the name of the axis that all of them give, and
none where they say that all outputs are wrong alike.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.inference.angle_stream import AngleStream, Answer
from ams.inference.faulty_axis import LEAST_ROWS, Cause, Explanation, Judgement, PackageRows, judge
from ams.inference.inference import Inference, Package
from ams.inference.monitored import MonitoredAngles

MOST_ROWS: Final = 1024
"""That are kept; of more every second is left out."""
LARGEST_SHARE_BY_CHANCE: Final = 0.01
"""Of flagged rows: a good package has one in a thousand, and hardly a calibration that is wrong has ten times that."""


def can_be_watched(package: Package) -> bool:
    """Return whether a package has three accelerometers, whose outputs test one another."""
    axes = package.coefficients.axes.values()
    return len(package.columns) == 3 and all(axis.form.unit == "g" and axis.model_output is None for axis in axes)


@dataclass
class _Kept:
    """Rows evenly spaced over all that came."""

    columns: tuple[str, ...]
    stride: int = 1
    seen: int = 0

    def __post_init__(self) -> None:
        self.rows = np.empty((len(self.columns), 0))

    def take(self, readings: Mapping[str, FloatArray]) -> None:
        start = -self.seen % self.stride
        further = np.stack([readings[name][start :: self.stride] for name in self.columns])
        self.seen += readings[self.columns[0]].size
        self.rows = np.concatenate([self.rows, further], axis=1)
        while self.rows.shape[1] > MOST_ROWS:
            self.rows, self.stride = self.rows[:, ::2], 2 * self.stride

    def finite(self) -> dict[str, FloatArray]:
        whole = self.rows[:, np.isfinite(self.rows).all(axis=0)]
        return dict(zip(self.columns, whole, strict=True))


class WatchedAxes:
    """An inference whose packages are judged by all rows together."""

    def __init__(self, inference: Inference) -> None:
        self._inference = inference
        second = inference.model_package
        self._packages = [inference.package, *([] if second is None else [second])]
        self._judgements = [Judgement(Cause.NOTHING, 0) for _ in self._packages]
        self._kept: _Kept | None = None
        self._flagged = 0
        self._judged_at = 0

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

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of further rows, flagged with the name that all rows up to them give."""
        found = self._inference.answer(readings)
        if self._kept is None:
            names = (*self.needed, *(name for name in self.optional if name in readings))
            self._kept = _Kept(tuple(dict.fromkeys(names)))
        self._kept.take(readings)
        disagree = np.flatnonzero(found.codes & flag_codes.REDUNDANCY)
        self._flagged += disagree.size
        if disagree.size and self._kept.seen >= max(2 * self._judged_at, LEAST_ROWS):
            self._judge()
        return replace(found, codes=self._named(found.codes, disagree)) if disagree.size else found

    def finish(self) -> Answer:
        """Return nothing, every row being answered at once."""
        if self._kept is not None and self._flagged and self._kept.seen > self._judged_at:
            self._judge()
        return self._inference.finish()

    def judgements(self) -> tuple[tuple[str, Package, Judgement], ...]:
        """Return what the rows say of each package: its name beside another, itself, and the judgement."""
        names = ("",) if len(self._packages) == 1 else ("sting", "model")
        return tuple(zip(names, self._packages, self._judgements, strict=True))

    def _judge(self) -> None:
        assert self._kept is not None
        self._judged_at = self._kept.seen
        if self._flagged <= LARGEST_SHARE_BY_CHANCE * self._kept.seen:
            self._judgements = [Judgement(Cause.NOTHING, 0) for _ in self._packages]
            return
        readings = self._kept.finite()
        self._judgements = [self._judged(package, readings) for package in self._packages]

    def _judged(self, package: Package, readings: Mapping[str, FloatArray]) -> Judgement:
        sensors = package.sensors(readings, self._inference.reading_sd_v)
        return judge(PackageRows(sensors, package.together(sensors), package.outputs_v(sensors, readings)))

    def _named(self, codes: flag_codes.AnswerCodes, disagree: np.ndarray) -> flag_codes.AnswerCodes:
        """Return the codes with the name that all rows give, in the order of the axes of the set."""
        known = [judgement for judgement in self._judgements if judgement.cause in (Cause.AXIS, Cause.ALIKE)]
        if not known:
            return codes
        bits = 0
        suspects = (flag_codes.SUSPECTS, flag_codes.MODEL_SUSPECTS)
        for of_package, package, judgement in zip(suspects, self._packages, self._judgements, strict=False):
            if judgement.axis is not None:
                axis = tuple(package.columns)[judgement.axis]
                bits |= of_package["xyz".index(package.coefficients.axes[axis].nominal_axis)]
        every = sum((*flag_codes.SUSPECTS, *flag_codes.MODEL_SUSPECTS))
        named = codes.copy()
        named[disagree] = (named[disagree] & ~named.dtype.type(every)) | named.dtype.type(bits)
        return named


def watched_axes(inference: Inference) -> Inference | WatchedAxes:
    """Return the inference with an eye on its axes, where every package has three."""
    packages = [inference.package, *([inference.model_package] if inference.model_package else [])]
    return WatchedAxes(inference) if all(can_be_watched(package) for package in packages) else inference


def doubts_of(angles: AngleStream) -> tuple[str, ...]:
    """Say what the rows tell of each package whose axes are watched; nothing where nothing is wrong."""
    watched = angles.packages if isinstance(angles, MonitoredAngles) else angles
    found = watched.judgements() if isinstance(watched, WatchedAxes) else ()
    return tuple(text for name, package, judgement in found if (text := in_words(name, package, judgement)))


_EVERY_ROW: Final = "; angles of rows without a flag are wrong by it as well"
"""Redundancy tells a row only where the fault changes the length of what is sensed."""


def in_words(package_name: str, package: Package, judgement: Judgement) -> str:
    """Say what the rows of a package tell of its axes; empty where nothing is wrong."""
    if judgement.cause is Cause.NOTHING:
        return ""
    sensor = package.coefficients.sensor + (f", {package_name} package" if package_name else "")
    head = f"{sensor}: {judgement.rows} rows evenly spaced over all were judged together: "
    axes = tuple(package.columns)
    if judgement.cause is Cause.AXIS:
        fault = judgement.possible[0]
        return (
            f"{head}{axes[fault.axis or 0]} is the faulty axis: {_fault(fault, judgement.rows)}; no other axis "
            f"explains them, nor an error of all alike{'' if 0 < fault.standing < judgement.rows else _EVERY_ROW}"
        )
    if judgement.cause is Cause.ALIKE:
        return (
            f"{head}all outputs are wrong alike and no axis by itself: {_changed(judgement.possible[0])}; look at "
            f"supply, meter and local gravity (--gravity-mps2){_EVERY_ROW}"
        )
    if judgement.cause is Cause.SEVERAL:
        said = [axes[fault.axis] if fault.axis is not None else "all outputs alike" for fault in judgement.possible]
        return (
            f"{head}the faulty axis cannot be named: {' or '.join(said)}, which these attitudes do not part; rows of "
            "other attitudes do"
        )
    if judgement.cause is Cause.UNMOVED:
        return f"{head}the faulty axis cannot be named: all outputs stand still; rows of other attitudes are needed"
    return (
        f"{head}the faulty axis cannot be named: no single one explains them, nor an error of all alike: more than "
        "one is wrong, two are interchanged, the fault came and went, the package was accelerated, or readings scatter "
        "more than is stated (--reading-sd-v)"
    )


def _fault(fault: Explanation, rows: int) -> str:
    if not fault.standing:
        return _changed(fault)
    at = " and ".join(f"{value:.6g} V" for value in fault.stands_at_v)
    if fault.standing == rows:
        return f"it stands at {at} while the others move"
    return f"it stands at {at} where the rows disagree, and agrees elsewhere"


def _changed(fault: Explanation) -> str:
    """Say what differs from the calibration, gain and offset, with twice their standard deviations."""
    said = []
    if abs(fault.gain - 1.0) > 2.0 * fault.gain_sd:
        said.append(f"{fault.gain:.6g} ± {2.0 * fault.gain_sd:.1g} times what the calibration says")
    if abs(fault.offset_v) > 2.0 * fault.offset_sd_v or not said:
        said.append(f"an offset of {1e3 * fault.offset_v:+.4g} ± {2e3 * fault.offset_sd_v:.1g} mV")
    return f"{' and '.join(said)} (k = 2)"
