"""Two drives on one line: each hears what is said to the other, and both watchdogs are proven all the same."""

import json
from pathlib import Path

from small_run import RIG, bench

from procedures.journal.journal_reader import JournalReader

AXIS = """driver = "{driver}"
port = "twin"
{keys}limits_deg = [-180.0, 180.0]
speed_dps = {speed_dps}
"""
TABLE = AXIS.format(driver="indexing-table", keys="increment_deg = 1.0\n", speed_dps=180.0)
DRIVE_KEYS = "step_deg = 0.01\nwatchdog_s = 3.0\narrival_tolerance_deg = 0.02\n"
DRIVE = AXIS.format(driver="oriental-az", keys=DRIVE_KEYS, speed_dps=20.0)


def test_the_silence_that_proves_one_is_not_broken_by_the_other(tmp_path: Path) -> None:
    assert RIG.count(TABLE) == 2
    small = bench(tmp_path, rig=((TABLE, DRIVE),), procedure=(("replications = 2", "replications = 1"),))
    outcome = small.run(tmp_path / "run")
    assert outcome.state == "finished", outcome
    with JournalReader.open(tmp_path / "run") as reader:
        found = [event.detail for event in reader.events() if event.kind == "watchdog"]
    assert [entry["is_armed"] for entry in found] == [True, True], json.dumps(found)
    assert all("3.75 s were noticed" in str(entry["told"]) for entry in found)
