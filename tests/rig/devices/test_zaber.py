"""Laws of the Zaber stage's driver: a reply names its question, a start is sent once, a rate is measured."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motion_bench import motion_bench, settings_of, twin_of, world_of
from table_bench import virtual_clock

from rig.abilities.abilities import TurnLook
from rig.abilities.rates import measured_rate
from rig.devices.zaber import connect
from rig.errors import DeviceNonsense, DeviceRefused, DeviceSilent, RequestRefused
from rig.link import faults
from rig.link.memory import MemoryStream
from rig.motion.move import home_and_arrive, move_and_arrive
from rig.wire.zaber import Reply, encode_reply


def test_a_target_becomes_whole_microsteps() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    bench.pitch.start_move(10.0)
    bench.clock.sleep(100.0)
    # 10 / 0.000234375 = 42666.67, so 42667 microsteps.
    assert bench.pitch.state().position_deg == pytest.approx(42667 * 0.000234375, abs=1e-12)


def test_alerts_and_info_lines_are_skipped() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    bench.faults.reads = {
        bench.faults.taken + i: faults.prepend(b"!02 1 IDLE --\r\n#02 0 some news\r\n") for i in range(4)
    }
    assert bench.pitch.state().position_deg == 0.0
    bench.pitch.start_move(5.0)


def test_an_alert_that_waits_before_a_question_is_no_answer() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    bench.twin.say(b"@01 1 07 OK IDLE -- 99999:8C")
    assert bench.pitch.state().position_deg == 0.0


@pytest.mark.parametrize(
    "wrong",
    [
        Reply(2, 1, True, False, "--", "5", 1),
        Reply(1, 2, True, False, "--", "5", 1),
        Reply(1, 1, True, False, "--", "5", 77),
        Reply(1, 1, True, False, "--", "5", None),
    ],
    ids=["device", "axis", "id", "no id"],
)
def test_a_reply_to_another_question_is_nonsense(wrong: Reply) -> None:
    bench = motion_bench("zaber")
    bench.faults.reads = dict.fromkeys(range(20), faults.replace(encode_reply(wrong)))
    with pytest.raises(DeviceNonsense, match="was not asked"):
        bench.pitch.state()


def test_a_reply_without_a_checksum_is_refused_unless_the_file_allows_it() -> None:
    bench = motion_bench("zaber")
    bench.twin.stages[1].settings["comm.checksum"] = 0
    with pytest.raises(DeviceNonsense, match=r"no checksum \(set the stage's comm\.checksum to 1"):
        bench.pitch.state()
    bench = motion_bench("zaber", require_checksum=False)
    bench.twin.stages[1].settings["comm.checksum"] = 0
    assert bench.pitch.state().position_deg == 0.0


def test_a_lost_acknowledgement_is_settled_by_asking_not_by_sending_again() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    sent: list[bytes] = []
    receive = bench.twin.receive
    bench.twin.receive = lambda data, now_s: (sent.append(data), receive(data, now_s))
    bench.faults.reads = {bench.faults.taken + 4: faults.drop}  # position, reference, scale, zero; the start
    bench.pitch.start_move(40.0)
    bench.clock.sleep(100.0)
    assert bench.pitch.state().position_deg == pytest.approx(40.0, abs=2e-4)
    assert len([line for line in sent if b"move abs" in line]) == 1


def test_a_lost_start_is_an_error_and_nothing_moves() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    bench.pitch.start_move(0.0)
    bench.faults.writes = {bench.faults.written + 4: faults.drop}  # position, reference, scale, zero
    with pytest.raises(DeviceSilent, match="move abs"):
        bench.pitch.start_move(40.0)
    bench.clock.sleep(100.0)
    assert bench.true_deg == 0.0


def test_what_the_stage_rejects_is_told_in_its_words() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    bench.pitch.start_move(0.0)
    bench.twin.stages[1].settings["limit.max"] = 1000
    with pytest.raises(DeviceRefused, match=r"device 1 rejected 'move abs 42667': BADDATA"):
        bench.pitch.start_move(10.0)


def test_limits_of_the_stage_inside_those_of_the_file_are_refused() -> None:
    bench = motion_bench("zaber")
    bench.twin.stages[1].settings["limit.min"] = 0
    with pytest.raises(RequestRefused, match="end the travel at 0 and"):
        bench.pitch.home()


def test_a_fault_warning_is_a_fault_and_a_lost_reference_is_not_homed() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    bench.twin.stages[1].status = lambda now_s: (False, "FS")  # stalled
    assert bench.pitch.state().fault == "the stage warns FS"
    del bench.twin.stages[1].status
    bench.twin.stages[1].power_cycle(bench.clock.monotonic_s())
    assert not bench.pitch.state().is_homed


def test_a_rate_is_measured_from_position_and_time() -> None:
    bench = motion_bench("zaber", sign=-1)
    bench.home_all()
    bench.pitch.start_rate(-30.0)
    bench.clock.sleep(5.0)
    first = bench.pitch.turn_look(bench.clock)
    bench.clock.sleep(60.0)
    measured = measured_rate(first, bench.pitch.turn_look(bench.clock))
    assert measured.turned_deg == pytest.approx(-1800.0, abs=0.01)  # five revolutions, counted through
    assert measured.rate_dps == pytest.approx(-30.0, abs=2e-4)
    bench.pitch.stop()
    bench.clock.sleep(2.0)
    assert not bench.pitch.state().is_moving


def test_the_time_between_question_and_answer_is_the_uncertainty_of_a_rate() -> None:
    measured = measured_rate(TurnLook(0.0, 10.0, 0.01), TurnLook(360.0, 46.0, 0.02))
    assert measured.rate_dps == pytest.approx(10.0)
    assert measured.uncertainty_dps == pytest.approx(10.0 * 0.03 / 36.0)
    with pytest.raises(RequestRefused, match="look again later"):
        measured_rate(TurnLook(0.0, 10.0, 0.0), TurnLook(1.0, 10.0, 0.0))


@settings(max_examples=20)
@given(st.one_of(st.just(0.0), st.sampled_from([math.nan, math.inf, -math.inf]), st.floats(450.001, 1e6)))
def test_a_rate_outside_is_refused(rate_dps: float) -> None:
    bench = motion_bench("zaber")
    with pytest.raises(RequestRefused, match="allowed up to 450 °/s"):
        bench.pitch.start_rate(rate_dps)
    assert bench.faults.written == 0


def test_an_axis_that_only_positions_turns_at_no_rate() -> None:
    bench = motion_bench("zaber", top_rate_dps=None)
    with pytest.raises(RequestRefused, match="allowed up to 0 °/s"):
        bench.pitch.start_rate(1.0)


def test_fault_23_two_stages_that_change_places_have_other_identities() -> None:
    bench = motion_bench("zaber")
    before = {name: axis.identify() for name, axis in bench.axes.items()}
    assert before["pitch"] == "Zaber device 50952, serial 12345, firmware 7.38, number 1"
    bench.twin.stages[1].settings["system.serial"] = 54321  # another stage at the same number
    assert bench.pitch.identify() == "Zaber device 50952, serial 54321, firmware 7.38, number 1"
    assert bench.axes["roll"].identify() == before["roll"]


def test_the_turn_of_the_device_proves_the_scale_of_the_file() -> None:
    # docs/devices/zaber.md: `get limit.cycle.dist` = "the one number on the device that proves degrees per count".
    bench = motion_bench("zaber")
    bench.twin.stages[1].settings["limit.cycle.dist"] //= 2
    for ask in (bench.pitch.identify, bench.pitch.home):
        with pytest.raises(DeviceRefused, match=r"which are 180° with microstep_deg .*axes\.pitch"):
            ask()
    bench.twin.stages[1].settings["limit.cycle.dist"] = 0  # it does not turn on and on: proves nothing
    assert "Zaber device" in bench.pitch.identify()


def test_a_scale_that_somebody_changes_during_a_run_is_found_before_the_next_start() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    bench.pitch.start_move(5.0)
    bench.clock.sleep(60.0)
    bench.twin.stages[1].settings["limit.cycle.dist"] //= 2
    with pytest.raises(DeviceRefused, match="which are 180° with microstep_deg"):
        bench.pitch.start_move(10.0)
    with pytest.raises(DeviceRefused, match="which are 180° with microstep_deg"):
        bench.pitch.start_rate(10.0)
    assert bench.true_deg == pytest.approx(5.0, abs=1e-3)


def test_a_flag_that_stays_until_it_is_acknowledged_is_acknowledged_by_a_home() -> None:
    """FS: "This warning persists until acknowledged and cleared by the user with the warnings command."."""
    bench = motion_bench("zaber")
    bench.home_all()
    bench.twin.stages[1].latched.add("FS")
    assert "FS" in bench.pitch.state().fault
    bench.home_all()
    assert bench.pitch.state().fault == ""
    bench.pitch.start_move(5.0)


def test_a_stage_without_a_reference_says_so_while_it_moves() -> None:
    """The manual's example of a home: BUSY WR."""
    bench = motion_bench("zaber")
    bench.twin.receive(b"/1 1 get limit.home.triggered\n", bench.clock.monotonic_s())
    assert bench.twin.transmit(bench.clock.monotonic_s()).startswith(b"@01 1 OK IDLE WR 0:")
    bench.pitch.home()
    state = bench.pitch.state()
    assert state.is_moving
    assert not state.is_homed


@pytest.mark.parametrize("hides", ["FD", "WV"])
def test_a_lost_reference_behind_another_warning_is_found(hides: str) -> None:
    # docs/devices/zaber.md: "`limit.home.triggered` is the direct question. A device whose reply shows `FD` hides `WR`
    # behind it: do not read "homed" from the absence of WR."
    bench = motion_bench("zaber")
    bench.home_all()
    bench.twin.stages[1].power_cycle(bench.clock.monotonic_s())
    bench.twin.stages[1].latched.add(hides)
    assert not bench.pitch.state().is_homed
    with pytest.raises(RequestRefused, match="not homed"):
        bench.pitch.start_move(5.0)
    bench.twin.stages[1].latched.clear()
    assert not bench.pitch.state().is_homed


def test_the_reference_is_asked_for_before_a_start_and_not_with_every_look() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    heard: list[bytes] = []
    receive = bench.twin.receive
    bench.twin.receive = lambda data, now_s: (heard.append(data), receive(data, now_s))
    for _ in range(5):
        assert bench.pitch.state().is_homed
    assert not [line for line in heard if b"limit.home.triggered" in line]
    bench.pitch.start_move(5.0)
    assert len([line for line in heard if b"limit.home.triggered" in line]) == 1


def test_a_stage_without_a_home_sensor_is_believed_by_its_warnings() -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    stage = bench.twin.stages[1]
    act = stage.act
    stage.act = lambda text, now_s: (False, "BADCOMMAND") if text == "get limit.home.triggered" else act(text, now_s)
    bench.pitch.start_move(5.0)
    assert bench.pitch.state().is_homed
    stage.latched.add("FD")
    assert not bench.pitch.state().is_homed, "nothing tells it"


def test_two_axes_of_one_device_are_two_axes() -> None:
    """A controller with several axes: one number on the chain, ``device_axis`` 1 and 2."""
    axes = settings_of("zaber")
    pair = {
        name: axis.model_copy(update={"axis": 1, "device_axis": index})
        for index, (name, axis) in enumerate(axes.items(), start=1)
    }
    world, clock = world_of(pair), virtual_clock()
    opened = connect(pair, MemoryStream(twin_of("zaber", pair, world), clock, "zaber"))
    for axis in opened.values():
        home_and_arrive(axis, clock, clock.sleep)
    move_and_arrive(opened["roll"], 20.0, clock, clock.sleep)
    assert opened["roll"].state().position_deg == pytest.approx(20.0, abs=0.001)
    assert opened["pitch"].state().position_deg == 0.0
    assert opened["roll"].identify().endswith("number 1, axis 2")


def test_a_move_during_a_move_replaces_it_and_is_noted() -> None:
    """NI: "A movement operation was requested while the axis was executing another movement command."."""
    bench = motion_bench("zaber")
    bench.home_all()
    bench.pitch.start_move(50.0)
    bench.pitch.start_move(-50.0)
    bench.twin.receive(b"/1 1 warnings\n", bench.clock.monotonic_s())
    assert b" NI" in bench.twin.transmit(bench.clock.monotonic_s())
    assert bench.pitch.state().fault == "", "a note is no fault"
