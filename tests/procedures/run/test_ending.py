"""Which of two errors a run is told to end by, where the second came on the way out of the first."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from asking import put
from faulty_rig import FaultyRig
from small_run import Bench, bench
from unattended_run import RigReopenedLate, UnattendedRun, events, run_unattended, states

from procedures.errors import StorageFailed
from procedures.journal.sidecar.last_words import STORAGE
from procedures.records.states import State
from procedures.run.ending import Ending, RunEnds, decision, defect_of, ending_of
from procedures.run.judgement.alarm import TrustLost
from rig.abilities.abilities import AxisState, Burst
from rig.errors import DeviceFault, DeviceRefused, DeviceSilent, GuardLost, LinkLost, MotionBreach, RigError, WaitEnded
from rig.local_time import at_both
from rig.motion.move import NotSeenAtRest

BY_ANNA = Ending(State.ABORTED, "smoke", "anna")
GONE = "roll: the port is gone"
UNSEEN = f"stop: not every axis is known to stand still: {GONE}; use the stop button at the machine"


class _Asked:
    """What was asked of a run."""

    def __init__(self, at_once: Ending | None = None) -> None:
        self.at_once = at_once


DECIDED: dict[str, tuple[BaseException, Ending | None, Ending]] = {
    "abort": (WaitEnded("abort", "anna"), BY_ANNA, BY_ANNA),
    "told to end": (
        WaitEnded("stop at once", "signal SIGTERM"),
        Ending(State.STOPPED, "told to end", "signal SIGTERM"),
        Ending(State.STOPPED, "told to end", "signal SIGTERM"),
    ),
    "by the guard": (
        WaitEnded("the axes were stopped", "bert"),
        None,
        Ending(State.ABORTED, "the axes were stopped", "bert"),
    ),
    "stop": (RunEnds(Ending(State.STOPPED, "enough", "anna")), None, Ending(State.STOPPED, "enough", "anna")),
    "limit": (
        RunEnds(Ending(State.STOPPED, "[stop] max_duration_s = 60 s has passed", "procedure")),
        None,
        Ending(State.STOPPED, "[stop] max_duration_s = 60 s has passed", "procedure"),
    ),
    "interlock": (
        RunEnds(Ending(State.TRIPPED, "no coolant", cause="interlock")),
        None,
        Ending(State.TRIPPED, "no coolant", cause="interlock"),
    ),
    "disk": (StorageFailed("the disk is full"), None, Ending(State.STOPPED, "the disk is full", cause=STORAGE)),
    "breach": (
        MotionBreach("roll left its way"),
        None,
        Ending(State.TRIPPED, "roll left its way", cause="supervision"),
    ),
    "guard": (GuardLost("the guard is gone"), None, Ending(State.TRIPPED, "the guard is gone", cause="supervision")),
    "keyboard": (KeyboardInterrupt(), None, Ending(State.ABORTED, "interrupted from the keyboard", "Ctrl-C")),
}
MET: dict[str, tuple[Callable[[], RigError], str, str]] = {
    "stop failed": (lambda: NotSeenAtRest(UNSEEN, GONE), f"a stop on the way out failed: {GONE}", ""),
    "line lost": (lambda: LinkLost(GONE), GONE, ""),
    "silent": (lambda: DeviceSilent("roll: no answer"), "roll: no answer", ""),
    "refused": (lambda: DeviceRefused("meter: no"), "meter: no", ""),
    "fault": (lambda: DeviceFault("roll went on"), "roll went on", "device"),
    "breach": (lambda: MotionBreach("yaw turned the wrong way"), "yaw turned the wrong way", "supervision"),
}


@contextmanager
def _on_the_way_out(second: BaseException) -> Iterator[None]:
    try:
        yield
    finally:
        raise second


def _both(first: BaseException, *later: BaseException) -> BaseException:
    """Return what arrives where every error came on the way out of the one before."""
    first.__context__ = None
    arriving = first
    for second in later:
        with pytest.raises(type(second)) as caught, _on_the_way_out(second):
            raise arriving
        arriving = caught.value
    return arriving


@pytest.mark.parametrize("met", MET)
@pytest.mark.parametrize("first", DECIDED)
def test_what_decided_the_end_is_told_first_and_what_failed_behind_it_is_told_as_well(
    first: str, met: str, tmp_path: Path
) -> None:
    decided, at_once, expected = DECIDED[first]
    make, words, cause = MET[met]
    ending = ending_of(_both(decided, make()), None, _Asked(at_once), tmp_path)
    assert (ending.state, ending.reason, ending.by, ending.cause) == (
        expected.state,
        expected.reason,
        expected.by,
        expected.cause,
    )
    assert ending.met_in_words(last_stop_failed=False) == [words]
    assert ending.fault_met == cause


def test_a_stop_that_failed_is_left_to_the_last_stop_where_that_fails_too(tmp_path: Path) -> None:
    ending = ending_of(_both(WaitEnded("abort", "anna"), NotSeenAtRest(UNSEEN, GONE)), None, _Asked(BY_ANNA), tmp_path)
    assert ending.met_in_words(last_stop_failed=True) == []


def test_all_that_failed_on_the_way_out_is_told_in_its_order(tmp_path: Path) -> None:
    error = _both(WaitEnded("abort", "anna"), OSError("[Errno 5]"), LinkLost("coil: gone"), NotSeenAtRest(UNSEEN, GONE))
    ending = ending_of(error, None, _Asked(BY_ANNA), tmp_path)
    assert ending.met_in_words(last_stop_failed=False) == ["coil: gone", f"a stop on the way out failed: {GONE}"]


def test_who_aborted_is_told_where_the_disk_refused_to_record_it(tmp_path: Path) -> None:
    ending = ending_of(StorageFailed("the disk is full"), None, _Asked(BY_ANNA), tmp_path)
    assert (ending.state, ending.cause) == (State.STOPPED, STORAGE)
    assert ending.reason == "the disk is full; it was to be aborted: smoke (asked for by anna)"


def test_who_aborted_is_told_where_a_defect_came_on_the_way_out(tmp_path: Path) -> None:
    error = _both(WaitEnded("abort", "anna"), TypeError("no number"))
    ending = ending_of(error, None, _Asked(BY_ANNA), tmp_path)
    assert defect_of(error, None) is error
    assert ending.state is State.FAILED
    assert ending.reason == (
        "a defect of calrig: TypeError: no number; it was to be aborted: smoke (asked for by anna)"
    )


def test_a_defect_is_one_where_the_stop_on_its_way_out_fails() -> None:
    defect = TypeError("no number")
    assert defect_of(_both(defect, NotSeenAtRest(UNSEEN, GONE)), None) is defect
    assert defect_of(_both(LinkLost(GONE), NotSeenAtRest(UNSEEN, GONE)), None) is None


def test_a_line_that_broke_while_an_axis_turned_trips_as_that(tmp_path: Path) -> None:
    ending = ending_of(_both(LinkLost(GONE), NotSeenAtRest(UNSEEN, GONE)), None, _Asked(), tmp_path)
    assert ending == Ending(State.TRIPPED, GONE, cause="broken line")


def test_who_asked_for_another_end_while_a_stop_failed_is_told(tmp_path: Path) -> None:
    ending = ending_of(_both(LinkLost(GONE), NotSeenAtRest(UNSEEN, GONE)), None, _Asked(BY_ANNA), tmp_path)
    assert ending.state is State.TRIPPED
    assert ending.reason.startswith(f"{GONE}; meanwhile it was to be aborted")
    assert "anna" in ending.reason
    assert "smoke" in ending.reason


@pytest.mark.parametrize("second", [NotSeenAtRest(UNSEEN, GONE), LinkLost(GONE), DeviceFault("roll stalled")])
def test_what_whoever_began_the_run_was_handling_decides_nothing(second: RigError, tmp_path: Path) -> None:
    outer = KeyboardInterrupt()
    error = _both(outer, second)
    assert decision(error, outer) is None
    assert ending_of(error, outer, _Asked(), tmp_path).reason == str(second)


def test_what_was_answered_by_a_new_epoch_decides_nothing() -> None:
    assert (
        decision(_both(MotionBreach("roll left its way"), TrustLost("home", "no home"), LinkLost(GONE)), None) is None
    )


def _trip_found_in_a_breach(trip: RunEnds) -> None:
    try:
        raise MotionBreach("roll left its way")
    except MotionBreach as breach:
        raise trip from breach


def test_a_trip_that_was_raised_from_a_breach_keeps_its_own_words() -> None:
    trip = RunEnds(Ending(State.TRIPPED, "roll was found moving", cause="interlock"))
    with pytest.raises(RunEnds) as caught:
        _trip_found_in_a_breach(trip)
    assert decision(caught.value, None) is trip


HEARD = "the stop guard told the axes to stop at once"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


@pytest.mark.parametrize("second", [DeviceSilent("dmm: no answer"), LinkLost("dmm: the port is gone")])
def test_a_stop_that_the_guard_heard_is_obeyed_where_a_device_fails_behind_it(
    small: Bench, tmp_path: Path, second: RigError
) -> None:
    """Nothing is measured again, and no line is opened anew: somebody stopped the axes."""

    def spoil(number: int, burst: Burst) -> Burst:
        if number == 50:
            with _on_the_way_out(second):
                raise WaitEnded(HEARD, "bert")
        return burst

    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=lambda rig: RigReopenedLate(rig, 1, spoil=spoil))
    assert outcome.state is State.ABORTED
    assert outcome.reason == f"{HEARD}; {second} (asked for by bert)"
    assert events(unattended.run_dir, "void") == []
    assert "held" not in states(unattended.run_dir)


def test_a_stop_that_the_guard_heard_ends_a_run_that_waits_for_its_lines(small: Bench, tmp_path: Path) -> None:
    class Stopped(RigReopenedLate):
        def reconnect(self) -> None:
            super().reconnect()
            if self.attempts == 1:
                raise WaitEnded(HEARD, "bert")

    def spoil(number: int, burst: Burst) -> Burst:
        if number == 50:
            raise LinkLost("dmm: the port is gone")
        return burst

    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=lambda rig: Stopped(rig, 1, spoil=spoil))
    assert (outcome.state, outcome.reason) == (State.ABORTED, f"{HEARD} (asked for by bert)")


def test_a_fault_on_the_way_out_trips_the_run_and_tells_who_stopped_it(small: Bench, tmp_path: Path) -> None:
    heard: list[str] = []

    def spoil(number: int, burst: Burst) -> Burst:
        if number == 50:
            heard.append(at_both(unattended.rig.clock.now_utc(), to_the_second=True))
            with _on_the_way_out(MotionBreach("pitch moved unasked")):
                raise WaitEnded(HEARD, "bert")
        return burst

    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=lambda rig: RigReopenedLate(rig, 1, spoil=spoil))
    assert (outcome.state, outcome.cause) == (State.TRIPPED, "supervision")
    assert outcome.reason == f"the run was aborted {heard[0]}: {HEARD}; pitch moved unasked (asked for by bert)"


def test_when_a_run_was_aborted_is_when_somebody_asked_for_it(small: Bench, tmp_path: Path) -> None:
    """Before its axes were seen to stand, which takes its time, and a device fails meanwhile."""
    asked: list[str] = []

    def abort(unattended: UnattendedRun) -> None:
        asked.append(at_both(unattended.rig.clock.now_utc(), to_the_second=True))
        put(unattended.spool, "abort", "bert", "smoke")

    def look(state: AxisState) -> AxisState:
        if asked:
            unattended.rig.clock.sleep(30.0)
            raise DeviceFault("pitch: its drive reports a fault")
        return state

    unattended = UnattendedRun(tmp_path / "run", after={5: abort})
    outcome = run_unattended(small, unattended, rig_of=lambda rig: FaultyRig(rig, look=look))
    assert outcome.state is State.TRIPPED
    assert outcome.reason.startswith(f"the run was aborted {asked[0]}: smoke; "), outcome.reason
