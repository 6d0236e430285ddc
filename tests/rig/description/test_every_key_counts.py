"""No dead keys in ``rig.toml``: each, changed, changes a plan, a result, a page, a line on the wire or a refusal."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from _pytest.mark import ParameterSet
from file_keys import keys_of
from key_jobs import LOST_REPLY
from key_trials import REMOVED, Trial, marks_of, what_a_change_does

from rig.description.device_settings import AxisSettings
from rig.description.read import rig_form

FREE_TEXT = frozenset(
    {
        "rig.name",
        "rig.gravity_source",
        "sensors.*.mount.datum",
        "standards.*.serial",
        "standards.*.certificate",
        "level.instrument",
        "level.after.taken",
        "job.number",
        "job.customer",
        "job.customer_contact",
        "job.location",
        "job.item",
        "job.remarks",
        "laboratory.name",
        "laboratory.address",
        "laboratory.accreditation",
    }
)
"""Titles, names, addresses, remarks: printed as they are."""
PENDING: frozenset[str] = frozenset()
"""Keys that nothing uses yet: none."""
NEAR_TURIN = {"rig": {"latitude_deg": 45.5}}
NOISY = {"dwell": {"max_noise_factor": 1.001, "samples": 5}}
OUT_OF_BAND = {"interlocks": {"temperature": {"air": {"band_degc": [10.0, 25.0]}}}}
SUPPLY_OUT = {"interlocks": {"voltage": {"dmm.s": {"band_v": [9.0, 9.5]}}}}
BOTH_WATCHED = {"axes": {name: {"watchdog_s": 2.0} for name in ("pitch", "roll")}}
REFERENCE_OFF = {"twin": {"readouts": {"dmm": {"reference_error_v": 0.5}}}}
WARMING = {"twin": {"readouts": {"dmm": {"own_temperature_drift_degc_per_h": 300.0}}}}
AZ_THAT_TURNS = {
    "axes": {"roll": {"driver": "oriental-az", "axis": 1, "microstep_deg": None, "step_deg": 0.01}}
}  # fmt: skip
IN_A_THERMOTRON = {"environment": {"air": {"model": "thermotron-8800", "address": None}}}
LINES_THAT_TURN = {
    "axes": {"roll": {"driver": "rate-table", "axis": 1, "microstep_deg": None}}
}  # fmt: skip
SLIP = {"slip": {"line": "axes.pitch", "kind": "slip", "at_s": 60.0, "slip_deg": 0.05, "seen": True}}
AHRS_RAW = {
    "attitude_reference": None,
    "streams": {"ahrs": {"output": "YMR"}},
    "twin": {"streams": {"ahrs": {}}},
}
FIELD_IN_VOLTS = {
    "twin": {"truth": {"MicroMag3": {"x": {"reading": None, "offset_v": 0.0, "sensitivity_v_per_ut": 1.0}}}}
}
AT_PORTS = {
    "axes": {name: {"port": "socket://127.0.0.1:1"} for name in ("pitch", "roll")},
    "readouts": {"dmm": {"resource": "prologix+socket://127.0.0.1:7#22"}},
    "environment": {"air": {"port": "socket://127.0.0.1:2"}},
    "twin": {"control": "socket://127.0.0.1:3"},
}
INDEX_ERRORS = "angle_deg,error_arcsec,uncertainty_arcsec\n" + "".join(
    f"{angle},{5.0 if angle % 20 else -5.0},0.2\n" for angle in range(-720, 721, 10)
)
READ_FROM_A_TABLE = (
    "index_table.file",
    "index_table.angle_deg",
    "index_table.error_arcsec",
    "index_table.uncertainty_arcsec",
)
"""What the file holds that ``index_table`` names: nobody writes these into a rig file."""
BY_NAME = {
    "index_zero_deg": Trial(0.0),
    "index_table": Trial("errors.csv", files={"errors.csv": INDEX_ERRORS}),
    "resolution_deg": Trial(0.5),
    "wrap": Trial(True),
    "electronic_gear": Trial([2, 1]),
    "motor_direction": Trial(0),
    "values": Trial("degf"),
    "port": Trial("socket://127.0.0.1:1"),
    "identity": Trial("no such device"),
    "standard": Trial("second"),
    "limits_deg": Trial([-10.0, 10.0]),
    "limits_degc": Trial([-60.0, 15.0]),
    "arrival_tolerance_deg": Trial(0.1, faults=SLIP),
    "wrap_turns": Trial(1.0),
    "period_select": Trial(32, job="levels", at="mx"),
}
"""What drivers have in common, by the last part of the key."""
USED_WARM = {"sensors": {"SN1047": {"use_temperature_degc": [10.0, 35.0]}}}
NOT_MODELLED = {"solve": {"temperature": "none"}}
TRIALS = {
    "sensors.*.stage": Trial(["pitch", "yaw"], job="levels"),
    "sensors.*.use_temperature_degc": Trial([10.0, 35.0], job="table"),
    "sensors.*.largest_offset_tc_v_per_degc": Trial(1e-5, job="table", rig=USED_WARM, procedure=NOT_MODELLED),
    "sensors.*.largest_sensitivity_tc_per_degc": Trial(1e-5, job="table", rig=USED_WARM, procedure=NOT_MODELLED),
    "sensors.*.largest_offset_shift_v": Trial(1e-4),
    "sensors.*.largest_sensitivity_shift": Trial(1e-4),
    "sensors.*.largest_nonlinearity_v": Trial(1e-4),
    "sensors.*.largest_g_sensitivity_dps_per_g": Trial(0.1, job="rates"),
    "sensors.*.nominal_sensitivity_v_per_dps": Trial(0.1, job="rates"),
    "sensors.*.nominal_sensitivity_v_per_ut": Trial(0.1, job="levels"),
    "rig.gravity_mps2": Trial(9.81),
    "rig.latitude_deg": Trial(45.5, job="rates"),
    "rig.heading_deg": Trial(20.0, job="rates", rig=NEAR_TURIN),
    "rig.height_m": Trial(2000.0, job="rates", rig=NEAR_TURIN),
    "motion.together": Trial(True, job="indexing-table", rig={"motion": {"together": False}}),
    "reading.together": Trial(True, job="meters", rig={"reading": {"together": False}}),
    "axes.*:indexing-table.dialect": Trial("single-axis-0.0001deg"),
    "axes.*:maestro.points": Trial([[500.0, -181.0], [2500.0, 181.0]]),
    "axes.*:maestro.period_ms": Trial(12, rig={"axes": {name: {"model": "mini"} for name in ("pitch", "roll")}}),
    "axes.*:maestro.device_number": Trial(13),
    "axes.*:maestro.watchdog_s": Trial(3.0, rig=BOTH_WATCHED),
    "axes.*:pi-gcs.axis_id": Trial("ROT"),
    "readouts.*:hp3458a.cards": Trial({"1": "44472"}),
    "readouts.*:scpi-daq.cards": Trial({"1": "34902A"}),
    "axes.*:zaber.direction_uncertainty_arcsec": Trial(20.0, job="rates"),
    "axes.*:rate-table.dialect": Trial("acutronic-acutrol3000"),
    "axes.*:rate-table.top_rate_dps": Trial(20.0, job="rates", rig=LINES_THAT_TURN),
    "axes.*:rate-table.wrap_turns": Trial(0.1, job="rates", rig=LINES_THAT_TURN),
    "axes.*:oriental-az.top_rate_dps": Trial(20.0, job="rates", rig=AZ_THAT_TURNS),
    "axes.*:oriental-az.wrap_turns": Trial(0.1, job="rates", rig=AZ_THAT_TURNS),
    "axes.*:oriental-az.current_percent": Trial(50.0),
    "axes.*:oriental-az.home_end_bit": Trial(0),
    "axes.*:oriental-az.alarm_bit": Trial(5),
    "axes.*:oriental-az.watchdog_s": Trial(3.0, rig=BOTH_WATCHED),
    "axes.*:oriental-az.reply_timeout_s": Trial(2.0, faults={"lost": {**LOST_REPLY["lost"], "nth": [1]}}),
    "axes.*:oriental-az.watchdog_register": Trial(rig=BOTH_WATCHED),
    "axes.*:zaber.top_rate_dps": Trial(20.0, job="rates"),
    "axes.*:zaber.wrap_turns": Trial(0.1, job="rates"),
    "readouts.*:angle-meter.resource": Trial("socket://127.0.0.1:1"),
    "readouts.*:angle-meter.baud_rate": Trial(19200),
    "readouts.*:angle-meter.dialect": Trial("jewell-tuff-tilt"),
    "readouts.*:angle-meter.values": Trial("mrad"),
    "readouts.*:angle-meter.channels.*.about": Trial("roll"),
    "readouts.*:angle-meter.channels.*.value": Trial("y"),
    "readouts.*:angle-meter.channels.*.sign": Trial(-1),
    "readouts.*:angle-meter.channels.*.range_deg": Trial(5.0),
    "readouts.*:hp3458a.crosstalk_ratio": Trial(1e-5),
    "readouts.*:scpi-daq.crosstalk_ratio": Trial(1e-5),
    "readouts.*:hp3458a.terminals": Trial("rear"),
    "readouts.*:hp3458a.resource": Trial("prologix+socket://127.0.0.1:7#22"),
    "readouts.*:hp3458a.scanner_resource": Trial("prologix+socket://127.0.0.1:7#9"),
    "readouts.*:hp3458a.checks.action": Trial(rig=REFERENCE_OFF),
    "readouts.*:hp3458a.checks.temperature_step_degc": Trial(5.0, rig=WARMING),
    "readouts.*:scpi-daq.resource": Trial("socket://127.0.0.1:1"),
    "readouts.*:scpi-meter.resource": Trial("socket://127.0.0.1:1"),
    "readouts.*:scpi-meter.terminals": Trial("rear"),
    "readouts.*:scpi-daq.nplc": Trial(2.0),
    "readouts.*:scpi-daq.channels.*.nplc": Trial(2.0),
    "readouts.*:scpi-daq.channels.*.range_v": Trial(100.0),
    "readouts.*:hp3458a.channels.*.range_v": Trial(100.0),
    "readouts.*:scpi-daq.channels.*.channel": Trial(105),
    "readouts.*:hp3458a.channels.*.scanner": Trial(7),
    "readouts.*:hp3458a.checks.short_scanner": Trial(7),
    "readouts.*:scpi-daq.checks.action": Trial(rig=REFERENCE_OFF),
    "environment.*:ascii-chamber.pause_s": Trial(10.0),
    "environment.*:ascii-chamber.channel": Trial(2, rig=IN_A_THERMOTRON),
    "environment.*:watlow-f4t.plausible_degc": Trial([30.0, 40.0]),
    "streams.*:csv-imu.columns": Trial(["t", "n", "gx", "gy", "gz"], job="rates", at="logger"),
    "streams.*:csv-imu.channels.*.unit": Trial("dps", job="rates", at="gx"),
    "streams.*:csv-imu.count.column": Trial("t"),
    "streams.*:csv-imu.count.wraps_at": Trial(16.0),
    "streams.*:csv-imu.time.column": Trial("n"),
    "streams.*:csv-imu.time.wraps_at": Trial(1000.0, job="rates"),
    "streams.*:csv-imu.prefix": Trial("IMU"),
    "streams.*:vn100.baud_rate": Trial(230400),
    "streams.*:vn100.rate_hz": Trial(20),
    "field.*:manual.limits_ut": Trial([-10.0, 10.0]),
    "attitude_reference.channels": Trial({"pitch": "ahrs.pitch"}),
    "attitude_reference.tolerance_deg": Trial(0.0001, job="levels"),
    "attitude_reference.corrections": Trial(1, job="levels", rig={"attitude_reference": {"tolerance_deg": 0.0001}}),
    "sensors.*.channels": Trial({"x": "dmm.y", "y": "dmm.x", "z": "dmm.z"}, job="daq"),
    "sensors.*.temperature.channel": Trial("dmm.s"),
    "level.before.taken": Trial("2026-01-01"),
    "chain.*.serial": Trial("R2"),
    "job.relative_humidity_percent": Trial([30.0, 45.0]),
    "job.fields": Trial({"cost centre": "30-221"}),
    "chain.*.load_resistor_at": Trial("nowhere"),
    "chain.*.supply_channel": Trial("dmm.t"),
    "chain.*.supply_band_v": Trial([9.5, 11.0]),
    "chain.*.supply_nominal_v": Trial(9.0),
    "chain.*.warm_up_s": Trial(600.0),
    "chain.*.warm_up_slope_v_per_h": Trial(1e-3),
    "laboratory.country_code": Trial("DE"),
    "interlocks.temperature.*.band_degc": Trial([10.0, 22.0]),
    "interlocks.temperature.*.hysteresis_degc": Trial(
        4.0, job="table", rig={"interlocks": {"temperature": {"air": {"band_degc": [10.0, 25.0]}}}}
    ),
    "interlocks.temperature.*.delay_s": Trial(5.0, job="table", rig=OUT_OF_BAND),
    "interlocks.temperature.*.action": Trial(job="table", rig=OUT_OF_BAND),
    "interlocks.voltage.*.band_v": Trial([9.0, 9.5]),
    "interlocks.voltage.*.hysteresis_v": Trial(0.1, job="table", rig=SUPPLY_OUT),
    "interlocks.voltage.*.delay_s": Trial(5.0, job="table", rig=SUPPLY_OUT),
    "interlocks.voltage.*.action": Trial(job="table", rig=SUPPLY_OUT),
    "interlocks.rejected.most": Trial(1, procedure=NOISY),
    "interlocks.rejected.within": Trial(2, procedure=NOISY, rig={"interlocks": {"rejected": {"most": 1}}}),
    "interlocks.min_free_mb": Trial(1e9),
    "interlocks.max_link_error_rate": Trial(0.9, faults={"lost": {"line": "axes.pitch", "kind": "drop", "every": 10}}),
    "approved_by": Trial(REMOVED),
    "twin.time": Trial("real"),
    "twin.control": Trial(REMOVED, job="table", rig=AT_PORTS),
    "twin.mounting": Trial(rig={"twin": {"base": {"remount_arcsec": 10.0}}}),
    "twin.truth.*.*.sensitivity_v_per_ut": Trial(1.5, job="levels", rig=FIELD_IN_VOLTS, at="MicroMag3"),
    "twin.truth.*.*.reference_temperature_degc": Trial(
        rig={"twin": {"truth": {"SN1047": {"x": {"offset_tc_v_per_degc": 1e-4}}}}}
    ),
    "twin.truth.*.*.q_v_per_g2": Trial([1e-4, 0.0, 0.0, 0.0, 0.0]),
    "twin.base.earth": Trial([45.5, 20.0], job="rates", rig={"twin": {"base": {}}}),
    "twin.axes.*.index_error_arcsec": Trial(5.0),
    "twin.axes.*.index_harmonics": Trial([[1.0, 5.0, 0.0]]),
    "twin.axes.*.index_list": Trial([[-90.0, 3.0], [0.0, -3.0], [90.0, 3.0]]),
    "twin.axes.*.rate_error": Trial(0.01, job="rates", rig={"twin": {"axes": {"roll": {}}}}),
    "twin.axes.*.runaway_after_s": Trial(2.0, job="rates", rig={"twin": {"axes": {"roll": {}}}}),
    "twin.streams.*.rate_bias_dps": Trial([1.0, 0.0, 0.0], job="levels", rig=AHRS_RAW, at="ahrs"),
    "twin.streams.*.noise_g": Trial(job="levels", rig=AHRS_RAW, at="ahrs"),
    "twin.streams.*.noise_dps": Trial(job="levels", rig=AHRS_RAW, at="ahrs"),
    "twin.streams.*.noise_ut": Trial(job="levels", rig=AHRS_RAW, at="ahrs"),
}
KEYS = keys_of(rig_form())


def trial_of(key: str) -> Trial:
    return TRIALS.get(key) or BY_NAME.get(key.rpartition(".")[2]) or Trial()


def _tried() -> Iterator[ParameterSet]:
    """Yield every key that a person writes; what all axes share is tried on the table, on the others by `make soak`."""
    for key in KEYS:
        if key in FREE_TEXT | PENDING or key.endswith(READ_FROM_A_TABLE):
            continue
        driver, _, name = key.removeprefix("axes.*:").partition(".")
        is_shared = key.startswith("axes.*:") and driver != "indexing-table" and name in AxisSettings.model_fields
        yield pytest.param(key, marks=pytest.mark.soak if is_shared else marks_of(key))


@pytest.mark.parametrize("key", list(_tried()))
def test_a_change_of_the_key_is_seen(key: str, tmp_path: Path) -> None:
    assert what_a_change_does("rig", key, KEYS[key], trial_of(key), tmp_path), f"{key}: nothing reads it"


def test_every_key_that_is_named_is_a_key_of_the_form() -> None:
    assert FREE_TEXT | PENDING | TRIALS.keys() <= KEYS.keys()


def test_no_key_is_pending() -> None:
    assert not PENDING
