"""Laws of watchdogs in a run: proven before anything moves, fed through every wait, let go at the end, all told."""

from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from resumed import resume_on
from runs_with_faults import faults, run_with_faults
from small_run import Bench, bench, dwells_of
from unattended_run import UnattendedRun

from procedures.journal.journal_reader import JournalReader
from procedures.records.dwells import Event
from procedures.records.states import State
from procedures.report.conditions import condition_sections
from procedures.run.begin import begin
from procedures.run.dwell.measure import OpenRig
from procedures.run.watch.watchdogs import Watchdogs
from rig.abilities.abilities import Wait, Watchdog
from rig.assembly.open_rig import open_rig

TABLE = 'driver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\n'
AZ = 'driver = "oriental-az"\nport = "twin"\nstep_deg = 0.001\nwatchdog_s = 4.0\n'
SERVO = (
    'driver = "maestro"\nport = "twin"\nwatchdog_s = 20.0\narrival_tolerance_deg = 0.2\n'
    "points = [[500.0, -180.0], [2500.0, 180.0]]\npulse_limits_us = [500.0, 2500.0]\n"
)
SOAK = ("[check]", "[environment]\nplateaus_degc = [22.0]\nband_degc = 1.0\nsoak_s = 600.0\n[check]")


def _bench(folder: Path, machine: str) -> Bench:
    return bench(folder, rig=((TABLE, machine),), procedure=(SOAK,))


def _events(run_dir: Path, kind: str) -> list[Event]:
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        return list(reader.events(kind))


@pytest.mark.parametrize("machine", [AZ, SERVO], ids=["oriental-az", "maestro"])
def test_fault_56_a_run_proves_the_watchdogs_feeds_them_through_a_soak_and_lets_go(
    tmp_path: Path, machine: str
) -> None:
    """Detected: the device's own time-out, set and verified when the run begins.
    Response: the device stops by itself within its time-out.
    """
    entry = _bench(tmp_path, machine)
    run_dir = tmp_path / "run"
    outcome = entry.run(run_dir)
    assert (outcome.state, outcome.reason) == (State.FINISHED, "")
    text = [(event.detail["axis"], event.detail["is_armed"]) for event in _events(run_dir, "watchdog")]
    assert text == [("pitch", True), ("roll", True)]
    assert "were noticed" in str(_events(run_dir, "watchdog")[0].detail["told"])
    with JournalReader.open(run_dir) as reader:
        kinds = [event.kind for event in reader.events()]
    assert kinds.index("watchdog") < kinds.index("intent")
    assert all(dwell.accepted for dwell in dwells_of(run_dir))


@pytest.mark.parametrize("at_s", [120.0, 300.0])
def test_one_that_is_gone_in_mid_run_is_told_and_trips_as_one_that_does_not_act(tmp_path: Path, at_s: float) -> None:
    """The time-out of an AZ is in RAM: power that fails for a moment takes it away, and the drive answers as before."""
    entry, unattended = _bench(tmp_path, AZ), UnattendedRun(tmp_path / "run")
    cut = {"line": "axes.pitch", "kind": "power-cycle", "away_s": 0.0, "at_s": at_s}
    outcome, said = run_with_faults(entry, unattended, faults(cut=cut))
    assert said
    assert outcome.state is State.TRIPPED
    assert "its watchdog is gone: register 0x138a reads 0 ms, 4000 ms were armed and proven" in outcome.reason
    last = _events(unattended.run_dir, "watchdog")[-1]
    assert last.detail["is_armed"] is False
    rows = condition_sections(_events(unattended.run_dir, "watchdog"))["watchdogs of the axes"]
    assert "its watchdog is gone" in rows[str(last.detail["axis"])]
    with open_rig(entry.rig) as rig:
        assert resume_on(unattended.run_dir, rig, "carla", "looked at its supply").state is State.FINISHED
    assert [event.detail["is_armed"] for event in _events(unattended.run_dir, "watchdog")[-2:]] == [True, True]


def test_an_axis_without_one_is_told_in_the_journal(tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    assert bench(tmp_path).run(run_dir).state is State.FINISHED
    assert ["no watchdog" in str(event.detail["told"]) for event in _events(run_dir, "watchdog")] == [True, True]


def test_a_watchdog_that_does_not_act_trips_the_run_before_anything_moves(tmp_path: Path) -> None:
    entry = _bench(tmp_path, AZ.replace("watchdog_s", "watchdog_register = 0x5C\nwatchdog_s"))
    run_dir = tmp_path / "run"
    outcome = entry.run(run_dir)
    assert outcome.state is State.TRIPPED
    assert "pitch: the machine did not notice a silence of 5 s" in outcome.reason
    assert not _events(run_dir, "intent")


def test_after_a_line_was_opened_anew_for_the_last_stop_the_watchdog_is_let_go_by_the_new_line() -> None:
    class Drive:
        name, watchdog_s, is_armed = "pitch", 4.0, False

        def arm_watchdog(self, wait: Wait) -> str:
            self.is_armed = True
            return "proven"

        def feed_watchdog(self) -> None: ...

        def disarm_watchdog(self) -> None:
            self.is_armed = False

    before, after = Drive(), Drive()
    rig, told = SimpleNamespace(axes={"pitch": before}, clock=None), list[Mapping[str, object]]()
    watchdogs = Watchdogs(cast("OpenRig", rig), lambda _, detail: told.append(detail))
    watchdogs.arm(lambda _: None)
    after.is_armed = True  # the drive is the same one
    rig.axes = {"pitch": after}
    watchdogs.disarm()
    assert not after.is_armed
    assert len(told) == 1, "nothing but that it was armed"


def test_after_a_run_an_az_waits_for_nobody(tmp_path: Path) -> None:
    entry = _bench(tmp_path, AZ)
    with open_rig(entry.rig) as rig:
        (tmp_path / "run").mkdir()
        begin(tmp_path / "run", entry.header(tmp_path / "run"), entry.plan, rig)
        rig.clock.sleep(3600.0)
        pitch = rig.axes["pitch"]
        assert isinstance(pitch, Watchdog)
        assert pitch.state().fault == ""
