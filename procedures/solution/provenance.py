"""What a coefficient set says about where it comes from, read out of the journal's header, the rig and the dwells."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from ams.arrays import FloatArray
from ams.frames import body_rates_rad_s, wrap_deg
from ams.models.possible_temperature import impossible_temperatures
from ams.sets.provenance import Provenance, Standard, level_ranges
from ams.sets.sensed_quantity import FIELDS
from procedures.journal.audit.audit_trail import missing_in
from procedures.journal.audit.known_devices import dwells_by_device
from procedures.records.dwells import DwellRecord, measured_again
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from procedures.solution.type_b import gravity_of
from rig.description.rig_file import RigDescription, Sensor

LARGEST_STEP_DEG = 120.0
ROUND_WITHIN = 1.001
"""What is read back is not to the last digit what was asked for."""
UNCERTAINTIES = ("uncertainty_arcsec", "uncertainty_v", "uncertainty_degc", "uncertainty_ohm")


def provenance_of(solved: SolvedSensor, record: RunRecord) -> Provenance:
    """Return everything of a set but the numbers.

    ``created_utc`` is when the last dwell ended: the same run gives the same set.
    """
    rig, plan, rows = record.rig, record.plan, solved.observations
    sensor = plan.sensors[solved.name]
    temperatures, gravity = rows.temperature_degc, gravity_of(rig)
    return Provenance(
        sensor=solved.name,
        gravity_mps2=gravity.value_mps2,
        gravity_source=gravity.source,
        gravity_uncertainty_mps2=gravity.standard_uncertainty_mps2,
        pitch_range_deg=pitch_range_deg(np.rad2deg(rows.pitch_rad)),
        roll_range_deg=roll_range_deg(np.rad2deg(rows.roll_rad)),
        yaw_range_deg=_yaw_range(solved),
        rate_range_dps=_rate_range(solved),
        level_ranges={} if solved.calibration is None else level_ranges(solved.calibration),
        created_utc=record.measured_utc,
        software_version=record.versions["calrig"],
        rig=rig.rig.name,
        procedure=plan.title,
        simulated=record.is_simulated,
        temperature_range_degc=_temperature_range(sensor, temperatures),
        temperature_recorded=temperatures is not None,
        serial=solved.name,
        sensor_model=sensor.model,
        operator=record.operator,
        run_id=record.run_id,
        journal_sha256=record.hashes["journal content"],
        approved_by=_approved_by(record),
        environment=_environment(record.dwells),
        standards=tuple(standards_pointed_to(rig)),
        mount=sensor.mount.model_dump(mode="json"),
        temperature_conversion=sensor.temperature.model_dump(mode="json") if sensor.temperature else None,
        chain={name: rig.chain[name].model_dump(mode="json", exclude_none=True) for name in _chained(sensor, rig)},
        readouts=_readouts(sensor, record),
        supplies=_supplies(sensor, record),
        dwells=_dwells(record),
        replaced_devices=_replaced(sensor, record),
        **declared_tables(rig),
    )


def declared_tables(rig: RigDescription) -> dict[str, Any]:
    """Return the tables of a rig file that a set has as they are declared, by the names of its provenance."""
    return {
        "level": rig.level.model_dump(mode="json", exclude_none=True),
        "job": rig.job.model_dump(mode="json", exclude_none=True, exclude=None if rig.job.fields else {"fields"}),
        "acceptance": rig.acceptance.model_dump(mode="json", exclude_none=True),
        "laboratory": rig.laboratory.model_dump(mode="json", exclude_none=True) if rig.laboratory else None,
    }


def _approved_by(record: RunRecord) -> str | None:
    """Return who approved the set, or None.

    An approval counts only where nothing was missing for a calibration when the run began; twins need nothing.
    """
    lacks = not record.is_simulated and bool(missing_in(record.events))
    return None if lacks else record.rig.approved_by


def _chained(sensor: Sensor, rig: RigDescription) -> list[str]:
    """Return the channels of this sensor whose chain is declared."""
    thermometer = [] if sensor.temperature is None else [sensor.temperature.channel]
    return [channel for channel in [*sensor.channels.values(), *thermometer] if channel in rig.chain]


def _temperature_range(sensor: Sensor, measured_degc: FloatArray | None) -> tuple[float, float] | None:
    """Return where the set is valid: the range of use that is declared, else the span measured; None without either."""
    if sensor.use_temperature_degc is not None:
        return sensor.use_temperature_degc
    return None if measured_degc is None else _range(measured_degc)


def _range(values: np.ndarray[Any, np.dtype[np.float64]]) -> tuple[float, float]:
    """Return the ends rounded to what a file states: degrees went through radians."""
    return round(float(values.min()), 9), round(float(values.max()), 9)


def roll_range_deg(values_deg: FloatArray) -> tuple[float, float]:
    """Return the span of the roll angles; all round where they go round.

    The span is what the widest gap of the circle leaves, however angles are counted: 320° to 40° is −40° to 40°, and
    one across 180° ends above it. Angles in steps of 30° all round leave no gap wider than the others: what lies in it
    is as well covered as what lies in any other. Three angles at least, since less tell no sine and cosine.
    """
    angles_deg = np.unique(np.round(_wrapped_deg(values_deg), 9))
    gaps_deg = np.diff(angles_deg, append=angles_deg[0] + 360.0)
    last = int(gaps_deg.argmax())
    if gaps_deg[-1] * ROUND_WITHIN >= gaps_deg[last]:
        last = angles_deg.size - 1
    widest_deg = float(np.delete(gaps_deg, last).max(initial=0.0)) * ROUND_WITHIN
    if gaps_deg[last] <= min(widest_deg, LARGEST_STEP_DEG * ROUND_WITHIN):
        return -180.0, 180.0
    low_deg = float(angles_deg[(last + 1) % angles_deg.size])
    return low_deg, round(low_deg + 360.0 - float(gaps_deg[last]), 9)


def pitch_range_deg(values_deg: FloatArray) -> tuple[float, float]:
    """Return the span of pitch or yaw angles, counted within ±180° as they are inferred: 350° is −10°."""
    return _range(_wrapped_deg(values_deg))


def _wrapped_deg(values_deg: FloatArray) -> FloatArray:
    return np.where(np.abs(values_deg) > 180.0, wrap_deg(values_deg), values_deg)


def _yaw_range(solved: SolvedSensor) -> tuple[float, float] | None:
    """Return the range of yaw; None where the model has none."""
    yaw_rad = solved.observations.yaw_rad
    if yaw_rad is None or solved.calibration is None or solved.calibration.convention == "TP":
        return None
    return pitch_range_deg(np.rad2deg(yaw_rad))


def _rate_range(solved: SolvedSensor) -> tuple[float, float] | None:
    """Return the range of angular velocity along the package's axes; None where the model senses no rate."""
    rows, calibration = solved.observations, solved.calibration
    form = None if calibration is None else FIELDS.get(calibration.model)
    if form is None or not form.senses_rates or rows.euler_rate_rad_s is None or rows.yaw_rad is None:
        return None
    euler = np.stack([rows.pitch_rad, rows.yaw_rad, rows.roll_rad], axis=-1)
    return _range(np.rad2deg(body_rates_rad_s(euler, rows.euler_rate_rad_s)))


def _environment(dwells: Iterable[DwellRecord]) -> dict[str, dict[str, float]]:
    """Return environment name to mean, lowest and highest temperature over the accepted dwells.

    What no sensor stands is of a thermometer, not of the air.
    """
    read: dict[str, list[float]] = {}
    for dwell in dwells:
        for name, value in dwell.temperature_degc.items() if dwell.accepted else ():
            if not impossible_temperatures(np.array(value)):
                read.setdefault(name, []).append(value)
    return {
        name: {"mean_degc": float(np.mean(values)), "min_degc": min(values), "max_degc": max(values)}
        for name, values in read.items()
    }


def _readouts(sensor: Sensor, record: RunRecord) -> dict[str, dict[str, Any]]:
    """Return what read the outputs of a sensor, by name; a sensor that sends by itself was read by none."""
    rig = record.rig
    scanners, found = rig.scanners_behind(sensor), dict[str, dict[str, Any]]()
    for axis, channel in sensor.channels.items():
        name = channel.partition(".")[0]
        if name in rig.readouts:
            entry = found.setdefault(name, {"driver": rig.readouts[name].driver, "axes": [], "scanned": False})
            entry["axes"].append(str(axis))
    for name, entry in found.items():
        if held := record.tenures.get(f"readouts.{name}"):
            entry["identity"] = held[0].identity
        if name in scanners:
            entry["scanned"] = True
            if scanners[name].crosstalk_ratio is not None:
                entry["crosstalk_ratio"] = scanners[name].crosstalk_ratio
    return found


def _replaced(sensor: Sensor, record: RunRecord) -> list[dict[str, object]] | None:
    """Return every device that measured in the place of the one that a run began with; None where none did.

    Of readouts and streams those that the numbers of this sensor rest on, with what they were ``used_for``.
    """
    read_for = _read_for(sensor, record)
    found: list[dict[str, object]] = []
    for device, held in record.tenures.items():
        table, _, name = device.partition(".")
        is_read = table in ("readouts", "streams")
        if is_read and name not in read_for:
            continue
        used_for = {"used_for": read_for[name]} if is_read else {}
        others = list(dwells_by_device(held).items())[1:]
        found += [{"device": device, "identity": who, "dwells": dwells, **used_for} for who, dwells in others]
    return found or None


def _read_for(sensor: Sensor, record: RunRecord) -> dict[str, list[str]]:
    """Return, by readout or stream, what of this sensor it told: outputs, temperature, supply, attitude."""
    chain, reference = record.rig.chain, record.plan.attitude_reference
    supplies = (chain[channel].supply_channel for channel in _chained(sensor, record.rig))
    roles: dict[str, Iterable[str | None]] = {
        "outputs": sensor.channels.values(),
        "temperature": () if sensor.temperature is None else (sensor.temperature.channel,),
        "supply": supplies,
        "attitude": () if reference is None else reference.channels.values(),
    }
    found: dict[str, list[str]] = {}
    for role, channels in roles.items():
        for name in dict.fromkeys(channel.partition(".")[0] for channel in channels if channel is not None):
            found.setdefault(name, []).append(role)
    return found


def _supplies(sensor: Sensor, record: RunRecord) -> dict[str, dict[str, float]]:
    """Return the volts of the sensor's supplies over the accepted dwells, by channel."""
    named = (record.rig.chain[channel].supply_channel for channel in _chained(sensor, record.rig))
    found = {}
    for channel in dict.fromkeys(name for name in named if name is not None):
        read = [row.readings[channel].mean for row in record.dwells if row.accepted and channel in row.readings]
        volts = [value for value in read if np.isfinite(value)]
        if volts:
            found[channel] = {"mean_v": float(np.mean(volts)), "min_v": min(volts), "max_v": max(volts)}
    return found


def standards_pointed_to(rig: RigDescription) -> Iterable[Standard]:
    """Yield the standards that a device or a resistor of this rig points to, each once."""
    used_for: dict[str, list[str]] = {}
    for device, standard in _pointing(rig):
        if standard is not None:
            used_for.setdefault(standard, []).append(device)
    for name, devices in used_for.items():
        declared = rig.standards[name]
        stated = {key: getattr(declared, key) for key in UNCERTAINTIES if getattr(declared, key) is not None}
        yield Standard(
            name=name,
            serial=declared.serial,
            certificate=declared.certificate,
            due=declared.due,
            uncertainty={**stated, "kind": declared.kind, "k": declared.k},
            used_for=tuple(devices),
        )


def _pointing(rig: RigDescription) -> Iterable[tuple[str, str | None]]:
    """Yield what may point to a standard, by its table and name, with the standard it points to."""
    yield from ((f"axes.{name}", axis.standard) for name, axis in rig.axes.items())
    yield from ((f"readouts.{name}", readout.standard) for name, readout in rig.readouts.items())
    yield from ((f"environment.{name}", chamber.standard) for name, chamber in rig.environment.items())
    yield from ((f"chain.{name}", chain.standard) for name, chain in rig.chain.items())
    yield from ((f"streams.{name}", stream.standard) for name, stream in rig.streams.items())
    yield from ((f"field.{name}", coil.standard) for name, coil in rig.field.items())
    if rig.attitude_reference is not None:
        yield "attitude_reference", rig.attitude_reference.standard
    yield "level", rig.level.standard


def _dwells(record: RunRecord) -> dict[str, Any]:
    """Return how many dwells a run measured, at reference attitudes among them, and each that does not count."""
    rejected = [
        {
            "purpose": dwell.purpose,
            "replication": dwell.replication,
            "point": dwell.point,
            "attempt": dwell.attempt,
            "reasons": list(dwell.reasons),
            "measured_again": is_repeated,
        }
        for dwell, is_repeated in zip(record.dwells, measured_again(record.dwells), strict=True)
        if not dwell.accepted
    ]
    beside = sum(dwell.purpose != "design" for dwell in record.dwells)
    return {"measured": len(record.dwells), "reference_visits": beside, "rejected": rejected}
