"""Which inputs of a meter are selected is the run's from the first look: a hand at the switch changes no number.

No ``terminals`` stand in the rig file. What the meter of the twins has at its rear is the same as at its front, so only
what the journal says tells them apart.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from small_run import Bench, StopAt, bench, dwells_of, measured
from unattended_run import RigReopenedLate, UnattendedRun, events, run_unattended

from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.ending import Outcome
from procedures.run.handover import handover
from procedures.run.resume import resume
from rig.abilities.abilities import Burst
from rig.assembly.open_rig import Rig
from rig.errors import DeviceRefused, LinkLost
from rig.twins.hp3458a import Hp3458aTwin

LATE_BURST = 50
VOID = DeviceRefused("dmm: meter: FUNC? reads back 1000, it was set to 10; no reading is taken")


@dataclass
class Switch:
    """TERMINALS at the panel: it stays as the last hand left it, whoever opens or closes the line."""

    is_front: bool = True


@pytest.fixture
def switch(monkeypatch: pytest.MonkeyPatch) -> Switch:
    switch = Switch()

    class Meter(Hp3458aTwin):
        @property
        def is_front(self) -> bool:
            return switch.is_front

        @is_front.setter
        def is_front(self, _is_front: bool) -> None:
            """No program turns it."""

    monkeypatch.setattr("rig.drivers.hp3458a.Hp3458aTwin", Meter)
    return switch


@pytest.fixture
def small(tmp_path: Path) -> Bench:
    return bench(tmp_path)


def _fails_once_with(error: Exception) -> Callable[[int, Burst], Burst]:
    def spoil(number: int, burst: Burst) -> Burst:
        if number == LATE_BURST:
            raise error
        return burst

    return spoil


def _turned_in_mid_run(small: Bench, switch: Switch, run_dir: Path) -> Outcome:
    """Turned while the sixth dwell is on its way."""

    class Hand:
        def on_event(self, progress: Progress) -> None:
            if progress.event == "dwell" and progress.dwells_done == 5:
                switch.is_front = False

    return small.run(run_dir, observer=Hand())


def _require_trip(outcome: Outcome, run_dir: Path) -> None:
    """It ended over the inputs, and nothing that they gave was kept."""
    assert outcome.state is State.TRIPPED, outcome.reason
    assert outcome.cause == "identity"
    assert "not the devices of this run: readouts.dmm: was 'HP3458A, " in outcome.reason
    was, _, found = outcome.reason.partition(", is 'HP3458A, ")
    assert ("front inputs" in was, "rear inputs" in found) == (True, True)
    turned = next(event for event in events(run_dir, "identities") if "rear" in str(event.detail))
    assert not [event for event in events(run_dir, "dwell") if event.sequence > turned.sequence]


def test_a_switch_turned_in_mid_run_is_adopted_by_no_retry(small: Bench, switch: Switch, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    outcome = _turned_in_mid_run(small, switch, run_dir)
    (void,) = events(run_dir, "void")
    assert "the rear inputs are selected, need those at the front" in str(void.detail["reason"])
    assert outcome.state is State.TRIPPED, outcome.reason
    assert (
        "need those at the front (readouts.dmm: terminals is left out, and those were selected first)" in outcome.reason
    )
    assert not [event for event in events(run_dir, "dwell") if event.sequence > void.sequence]

    switch.is_front = True
    assert resume(run_dir, "carla", "pressed the key").state is State.FINISHED
    assert not events(run_dir, "override")
    small.run(tmp_path / "clean")
    assert measured(dwells_of(run_dir)) == measured(dwells_of(tmp_path / "clean"))


def test_a_switch_turned_back_before_the_retry_costs_one_attempt(small: Bench, switch: Switch, tmp_path: Path) -> None:
    """A retry takes the inputs of the run, not those that the void named."""

    class Hand:
        def on_event(self, progress: Progress) -> None:
            if (progress.event, progress.dwells_done) in (("dwell", 5), ("void", 5)):
                switch.is_front = progress.event == "void"

    assert small.run(tmp_path / "run", observer=Hand()).state is State.FINISHED
    assert len(events(tmp_path / "run", "void")) == 1


@pytest.mark.parametrize("turned_before", [1, 2], ids=["the first preparation", "the preparation of a retry"])
def test_a_switch_turned_between_identity_and_preparation_is_not_adopted(
    small: Bench, switch: Switch, tmp_path: Path, turned_before: int
) -> None:
    """What was seen first holds for the device too: no identity sees what is turned behind it."""

    def turned(rig: Rig) -> FaultyRig:
        faulty = FaultyRig(rig, _fails_once_with(VOID))
        prepare, prepared = faulty.meter.prepare, count(1)

        def late() -> None:
            switch.is_front = next(prepared) != turned_before
            prepare()

        faulty.meter.prepare = late  # type: ignore[method-assign]
        return faulty

    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=turned)
    assert outcome.state is State.TRIPPED, outcome.reason
    assert "dmm: the rear inputs are selected, need those at the front" in outcome.reason
    assert "terminals is left out, and those were selected first" in outcome.reason


def test_a_switch_turned_while_the_line_is_away_trips(small: Bench, switch: Switch, tmp_path: Path) -> None:
    class Turned(RigReopenedLate):
        def reconnect(self) -> None:
            switch.is_front = False
            super().reconnect()

    unattended, gone = UnattendedRun(tmp_path / "run"), _fails_once_with(LinkLost("dmm: the adapter is gone"))
    _require_trip(run_unattended(small, unattended, rig_of=lambda rig: Turned(rig, 2, spoil=gone)), unattended.run_dir)


def test_a_switch_turned_between_stop_and_resume_trips_until_somebody_answers_for_it(
    small: Bench, switch: Switch, tmp_path: Path
) -> None:
    run_dir = tmp_path / "run"
    assert small.run(run_dir, observer=StopAt(run_dir, 5)).state is State.STOPPED
    switch.is_front = False
    _require_trip(resume(run_dir, "carla", "on with it"), run_dir)
    assert resume(run_dir, "carla", "wired at the rear", accepts_changes=True).state is State.FINISHED
    (override,) = events(run_dir, "override")
    assert (override.detail["by"], override.detail["reason"]) == ("carla", "wired at the rear")
    assert "rear inputs" in override.detail["devices"]["readouts.dmm"]  # type: ignore[index]
    assert "taken over by carla: wired at the rear, measured 19 dwells" in handover(run_dir)
