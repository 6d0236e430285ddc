"""Small jobs that between them hold every table of a rig file and of a procedure: where a key is changed and seen."""

import tomllib
from copy import deepcopy
from dataclasses import replace
from functools import cache
from typing import Any

from example_files import ROOT
from file_keys import Document
from observed_job import Job

EXAMPLES = ROOT / "examples"
QUICK = {"window_s": 1.0, "windows": 2, "min_s": 1.0, "max_s": 30.0}
LOST_REPLY = {"lost": {"line": "axes.pitch", "kind": "drop", "nth": [2]}}
"""A question that is not answered: how long it is waited for is seen on the wire."""
STANDARDS: Document = tomllib.loads("""
table = { serial = "1", certificate = "c1", due = 2027-06-30, kind = "expanded", k = 2.0, uncertainty_arcsec = 1.0 }
meter = { serial = "2", certificate = "c2", due = 2027-06-30, kind = "limit", uncertainty_v = 0.0001 }
resistor = { serial = "3", certificate = "c3", due = 2027-06-30, uncertainty_ohm = 0.1 }
probe = { serial = "4", certificate = "c4", due = 2027-06-30, uncertainty_degc = 0.05 }
level = { serial = "6", certificate = "c6", due = 2027-06-30, kind = "expanded", uncertainty_arcsec = 0.5 }
second = { serial = "5", certificate = "c5", due = 2027-06-30, kind = "standard", uncertainty_v = 0.0002 }
""")
GRID: Document = tomllib.loads("""
[procedure]
title = "grid"
kind = "grid"
replications = 2
[design]
kind = "D"
pitch_deg = { from = -30.0, to = 30.0, step = 60.0 }
roll_deg = { from = -90.0, to = 180.0, count = 4 }
[dwell]
samples = 3
settle = { window_s = 1.0, windows = 2, min_s = 1.0, max_s = 30.0 }
[solve]
model = "pitch-roll"
""")


def _example(path: str) -> Document:
    return tomllib.loads((EXAMPLES / path).read_text(encoding="utf-8"))


def merged(document: Document, more: Document) -> Document:
    """A copy with tables joined; what is no table is replaced, and None takes it away."""
    copy = deepcopy(document)
    for name, value in more.items():
        if value is None:
            copy.pop(name, None)
        else:
            copy[name] = merged(copy.get(name, {}), value) if isinstance(value, dict) else deepcopy(value)
    return copy


def _table() -> Job:
    """Indexing tables, a multimeter with its checks, a whole signal chain, a chamber; everything declared."""
    rig = merged(
        _example("rig.toml"),
        tomllib.loads("""
approved_by = "B. Chief"
console = { motion_from_elsewhere = false }
rig = { gravity_uncertainty_mps2 = 1e-5 }
environment.air = { standard = "probe" }
interlocks.temperature.air = { band_degc = [10.0, 30.0] }
interlocks.voltage."dmm.s" = { band_v = [8.0, 12.0] }
interlocks.rejected = { most = 5, within = 50 }
job.number = "J-7"
job.customer = "Tunnel Ltd"
job.customer_contact = "2 Wind Road"
job.location = "hall 3"
job.item = "package"
job.received = 2026-02-20
job.remarks = "clean"
laboratory = { name = "Laboratory", address = "1 Way", capability_deg = 0.0001 }
acceptance = { pitch_limit_deg = 0.01, roll_limit_deg = 0.01 }
[chain."dmm.x"]
serial = "R1"
load_resistor_ohm = 1000.0
load_resistor_tc_per_degc = 2e-5
load_resistor_at = "air"
supply_channel = "dmm.s"
supply_band_v = [9.0, 11.0]
ratiometric = true
standard = "resistor"
[readouts.dmm]
nplc = 1.0
standard = "meter"
[readouts.dmm.channels]
x = { scanner = 1, range_v = 10.0 }
y = { scanner = 2, range_v = 10.0 }
z = { scanner = 3, range_v = 10.0 }
t = { scanner = 4, range_v = 10.0 }
s = { scanner = 5, range_v = 10.0 }
[readouts.dmm.checks]
autocalibrate = true
short_scanner = 8
short_limit_v = 0.001
reference_scanner = 9
reference_v = 1.0
reference_limit_v = 0.001
every_s = 200.0
samples = 3
[sensors.SN1047]
mount = { x = "+x", y = "+y", z = "+z" }
temperature = { channel = "dmm.t", offset_degc = 20.0, slope_degc_per_v = 100.0 }
[level]
standard = "level"
uncertainty_arcsec = 0.5
before = { about_pitch_arcsec = 1.0, about_roll_arcsec = 2.0, taken = "2026-02-28" }
after = { about_pitch_arcsec = -1.5, about_roll_arcsec = 1.0 }
[twin.supplies."dmm.s"]
error_v = 0.01
[twin.axes.pitch]
creep_arcsec = 1.0
[twin.axes.roll]
[twin.base]
tilt_about_pitch_arcsec = 5.0
[twin.environment.air]
[twin.readouts.dmm]
"""),
    )
    rig["standards"] = deepcopy(STANDARDS)
    more = {
        "procedure": {"replications": 1},
        "environment": {"plateaus_degc": [20.0, 25.0], "soak_s": 60.0},
        "check": {"reference_every": 5},
        "stop": {"max_duration_s": 1e6},
    }
    return Job(rig, merged(GRID, more))


def _axes(driver: str, **keys: Any) -> Job:
    """The example's meter behind a pitch and a roll axis of one driver."""
    rig = merged(_example("rig.toml"), {"readouts": {"dmm": {"nplc": 1.0}}, "environment": None})
    common = {"driver": driver, "port": "twin", "limits_deg": [-180.0, 180.0], "speed_dps": 60.0, "standard": "table",
              "uncertainty_arcsec": 1.0}  # fmt: skip
    rig["axes"] = {
        name: {**common, "axis": number, **deepcopy(keys)} for number, name in enumerate(("pitch", "roll"), start=1)
    }
    rig["standards"] = deepcopy(STANDARDS)
    return Job(rig, merged(GRID, {"procedure": {"replications": 1}}), LOST_REPLY)


def _daq() -> Job:
    """A data-acquisition unit and an F4T chamber."""
    base = _axes("indexing-table", increment_deg=1.0)
    rig = merged(base.rig, {"readouts": None})
    rig["readouts"] = tomllib.loads("""
[dmm]
driver = "scpi-daq"
model = "34970A"
resource = "twin"
nplc = 1.0
standard = "meter"
[dmm.channels]
x = { channel = 101, range_v = 10.0 }
y = { channel = 102, range_v = 10.0 }
z = { channel = 103, range_v = 10.0 }
[dmm.checks]
short_channel = 110
short_limit_v = 0.001
reference_channel = 111
reference_v = 1.0
reference_limit_v = 0.001
every_s = 60.0
samples = 3
""")
    rig["environment"] = {"air": {"driver": "watlow-f4t", "port": "twin", "standard": "probe"}}
    rig["twin"]["environment"] = {"air": {}}
    rig["twin"]["readouts"] = {"dmm": {}}
    more = {"environment": {"plateaus_degc": [20.0], "soak_s": 0.0}, "solve": {"temperature": "none"}}
    return Job(rig, merged(base.procedure, more))


def _meters() -> Job:
    """A multimeter for each sensor, in a chamber that speaks lines of text."""
    base = _axes("indexing-table", increment_deg=1.0)
    rig = merged(base.rig, {"readouts": None, "standards": None})
    common = {"driver": "scpi-meter", "model": "34401A", "resource": "twin", "nplc": 1.0, "standard": "meter"}
    rig["readouts"] = {
        name: {**common, "channels": {axis: {"range_v": 10.0}}}
        for name, axis in (("dmm", "x"), ("second", "y"), ("third", "z"))
    }
    rig["standards"] = deepcopy(STANDARDS)
    rig["sensors"]["SN1047"]["channels"] = {"x": "dmm.x", "y": "second.y", "z": "third.z"}
    air = {"driver": "ascii-chamber", "port": "twin", "standard": "probe", "model": "espec-p300", "values": "degc"}
    rig["environment"] = {"air": air | {"address": 1}}
    rig["twin"]["environment"] = {"air": {}}
    more = {"environment": {"plateaus_degc": [20.0], "soak_s": 0.0}, "solve": {"temperature": "none"}}
    return Job(rig, merged(base.procedure, more))


def _tilt() -> Job:
    """An autocollimator that tells the pitch in place of the table."""
    base = _axes("indexing-table", increment_deg=1.0)
    rig = merged(
        base.rig,
        tomllib.loads("""
[readouts.level]
driver = "angle-meter"
resource = "twin"
dialect = "newport-lds1000"
channels = { pitch = { about = "pitch" } }
[attitude_reference]
channels = { pitch = "level.pitch" }
uncertainty_deg = 0.001
samples = 2
[twin.readouts.level]
noise_deg = 0.0001
"""),
    )
    return Job(rig, base.procedure)


def _servo(procedure: str, table: Document) -> Job:
    """Servos, a board and a VN-100 that stream, a coil."""
    rig = _example("servo-mechanism/rig.toml")
    rig["standards"] = deepcopy(STANDARDS)
    wanted = merged(_example(f"servo-mechanism/{procedure}.toml"), {"dwell": {"settle": QUICK}})
    return Job(rig, merged(merged(wanted, {"procedure": {"replications": 1}}), table))


def _rate_table(procedure: str, table: Document) -> Job:
    """Rotary stages that turn on and on, loggers that stream."""
    rig = _example("rate-table/rig.toml")
    for stream in rig["streams"].values():
        stream["rate_hz"] = 20.0
    rig["standards"] = deepcopy(STANDARDS)
    return Job(rig, merged(merged(_example(f"rate-table/{procedure}.toml"), {"procedure": {"replications": 1}}), table))


def _rates(pitch_dps: float, others_dps: float, dwell_s: float) -> Document:
    wanted = {"pitch_dps": [pitch_dps], "yaw_dps": [others_dps], "roll_dps": [others_dps]}
    return {"rates": {**wanted, "dwell_s": dwell_s}}


@cache
def jobs() -> dict[str, Job]:
    """By name. A key is looked for in them in this order."""
    return {
        "indexing-table": _axes("indexing-table", increment_deg=1.0),
        "table": _table(),
        "daq": _daq(),
        "meters": _meters(),
        "tilt": _tilt(),
        "esp301": _axes("esp301"),
        "zaber": _axes("zaber", microstep_deg=0.000234375, top_rate_dps=100.0),
        "pi-gcs": _axes("pi-gcs"),
        "rate-table": _axes("rate-table", top_rate_dps=100.0),
        "oriental-az": _axes("oriental-az", step_deg=0.01, top_rate_dps=100.0),
        "manual": replace(_axes("manual"), faults={}),
        "maestro": _axes("maestro", points=[[500.0, -180.0], [2500.0, 180.0]], pulse_limits_us=[500.0, 2500.0]),
        "levels": _servo("magnetometer", {"levels": {"rest_s": 5.0}}),
        "static": _servo("drift", {"static": {"duration_s": 120.0, "use_s": 20.0}}),
        "sweeps": _servo(
            "gyro", {"rates": {"pitch_dps": [20.0], "yaw_dps": [13.5], "roll_dps": [13.5], "dwell_s": 10.0}}
        ),
        "rates": _rate_table(
            "rates", {"rates": {"pitch_dps": [90.0], "yaw_dps": [90.0], "roll_dps": [90.0], "dwell_s": 4.0}}
        ),
        "profile": _rate_table("harmonic", {}),
    }
