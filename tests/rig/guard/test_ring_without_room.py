"""Who tells people of a dead engine where the system has no room for another process: the guard becomes that one."""

import json
import subprocess
import sys
from pathlib import Path

from guarded_engine import CLOCK, until
from turning_rig import STAGE_FOR_ROLL, served

from procedures.journal.sidecar.guard_record import read_guard_record
from rig.guard import stop_guard

BUSY_LIMIT_S = 20.0
RINGS = """
import json, os, sys
with open(sys.argv[1] + ".partial", "w") as file:
    json.dump({"pid": os.getpid(), "open": len(os.listdir("/proc/self/fd")), "told": json.loads(sys.argv[2])}, file)
os.replace(sys.argv[1] + ".partial", sys.argv[1])
"""
GUARD_WITHOUT_ROOM = f"""
import errno, runpy, subprocess, sys

class NoRoom:
    def __init__(self, *_, **__):
        raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")

subprocess.Popen = NoRoom
sys.path[:0] = [{str(Path(__file__).parents[3])!r}]
sys.argv[0] = {str(stop_guard.PROCESS)!r}
runpy.run_path(sys.argv[0], run_name="__main__")
"""
ENGINE = """
import sys
from pathlib import Path
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.guard import stop_guard
from rig.motion.move import home_and_arrive

path, run = Path(sys.argv[1]), Path(sys.argv[2])
stop_guard.PROCESS = Path(sys.argv[3])
with open_rig(read_rig(path), rig_file=path, purpose="test") as rig:
    rig.belongs_to(run, sys.argv[4:])
    home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
    rig.axes["roll"].start_move(rig.axes["roll"].limits_deg[1])
    print(rig._guard.pid, flush=True)
    sys.stdin.read()
"""


def test_people_are_told_of_a_dead_engine_where_there_is_room_for_no_other_process(tmp_path: Path) -> None:
    guard, rung, run = tmp_path / "guard.py", tmp_path / "rung.json", tmp_path / "night"
    guard.write_text(GUARD_WITHOUT_ROOM, encoding="utf-8")
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL, pty=True) as (_, rig_file):
        words = [str(rig_file), str(run), str(guard), sys.executable, "-c", RINGS, str(rung)]
        with subprocess.Popen(
            [sys.executable, "-c", ENGINE, *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as engine:
            assert engine.stdout is not None
            guard_pid = int(engine.stdout.readline())
            engine.kill()
        assert until(rung.exists, BUSY_LIMIT_S)
    found = json.loads(rung.read_text(encoding="utf-8"))
    assert found["pid"] == guard_pid
    assert found["told"] == read_guard_record(run)
    assert found["open"] <= 5, "the lines are given back: a port may open but once"
