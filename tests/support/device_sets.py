"""Four sets of devices for one small campaign: an indexing table with a meter, two motion controllers with a
data-acquisition unit, servos with two streaming packages beside. Cheap: 14 dwells of the design and a check set."""

from pathlib import Path

from small_run import Bench

from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from rig.description.read import read_rig

COMMON = """
[rig]
name = "{name}"
gravity_mps2 = 9.80665
[sensors.SN1]
model = "three-axis package"
channels = {{ x = "dmm.x", y = "dmm.y", z = "dmm.z" }}
nominal_sensitivity_v_per_g = 2.5
[twin]
seed = 7
[twin.truth.SN1]
x = {{ offset_v = 0.005, sensitivity_v_per_g = 2.5, coning_deg = 0.5, azimuth_deg = 35.0, noise_v = 2e-5 }}
y = {{ offset_v = -0.003, sensitivity_v_per_g = 2.48, coning_deg = 0.3, azimuth_deg = -110.0, noise_v = 2e-5 }}
z = {{ offset_v = 0.008, sensitivity_v_per_g = 2.52, coning_deg = 0.4, azimuth_deg = 160.0, noise_v = 2e-5 }}
"""
AXIS = """
[axes.{axis}]
driver = "{driver}"
port = "twin"
axis = {number}
limits_deg = [-180.0, 180.0]
speed_dps = 180.0
arrival_tolerance_deg = {tolerance_deg}
{extra}
"""
TABLE, SERVO = "increment_deg = 1.0", "points = [[500.0, -190.0], [2500.0, 190.0]]\npulse_limits_us = [500.0, 2500.0]"
METER = """
[readouts.dmm]
driver = "hp3458a"
resource = "twin"
nplc = 1
channels = { x = { scanner = 1, range_v = 10.0 }, y = { scanner = 2, range_v = 10.0 }, z = { scanner = 3, range_v = 10.0 } }
"""  # noqa: E501
DAQ = """
[readouts.dmm]
driver = "scpi-daq"
model = "34970A"
resource = "twin"
nplc = 1
channels = { x = { channel = 101, range_v = 10.0 }, y = { channel = 102, range_v = 10.0 }, z = { channel = 103, range_v = 10.0 } }
"""  # noqa: E501
F4 = '[environment.air]\ndriver = "watlow-f4"\nport = "twin"\n'
F4T = '[environment.air]\ndriver = "watlow-f4t"\nport = "twin"\n'
STREAMS = """
[streams.imu]
driver = "vn100"
port = "twin"
baud_rate = 460800
rate_hz = 200
[streams.board]
driver = "csv-imu"
port = "twin"
rate_hz = 50.0
columns = ["n", "ax", "ay", "az"]
count = { column = "n", wraps_at = 65536 }
[streams.board.channels]
ax = { preset = "SCA3000" }
ay = { preset = "SCA3000" }
az = { preset = "SCA3000" }
"""
CAMPAIGN = """
[procedure]
title = "kills"
kind = "grid"
replications = 2
[design]
kind = "D"
pitch_deg = [-45.0, 45.0]
roll_deg = [-180.0, -90.0, 0.0, 90.0]
order = "raster"
[dwell]
samples = 4
settle = { window_s = 0.5, windows = 2, min_s = 0.5, max_s = 30.0 }
[check]
reference_every = 6
"""
SHORTER = CAMPAIGN.replace("[-180.0, -90.0, 0.0, 90.0]", "[-120.0, 0.0, 120.0]")
"""Where hundreds of campaigns are wanted: 12 dwells of the design."""


def _axes(driver: str, extra: str = "", first: int = 1, tolerance_deg: float = 0.001) -> str:
    return "".join(
        AXIS.format(axis=axis, driver=driver, number=first + index, extra=extra, tolerance_deg=tolerance_deg)
        for index, axis in enumerate(("pitch", "roll"))
    )


RIGS = {
    "table-3458a": _axes("indexing-table", TABLE) + METER + F4,
    "esp301-daq": _axes("esp301") + DAQ + F4T,
    "zaber-daq": _axes("zaber", "microstep_deg = 0.000234375\ntop_rate_dps = 450.0") + DAQ + F4,
    "maestro-imu": _axes("maestro", SERVO, first=0, tolerance_deg=0.1) + DAQ + STREAMS,
}


CHAMBER = '[environment.air]\ndriver = "ascii-chamber"\nport = "twin"\nmodel = "thermotron-8800"\nvalues = "degc"\n'
SLOW_DPS = 30.0
EVERY_AXIS = {
    name: text.replace("speed_dps = 180.0", f"speed_dps = {SLOW_DPS}")
    for name, text in {
        "indexing-table": _axes("indexing-table", TABLE) + METER + F4,
        "esp301": _axes("esp301") + DAQ + F4T,
        "zaber": _axes("zaber", "microstep_deg = 0.000234375\ntop_rate_dps = 450.0") + METER + F4,
        "maestro": _axes("maestro", SERVO, first=0, tolerance_deg=0.1) + DAQ + F4T,
        "pi-gcs": _axes("pi-gcs") + METER + CHAMBER,
        "rate-table": _axes("rate-table", "top_rate_dps = 100.0") + DAQ + F4,
        "oriental-az": _axes("oriental-az", "step_deg = 0.01\ntop_rate_dps = 100.0", tolerance_deg=0.01) + METER + F4T,
    }.items()
}
"""By the driver of their axes: each that moves by itself, with meters and chambers of several kinds."""


def device_set(name: str, folder: Path, procedure: str = CAMPAIGN) -> Bench:
    """The small campaign on one of :data:`RIGS` or :data:`EVERY_AXIS`."""
    rig_file, procedure_file = folder / "rig.toml", folder / "procedure.toml"
    rig_file.write_text(COMMON.format(name=name) + (RIGS | EVERY_AXIS)[name], encoding="utf-8")
    procedure_file.write_text(procedure, encoding="utf-8")
    description = read_rig(rig_file)
    return Bench(folder, description, make_plan(description, read_procedure(procedure_file)))
