"""From columns of readings to columns of angles: the geometry that a coefficient set calls for.

One axis near x gives pitch where roll is known; two and three axes give pitch and roll; CR's sting package gives pitch
and yaw, together with its model package also roll. A model package alone has gravity for its reference and nothing
else: its yaw is taken as zero. Every row has a flag, empty where all is well. Source: TP 6, CR IV-B.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.attitude.spread import PackageErrors
from ams.attitude.static import Angles, pitch_roll_from_three, pitch_roll_from_two, pitch_with_known_roll
from ams.attitude.three_axes import BLOCK_ROWS, AttitudeColumns, blocks
from ams.errors import OutsideValidity
from ams.inference.package.alignment import AlignedPackage, AlignedSensor, Alignment
from ams.inference.package.bent_sensors import unbent
from ams.inference.package.by_inverse import pitch_by_inverse
from ams.inference.package.calibrated import CalibratedPackage, CalibratedSensor, package_of_set, sensor_of_set
from ams.inference.package.fixed_sensors import Kernel, kernel_of, name_suspects_of
from ams.inference.package.packages import SpreadAngles, angles_from_packages, angles_from_sting
from ams.inference.package.site_gravity import check_site_gravity, gravity_shares, shares_in_common
from ams.inference.rows.angle_stream import SD_FACTOR, Answer, nothing, with_temperature_codes
from ams.inference.rows.possible_rows import possible_readings, with_overload_codes
from ams.inference.rows.used_beyond import codes_of_angles, senses_roll_within
from ams.models.registry import MODELS
from ams.sets.axis_section import lack_of_fit_of
from ams.sets.canonical import table
from ams.sets.coefficients import CoefficientSet
from ams.sets.sensed_quantity import FIELDS
from ams.units import printed

_DEG_PER_RAD: Final = float(np.rad2deg(1.0))
"""A product of a column costs a fifth of what numpy's function of it does."""


@dataclass(frozen=True)
class Package:
    """A set and the columns that its axes are read from."""

    coefficients: CoefficientSet
    columns: Mapping[str, str]
    """Axis to column; a set may be used with fewer axes than it has."""
    site_gravity_mps2: float | None = None
    """The g where the set is used; None: that of the calibration."""
    alignment: Alignment | None = None
    """How the package sits in the model; None: angles are those of the package."""
    site_gravity_uncertainty_mps2: float | None = None
    """Standard, of the g where the set is used; None where nobody declares it."""
    gravity_in_common: frozenset[str] = frozenset()
    """Causes of an error of gravity that are counted beside the package, where another one has the same."""

    def __post_init__(self) -> None:
        self.coefficients.require_standing(self.coefficients.sensor, "nothing was computed")
        self._check_alignment()
        check_site_gravity(self.coefficients, self.site_gravity_mps2, self.site_gravity_uncertainty_mps2)

    def _check_alignment(self) -> None:
        if self.alignment is None:
            return
        name, axes = self.coefficients.sensor, self.coefficients.axes
        if self.alignment.sensor != name:
            raise OutsideValidity(
                f"{name}: alignment: is that of {self.alignment.sensor}; nothing was computed; solve this sensor's"
            )
        is_fit = all(
            axis.form.unit == "g" and not axis.form.is_gravity and axis.model_output is None for axis in axes.values()
        )
        if len(self.columns) != 3 or not is_fit:
            raise OutsideValidity(
                f"{name}: alignment: turns three accelerometers of pitch and roll: got {len(self.columns)} axes by "
                f"{self.model}; nothing was computed; leave the alignment out"
            )

    @property
    def model(self) -> str:
        return next(iter(self.coefficients.axes.values())).model

    @property
    def states_roll(self) -> bool:
        """Whether observations for its model state roll."""
        return "roll" in MODELS[self.model].columns

    @property
    def is_of_sting(self) -> bool:
        """Whether its model is that of CR's package on the sting."""
        return MODELS[self.model].is_of_sting

    @property
    def follows_sting(self) -> bool:
        """Whether its model is that of CR's package in the model."""
        return MODELS[self.model].follows_sting

    @property
    def senses_rates(self) -> bool:
        """Whether its axes are gyros, by whatever model."""
        return all(numbers.form.unit == "dps" for numbers in self.coefficients.axes.values())

    def in_model_axes(self, sensors: Sequence[CalibratedSensor]) -> list[CalibratedSensor | AlignedSensor]:
        """Return the sensors as the model that carries them has them."""
        if self.alignment is None:
            return list(sensors)
        return [AlignedSensor(sensor, self.alignment.rotation) for sensor in sensors]

    def errors_together(self, sensors: Sequence[CalibratedSensor]) -> PackageErrors | None:
        """Return what is not known of the axes together: their calibrations, and the alignment."""
        together = self.together(sensors)
        if self.alignment is None:
            return together
        aligned = [AlignedSensor(sensor, self.alignment.rotation) for sensor in sensors]
        return AlignedPackage(aligned, together, self.alignment)

    def sensors(self, readings: Mapping[str, FloatArray], reading_sd_v: float | None) -> list[CalibratedSensor]:
        """Return the sensors at (N,) readings; a standard deviation that is stated has the factor of every row.

        It is of the noise where the set is used: what the sensor lacks of its model stays beside it, as it does in the
        standard error that stands for both where nothing is stated.
        """
        temperature, site = readings.get("temperature_degc"), self.site_gravity_mps2
        found = [
            sensor_of_set(self.coefficients, axis, reading_sd_v, temperature, site, self._gravity_shares)
            for axis in self.columns
        ]
        if reading_sd_v is None:
            return found
        noise_v = reading_sd_v * readings.get(SD_FACTOR, np.ones(()))
        axes = self.coefficients.axes
        sections = table(self.coefficients.document["axes"])
        lacks_v = [lack_of_fit_of(table(sections[axis]), axes[axis]) for axis in self.columns]
        return [replace(sensor, reading_sd_v=np.hypot(noise_v, v)) for sensor, v in zip(found, lacks_v, strict=True)]

    def together(self, sensors: Sequence[CalibratedSensor]) -> CalibratedPackage | None:
        """Return what the calibrations of the axes have in common, where the set states it."""
        site = self.site_gravity_mps2
        return package_of_set(self.coefficients, tuple(self.columns), sensors, site, self._gravity_shares)

    @property
    def _gravity_shares(self) -> Mapping[str, float]:
        shares = gravity_shares(self.coefficients, self.site_gravity_mps2, self.site_gravity_uncertainty_mps2)
        return {name: share for name, share in shares.items() if name not in self.gravity_in_common}

    def beside(self, other: "Package") -> tuple["Package", "Package", float]:
        """Return two packages without what gravity is wrong by in both alike, and that, over gravity."""
        site = self.site_gravity_mps2, self.site_gravity_uncertainty_mps2
        if site != (other.site_gravity_mps2, other.site_gravity_uncertainty_mps2):
            return self, other, 0.0
        shares = shares_in_common((self.coefficients, other.coefficients), *site)
        first, second = (replace(package, gravity_in_common=frozenset(shares)) for package in (self, other))
        return first, second, float(np.sqrt(sum(share**2 for share in shares.values())))

    def outputs_v(self, sensors: Sequence[CalibratedSensor], readings: Mapping[str, FloatArray]) -> FloatArray:
        """Return the (N, A) readings brought to the reference temperature."""
        pairs = zip(sensors, self.columns.values(), strict=True)
        return np.stack([sensor.line_output_v(readings[column]) for sensor, column in pairs], axis=-1)


@dataclass(frozen=True)
class Inference:
    """How one stream of readings becomes angles."""

    package: Package
    model_package: Package | None = None
    """CR's second package, where there are two."""
    reading_sd_v: float | None = None
    """Standard deviation of a reading where the sets are used; None: that of the calibration."""
    upright: bool = True
    right_wing_down: bool = True
    intervals: bool = False
    """Whether the answer has half-widths of 95 % intervals as well."""

    @cached_property
    def needed(self) -> tuple[str, ...]:
        """Columns that every row must have."""
        columns = [column for package in self._packages for column in package.columns.values()]
        if any(package.coefficients.needs_temperature for package in self._packages):
            columns.append("temperature_degc")
        if self.package.states_roll and len(self.package.columns) == 1:
            columns.append("roll_deg")
        return tuple(dict.fromkeys(columns))

    @property
    def answers_at_once(self) -> bool:
        return True

    @cached_property
    def answers(self) -> tuple[str, ...]:
        """Columns of the answer, in order."""
        angles = ("pitch", "roll", *(["yaw"] if self.package.is_of_sting else []))
        endings = ("_deg", "_sd_deg", *(["_half_95_deg"] if self.intervals else []))
        return (*(f"{angle}{ending}" for angle in angles for ending in endings), "flag")

    @property
    def optional(self) -> tuple[str, ...]:
        """Columns that are used where they are there."""
        return ("temperature_degc", SD_FACTOR)

    def finish(self) -> Answer:
        """Return nothing: every row is answered at once."""
        return nothing(self.answers)

    def infer(self, readings: Mapping[str, FloatArray]) -> dict[str, FloatArray | tuple[str, ...]]:
        """Return the answers by column from (N,) readings by column, NaN where the flag says why.

        Raises: DesignError, OutsideValidity where no row can be inferred.
        """
        found = self.answer(readings)
        return {**found.columns, "flag": found.flags}

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Answer (N,) readings by column; a row without a reading that can be has no angles and says so.

        Raises: DesignError, OutsideValidity where no row can be inferred.
        """
        sets, possible = [used.coefficients for used in self._packages], possible_readings(readings, self._packages)
        found = with_temperature_codes(self._in_blocks(possible), readings, sets)
        return with_overload_codes(found, readings, possible)

    def _in_blocks(self, readings: Mapping[str, FloatArray]) -> Answer:
        rows = readings[self.needed[0]].size
        if rows <= BLOCK_ROWS:
            return self._answered(readings)
        columns = {name: np.empty(rows) for name in self.answers if name != "flag"}
        codes: flag_codes.AnswerCodes = np.empty(rows, dtype=np.uint64 if self._checks_roll else np.uint32)
        reasons: Mapping[int, str] = flag_codes.WORDS
        for block in blocks(rows):
            found = self._answered({name: values[block] for name, values in readings.items()})
            for name, values in found.columns.items():
                columns[name][block] = values
            codes[block], reasons = found.codes, found.reasons
        return Answer(columns, codes, reasons)

    def _answered(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Answer the rows of one block: those with a reading missing as well as the others."""
        is_whole = np.logical_and.reduce([np.isfinite(readings[name]) for name in self.needed])
        if is_whole.all():
            return self._answer(readings)
        found = self._answer({name: values[is_whole] for name, values in readings.items()})
        codes = np.full(is_whole.size, flag_codes.NOT_FINITE, dtype=found.codes.dtype)
        codes[is_whole] = found.codes
        columns = {name: np.full(is_whole.size, np.nan) for name in found.columns}
        for name, values in found.columns.items():
            columns[name][is_whole] = values
        return Answer(columns, codes, found.reasons)

    def _answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        found = self._angles(readings)
        columns = {name: _DEG_PER_RAD * getattr(found, in_rad) for name, in_rad in self._in_rad}
        return Answer(columns, found.codes | self._beyond(found), found.reasons)

    @cached_property
    def _in_rad(self) -> tuple[tuple[str, str], ...]:
        """Columns of the answer but the flag, with the names of what is found."""
        return tuple((name, name.replace("_deg", "_rad")) for name in self.answers if name != "flag")

    @cached_property
    def _kernel(self) -> Kernel | None:
        """What solves sensors that stay the same from row to row; None where they do not, or more is asked for."""
        is_plain = self.model_package is None and FIELDS[self.package.model].output is None
        is_plain = is_plain and self.package.alignment is None
        if not is_plain or self.intervals or self.package.is_of_sting or self.package.coefficients.needs_temperature:
            return None
        sensors = self.package.sensors({}, self.reading_sd_v)
        together = self.package.together(sensors)
        return kernel_of(sensors, together, upright=self.upright, right_wing_down=self.right_wing_down)

    def _angles(self, readings: Mapping[str, FloatArray]) -> AttitudeColumns | Angles | SpreadAngles:
        is_alike = self.reading_sd_v is None or bool(np.all(readings.get(SD_FACTOR, 1.0) == 1.0))
        if is_alike and self._kernel is not None:
            outputs_v = np.stack([readings[column] for column in self.package.columns.values()])
            return self._kernel(outputs_v, self._known_roll_rad(readings))
        if self.model_package is not None:
            return self._angles_of_two(*self.package.beside(self.model_package), readings)
        sensors = self.package.sensors(readings, self.reading_sd_v)
        outputs = self.package.outputs_v(sensors, readings)
        output = FIELDS[self.package.model].output
        if output is not None:
            nominal_axis = self.package.coefficients.axes[next(iter(self.package.columns))].nominal_axis
            return pitch_by_inverse(self.package.model, nominal_axis, output, sensors[0], outputs[:, 0])
        if self.package.is_of_sting:
            alone = angles_from_sting(sensors, outputs, self.package.together(sensors))
            return replace(alone, codes=alone.codes | np.uint32(flag_codes.NO_ROLL))
        turned = self.package.in_model_axes(sensors)
        found = unbent(turned, outputs, self._geometry(sensors, readings))
        if len(turned) == 3:
            name_suspects_of(turned, found.codes, outputs.T)
        return found

    def _angles_of_two(
        self, sting: Package, model: Package, gravity_relative_u: float, readings: Mapping[str, FloatArray]
    ) -> SpreadAngles:
        first, second = (package.sensors(readings, self.reading_sd_v) for package in (sting, model))
        outputs = sting.outputs_v(first, readings), model.outputs_v(second, readings)
        together = sting.together(first), model.together(second)
        return angles_from_packages(first, second, *outputs, together, gravity_relative_u=gravity_relative_u)

    def _geometry(
        self, sensors: Sequence[CalibratedSensor], readings: Mapping[str, FloatArray]
    ) -> Callable[[FloatArray], Angles]:
        together = self.package.errors_together(sensors)
        if len(sensors) == 3:
            turned = self.package.in_model_axes(sensors)
            return lambda outputs: pitch_roll_from_three(turned, outputs, together)
        if len(sensors) == 2:
            return lambda outputs: pitch_roll_from_two(
                sensors, outputs, upright=self.upright, right_wing_down=self.right_wing_down, package=together
            )
        roll_rad = self._known_roll_rad(readings)
        return lambda outputs: pitch_with_known_roll(sensors[0], outputs[:, 0], roll_rad)

    def _known_roll_rad(self, readings: Mapping[str, FloatArray]) -> FloatArray:
        """Return the (N,) roll that one axis alone needs; zero where nothing states it, or the model has none."""
        if "roll_deg" in readings and self.package.states_roll:
            return np.deg2rad(readings["roll_deg"])
        return np.zeros(readings[next(iter(self.package.columns.values()))].size)

    def _beyond(self, found: AttitudeColumns | Angles | SpreadAngles) -> flag_codes.AnswerCodes:
        """Return the codes of angles at which a set is used beyond its calibration."""
        yaw_deg = _DEG_PER_RAD * found.yaw_rad if isinstance(found, SpreadAngles) else None
        codes: flag_codes.AnswerCodes = np.zeros(found.codes.size, dtype=np.uint32)
        for package in self._packages:
            roll_deg = _DEG_PER_RAD * found.roll_rad if senses_roll_within(package.coefficients) else None
            codes = codes | codes_of_angles(package.coefficients, _DEG_PER_RAD * found.pitch_rad, yaw_deg, roll_deg)
        return codes

    @cached_property
    def _packages(self) -> tuple[Package, ...]:
        return (self.package,) if self.model_package is None else (self.package, self.model_package)

    @cached_property
    def _checks_roll(self) -> bool:
        """Whether an answer has codes of roll, which is not valid all round."""
        return any(senses_roll_within(package.coefficients) for package in self._packages)


def inference(
    package: Package,
    model_package: Package | None = None,
    reading_sd_v: float | None = None,
    *,
    upright: bool = True,
    right_wing_down: bool = True,
    intervals: bool = False,
) -> Inference:
    """Return the inference that the sets allow. Raises: OutsideValidity where they allow none."""
    if reading_sd_v is not None and not (np.isfinite(reading_sd_v) and reading_sd_v >= 0.0):
        raise OutsideValidity(f"standard deviation of a reading: got {reading_sd_v!r} V, allowed 0 V or more")
    _check_axes(package)
    name, model, axes = package.coefficients.sensor, package.model, len(package.columns)
    form = package.coefficients.axes[next(iter(package.columns))].form
    if form.unit == "dps":
        raise OutsideValidity(
            f"{name}: gyros sense rates, not attitude: nothing was computed; integrate them with ams.load_gyros"
        )
    if form.unit != "g":
        raise OutsideValidity(
            f"{name}: senses {printed(form.unit)}, which tells no attitude by itself; nothing was computed; "
            "ams.sensed_level gives the quantity itself"
        )
    output = form.output
    if output is not None and output.pitch_rad is None:
        raise OutsideValidity(f"{name}: model {model}: brings no inverse: angles cannot be told; nothing was computed")
    tells_pitch = output is not None or not package.states_roll
    needed = 3 if package.is_of_sting else 1 if tells_pitch else axes
    if axes != needed:
        raise OutsideValidity(
            f"{name}: model {model}: got {axes} axes, needed {needed}; nothing was computed; name the axes to use"
        )
    if axes == 1 and package.coefficients.axes[next(iter(package.columns))].nominal_axis != "x":
        raise OutsideValidity(
            f"{name}: one axis tells pitch only where it lies along x: got {next(iter(package.columns))}; nothing was "
            "computed; use the x axis, or two axes"
        )
    if model_package is not None:
        _check_pair(package, model_package)
    return Inference(package, model_package, reading_sd_v, upright, right_wing_down, intervals)


def _check_axes(package: Package) -> None:
    unknown = [axis for axis in package.columns if axis not in package.coefficients.axes]
    if unknown or not package.columns:
        raise OutsideValidity(
            f"{package.coefficients.sensor}: axis {', '.join(unknown) or 'none'}: the set has "
            f"{', '.join(package.coefficients.axes)}; nothing was computed; name axes of the set"
        )


def _check_pair(sting: Package, model: Package) -> None:
    _check_axes(model)
    if not sting.is_of_sting or not model.follows_sting or len(model.columns) != 3:
        raise OutsideValidity(
            f"two packages: got {sting.model} and {model.model} with {len(model.columns)} axes, needed a sting package "
            "and a model package of three axes each; nothing was computed"
        )
