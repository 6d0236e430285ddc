"""Which sets become which angles: accelerometers alone, gyros alone, or both together."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Final, Literal

from cyclopts import Parameter

from ams.attitude.earth_rate import EarthRate
from ams.errors import OutsideValidity
from ams.inference.gyros.aided_rates import AidedAngles, Aiding
from ams.inference.gyros.field_aid import FieldAid
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.monitored import MonitoredAngles
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.inference import Package
from ams.inference.rows.angle_stream import AngleStream
from ams.inference.rows.averaged import AveragedAngles
from ams.inference.rows.low_passed import LowPassedAngles, LowPassWish
from ams.inference.rows.stated_rate import StatedRate
from ams.inputs.csv_table import Remedies
from procedures.cli.attitude.package_file import package_of
from procedures.cli.attitude.rig_stream import StreamWiring
from procedures.errors import RequestError

OF_FIELD: Final = ("magnetometers", "magnetometer_axis", "field_ut", "field_sd_ut")
OF_AIDING: Final = (
    "accelerometers",
    "accelerometer_axis",
    "force_sd_g",
    "bias_walk_dps_per_sqrt_s",
    "zero_sd_dps",
    *OF_FIELD,
)
DEFAULT_AGREEMENT_DEG: Final = 0.1
REMEDIES: Final = Remedies(
    not_done="nothing was computed",
    column="--axis AXIS=COLUMN; --model-axis, --gyro-axis, --accelerometer-axis, --magnetometer-axis for those of the "
    "other sets",
    separators="",
)
"""What refusals of files and streams say."""
Named = Annotated[list[str] | None, Parameter(negative=())]


@Parameter(name="*")
@dataclass(frozen=True)
class OfSamples:
    """What is done to samples before they become angles."""

    rate_hz: float | None = None
    """Gyros, filter and averages: samples a second; by default what the column time_s tells."""
    low_pass_hz: float | None = None
    """Filter every output first, Chebyshev type I with this cut-off; its delay is taken off, unsettled rows told."""
    low_pass_order: int | None = None
    """Order of that filter; by default 4."""
    low_pass_ripple_db: float | None = None
    """Ripple in its pass band; by default 0.1 dB."""
    average_s: float | None = None
    """Accelerometers: average the outputs over windows of this length, one answer a window with its time_s."""

    def sampled_at(self, rate_hz: float, *, is_needed: bool) -> "OfSamples":
        """Return the same with a stream's own rate, where a rate is needed and none is stated."""
        uses = is_needed or self.low_pass_hz is not None or self.average_s is not None
        return replace(self, rate_hz=rate_hz) if uses and self.rate_hz is None else self

    def refuse_idle_rate(self) -> None:
        """Refuse a rate where accelerometers are neither filtered nor averaged. Raises: RequestError."""
        if self.rate_hz is not None and self.low_pass_hz is None and self.average_s is None:
            raise RequestError(
                "--rate-hz: belongs to a set of gyros, to --low-pass-hz or to --average-s: accelerometers at rest are "
                "answered row by row"
            )

    def held_to(self, found: AngleStream) -> AngleStream:
        """Return the angles with the stated rate held against the times of their rows, where there is one."""
        return found if self.rate_hz is None else StatedRate(found, self.rate_hz)

    def before(self, found: AngleStream) -> AngleStream:
        """Return the angles of filtered and averaged samples. Raises: RequestError, OutsideValidity."""
        for name in ("low_pass_order", "low_pass_ripple_db"):
            if getattr(self, name) is not None and self.low_pass_hz is None:
                raise RequestError(f"--{name.replace('_', '-')}: belongs to --low-pass-hz, which is missing")
        if self.average_s is not None:
            found = AveragedAngles(found, self.average_s, self.rate_hz)
        if self.low_pass_hz is None:
            return found
        wish = LowPassWish(self.low_pass_hz)
        order, ripple_db = self.low_pass_order, self.low_pass_ripple_db
        return LowPassedAngles(
            found,
            LowPassWish(
                wish.cutoff_hz,
                wish.order if order is None else order,
                wish.ripple_db if ripple_db is None else ripple_db,
            ),
            self.rate_hz,
        )


@Parameter(name="*")
@dataclass(frozen=True)
class OfGyros:
    """What belongs to a set of gyros, and to no other."""

    interpolation: Literal["cubic", "linear", "hold"] | None = None
    """Gyros: how the rate runs from sample to sample; by default cubic."""
    method: Literal["quaternion", "butcher"] | None = None
    """Gyros: by turns of the quaternion (the default), or Euler's angles by Butcher's method as CR does."""
    start_deg: Annotated[tuple[float, float, float] | None, Parameter(negative=())] = None
    """Gyros: pitch, yaw and roll at the first sample; by default 0 0 0, with accelerometers what gravity says."""
    start_sd_deg: float | None = None
    """Gyros: standard deviation of the start."""
    rest_s: float | None = None
    """Gyros: seconds at the beginning over which nothing turns; the mean of the outputs is then their zero."""
    latitude_deg: float | None = None
    """Gyros: take the Earth's turn off, at this latitude (north positive)."""
    heading_deg: float | None = None
    """Gyros: with the latitude, where x points at zero yaw, degrees from north through east."""
    accelerometers: Path | None = None
    """Gyros: the set of accelerometers in the same package; its columns are accelerometer_x_v and so on."""
    accelerometer_axis: Named = None
    """AXIS=COLUMN for the accelerometers."""
    force_sd_g: float | None = None
    """With accelerometers: standard deviation of one component of the force, vibration included; by default 0.005 g."""
    bias_walk_dps_per_sqrt_s: float | None = None
    """With accelerometers: how far the zero of a gyro wanders in a second; by default 0.0001 °/s."""
    zero_sd_dps: float | None = None
    """With accelerometers: standard deviation of what the zero of a gyro has gone since its calibration; by default as
    the set counts it, else 0.1 °/s. A rest measures it."""
    magnetometers: Path | None = None
    """With accelerometers: the set of magnetometers in the same package; its columns are magnetometer_x_ut and so on.
    Yaw then rests on the field."""
    magnetometer_axis: Named = None
    """AXIS=COLUMN for the magnetometers."""
    field_ut: Annotated[tuple[float, float, float] | None, Parameter(negative=())] = None
    """With magnetometers: the field where they are used, µT along x at zero yaw, to the right and down."""
    field_sd_ut: float | None = None
    """With magnetometers: standard deviation of what disturbance and the stated field make of one component, the same
    in all rows; by default 0.5 µT. What the set leaves open is added."""
    gyro_set: Path | None = None
    """Accelerometers: the set of gyros beside them, columns gyro_x_v and so on; the answers are compared."""
    gyro_axis: Named = None
    """AXIS=COLUMN for these gyros."""
    agreement_deg: float | None = None
    """With --gyro-set: flag rows that differ by more than this beyond what both uncertainties explain; else 0.1."""

    def refuse_for(self, model: str) -> None:
        """Refuse what belongs to gyros where there are none. Raises: RequestError."""
        given = [name for name, value in vars(self).items() if value is not None]
        if given:
            raise RequestError(f"--{given[0].replace('_', '-')}: belongs to a set of gyros, got the model {model}")


def monitored(
    found: AngleStream, model: str, settings: OfGyros, rate_hz: float | None, wiring: StreamWiring | None = None
) -> AngleStream:
    """Return the angles of accelerometers compared with those of gyros, where these are named. Raises: RequestError."""
    if settings.gyro_set is None:
        for name in ("gyro_axis", "agreement_deg"):
            if getattr(settings, name) is not None:
                raise RequestError(f"--{name.replace('_', '-')}: belongs to --gyro-set, which is missing")
        settings.refuse_for(model)
        return found
    for name in OF_AIDING:
        if getattr(settings, name) is not None:
            raise RequestError(f"--{name.replace('_', '-')}: belongs to the filter, not to --gyro-set")
    gyros = package_of(settings.gyro_set, settings.gyro_axis, "--gyro-axis", "gyro_", wiring=wiring)
    limit_deg = DEFAULT_AGREEMENT_DEG if settings.agreement_deg is None else settings.agreement_deg
    return MonitoredAngles(found, angles_of_gyros(gyros, None, settings, rate_hz), limit_deg)


def used_at(package: Package, gravity_mps2: float | None, uncertainty_mps2: float | None) -> Package:
    """Return a package at the g where it is used. Raises: OutsideValidity."""
    return replace(package, site_gravity_mps2=gravity_mps2, site_gravity_uncertainty_mps2=uncertainty_mps2)


def _earth_rate(settings: OfGyros) -> EarthRate | None:
    if (settings.latitude_deg is None) != (settings.heading_deg is None):
        raise RequestError("--latitude-deg, --heading-deg: the Earth's turn needs both; give both or none")
    if settings.latitude_deg is None or settings.heading_deg is None:
        return None
    return EarthRate(settings.latitude_deg, settings.heading_deg)


def angles_of_gyros(
    package: Package,
    reading_sd_v: float | None,
    settings: OfGyros,
    rate_hz: float | None,
    gravity_mps2: float | None = None,
    wiring: StreamWiring | None = None,
) -> GyroAngles | AidedAngles:
    """Return what makes angles of gyros, with accelerometers where these are named.

    Raises: RequestError for an option that goes with accelerometers alone; OutsideValidity, SetError.
    """
    if reading_sd_v is not None and not reading_sd_v >= 0.0:
        raise OutsideValidity(f"standard deviation of a reading: got {reading_sd_v!r} V, allowed 0 V or more")
    gyros = GyroPackage(package.coefficients, package.columns, reading_sd_v)
    motion = Motion(
        rate_hz,
        settings.interpolation or "cubic",
        settings.start_deg,
        settings.start_sd_deg,
        settings.rest_s or 0.0,
        _earth_rate(settings),
        settings.method or "quaternion",
    )
    if settings.accelerometers is None:
        for name in OF_AIDING[1:]:
            if getattr(settings, name) is not None:
                raise RequestError(f"--{name.replace('_', '-')}: belongs to --accelerometers, which is missing")
        if gravity_mps2 is not None:
            raise RequestError("--gravity-mps2: belongs to accelerometers, got gyros alone")
        return GyroAngles(gyros, motion)
    if settings.interpolation is not None:
        raise RequestError("--interpolation: the filter takes the rate's mean over an interval; leave it out")
    accelerometers, pairs = settings.accelerometers, settings.accelerometer_axis
    force = package_of(accelerometers, pairs, "--accelerometer-axis", "accelerometer_", gravity_mps2, wiring)
    default = Aiding()
    walk, sd_g = settings.bias_walk_dps_per_sqrt_s, settings.force_sd_g
    aiding = Aiding(
        default.force_sd_g if sd_g is None else sd_g,
        default.bias_walk_dps_per_sqrt_s if walk is None else walk,
        settings.zero_sd_dps,
    )
    return AidedAngles(gyros, force, motion, aiding, _field_aid(settings, wiring))


def _field_aid(settings: OfGyros, wiring: StreamWiring | None) -> FieldAid | None:
    """Return the magnetometers beside a filter, where they are named. Raises: RequestError, OutsideValidity."""
    if settings.magnetometers is None:
        for name in OF_FIELD[1:]:
            if getattr(settings, name) is not None:
                raise RequestError(f"--{name.replace('_', '-')}: belongs to --magnetometers, which is missing")
        return None
    if settings.field_ut is None:
        raise RequestError(
            "--magnetometers: the field where they are used is missing: give --field-ut X Y Z, µT along x at zero yaw, "
            "to the right and down"
        )
    package = package_of(
        settings.magnetometers, settings.magnetometer_axis, "--magnetometer-axis", "magnetometer_", wiring=wiring
    )
    if settings.field_sd_ut is None:
        return FieldAid(package, settings.field_ut)
    return FieldAid(package, settings.field_ut, settings.field_sd_ut)
