"""A coefficient set from a fit: what the file and the command say about where the numbers come from."""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ams.calibration_result import Calibration
from ams.exports.formats import export_set
from ams.frames import body_rates_rad_s
from ams.gravity import Gravity
from ams.models.convert import STANDARD_GRAVITY_MPS2
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.sets.provenance import NO_GRAVITY_STATED, Provenance, Standard, level_ranges
from ams.sets.stated_findings import DAY_NOT_KNOWN
from procedures.errors import RequestError
from procedures.solution.provenance import declared_tables, pitch_range_deg, roll_range_deg, standards_pointed_to
from procedures.solution.type_b import gravity_of
from rig.description.rig_file import RigDescription

ROUNDING_DIGITS = 9
OF_TODAY: Final = (
    f"{DAY_NOT_KNOWN}: the set has the day on which they were solved (--calibrated-on of calrig fit, or a column "
    "started_utc, tells it)"
)


@dataclass(frozen=True)
class WishedSet:
    """What the command says about the set it asks for."""

    path: Path
    sensor: str
    gravity: Gravity | None
    """None: not stated, and the model senses none."""
    rig: str
    standards: tuple[Standard, ...] = ()
    declared: Mapping[str, Any] = field(default_factory=dict)
    """The level, the job and what else the rig file declares of a calibration; nothing without one."""
    measured_utc: datetime | None = None
    """When the readings were taken; None where nothing says it."""
    use_degc: tuple[float, float] | None = None
    """Temperatures that the sensor is to be used at, as the rig file declares them."""
    readings: Mapping[str, object] = field(default_factory=dict)
    """The ``file`` they are in, its ``sha256``, and ``day_stated_by`` whom."""


def wished_set(
    path: Path,
    sensor: str | None,
    gravity_mps2: float | None,
    rig: RigDescription | None,
    measured_utc: datetime | None,
    *,
    senses_gravity: bool,
) -> WishedSet:
    """Return the set that is to be written; ``senses_gravity``: whether the model's coefficients are per local g.

    ``measured_utc``: when the readings were taken; None where nothing says it.

    Raises: RequestError where the command does not say what a set must know.
    """
    if path.suffix != ".json":
        raise RequestError(f"--set {path}: a set is a JSON file: give a name that ends in .json")
    if not sensor:
        raise RequestError("--sensor is missing: --set needs the sensor's name, such as --sensor SN1047")
    if rig is None and gravity_mps2 is None and senses_gravity:
        raise RequestError(
            "--gravity-mps2 is missing: --set states the local gravity of the calibration: give it, or --rig RIG"
        )
    if rig is not None and gravity_mps2 is not None:
        raise RequestError("--gravity-mps2: the rig file states gravity already; give one of the two")
    if rig is not None:
        return WishedSet(
            path,
            sensor,
            gravity_of(rig),
            rig.rig.name,
            tuple(standards_pointed_to(rig)),
            {**declared_tables(rig), "sensor_model": rig.sensors[sensor].model},
            measured_utc,
            rig.sensors[sensor].use_temperature_degc,
        )
    if gravity_mps2 is None:
        return WishedSet(path, sensor, None, "", measured_utc=measured_utc)
    if not 9.7 <= gravity_mps2 <= 9.9:
        raise RequestError(f"--gravity-mps2: got {gravity_mps2:g} m/s², allowed 9.7 to 9.9 m/s²")
    stated = Gravity(gravity_mps2, 0.0, "stated on the command line")
    return WishedSet(path, sensor, stated, "", measured_utc=measured_utc)


def of_readings(wish: WishedSet, file: Path, stated_day: str | None) -> WishedSet:
    """Return the wish with the file that its readings are in; ``stated_day``: that of the command.

    Raises: RequestError where the file cannot be read.
    """
    try:
        with file.open("rb") as content:
            sha256 = hashlib.file_digest(content, "sha256").hexdigest()
    except OSError as error:
        raise RequestError(
            f"{file}: cannot be read: {error.strerror or error}; nothing was solved; check the file and its rights"
        ) from error
    readings = {"file": file.name, "sha256": sha256}
    if wish.measured_utc is not None:
        readings["day_stated_by"] = "the file" if stated_day is None else "whoever solved it"
    return replace(wish, readings=readings)


def refuse_per_g(wish: WishedSet, units: Iterable[str]) -> None:
    """Refuse straight lines of accelerometers, in ``units`` of what they sense, without the gravity they are per."""
    if wish.gravity is None and "g" in units:
        raise RequestError(
            "--gravity-mps2 is missing: the levels are in g, and --set states the local gravity of the calibration: "
            "give it (a site's own; 9.7 to 9.9 m/s²)"
        )


def write_set(wish: WishedSet, observations: Observations, calibration: Calibration, rows: int | None = None) -> None:
    """Write the set whole, dated by its readings; where nothing says when, by today, which a remark tells.

    ``rows``: how many were solved, where the observations are not all of them.

    Raises: ams.errors.SetError.
    """
    if wish.measured_utc is None:
        calibration = replace(calibration, remarks=(*calibration.remarks, OF_TODAY))
    wish = replace(wish, readings={**wish.readings, "rows": rows or observations.rows})
    export_set(build_set(calibration, _provenance(wish, observations, calibration)), "json", wish.path)


def _provenance(wish: WishedSet, rows: Observations, calibration: Calibration) -> Provenance:
    rates = None
    if rows.euler_rate_rad_s is not None:
        yaw = np.zeros(rows.rows) if rows.yaw_rad is None else rows.yaw_rad
        euler = np.stack([rows.pitch_rad, yaw, rows.roll_rad], axis=-1)
        rates = _range(np.rad2deg(body_rates_rad_s(euler, rows.euler_rate_rad_s)))
    degc = None if rows.temperature_degc is None else _range(rows.temperature_degc)
    gravity = wish.gravity or Gravity(STANDARD_GRAVITY_MPS2, 0.0, NO_GRAVITY_STATED)
    return Provenance(
        sensor=wish.sensor,
        gravity_mps2=gravity.value_mps2,
        gravity_source=gravity.source,
        gravity_uncertainty_mps2=gravity.standard_uncertainty_mps2,
        pitch_range_deg=pitch_range_deg(np.rad2deg(rows.pitch_rad)),
        roll_range_deg=roll_range_deg(np.rad2deg(rows.roll_rad)),
        yaw_range_deg=_yaw_range(rows, calibration),
        rate_range_dps=rates,
        level_ranges=level_ranges(calibration),
        temperature_range_degc=wish.use_degc or degc,
        temperature_recorded=degc is not None,
        created_utc=wish.measured_utc or datetime.now(UTC),
        software_version=version("calrig"),
        rig=wish.rig,
        procedure=f"fit of {Path(rows.source).name}",
        simulated=False,
        serial=wish.sensor,
        standards=wish.standards,
        readings=wish.readings,
        **wish.declared,
    )


def _yaw_range(rows: Observations, calibration: Calibration) -> tuple[float, float] | None:
    return None if rows.yaw_rad is None or calibration.convention == "TP" else pitch_range_deg(np.rad2deg(rows.yaw_rad))


def _range(values: NDArray[Any]) -> tuple[float, float]:
    return round(float(values.min()), ROUNDING_DIGITS), round(float(values.max()), ROUNDING_DIGITS)
