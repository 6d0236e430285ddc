"""A coefficient set in use: volts in, angles out, for programs of a tunnel.

>>> package = ams.load("SN1047.json")                                  # doctest: +SKIP
>>> package.attitude([0.1, -0.2, -2.4]).pitch_deg                      # doctest: +SKIP
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.errors import OutsideValidity, SetNotUsable
from ams.exports.formats import load_set
from ams.inference.gyros.aided_rates import AidedAngles, Aiding
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.inference import Inference, Package, inference
from ams.inference.rows.angle_stream import AngleStream, Answer
from ams.inference.rows.stated_rate import StatedRate
from ams.inference.watch.frozen_outputs import FrozenOutputs, noise_by_column
from ams.inference.watch.reliability import Unseen, unseen_errors
from ams.inference.watch.standing_outputs import StandingOutputs, can_stand
from ams.inference.watch.watched_axes import answered_at_once, watched_axes
from ams.sets.coefficients import CoefficientSet

Volts = ArrayLike | Mapping[str, ArrayLike]
"""(…, A) with the axes in the order of the set, or a scalar or an array for each axis by name."""


@dataclass(frozen=True)
class Attitude:
    """Angles with their standard deviations in degrees, in the shape of the readings; NaN where the code says why."""

    pitch_deg: FloatArray
    pitch_sd_deg: FloatArray
    roll_deg: FloatArray
    roll_sd_deg: FloatArray
    codes: flag_codes.AnswerCodes
    """0 where all is well, else bits of :mod:`ams.attitude.flag_codes`."""
    reasons: Mapping[int, str] = field(repr=False)
    """Every code that there is, in words."""
    yaw_deg: FloatArray | None = None
    """None but for a sting package."""
    yaw_sd_deg: FloatArray | None = None

    @property
    def is_good(self) -> BoolArray:
        """Whether nothing is flagged."""
        return np.asarray(self.codes == 0)

    @property
    def flags(self) -> tuple[str, ...]:
        """The codes in words, row by row."""
        return flag_codes.words(np.atleast_1d(self.codes).ravel(), self.reasons)


@dataclass(frozen=True)
class PackageInUse:
    """A calibrated package of accelerometers, alone or a sting package with its model package."""

    coefficients: CoefficientSet
    model_coefficients: CoefficientSet | None = None
    reading_sd_v: float | None = None
    """Standard deviation of one reading where the package is used; None: that of the calibration."""
    upright: bool = True
    right_wing_down: bool = True
    gravity_mps2: float | None = None
    """Local gravity where the package is used; None: that of the calibration."""
    gravity_uncertainty_mps2: float | None = None
    """Standard; None where nobody declares it, and then no angle counts it."""

    @property
    def axes(self) -> tuple[str, ...]:
        """The order of the volts: the set's axes, those of a model package behind, as ``model x``."""
        behind = () if self.model_coefficients is None else self.model_coefficients.axes
        return (*self.coefficients.axes, *(f"model {axis}" for axis in behind))

    def attitude(
        self, volts: Volts, *, temperature_degc: ArrayLike | None = None, roll_deg: ArrayLike | None = None
    ) -> Attitude:
        """Return the attitude of every reading; all are judged together, in their order, as the use of one package.

        ``temperature_degc`` is needed where the set has temperature terms, ``roll_deg`` where one axis tells pitch.

        Raises: OutsideValidity where an input is missing or of another shape; DesignError.
        """
        return self._attitude(self._answered_at_once, volts, temperature_degc, roll_deg)

    def _answered_at_once(self, readings: Mapping[str, FloatArray]) -> Answer:
        if can_stand(self._inference.package):
            return self._with_eye_on_outputs().answer(readings)
        return answered_at_once(self._inference, readings)

    def _with_eye_on_outputs(self) -> FrozenOutputs:
        """Return the angles of one or two axes, whose outputs nothing else tests."""
        package = self._inference.package
        noise, columns = noise_by_column([package], self.reading_sd_v), tuple(package.columns.values())
        return FrozenOutputs(StandingOutputs(self._inference), noise, packages=[package], untested=columns)

    def _attitude(
        self,
        answer: Callable[[Mapping[str, FloatArray]], Answer],
        volts: Volts,
        temperature_degc: ArrayLike | None,
        roll_deg: ArrayLike | None,
    ) -> Attitude:
        readings, shape = self._readings(volts, temperature_degc, roll_deg)
        found = answer(readings)
        angles = {name: values.reshape(shape)[()] for name, values in found.columns.items()}
        return Attitude(**angles, codes=found.codes.reshape(shape)[()], reasons=found.reasons)

    def unseen(
        self,
        volts: Volts,
        chance: np.random.Generator,
        *,
        temperature_degc: ArrayLike | None = None,
        roll_deg: ArrayLike | None = None,
    ) -> Unseen | None:
        """Return which errors of outputs these readings do not show, and how far angles are off by them.

        None where the outputs do not test one another: three accelerometers do, and two packages of them.

        Raises: as :meth:`attitude`.
        """
        return unseen_errors(self._inference, self._readings(volts, temperature_degc, roll_deg)[0], chance)

    def _readings(
        self, volts: Volts, temperature_degc: ArrayLike | None, roll_deg: ArrayLike | None
    ) -> tuple[dict[str, FloatArray], tuple[int, ...]]:
        """Return the readings by column in one row each, and the shape that they had."""
        outputs = outputs_by_axis(volts, self.axes, self.coefficients.sensor)
        shape = outputs[0].shape
        readings = {axis: values.ravel() for axis, values in zip(self.axes, outputs, strict=True)}
        for name, value in (("temperature_degc", temperature_degc), ("roll_deg", roll_deg)):
            if value is not None:
                readings[name] = np.broadcast_to(np.asarray(value, dtype=float), shape).ravel()
        missing = [name for name in self._inference.needed if name not in readings]
        if missing:
            raise OutsideValidity(
                f"{self.coefficients.sensor}: {' and '.join(missing)} missing; nothing was computed; give "
                f"{' and '.join(missing)} beside the volts"
            )
        return readings, shape

    @cached_property
    def _inference(self) -> Inference:
        package, model = self._at_use(self.coefficients, ""), self.model_coefficients
        second = None if model is None else self._at_use(model, "model ")
        return inference(package, second, self.reading_sd_v, upright=self.upright, right_wing_down=self.right_wing_down)

    def _at_use(self, coefficients: CoefficientSet, prefix: str) -> Package:
        columns = {axis: f"{prefix}{axis}" for axis in coefficients.axes}
        g_mps2, u_mps2 = self.gravity_mps2, self.gravity_uncertainty_mps2
        return Package(coefficients, columns, g_mps2, site_gravity_uncertainty_mps2=u_mps2)


def outputs_by_axis(volts: Volts, axes: Sequence[str], sensor: str) -> list[FloatArray]:
    """Return the volts of every axis, all of one shape. Raises: OutsideValidity."""
    if isinstance(volts, Mapping):
        if set(volts) != set(axes):
            raise OutsideValidity(
                f"{sensor}: volts: got the axes {', '.join(volts)}, needed are {', '.join(axes)}; nothing was computed"
            )
        return list(np.broadcast_arrays(*(np.asarray(volts[axis], dtype=float) for axis in axes)))
    array = np.asarray(volts, dtype=float)
    if array.ndim == 0 or array.shape[-1] != len(axes):
        raise OutsideValidity(
            f"{sensor}: volts: got an array of shape {array.shape}, needed (…, {len(axes)}) in the order "
            f"{', '.join(axes)}; nothing was computed"
        )
    return list(np.moveaxis(array, -1, 0))


@dataclass
class PackageStream:
    """The attitude of readings that come piece by piece, with what became of them counted.

    All rows up to the newest are judged together: what they prove is told from then on.
    """

    package: PackageInUse
    rows: int = 0
    lost: int = 0
    """Rows without an angle."""
    flagged: int = 0
    """Rows with a flag, the lost ones among them."""

    def feed(
        self, volts: Volts, *, temperature_degc: ArrayLike | None = None, roll_deg: ArrayLike | None = None
    ) -> Attitude:
        """Return the attitude of further readings. Raises: as :meth:`PackageInUse.attitude`."""
        found = self.package._attitude(self._angles.answer, volts, temperature_degc, roll_deg)
        self.rows += np.size(found.codes)
        self.lost += int(np.count_nonzero(np.isnan(found.pitch_deg)))
        self.flagged += int(np.count_nonzero(found.codes))
        return found

    @cached_property
    def _angles(self) -> AngleStream:
        angles = self.package._inference
        return self.package._with_eye_on_outputs() if can_stand(angles.package) else watched_axes(angles)


def load(
    path: str | Path,
    model: str | Path | None = None,
    *,
    reading_sd_v: float | None = None,
    upright: bool = True,
    right_wing_down: bool = True,
    gravity_mps2: float | None = None,
    gravity_uncertainty_mps2: float | None = None,
) -> PackageInUse:
    """Return the set of a file, of any format, its test vectors recomputed; with ``model`` CR's two packages.

    ``gravity_mps2``: where the package is used, None for that of the calibration; with its standard uncertainty.

    Warns: SetNotUsable for a set whose calibration has the verdict ``not usable``.

    Raises: SetError, VectorsDisagree; OutsideValidity for a set that tells no angles.
    """
    sets = _loaded(path, model)
    package = PackageInUse(
        sets[0],
        sets[1] if model is not None else None,
        reading_sd_v,
        upright,
        right_wing_down,
        gravity_mps2,
        gravity_uncertainty_mps2,
    )
    _ = package._inference  # a set that tells no angles is refused here, not at the first reading
    return package


def _loaded(*paths: str | Path | None) -> list[CoefficientSet]:
    """Return the sets as whoever calls the caller uses them, with a warning of each that is not usable.

    Raises: SetError, VectorsDisagree.
    """
    sets = []
    for path in paths:
        if path is not None:
            sets.append(load_set(path))
            sets[-1].check_vectors(str(path))
    for coefficients in sets:
        if coefficients.doubt is not None:
            warnings.warn(coefficients.doubt, SetNotUsable, stacklevel=3)
    return sets


class GyroStream:
    """Attitudes of gyros, alone or with accelerometers, of samples that come piece by piece."""

    def __init__(self, angles: GyroAngles | AidedAngles) -> None:
        stated_hz = angles.motion.rate_hz
        self._angles: AngleStream = angles if stated_hz is None else StatedRate(angles, stated_hz)

    @property
    def axes(self) -> tuple[str, ...]:
        """The order of the volts: the gyros' axes, those of accelerometers behind, as ``accelerometer x``."""
        return self._angles.needed

    def feed(self, volts: Volts, *, time_s: ArrayLike | None = None) -> Attitude:
        """Return the attitudes that further samples settle, oldest first; of gyros alone the newest comes later.

        ``volts`` is (n, A), one row a sample, or by axis; NaN is a reading that is missing. With ``time_s`` samples
        that never came or came twice are noticed.

        Raises: OutsideValidity for another shape, without a sampling rate, or with one that ``time_s`` contradicts.
        """
        outputs = outputs_by_axis(volts, self.axes, "gyros")
        readings = dict(zip(self.axes, map(np.atleast_1d, outputs), strict=True))
        if time_s is not None:
            readings["time_s"] = np.atleast_1d(np.asarray(time_s, dtype=float))
        return _attitude_of(self._angles.answer(readings))

    def finish(self) -> Attitude:
        """Return the attitudes still due; the stream ends here. Raises: ObservationsError with too few samples."""
        return _attitude_of(self._angles.finish())


def _attitude_of(found: Answer) -> Attitude:
    return Attitude(**found.columns, codes=found.codes, reasons=found.reasons)


def load_gyros(
    path: str | Path,
    motion: Motion | None = None,
    *,
    accelerometers: str | Path | None = None,
    aiding: Aiding | None = None,
    reading_sd_v: float | None = None,
) -> GyroStream:
    """Return the stream of a set of gyros from the start of a motion; with a set of accelerometers both by a filter.

    Warns: SetNotUsable for a set whose calibration has the verdict ``not usable``.

    Raises: SetError, VectorsDisagree; OutsideValidity for sets that tell no rates or no force.
    """
    sets = _loaded(path, accelerometers)
    rates_set = sets[0]
    gyros = GyroPackage(rates_set, {axis: axis for axis in rates_set.axes}, reading_sd_v)
    start = motion or Motion()
    if accelerometers is None:
        return GyroStream(GyroAngles(gyros, start))
    force = Package(sets[1], {axis: f"accelerometer {axis}" for axis in sets[1].axes})
    return GyroStream(AidedAngles(gyros, force, start, aiding or Aiding()))
