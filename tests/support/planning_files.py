"""Rig and procedure files for the tests of planning, made from small changes to two that work."""

from pathlib import Path

from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.read import read_procedure
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

RIG = """
[rig]
name = "bench"
gravity_mps2 = 9.80665
[axes.pitch]
driver = "indexing-table"
port = "socket://127.0.0.1:1"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 5.0
[axes.roll]
driver = "indexing-table"
port = "socket://127.0.0.1:1"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 10.0
axis = 2
[readouts.dmm]
driver = "hp3458a"
resource = "prologix+socket://127.0.0.1:7#22"
nplc = 10
channels = { x = { scanner = 1, range_v = 10.0 }, y = { scanner = 2, range_v = 10.0 }, z = { scanner = 3, range_v = 10.0 }, t = { scanner = 4, range_v = 10.0 } }
[sensors.SN1]
model = "three-axis package"
channels = { x = "dmm.x", y = "dmm.y", z = "dmm.z" }
nominal_sensitivity_v_per_g = 2.5
"""  # noqa: E501
AIR = """
[environment.air]
driver = "watlow-f4"
port = "socket://127.0.0.1:2"
"""
PROCEDURE = """
[procedure]
title = "small grid"
kind = "grid"
replications = 2
[design]
kind = "D1"
pitch_deg = { from = -30.0, to = 30.0, step = 10.0 }
roll_deg = { from = -180.0, to = 180.0, step = 90.0 }
"""


def rig_file(folder: Path, *changes: tuple[str, str], more: str = "") -> RigDescription:
    """The bench with pieces of its text replaced and text added."""
    return read_rig(_written(folder / "rig.toml", RIG, changes, more))


def procedure_file(folder: Path, *changes: tuple[str, str], more: str = "") -> ProcedureDescription:
    """The small grid with pieces of its text replaced and text added."""
    return read_procedure(_written(folder / "procedure.toml", PROCEDURE, changes, more))


def _written(path: Path, text: str, changes: tuple[tuple[str, str], ...], more: str) -> Path:
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    path.write_text(text + more, encoding="utf-8")
    return path
