"""The safe state: axes stopped and seen at rest, the chamber where the procedure wants it, whatever fails meanwhile."""

import os
import signal
import threading
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from small_run import bench
from unattended_run import UnattendedRun, asks, events, run_unattended

from procedures.journal.audit.audit_trail import interruptions_in
from procedures.journal.journal_reader import JournalReader
from procedures.records.states import State
from procedures.run.watch.safe_state import Safe, make_safe
from rig.abilities.abilities import AxisState, Environment
from rig.assembly.open_rig import open_rig
from rig.errors import DeviceFault, LinkLost
from rig.link.byte_stream import ByteStream

PLATEAU = "[environment]\nplateaus_degc = [30.0]\nsoak_s = 60.0\n{end}[check]"


@pytest.mark.parametrize(("end", "left_at_degc"), [("", 30.0), ("end_degc = 15.0\n", 15.0)])
def test_the_chamber_keeps_its_setpoint_unless_the_procedure_says_otherwise(
    tmp_path: Path, end: str, left_at_degc: float
) -> None:
    small = bench(tmp_path, procedure=(("[check]", PLATEAU.format(end=end)),))
    seen: list[float] = []

    class Kept(FaultyRig):
        def identities(self) -> dict[str, str]:
            self.chamber = self._rig.environments["air"]
            kept.append(self.chamber)
            return dict(super().identities())

    kept: list[Environment] = []
    unattended = UnattendedRun(tmp_path / "run", after={5: asks("stop")})
    unattended.run_dir.mkdir()
    from procedures.run.begin import begin

    with open_rig(small.rig) as rig:
        assert (
            begin(
                unattended.run_dir, small.header(unattended.run_dir), small.plan, Kept(rig), unattended, unattended
            ).state
            is State.STOPPED
        )
        seen.append(kept[0].setpoint_degc())
    assert seen == [left_at_degc]


def test_fault_20_gone_a_chamber_that_refuses_keeps_no_axis_from_its_stop_and_is_told(tmp_path: Path) -> None:
    small = bench(tmp_path, procedure=(("[check]", PLATEAU.format(end="end_degc = 15.0\n")),))

    class Refuses(FaultyRig):
        @property
        def environments(self):  # type: ignore[no-untyped-def]
            chamber = self._rig.environments["air"]
            if self.meter.read_so_far > 40:
                chamber.hold = self._refuse  # type: ignore[method-assign]
            return {"air": chamber}

        def _refuse(self, setpoint_degc: float) -> None:
            raise DeviceFault(f"air: setpoint {setpoint_degc:g} °C was acknowledged, but reads back 30 °C")

    unattended = UnattendedRun(tmp_path / "run", after={12: asks("stop")})
    outcome = run_unattended(small, unattended, rig_of=Refuses)
    assert outcome.state is State.TRIPPED, "a person must look"
    assert "air: setpoint 15 °C was acknowledged" in outcome.reason
    (safe,) = events(unattended.run_dir, "safe")
    assert set(safe.detail["positions_deg"]) == {"pitch", "roll"}  # type: ignore[call-overload]
    assert (outcome.cause, safe.detail["failures"]) == ("chamber", [])
    with JournalReader.open(unattended.run_dir) as reader:
        (stretch,) = interruptions_in(reader.events())
    assert "seen to stand: pitch at " in stretch.axes, "it was said that not every axis was seen to stand"


@pytest.mark.usefixtures("terminal_signals")
def test_fault_19_signals_during_the_stop_of_the_axes_change_nothing(tmp_path: Path) -> None:
    small = bench(tmp_path)

    class Nervous(FaultyRig):
        def __init__(self, rig: object) -> None:
            super().__init__(rig)  # type: ignore[arg-type]
            stop = self.pitch.stop

            def interrupted() -> None:
                for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT):
                    os.kill(os.getpid(), number)
                stop()

            self.pitch.stop = interrupted  # type: ignore[method-assign]

    unattended = UnattendedRun(tmp_path / "run", after={5: asks("stop")})
    outcome = run_unattended(small, unattended, rig_of=Nervous)
    assert (outcome.state, set(outcome.positions_deg)) == (State.STOPPED, {"pitch", "roll"})
    assert events(unattended.run_dir)[-1].detail["to"] == "stopped"


class _Heard:
    """A line that notes what goes over it."""

    def __init__(self, stream: ByteStream, heard: list[bytes]) -> None:
        self._stream, self._heard = stream, heard
        self.name, self.clock = stream.name, stream.clock
        self.read, self.discard_input, self.close = stream.read, stream.discard_input, stream.close

    def write(self, data: bytes) -> None:
        self._stream.write(data)
        self._heard.append(data)


@pytest.mark.parametrize("end", ["", "end_degc = 15.0\n"])
def test_nothing_is_asked_before_the_stop_where_lines_were_left_closed(tmp_path: Path, end: str) -> None:
    """A run that is held for a chamber is given up: what may move on the other lines waits for no answer."""
    small = bench(tmp_path, procedure=(("[check]", PLATEAU.format(end=end)),))
    heard: list[bytes] = []
    refusals = [0]

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        if key == "environment.air" and refusals[0]:
            refusals[0] -= 1
            raise LinkLost("air: the port is gone; check cable and adapter")
        return _Heard(open_line(), heard)

    with open_rig(small.rig, line_source=source) as rig:
        refusals[0] = 1
        with pytest.raises(LinkLost):
            rig.reconnect()
        heard.clear()
        safe = make_safe(rig, small.plan, is_open=False)
        assert heard[0] in (b"1 STOP\r\n", b"2 STOP\r\n")
        assert (safe.failures, safe.of_chamber, set(safe.positions_deg)) == ((), (), {"pitch", "roll"})
        if end:
            assert rig.environments["air"].setpoint_degc() == 15.0


def test_an_axis_that_moves_after_it_was_seen_at_rest_is_stopped_again(tmp_path: Path) -> None:
    """The last question before the end can itself move something: a servo controller goes home at a damaged one."""
    small = bench(tmp_path)
    with open_rig(small.rig) as rig:
        looks_after_the_stop = count()
        has_moved = False

        def look(state: AxisState) -> AxisState:
            nonlocal has_moved
            if threading.current_thread() is threading.main_thread():  # the stop itself looks in a thread of its own
                has_moved = has_moved or next(looks_after_the_stop) == 1
            return replace(state, position_deg=5.0 if has_moved else 0.0)

        spoilt = FaultyRig(rig, look=look)
        safe = make_safe(spoilt, small.plan)
    assert spoilt.pitch.stops == 2
    assert safe.failures == ()
    assert safe.positions_deg == {"pitch": 5.0, "roll": 0.0}


@pytest.mark.parametrize("answers", [True, False])
def test_an_axis_that_is_seen_at_rest_by_neither_look_is_told_and_stopped_again(tmp_path: Path, answers: bool) -> None:
    """Missing in both looks it agreed with itself: a stop that a damaged command undid was told as a rest."""
    from procedures.run.watch.safe_state import MOST_STOPS

    small = bench(tmp_path)
    with open_rig(small.rig) as rig:

        def look(state: AxisState) -> AxisState:
            if threading.current_thread() is threading.main_thread():  # the stop itself looks in a thread of its own
                if not answers:
                    raise DeviceFault("pitch: no answer")
                return replace(state, is_moving=True)
            return state

        spoilt = FaultyRig(rig, look=look)
        safe = make_safe(spoilt, small.plan)
    assert spoilt.pitch.stops == 1 + MOST_STOPS
    assert "not every axis is known to stand still: pitch moves again after it was seen at rest" in safe.failures[0]
    assert (set(safe.positions_deg), safe.cause) == ({"roll"}, "standstill")


@pytest.mark.parametrize("moment", [2, 5])
def test_an_abort_stops_every_axis_though_every_new_thread_dies_before_it_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: int
) -> None:
    """As they do where no memory is left for the first line that they run."""
    small = bench(tmp_path)
    monkeypatch.setattr("rig.threads.start_new_thread", lambda *_: 0)
    outcome = run_unattended(small, UnattendedRun(tmp_path / "run", after={moment: asks("abort")}))
    assert outcome.state is State.ABORTED
    assert set(outcome.positions_deg) == set(small.rig.axes)


def test_a_run_without_memory_asks_the_stop_guard_before_its_own_stops_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []

    def out_of_memory(_: object) -> None:
        raise MemoryError

    def heard(_: object) -> bool:
        done.append("the guard")
        return True

    def safe(rig: object, plan: object, **how: bool) -> Safe:
        done.append("our stops")
        return Safe(())

    monkeypatch.setattr("procedures.run.engine.Epoch.run", out_of_memory)
    monkeypatch.setattr("procedures.run.engine.stop_by_guard", heard)
    monkeypatch.setattr("procedures.run.engine.make_safe", safe)
    with pytest.raises(MemoryError):
        run_unattended(bench(tmp_path), UnattendedRun(tmp_path / "run"))
    assert done == ["the guard", "our stops"]
    last = events(tmp_path / "run", "state")[-1].detail
    assert "MemoryError" in str(last["reason"])
    assert "the stop guard was asked first to stop every axis" in str(last["reason"])
