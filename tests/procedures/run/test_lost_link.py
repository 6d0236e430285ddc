"""Links that break, devices that fall silent, axes that lose their home: held, reached, homed, checked, gone on."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from small_run import Bench, bench, dwells_of, measured
from unattended_run import RigReopenedLate, UnattendedRun, asks, events, run_unattended, states

from procedures.journal.status.status import status
from procedures.records.states import State
from procedures.run.ending import Outcome
from rig.abilities.abilities import AxisState, Burst
from rig.assembly.identity import Identifiable
from rig.assembly.open_rig import Rig
from rig.errors import DeviceNonsense, DeviceSilent, LinkLost
from rig.motion.supervisor import SupervisedAxis

GONE = "axes.pitch at /dev/serial/by-id/usb-x: the port is gone or broken; check cable and adapter"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def clean(small: Bench) -> Path:
    assert small.run(small.folder / "clean").state is State.FINISHED
    return small.folder / "clean"


def _fails_at(error: Exception, first: int, last: int) -> Callable[[int, Burst], Burst]:
    def spoil(number: int, burst: Burst) -> Burst:
        if first <= number <= last:
            raise error
        return burst

    return spoil


def _unattended(
    small: Bench, run_dir: Path, unattended: UnattendedRun, answers_at: int, **wrong: object
) -> tuple[Outcome, RigReopenedLate]:
    kept: list[RigReopenedLate] = []

    def around(rig: Rig) -> RigReopenedLate:
        kept.append(RigReopenedLate(rig, answers_at, **wrong))
        return kept[0]

    return run_unattended(small, unattended, rig_of=around), kept[0]


def test_fault_21_gone_link_is_held_reached_again_homed_checked_and_the_run_goes_on(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    outcome, rig = _unattended(small, unattended.run_dir, unattended, 4, spoil=_fails_at(LinkLost(GONE), 50, 50))
    assert outcome.state is State.FINISHED
    assert rig.attempts == 4
    assert states(unattended.run_dir)[3:] == ["held", "checking", "running", "finished"]
    held = next(event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held")
    assert (held.detail["reason"], held.detail["cause"]) == (f"link lost: {GONE}", "link")
    assert [event.detail["epoch"] for event in events(unattended.run_dir, "opened")] == [1, 2]
    (seam,) = events(unattended.run_dir, "seam")
    assert (seam.detail["tested"], seam.detail["steps"]) == (True, 0)
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(clean))


def test_fault_21_every_axis_is_told_to_stop_before_anything_else(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    outcome, rig = _unattended(small, unattended.run_dir, unattended, 1, spoil=_fails_at(LinkLost(GONE), 50, 50))
    assert outcome.state is State.FINISHED
    assert rig.pitch.stops == 2
    kinds = [event.kind for event in events(unattended.run_dir)]
    assert kinds.index("safe") < kinds.index("reconnect")


@pytest.mark.parametrize(("kind", "state"), [("stop", State.STOPPED), ("abort", State.ABORTED)])
def test_fault_21_stuck_link_is_given_up_only_by_stop_or_abort(
    small: Bench, tmp_path: Path, kind: str, state: State
) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={20_000: asks(kind)})
    outcome, rig = _unattended(small, unattended.run_dir, unattended, 10**6, spoil=_fails_at(LinkLost(GONE), 50, 10**6))
    assert outcome.state is state
    assert 15 < rig.attempts < 30, "growing pauses, at most a minute, over 1000 s"
    assert len(events(unattended.run_dir, "reconnect")) == 1, "the same refusal is written once"


def test_fault_21_what_keeps_the_lines_shut_by_now_is_told_beside_what_was_lost(small: Bench, tmp_path: Path) -> None:
    """Who has plugged the meter in again must not go on looking for it while the table stays away."""
    seen: list[tuple[str, str]] = []

    class TableStaysAway(RigReopenedLate):
        def reconnect(self) -> None:
            if self.attempts >= 2 and not seen:
                raise LinkLost("axes.pitch at /dev/ttyUSB3: cannot be opened; check the cable and the path")
            super().reconnect()

    def look(run: UnattendedRun) -> None:
        seen.append((status(run.run_dir).reason, (run.run_dir / "why.txt").read_text(encoding="utf-8")))

    unattended = UnattendedRun(tmp_path / "run", at={300: look})
    lost = _fails_at(LinkLost(GONE), 50, 50)
    outcome = run_unattended(small, unattended, rig_of=lambda rig: TableStaysAway(rig, 4, spoil=lost))
    assert outcome.state is State.FINISHED
    ((reason, page),) = seen
    words = "at the last try to open the lines: axes.pitch at /dev/ttyUSB3: cannot be opened"
    assert reason.startswith(f"link lost: {GONE}")
    assert words in reason
    assert words in page
    assert status(unattended.run_dir).reason == ""


def test_fault_22_what_answers_after_the_replug_is_asked_who_it_is(small: Bench, tmp_path: Path) -> None:
    """Addresses are stable ids; whatever sits there now is identified before anything moves.

    Detected: ports by stable names; every device is asked who it is after a reconnect.
    Response: another device trips before anything moves.
    """
    unattended = UnattendedRun(tmp_path / "run")

    class Other(RigReopenedLate):
        def reconnect(self) -> None:
            super().reconnect()
            self._identity = "HP3458A, other serial"

    outcome = run_unattended(
        small, unattended, rig_of=lambda rig: Other(rig, 2, spoil=_fails_at(LinkLost(GONE), 50, 50))
    )
    assert outcome.state is State.TRIPPED
    assert "not the devices of this run: readouts.dmm: was" in outcome.reason
    identities = [event.sequence for event in events(unattended.run_dir, "identities")]
    assert not [event for event in events(unattended.run_dir, "intent") if event.sequence > identities[-1]]


def test_fault_23_swapped_adapters_are_refused_by_what_the_devices_say(small: Bench, tmp_path: Path) -> None:
    """Detected: every device is asked who it is.
    Response: trip before anything moves; both are named.
    """
    unattended = UnattendedRun(tmp_path / "run")

    class Swapped(RigReopenedLate):
        def identities(self) -> dict[str, str]:
            found = dict(super().identities())
            if self.attempts:
                found["axes.pitch"], found["axes.roll"] = found["axes.roll"], found["axes.pitch"]
            return found

    outcome = run_unattended(
        small, unattended, rig_of=lambda rig: Swapped(rig, 1, spoil=_fails_at(LinkLost(GONE), 50, 50))
    )
    assert outcome.state is State.TRIPPED
    assert "axes.pitch: was" in outcome.reason
    assert "axes.roll: was" in outcome.reason


def test_an_axis_behind_whose_line_another_device_answers_is_not_told_to_stand(
    small: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What answers there obeys the last stop and reads back at rest: of the run's own axis that says nothing."""
    unattended = UnattendedRun(tmp_path / "run")

    class Other(RigReopenedLate):
        def reconnect(self) -> None:
            super().reconnect()
            monkeypatch.setattr(SupervisedAxis, "identify", lambda axis: f"another {axis.name}")

    outcome = run_unattended(
        small, unattended, rig_of=lambda rig: Other(rig, 2, spoil=_fails_at(LinkLost(GONE), 50, 50))
    )
    assert outcome.state is State.TRIPPED
    assert "not the devices of this run: axes.pitch: was" in outcome.reason
    assert "not every axis is known to stand still: pitch: another device answers on its line: was" in outcome.reason
    assert outcome.positions_deg == {}


@pytest.mark.parametrize("error", [DeviceSilent("dmm: no reply within 2 s"), DeviceNonsense("dmm: 12.x4")])
def test_fault_36_a_device_that_no_longer_answers_counts_as_a_lost_link_whatever_its_port_says(
    small: Bench, clean: Path, tmp_path: Path, error: Exception
) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    outcome, rig = _unattended(small, unattended.run_dir, unattended, 2, spoil=_fails_at(error, 50, 52))
    assert outcome.state is State.FINISHED
    assert len(events(unattended.run_dir, "void")) == small.plan.dwell.retries + 1
    assert rig.attempts == 2
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(clean))


def test_fault_36_a_device_that_never_gives_a_dwell_trips_in_the_end(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    outcome, rig = _unattended(
        small, unattended.run_dir, unattended, 1, spoil=_fails_at(DeviceSilent("dmm: silent"), 50, 10**6)
    )
    assert outcome.state is State.TRIPPED
    assert "lost 6 times without a dwell between" in outcome.reason
    assert rig.attempts == 5


def test_fault_45_an_axis_that_lost_its_home_is_only_homed_and_the_check_set_comes_first(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    """A controller that was switched off and on: no absolute move from a false zero, nothing but the reference move.

    Detected: homed flag of the machine at every look.
    Response: held; nothing but the reference move, then check set and seam test.
    """
    messages: list[str] = []

    class PowerCycled(FaultyRig):
        def __init__(self, rig: Rig) -> None:
            super().__init__(rig, look=self._after_the_cut)
            home, start_move = self.pitch.home, self.pitch.start_move
            self.pitch.home = lambda: (messages.append("home"), home())[1]  # type: ignore[method-assign]
            self.pitch.start_move = lambda deg: (messages.append("move"), start_move(deg))[1]  # type: ignore[method-assign]

        def _after_the_cut(self, state: AxisState) -> AxisState:
            is_cut = self.meter.read_so_far >= 60 and messages.count("home") < 2
            if is_cut and "cut" not in messages:
                messages.append("cut")
            return replace(state, is_homed=False) if is_cut else state

    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(small, unattended, rig_of=PowerCycled).state is State.FINISHED
    assert messages[messages.index("cut") + 1] == "home"
    assert states(unattended.run_dir)[3:] == ["held", "checking", "running", "finished"]
    assert "pitch: the axis is not homed" in str(
        [event.detail["reason"] for event in events(unattended.run_dir, "state")]
    )
    assert measured(dwells_of(unattended.run_dir)).keys() == measured(dwells_of(clean)).keys()


def test_a_stop_that_cannot_be_verified_leaves_a_run_that_a_person_can_take_up_again(
    small: Bench, tmp_path: Path
) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={50: asks("stop")})

    class Dead(RigReopenedLate):
        def reconnect(self) -> None:
            self.pitch.stop = self._refuse  # type: ignore[method-assign]
            super().reconnect()

        def _refuse(self) -> None:
            raise LinkLost(GONE)

    outcome = run_unattended(
        small, unattended, rig_of=lambda rig: Dead(rig, 10**6, spoil=_fails_at(LinkLost(GONE), 50, 10**6))
    )
    assert outcome.state is State.TRIPPED
    assert "not every axis is known to stand still" in outcome.reason


@dataclass
class _Device:
    """Answers who it is, or not."""

    name: str
    is_silent: bool

    def identify(self) -> str:
        if self.is_silent:
            raise DeviceSilent(f"{self.name}: no answer")
        return self.name


TABLES = ["axes.pitch", "axes.roll", "readouts.dmm", "environment.air"]


@pytest.mark.parametrize(
    ("silent", "told"),
    [
        (["axes.pitch"], ""),
        (["axes.pitch", "readouts.dmm"], "; no answer now from axes.pitch, readouts.dmm"),
        (TABLES, f"; no device of the rig answers ({', '.join(TABLES)}): look at what they share, such as power, a hub"
                 " or the network"),
    ],
)  # fmt: skip
def test_people_are_told_whether_one_line_is_silent_or_all(
    small: Bench, tmp_path: Path, silent: list[str], told: str
) -> None:
    """A dark hub takes every line: who is woken must not be sent to the one cable that was asked first."""
    unattended = UnattendedRun(tmp_path / "run")

    class Dark(FaultyRig):
        def by_table(self) -> dict[str, Identifiable]:
            return {name: _Device(name, name in silent) for name in TABLES}

    run_unattended(small, unattended, rig_of=lambda rig: Dark(rig, spoil=_fails_at(LinkLost(GONE), 50, 50)))
    (held,) = [heard for heard in unattended.heard if heard.event == "state" and heard.state is State.HELD]
    assert held.message == f"link lost: {GONE}{told}"


def test_who_is_asked_is_asked_for_no_longer_than_a_quarter_of_a_minute(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    asked: list[str] = []

    class Slow(FaultyRig):
        def by_table(self) -> dict[str, Identifiable]:
            class Waits(_Device):
                def identify(device) -> str:  # noqa: N805
                    asked.append(device.name)
                    self.clock.sleep(6.0)
                    return super().identify()

            return {name: Waits(name, True) for name in TABLES}

    run_unattended(small, unattended, rig_of=lambda rig: Slow(rig, spoil=_fails_at(LinkLost(GONE), 50, 50)))
    (held,) = [heard for heard in unattended.heard if heard.event == "state" and heard.state is State.HELD]
    assert asked == TABLES[:3]
    assert held.message.endswith("; no answer now from axes.pitch, axes.roll, readouts.dmm")
