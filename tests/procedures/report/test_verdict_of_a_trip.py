"""What the verdict of a run says first that was held and then tripped: the trip, then the hold, by runs on the twin."""

import re
from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from small_run import Bench, bench
from unattended_run import RigReopenedLate, UnattendedRun, asks, run_unattended

from procedures.journal.audit.audit_trail import interruptions_in
from procedures.journal.journal_reader import JournalReader
from procedures.records.states import State
from procedures.report.assemble import assemble_view
from procedures.solution.record import RunRecord, read_record
from rig.abilities.abilities import Burst
from rig.assembly.open_rig import Rig
from rig.errors import LinkLost

GONE = "readouts.dmm: the port is gone"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


def _lost(number: int, burst: Burst) -> Burst:
    if number == 50:
        raise LinkLost(GONE)
    return burst


class OtherMeter(RigReopenedLate):
    """Another meter answers where the one of the run was: a trip out of the hold."""

    def reconnect(self) -> None:
        super().reconnect()
        self._identity = "HP3458A, other serial"


class LameAxis(FaultyRig):
    """An axis that cannot be told to stop."""

    def __init__(self, rig: Rig) -> None:
        super().__init__(rig, spoil=lambda number, burst: burst)
        stop = self.pitch.stop

        def no_stop() -> None:
            if self.meter.read_so_far >= 10:
                raise LinkLost("axes.pitch: the port is gone")
            stop()

        self.pitch.stop = no_stop  # type: ignore[method-assign]


def _record(run_dir: Path) -> RunRecord:
    with JournalReader.open(run_dir) as reader:
        return read_record(reader)


def _why_unfinished(record: RunRecord) -> str:
    """Return what is said of the run itself; what has no result, as nothing was solved here, is said before."""
    return next(ground for ground in assemble_view(record, {}).verdict.grounds if ground.startswith("The run"))


def test_a_trip_that_followed_a_hold_is_told_first_with_its_moment_and_where_the_axes_stand(
    small: Bench, tmp_path: Path
) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=lambda rig: OtherMeter(rig, 2, spoil=_lost))
    assert outcome.state is State.TRIPPED
    record = _record(unattended.run_dir)
    held, tripped = (
        next(event for event in record.events if event.kind == "state" and event.detail["to"] == state)
        for state in ("held", "tripped")
    )
    moment = r"[-\d]+ [:\d]+"
    said = re.fullmatch(
        rf"The run did not finish \(state “tripped”\), since (?P<tripped>{moment}) UTC: (?P<why>.+)\. "
        r"Every axis was told to stop and seen to stand: (?P<axes>.+); the run moved nothing since\. "
        rf"Before that it was held, since (?P<held>{moment}) UTC: (?P<first>.+)\.",
        _why_unfinished(record),
    )
    assert said is not None
    assert said["tripped"] == f"{tripped.utc:%Y-%m-%d %H:%M}"
    assert said["held"] == f"{held.utc:%Y-%m-%d %H:%M}"
    assert said["why"] == tripped.detail["reason"] == outcome.reason
    assert said["why"].startswith("not the devices of this run: readouts.dmm")
    assert said["first"] == held.detail["reason"]
    assert GONE in said["first"]
    assert said["axes"] == ", ".join(f"{name} at {degrees:.4f}°" for name, degrees in outcome.positions_deg.items())


def test_axes_that_were_not_seen_to_stand_are_not_said_to(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run", after={4: asks("abort")})
    outcome = run_unattended(small, unattended, rig_of=LameAxis)
    assert outcome.state is State.TRIPPED
    ground = _why_unfinished(_record(unattended.run_dir))
    assert "Not every axis was seen to stand: go and look before anything else." in ground
    assert "moved nothing" not in ground
    assert "Before that" not in ground


def test_a_run_that_was_only_held_and_stopped_by_a_person_tells_both_in_this_order(
    small: Bench, tmp_path: Path
) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={200: asks("stop")})
    outcome = run_unattended(small, unattended, rig_of=lambda rig: RigReopenedLate(rig, 10**6, spoil=_lost))
    assert outcome.state is State.STOPPED
    record = _record(unattended.run_dir)
    ground = _why_unfinished(record)
    assert (
        ground.index("(state “stopped”)") < ground.index("asked for by bert") < ground.index("Before that it was held")
    )
    (stretch,) = interruptions_in(record.events)
    assert [stood.what for stood in stretch.newest_first] == ["stopped", "held"]
    assert stretch.ended_utc is None
