"""A line that breaks while an axis turns at a rate: it is opened again, and the axis stopped, before anything ends."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from cut_line import CutLine, cut_line
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served

from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import SimulatedRig
from rig.clock import SystemClock
from rig.description.read import read_rig
from rig.errors import DeviceFault, LinkLost
from rig.guard.ask import of_rig, stop
from rig.guard.outcomes import STOP_SENT
from rig.guard.process import TIMES
from rig.motion.jog import turn_for
from rig.motion.move import home_and_arrive
from rig.motion.out_of_reach import open_in_time, out_of_reach
from rig.motion.standstill import stop_what_moves
from rig.twins.zaber import Stage

CLOCK = SystemClock()
RATE_DPS = 10.0
REFUSALS = 2
FOR_GOOD = 1_000_000


@contextmanager
def _at_lines_that_break(folder: Path, *devices: str) -> Iterator[tuple[Rig, list[CutLine], SimulatedRig]]:
    """Roll, homed, and a line to each device that can be cut."""
    with served(folder, CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (simulated, rig_file), ExitStack() as lines:
        cut, text = [], rig_file.read_text(encoding="utf-8")
        for device in devices:
            address = simulated.addresses[device].removeprefix("prologix+").partition("#")[0]
            cut.append(lines.enter_context(cut_line(address)))
            text = text.replace(address, cut[-1].address)
        rig_file.write_text(text, encoding="utf-8")
        with open_rig(read_rig(rig_file), rig_file=rig_file) as rig:
            home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
            yield rig, cut, simulated


@contextmanager
def _at_a_line_that_breaks(folder: Path) -> Iterator[tuple[Rig, CutLine, SimulatedRig]]:
    """Roll, homed, over TCP."""
    with _at_lines_that_break(folder, "axes.roll") as (rig, (line,), simulated):
        yield rig, line, simulated


def _rate_dps(simulated: SimulatedRig) -> float:
    return simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s())


def test_an_axis_whose_line_is_reset_while_it_turns_by_hand_is_stopped_when_the_line_is_back(tmp_path: Path) -> None:
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):

        def wait(duration_s: float) -> None:
            rig.clock.sleep(duration_s)
            line.cut(REFUSALS)

        with pytest.raises(LinkLost, match="what was sent last is in doubt"):
            turn_for(rig, "roll", RATE_DPS, 60.0, wait)
        assert _rate_dps(simulated) == 0.0
        assert line.callers > REFUSALS


def test_a_stage_that_sends_its_alerts_on_and_on_is_stopped_and_seen_to_stand(
    tmp_path: Path,
) -> None:
    """Alerts as in Zaber's ASCII protocol manual, "Alerts": a state that changed, told unasked."""
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):

        def wait(duration_s: float) -> None:
            rig.clock.sleep(duration_s)
            line.says = b"!01 1 IDLE --\r\n"
            line.cut(REFUSALS)

        with pytest.raises(LinkLost, match="what was sent last is in doubt"):
            turn_for(rig, "roll", RATE_DPS, 60.0, wait)
        assert _rate_dps(simulated) == 0.0


def test_a_stage_on_a_line_that_is_never_quiet_again_is_stopped_though_nobody_can_see_it(tmp_path: Path) -> None:
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):
        began_s = CLOCK.monotonic_s()

        def wait(duration_s: float) -> None:
            rig.clock.sleep(duration_s)
            line.says = b"\x15~ 4711 ~\r\n"
            line.cut(REFUSALS)

        with pytest.raises(DeviceFault, match=r"roll: .*does not fall quiet.*; use the stop button at the machine"):
            turn_for(rig, "roll", RATE_DPS, 60.0, wait)
        assert _rate_dps(simulated) == 0.0
        assert CLOCK.monotonic_s() - began_s < 60.0


def test_a_line_that_does_not_come_back_is_waited_for_so_long_and_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rig.motion.out_of_reach.BACK_S", 1.0)
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):

        def wait(duration_s: float) -> None:
            rig.clock.sleep(duration_s)
            line.cut(FOR_GOOD)

        with pytest.raises(DeviceFault, match=r"roll: .*; use the stop button at the machine"):
            turn_for(rig, "roll", RATE_DPS, 60.0, wait)
        assert out_of_reach(rig)
        assert _rate_dps(simulated) == RATE_DPS, "nobody reaches it"
        line.cut(0)
        assert open_in_time(rig) == ""
        assert not out_of_reach(rig)
        rig.axes["roll"].stop()


def test_another_device_on_the_line_of_an_axis_that_turned_by_hand_never_passes_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody had asked before who answers there: what stops and stands is a stage that stood anyway."""
    (tmp_path / "other").mkdir()
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):
        defaults = Stage.__init__.__defaults__
        assert defaults is not None
        monkeypatch.setattr(Stage.__init__, "__defaults__", tuple(99999 if it == 12345 else it for it in defaults))
        with served(tmp_path / "other", CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (elsewhere, _):

            def wait(duration_s: float) -> None:
                rig.clock.sleep(duration_s)
                line.lead_to(elsewhere.addresses["axes.roll"])
                line.cut(REFUSALS)

            with pytest.raises(DeviceFault, match=r"roll: another device answers on its line: .* use the stop button"):
                turn_for(rig, "roll", RATE_DPS, 60.0, wait)
            line.cut(FOR_GOOD)
        assert _rate_dps(simulated) == RATE_DPS, "nobody reaches it"


def test_a_line_that_breaks_while_every_axis_stands_is_not_waited_for(tmp_path: Path) -> None:
    with _at_a_line_that_breaks(tmp_path) as (rig, line, _):
        line.cut(FOR_GOOD)
        with pytest.raises(LinkLost):
            rig.axes["roll"].state()
        assert not out_of_reach(rig)


def test_a_meter_that_stays_away_keeps_no_turning_axis_from_its_stop(tmp_path: Path) -> None:
    """Its adapter is dead when the line of the axis is back. A line that is whole is kept."""
    devices = "axes.roll", "axes.pitch", "readouts.dmm"
    with _at_lines_that_break(tmp_path, *devices) as (rig, (line, whole, dead), simulated):

        def wait(duration_s: float) -> None:
            rig.clock.sleep(duration_s)
            dead.cut(FOR_GOOD)
            line.cut(REFUSALS)

        with pytest.raises(LinkLost, match="what was sent last is in doubt"):
            turn_for(rig, "roll", RATE_DPS, 60.0, wait)
        assert _rate_dps(simulated) == 0.0
        assert whole.callers == 1
        assert "readouts.dmm" in rig.open_lost(rig.clock.monotonic_s() + 10.0)
        dead.cut(0)
        assert rig.open_lost(rig.clock.monotonic_s() + 10.0) == ""
        assert rig.readouts["dmm"].identify()
        assert whole.callers == 1


def test_whoever_opens_all_lines_again_stops_what_turned_though_a_meter_stays_away(tmp_path: Path) -> None:
    """A run that is held and a bench that is open do so; a meter may be away for a night."""
    with _at_lines_that_break(tmp_path, "axes.roll", "readouts.dmm") as (rig, (line, dead), simulated):
        rig.axes["roll"].start_rate(RATE_DPS)  # type: ignore[attr-defined]
        dead.cut(FOR_GOOD)
        line.cut(0)
        with pytest.raises(LinkLost, match="connection lost"):
            rig.reconnect()
        stop_what_moves(rig.axes, rig.clock, rig.motion)
        assert _rate_dps(simulated) == 0.0
        assert not out_of_reach(rig)


def test_who_opens_all_lines_again_and_again_calls_at_those_alone_that_stay_away(tmp_path: Path) -> None:
    """A run that is held for a night tries once a minute; what was open at the first attempt is kept."""
    with _at_lines_that_break(tmp_path, "axes.roll", "readouts.dmm") as (rig, (line, dead), _):
        dead.cut(FOR_GOOD)
        for _ in range(3):
            with pytest.raises(LinkLost, match="connection lost"):
                rig.reconnect()
        assert line.callers == 2
        line.cut(0)
        dead.cut(0)
        rig.reconnect()
        assert line.callers == 3, "it was lost meanwhile"
        assert set(rig.identities()) >= {"axes.roll", "readouts.dmm"}
        rig.reconnect()
        assert line.callers == 4, "nothing stays away: whatever fell silent is opened anew"


def test_a_line_that_the_stop_guard_opened_by_itself_is_given_back_to_who_opens_it(tmp_path: Path) -> None:
    """Somebody had the axes stopped while it was closed here; its device server takes one caller at a time."""
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):
        rig.axes["roll"].start_rate(RATE_DPS)  # type: ignore[attr-defined]
        line.cut(refusals=1)
        assert rig.open_lost(rig.clock.monotonic_s() + 10.0)
        line.is_single = True
        line.heard.clear()
        (guard,) = of_rig(str(tmp_path / "ports.toml"))
        told = stop(guard, ["roll"], "ann")
        assert told is not None
        assert told["roll"] == STOP_SENT
        until_s = CLOCK.monotonic_s() + 10.0
        while line.heard.count(b"stop") < TIMES:
            assert CLOCK.monotonic_s() < until_s
            rig.sign_of_life()
            CLOCK.sleep(0.02)
        assert _rate_dps(simulated) == 0.0
        assert open_in_time(rig) == ""
        assert rig.axes["roll"].identify()


def test_while_an_axis_that_turns_is_away_no_time_goes_to_other_lines(tmp_path: Path) -> None:
    with _at_lines_that_break(tmp_path, "axes.roll", "readouts.dmm") as (rig, (line, dead), _):
        rig.axes["roll"].start_rate(RATE_DPS)  # type: ignore[attr-defined]
        dead.cut(FOR_GOOD)
        line.cut(FOR_GOOD)
        before = dead.callers
        assert "axes.roll" in rig.open_lost(rig.clock.monotonic_s() + 10.0)
        assert dead.callers == before
        before = line.callers
        assert rig.open_lost(rig.clock.monotonic_s()), "the time is over"
        assert line.callers == before
        line.cut(0)
        assert open_in_time(rig) == ""
        stop_what_moves(rig.axes, rig.clock, rig.motion)
