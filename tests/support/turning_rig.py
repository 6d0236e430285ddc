"""The example rig with a Zaber stage in place of its roll table, and one with a servo in place of its pitch table."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from table_bench import rig_file

from rig.assembly.simulate import SimulatedRig, serve_rig, write_rig
from rig.clock import Clock, ScaledClock
from rig.description.read import read_rig

_TABLE = """driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 5.0
uncertainty_arcsec = 1.0
standard = "table"
axis = {axis}
"""
_STAGE = """driver = "zaber"
port = "twin"
limits_deg = [-180.0, 180.0]
speed_dps = 20.0
microstep_deg = 0.0005
arrival_tolerance_deg = 0.001
top_rate_dps = 24.0
"""
_SERVO = """driver = "maestro"
port = "twin"
axis = 0
points = [[1000.0, -45.0], [1500.0, 0.0], [2000.0, 46.0]]
limits_deg = [-44.0, 44.0]
speed_dps = 20.0
"""
STAGE_FOR_ROLL = (_TABLE.format(axis=2), _STAGE)
_DRIVE = """driver = "oriental-az"
port = "twin"
axis = 2
limits_deg = [-180.0, 180.0]
speed_dps = 20.0
step_deg = 0.01
top_rate_dps = 60.0
watchdog_s = 2.0
"""
DRIVE_FOR_ROLL = (_TABLE.format(axis=2), _DRIVE)
SERVO_FOR_PITCH = (_TABLE.format(axis=1), _SERVO)
QUICK_METER = ("nplc = 10", "nplc = 1")


@contextmanager
def served(
    folder: Path, clock: Clock, *changes: tuple[str, str], pty: bool = False
) -> Iterator[tuple[SimulatedRig, Path]]:
    """Such a rig on real ports in this process, and the rig file that reaches it."""
    path = rig_file(folder, *changes)
    with serve_rig(read_rig(path), clock, pty=pty) as simulated:
        factor = clock.factor if isinstance(clock, ScaledClock) else "real"
        write_rig(path, simulated.addresses, factor, folder / "ports.toml")
        yield simulated, folder / "ports.toml"
