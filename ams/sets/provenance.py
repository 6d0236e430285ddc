"""Where a set comes from and where it may be used: all that the numbers alone do not say."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, date, datetime

from ams.calibration_result import Calibration
from ams.errors import SetError
from ams.sets.canonical import Document, plain
from ams.sets.sensed_quantity import form_by_names
from ams.sets.stated_verdict import unsigned_status

NO_GRAVITY_STATED = "none was stated: standard gravity, on which nothing of this set depends"
"""Source of the gravity of a set that senses none, where nobody said any."""


@dataclass(frozen=True)
class Standard:
    """One standard the calibration rests on."""

    name: str
    """As declared in the rig file, ``standards.NAME``."""
    serial: str | None = None
    certificate: str | None = None
    due: date | None = None
    uncertainty: Mapping[str, object] | None = None
    """As declared: value with its unit in the key, kind, k."""
    used_for: tuple[str, ...] = ()
    """What points to it in the rig file, such as ``axes.pitch`` and ``environment.air``."""


@dataclass(frozen=True)
class Provenance:
    """Everything about a calibration that its solution does not know. Declared tables are carried as declared."""

    sensor: str
    """Name of the sensor in the rig file, such as ``SN1047``."""
    gravity_mps2: float
    """The local g that is the unit of acceleration."""
    gravity_source: str
    pitch_range_deg: tuple[float, float]
    """Where the set is valid, ends included."""
    roll_range_deg: tuple[float, float]
    """Where the set is valid; (0, 0) where roll was never varied; a whole circle is any range of 360°."""
    created_utc: datetime
    software_version: str
    rig: str
    procedure: str
    simulated: bool
    gravity_uncertainty_mps2: float = 0.0
    """Standard; 0: nobody declared it, and the set says none."""
    temperature_range_degc: tuple[float, float] | None = None
    temperature_recorded: bool | None = None
    """Whether a temperature was recorded with the readings; None: nobody said, and the set says nothing."""
    yaw_range_deg: tuple[float, float] | None = None
    """For models that know yaw."""
    rate_range_dps: tuple[float, float] | None = None
    """For gyros: of the angular velocity along each package axis."""
    level_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """For straight lines: ``level_x_ut`` and so on, what each axis was exposed to along its direction."""
    serial: str | None = None
    sensor_model: str | None = None
    operator: str | None = None
    run_id: str | None = None
    """None where the observations came from a file."""
    journal_sha256: str | None = None
    approved_by: str | None = None
    """None: everything drawn from the set is stamped 'engineering'."""
    environment: Mapping[str, object] = field(default_factory=dict)
    """What was measured while calibrating, such as ``{"air": {"mean_degc": 20.0, "min_degc": 19.8, …}}``."""
    standards: tuple[Standard, ...] = ()
    mount: Mapping[str, object] | None = None
    """Package axis to fixture axis, such as ``{"x": "+x", "y": "+y", "z": "+z", "datum": "face A"}``."""
    temperature_conversion: Mapping[str, object] | None = None
    """The sensor's own thermometer: ``{"channel": "dmm.t", "offset_degc": -273.15, "slope_degc_per_v": 100.0}``."""
    readouts: Mapping[str, object] | None = None
    """What read the outputs, by its name in the rig file: driver, ``identity``, the axes it read, whether through a
    scanner and with which ``crosstalk_ratio``; None where no rig was told, or nothing of it read them."""
    supplies: Mapping[str, object] | None = None
    """What was read of the supplies of the sensor while it was calibrated, such as
    ``{"dmm.supply": {"mean_v": 5.0, "min_v": 4.999, "max_v": 5.001}}``; empty where it has none that is read; None:
    nobody said."""
    readings: Mapping[str, object] | None = None
    """The ``file`` that the readings were handed over in, its ``sha256``, how many ``rows`` were solved, and
    ``day_stated_by`` whom; None of a run."""
    dwells: Mapping[str, object] | None = None
    """Of the run: how many were ``measured``, how many ``reference_visits`` are among them, and each that was
    ``rejected`` or taken back; None without a run.
    """
    replaced_devices: Sequence[Mapping[str, object]] | None = None
    """Devices that took the place of one of the rig while it was measured: ``device`` (its table, ``readouts.dmm``),
    ``identity``, how many ``dwells`` of the design each measured, and what a readout or a stream was ``used_for``
    (``outputs``, ``temperature``, ``supply``, ``attitude``); None where none did, or nobody said."""
    level: Mapping[str, object] | None = None
    chain: Mapping[str, object] | None = None
    job: Mapping[str, object] | None = None
    acceptance: Mapping[str, object] | None = None
    laboratory: Mapping[str, object] | None = None

    def __post_init__(self) -> None:
        if self.created_utc.tzinfo is None:
            raise SetError(
                f"{self.sensor}: provenance: created_utc has no time zone: got {self.created_utc.isoformat()}, "
                "needed is a time with its offset; nothing was built; pass an aware time"
            )
        _check_range(self.sensor, "pitch_range_deg", self.pitch_range_deg)
        _check_range(self.sensor, "roll_range_deg", self.roll_range_deg)
        for name in ("temperature_range_degc", "yaw_range_deg", "rate_range_dps"):
            limits = getattr(self, name)
            if limits is not None:
                _check_range(self.sensor, name, limits)
        for name, limits in self.level_ranges.items():
            _check_range(self.sensor, name, limits)


def _check_range(sensor: str, name: str, limits: tuple[float, float]) -> None:
    if not -float("inf") < limits[0] <= limits[1] < float("inf"):
        raise SetError(
            f"{sensor}: provenance: {name} is no range: got {limits[0]!r} to {limits[1]!r}, "
            "needed are two finite numbers, the lower first; nothing was built"
        )


def level_ranges(calibration: Calibration) -> dict[str, tuple[float, float]]:
    """Return what every straight line was exposed to along its axis, by its input; nothing for other models."""
    ranges = {}
    for axis in calibration.axes.values():
        form = form_by_names(axis.model, axis.primary_names)
        if form is None or not form.senses_level:
            continue
        primary = dict(zip(axis.primary_names, axis.primary.tolist(), strict=True))
        index = "xyz".index(axis.nominal_axis)
        # A fitted output turned round: whatever stood along the axis is in it, a field beside the coil as well.
        levels = (axis.fitted_v - primary[form.offset]) / primary[form.directions[index]]
        ranges[form.inputs[index]] = (round(float(levels.min()), 9), round(float(levels.max()), 9))
    return ranges


def utc_text(moment: datetime) -> str:
    """Return a moment as ISO 8601 in UTC, such as ``2026-03-01T06:20:00+00:00``."""
    return moment.astimezone(UTC).isoformat()


def origin_sections(provenance: Provenance, verdict: str) -> Document:
    """Return the document's sections before the coefficients: who calibrated and with what right.

    ``verdict``: of the calibration; who approved the rig has not approved one that is not usable.
    """
    u_mps2 = provenance.gravity_uncertainty_mps2
    return {
        "sensor": {
            "name": provenance.sensor,
            "serial": provenance.serial,
            "model": provenance.sensor_model,
        },
        "status": unsigned_status("approved" if provenance.approved_by else "engineering", verdict),
        "approved_by": provenance.approved_by,
        "simulated": provenance.simulated,
        "acceleration_unit": {
            "name": "local g",
            "value_mps2": float(provenance.gravity_mps2),
            "source": provenance.gravity_source,
            **({"standard_uncertainty_mps2": float(u_mps2)} if u_mps2 > 0.0 else {}),
        },
        "validity": {
            "pitch_deg": plain(provenance.pitch_range_deg, "pitch_range_deg"),
            "roll_deg": plain(provenance.roll_range_deg, "roll_range_deg"),
            "temperature_degc": plain(provenance.temperature_range_degc, "temperature_range_degc"),
            **_further_ranges(provenance),
        },
    }


def _further_ranges(provenance: Provenance) -> Document:
    ranges = {"yaw_deg": provenance.yaw_range_deg, "rate_dps": provenance.rate_range_dps}
    known = {name: limits for name, limits in ranges.items() if limits is not None}
    return {name: plain(limits, name) for name, limits in {**known, **provenance.level_ranges}.items()}


def record_sections(provenance: Provenance) -> Document:
    """Return the document's sections after the coefficients: how they came about."""
    declared = ("mount", "level", "chain", "job", "acceptance", "laboratory")
    recorded = provenance.temperature_recorded
    return {
        "environment": plain(provenance.environment, "environment"),
        **({} if recorded is None else {"temperature_recorded": recorded}),
        "provenance": {
            "rig": provenance.rig,
            "procedure": provenance.procedure,
            "operator": provenance.operator,
            "run_id": provenance.run_id,
            "journal_sha256": provenance.journal_sha256,
            "software_version": provenance.software_version,
            "created_utc": utc_text(provenance.created_utc),
            "standards": [_standard_document(standard) for standard in provenance.standards],
            **{name: plain(getattr(provenance, name), name) for name in declared},
            **{
                name: plain(stated, name)
                for name in ("readouts", "supplies", "readings", "dwells", "replaced_devices")
                if (stated := getattr(provenance, name)) is not None
            },
        },
    }


def _standard_document(standard: Standard) -> Document:
    return {
        "name": standard.name,
        "serial": standard.serial,
        "certificate": standard.certificate,
        "due": plain(standard.due, "due"),
        "uncertainty": plain(standard.uncertainty, "uncertainty"),
        **({"used_for": list(standard.used_for)} if standard.used_for else {}),
    }
