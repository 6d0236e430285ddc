"""Cables that wind up. The twin's own body says how far they really are; FAULTS 54: three turns and a crash."""

from pathlib import Path

import pytest
from example_files import ROOT
from motion_bench import MotionBench, motion_bench, settings_of
from table_bench import virtual_clock

from ams.whole_file import replace_file
from rig.assembly.open_rig import open_rig
from rig.cables.cable import CableGuard
from rig.cables.cable_memory import KeptInFile, Unkept, memory_of
from rig.cables.winding import Winding
from rig.description.read import read_rig
from rig.devices.rate_table import RateTableSettings
from rig.errors import DescriptionError, DeviceFault, RequestRefused
from rig.motion.move import home_and_arrive, move_and_arrive


def _bench() -> MotionBench:
    bench = motion_bench("zaber", speed_dps=90.0)
    bench.home_all()
    return bench


def _guard(bench: MotionBench, path: Path, wrap_turns: float = 4.0) -> CableGuard:
    """A process that has just begun: a driver that remembers nothing, and the file."""
    guard = CableGuard(bench.pitch, wrap_turns, KeptInFile(path, replace_file), bench.clock)
    guard.state()
    return guard


def _turn(bench: MotionBench, guard: CableGuard, rate_dps: float, seconds: float) -> None:
    guard.start_rate(rate_dps)
    for _ in range(int(seconds)):
        bench.clock.sleep(1.0)
        guard.turn_look(bench.clock)
    guard.stop()
    bench.clock.sleep(5.0)
    for _ in range(2):  # a single look does not show that it rests
        guard.state()


def _watch(bench: MotionBench, guard: CableGuard) -> None:
    for _ in range(100):
        bench.clock.sleep(0.5)
        guard.turn_look(bench.clock)


def test_it_counts_what_the_body_really_turned(tmp_path: Path) -> None:
    bench = _bench()
    guard = _guard(bench, tmp_path / "pitch.json")
    _turn(bench, guard, 36.0, 20.0)
    assert guard.wound_deg == pytest.approx(bench.true_deg, abs=1e-3)
    assert guard.wound_deg > 700.0
    move_and_arrive(guard, 0.0, bench.clock, bench.clock.sleep)
    assert guard.wound_deg == pytest.approx(0.0, abs=1e-3)


def test_fault_54_three_turns_and_a_crash_are_not_forgotten(tmp_path: Path) -> None:
    bench, path = _bench(), tmp_path / "state" / "pitch.json"
    before = _guard(bench, path)
    before.start_rate(36.0)
    bench.clock.sleep(31.0)  # killed here: nothing more was written, and the axis turned on
    after = _guard(bench, path)
    after.stop()
    bench.clock.sleep(5.0)
    after.state()
    assert after.wound_deg == pytest.approx(bench.true_deg, abs=1e-3)
    assert after.wound_deg > 3.0 * 360.0
    with pytest.raises(RequestRefused, match=r"wound \+3\.\d\d revolutions, allowed 4 either way.*--to 0"):
        after.require_room(360.0)
    after.require_room(-360.0)  # the other way they unwind
    again = _guard(bench, path)
    assert again.wound_deg == pytest.approx(after.wound_deg, abs=1e-3)


def test_fault_54_the_cables_end_stops_a_turn_that_goes_on(tmp_path: Path) -> None:
    """Detected: a count of turns in a synced file beside the run, kept through kills.
    Response: refused beyond what the cables bear; a turn that goes on is stopped; unwound before homing; where nobody
    knows how far they are wound, no rate until a person has looked.
    """
    bench = _bench()
    guard = _guard(bench, tmp_path / "pitch.json", wrap_turns=1.0)
    guard.start_rate(90.0)
    with pytest.raises(DeviceFault, match=r"wound \+1\.\d\d revolutions, allowed 1 either way.*unwind"):
        _watch(bench, guard)
    bench.clock.sleep(5.0)
    rested_deg = bench.true_deg
    assert rested_deg < 2.0 * 360.0
    bench.clock.sleep(5.0)
    assert bench.true_deg == rested_deg


def test_a_wound_axis_unwinds_before_it_homes(tmp_path: Path) -> None:
    bench = _bench()
    guard = _guard(bench, tmp_path / "pitch.json")
    _turn(bench, guard, -90.0, 12.0)
    assert guard.wound_deg < -2.0 * 360.0
    home_and_arrive(guard, bench.clock, bench.clock.sleep)
    assert bench.true_deg == pytest.approx(0.0, abs=1e-3)
    assert guard.wound_deg == pytest.approx(0.0, abs=1e-3)


def test_power_lost_while_it_turned_means_that_nobody_knows(tmp_path: Path) -> None:
    bench, path = _bench(), tmp_path / "pitch.json"
    before = _guard(bench, path)
    before.start_rate(36.0)
    bench.clock.sleep(31.0)
    bench.twin.stages[1].power_cycle(bench.clock.monotonic_s())
    for _ in range(2):  # also for the process behind the next one
        guard = _guard(bench, path)
        home_and_arrive(guard, bench.clock, bench.clock.sleep)
        with pytest.raises(RequestRefused, match=f"nobody knows how far its cables are wound.*remove {path}"):
            guard.start_rate(10.0)
        assert move_and_arrive(guard, 10.0, bench.clock, bench.clock.sleep) == pytest.approx(10.0, abs=0.01)
    path.unlink()
    guard = _guard(bench, path)
    guard.start_rate(10.0)


def test_power_lost_at_rest_with_wound_cables_stays_a_doubt_whatever_moves_come_between(tmp_path: Path) -> None:
    bench, path = _bench(), tmp_path / "pitch.json"
    guard = _guard(bench, path)
    _turn(bench, guard, 90.0, 9.0)
    assert bench.true_deg > 2.0 * 360.0
    bench.twin.stages[1].power_cycle(bench.clock.monotonic_s())
    for process in range(3):
        home_and_arrive(guard, bench.clock, bench.clock.sleep)
        move_and_arrive(guard, 10.0 + 20.0 * process, bench.clock, bench.clock.sleep)
        assert guard.is_in_doubt
        with pytest.raises(RequestRefused, match=f"nobody knows how far its cables are wound.*remove {path}"):
            guard.require_room(10.0)
        guard = _guard(bench, path)
    path.unlink()
    _guard(bench, path).start_rate(10.0)


def test_a_doubt_that_cannot_be_kept_lets_no_rate_through_and_a_look_is_answered(tmp_path: Path) -> None:
    bench, path = _bench(), tmp_path / "pitch.json"
    _turn(bench, _guard(bench, path), 90.0, 9.0)
    filed = path.read_bytes()
    bench.twin.stages[1].power_cycle(bench.clock.monotonic_s())
    guard = CableGuard(bench.pitch, 4.0, KeptInFile(path, None), bench.clock)
    home_and_arrive(guard, bench.clock, bench.clock.sleep)
    assert guard.state().is_homed
    assert path.read_bytes() == filed
    with pytest.raises(RequestRefused, match="nobody knows"):
        guard.start_rate(10.0)


def test_a_count_that_leaps_at_rest_is_another_count(tmp_path: Path) -> None:
    """Power lost and homed at the panel between two looks of one process: the machine was homed in both."""
    bench, path = _bench(), tmp_path / "pitch.json"
    guard = _guard(bench, path)
    _turn(bench, guard, 90.0, 9.0)
    bench.twin.stages[1].power_cycle(bench.clock.monotonic_s())
    bench.pitch.home()
    bench.clock.sleep(60.0)
    assert guard.state().is_homed
    assert guard.is_in_doubt
    assert _guard(bench, path).is_in_doubt


def test_a_move_of_a_process_that_has_not_looked_yet_trusts_no_count(tmp_path: Path) -> None:
    bench, path = _bench(), tmp_path / "pitch.json"
    _turn(bench, _guard(bench, path), 90.0, 9.0)
    bench.twin.stages[1].power_cycle(bench.clock.monotonic_s())
    bench.pitch.home()
    bench.clock.sleep(60.0)
    guard = CableGuard(bench.pitch, 4.0, KeptInFile(path, replace_file), bench.clock)
    guard.start_move(10.0)
    bench.clock.sleep(60.0)
    assert guard.state().is_homed
    assert _guard(bench, path).is_in_doubt


def test_power_lost_at_rest_and_unwound_is_no_doubt(tmp_path: Path) -> None:
    bench, path = _bench(), tmp_path / "pitch.json"
    guard = _guard(bench, path)
    _turn(bench, guard, 36.0, 5.0)
    move_and_arrive(guard, 5.0, bench.clock, bench.clock.sleep)
    bench.twin.stages[1].power_cycle(bench.clock.monotonic_s())
    after = _guard(bench, path)
    home_and_arrive(after, bench.clock, bench.clock.sleep)
    after.require_room(360.0)


def test_the_memory_is_whole_or_what_it_was(tmp_path: Path) -> None:
    memory = KeptInFile(tmp_path / "deep" / "yaw.json", replace_file)
    assert memory.read() is None
    memory.write(Winding(1080.0, 0.5, is_turning=True))
    assert KeptInFile(tmp_path / "deep" / "yaw.json", replace_file).read() == Winding(1080.0, 0.5, is_turning=True)
    assert [file.name for file in (tmp_path / "deep").iterdir()] == ["yaw.json"]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"format": "calrig cable 9"}', '{"format": "calrig cable 1"}'])
def test_a_damaged_memory_is_told_and_nothing_is_guessed(tmp_path: Path, text: str) -> None:
    (tmp_path / "yaw.json").write_text(text)
    with pytest.raises(DescriptionError, match=r"yaw\.json: cannot be read: .*unwind the cables by hand"):
        CableGuard(_bench().pitch, 3.0, KeptInFile(tmp_path / "yaw.json", replace_file), virtual_clock())


def test_a_memory_that_cannot_be_kept_keeps_the_axis_from_turning() -> None:
    bench = _bench()
    guard = CableGuard(bench.pitch, 3.0, KeptInFile(Path("/proc/calrig/pitch.json"), replace_file), bench.clock)
    with pytest.raises(DescriptionError, match=r"cannot be written: .*nothing was turned"):
        guard.start_rate(10.0)
    assert not bench.pitch.state().is_moving


def test_a_rig_that_was_opened_without_a_writer_turns_no_cables() -> None:
    bench = _bench()
    guard = CableGuard(bench.pitch, 3.0, KeptInFile(Path("/nowhere/pitch.json"), None), bench.clock)
    with pytest.raises(DescriptionError, match=r"opened without a writer of files; nothing was turned"):
        guard.start_rate(10.0)
    assert not bench.pitch.state().is_moving


def test_a_twin_begins_unwound_with_its_process() -> None:
    assert Unkept().read() is None


def test_an_open_rig_guards_the_axes_whose_cables_wind_up_and_no_others() -> None:
    description = read_rig(ROOT / "examples" / "rate-table" / "rig.toml")
    with open_rig(description) as rig:
        guards = [axis for axis in rig.axes.values() if isinstance(axis, CableGuard)]
        assert [guard.wrap_turns for guard in guards] == [5.0, 5.0, 5.0]
    with open_rig(read_rig(ROOT / "examples" / "servo-mechanism" / "rig.toml")) as rig:
        assert not any(isinstance(axis, CableGuard) for axis in rig.axes.values())


def test_a_table_that_tells_angles_within_a_turn_is_turned_back_at_a_rate(tmp_path: Path) -> None:
    description = read_rig(ROOT / "examples" / "rate-table" / "rig.toml")
    wraps = tmp_path / "wraps.toml"
    shipped = ROOT / "rig" / "dialects" / "rate" / "generic-rate-table.toml"
    wraps.write_text("position_wraps = true\n" + shipped.read_text(encoding="utf-8"), encoding="utf-8")
    name, settings = next(iter(description.axes.items()))
    plans = []
    for dialect in ("generic-rate-table", str(wraps)):
        axis = RateTableSettings.model_validate(
            {key: getattr(settings, key) for key in ("port", "limits_deg", "speed_dps", "wrap_turns", "top_rate_dps")}
            | {"driver": "rate-table", "dialect": dialect}
        )
        with open_rig(description.model_copy(update={"axes": {**description.axes, name: axis}})) as rig:
            guard = rig.axes[name]
            assert isinstance(guard, CableGuard)
            plans.append(guard.unwinding_plan())
    assert "--to 0" in plans[0]
    assert "--rate" in plans[1]


def test_every_axis_of_every_rig_has_a_memory_of_its_own(tmp_path: Path) -> None:
    settings = settings_of("zaber", port="/dev/serial/by-id/usb-x")
    indices = {
        memory_of(rig, name, axis, replace_file, tmp_path).location
        for rig in ("one rig", "another")
        for name, axis in settings.items()
    }
    assert len(indices) == 4
    assert all(Path(location).parent == tmp_path for location in indices)
    again = memory_of("one rig", "pitch", settings["pitch"], replace_file, tmp_path)
    assert again.location in indices
    assert isinstance(memory_of("one rig", "pitch", settings_of("zaber")["pitch"], replace_file), Unkept)
