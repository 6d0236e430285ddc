"""Rate tables by dialect: what public programs for two makers' tables show, put to driver and twin.

Source: docs/devices/rate-table.md. No manual could be used; nothing here is a manual's sentence.
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from table_bench import example_rig, virtual_clock

from rig.abilities.rates import measured_rate
from rig.devices.rate_table import RateTableAxis, RateTableSettings, connect
from rig.errors import DescriptionError, DeviceRefused, RequestRefused
from rig.link import faults
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.motion.move import home_and_arrive, move_and_arrive, stop_all
from rig.twins.physics.world import World
from rig.twins.rate_table import RateTableTwin
from rig.wire.indexing_table import (
    AskPosition,
    Command,
    Enable,
    Home,
    Move,
    Position,
    Rate,
    Reply,
    Speed,
    Stop,
    TableCodec,
)
from rig.wire.table_dialect import load_dialect, rate_dialects

IDEAL, ACUTRONIC = "ideal-aerosmith-1270vs", "acutronic-acutrol3000"


GENERIC = Path(__file__).parents[3] / "rig" / "dialects" / "rate" / "generic-rate-table.toml"


class Bench:
    def __init__(self, dialect: str, *, obeys_bare: bool = True, **changes: object) -> None:
        table = {"driver": "rate-table", "port": "twin", "limits_deg": (-180.0, 180.0), "speed_dps": 20.0}
        table |= {"dialect": dialect, "top_rate_dps": 300.0, "arrival_tolerance_deg": 0.01}
        self.settings = RateTableSettings.model_validate(table | changes)
        self.clock, self.codec = virtual_clock(), TableCodec(self.settings.spoken())
        self.world = World(example_rig().model_copy(update={"axes": {"pitch": self.settings}}))
        self.twin = RateTableTwin(self.codec, {1: "pitch"}, self.world, obeys_bare=obeys_bare)
        self.faults = FaultScript()
        self.stream = MemoryStream(self.twin, self.clock, dialect, self.faults)
        self.axis: RateTableAxis = connect({"pitch": self.settings}, self.stream)["pitch"]

    @property
    def true_dps(self) -> float:
        return self.world.axes["pitch"].rate_dps(self.clock.monotonic_s())

    def home(self) -> None:
        self.axis.home()
        self.clock.sleep(60.0)
        assert self.axis.state().is_homed


class Encoder(RateTableTwin):
    """With the noise of a servo that holds its place, and its settling, over a second, on a target."""

    sigma_deg = settling_deg = 0.0

    def __init__(self, codec: TableCodec, axes: Mapping[int, str], world: World) -> None:
        super().__init__(codec, axes, world)
        self._random = np.random.default_rng(5)
        self._ends_s = 0.0

    def _reply(self, command: Command, number: int, now_s: float) -> Reply:
        reply = super()._reply(command, number, now_s)
        if self.axes[number].is_moving(now_s):
            self._ends_s = now_s
        if not isinstance(reply, Position):
            return reply
        off_deg = self.sigma_deg * float(self._random.standard_normal())
        return Position(reply.position_deg + off_deg - self.settling_deg * math.exp(self._ends_s - now_s))


def _encoder(**changes: object) -> tuple[Bench, Encoder]:
    bench = Bench(ACUTRONIC, **changes)
    encoder = Encoder(bench.codec, {1: "pitch"}, bench.world)
    bench.stream = MemoryStream(encoder, bench.clock, ACUTRONIC, bench.faults)
    bench.axis = connect({"pitch": bench.settings}, bench.stream)["pitch"]
    return bench, encoder


@pytest.mark.parametrize("sigma_deg", [0.0, 1e-4, 2e-4, 3e-4])
def test_a_servo_that_holds_its_place_homes_goes_turns_and_stops_by_its_positions_alone(sigma_deg: float) -> None:
    """As seen with 0.0002°: --home and --to ended "still moving at 7.6e-05°, 20 s after the stop"."""
    bench, encoder = _encoder(arrival_tolerance_deg=0.001)
    encoder.sigma_deg = sigma_deg
    home_and_arrive(bench.axis, bench.clock, bench.clock.sleep)
    for target_deg in (20.0, 20.5, 0.0):
        move_and_arrive(bench.axis, target_deg, bench.clock, bench.clock.sleep)
    bench.axis.start_rate(20.0)
    bench.clock.sleep(5.0)
    assert bench.axis.state().is_moving
    stop_all({"pitch": bench.axis}, bench.clock)  # type: ignore[dict-item]
    assert not any(bench.axis.state().is_moving for _ in range(300))


@pytest.mark.parametrize("settling_deg", [0.0015, 0.003, 0.01, 0.1])
def test_a_servo_that_settles_slowly_has_not_arrived_before_it_is_there(settling_deg: float) -> None:
    bench, encoder = _encoder(arrival_tolerance_deg=0.001)
    home_and_arrive(bench.axis, bench.clock, bench.clock.sleep)
    bench.clock.sleep(10.0)
    encoder.settling_deg = settling_deg
    said: list[str] = []
    assert move_and_arrive(bench.axis, 20.0, bench.clock, bench.clock.sleep, said.append) == pytest.approx(
        20.0, abs=1e-3
    )
    assert said == []


@pytest.mark.parametrize(
    ("dialect", "command", "line"),
    [
        (IDEAL, Rate(1, 60.0), b"JOG60\r\n"),  # IA2
        (IDEAL, Rate(1, -60.0), b"JOG-60\r\n"),  # IA2: "Negative units represent Counter Clockwise"
        (IDEAL, Move(1, 90.0), b"MOV90\r\n"),  # IA1
        (IDEAL, Speed(1, 100.0), b"VEL100\r\n"),  # IA1
        (IDEAL, Home(1), b"HOM\r\n"),
        (IDEAL, Enable(1), b"SRV1\r\n"),  # IA2
        (IDEAL, Stop(1), b"STO\r\n"),  # IA1 sends no line end, and reads lines everywhere else
        (IDEAL, AskPosition(1), b"PPO\r\n"),
        (ACUTRONIC, Rate(1, 10.0), b":dem:rate 1,10.0000;:mode:rate 1;:dem:rate 1,10.0000\n"),
        (
            ACUTRONIC,
            Stop(1),
            b":dem:rate 1,0;:mode:rate 1;:dem:rate 1,0\n",
        ),  # AC1: "Stops movement by setting rate equal 0."
        (ACUTRONIC, Move(1, 90.0), b":dem:pos 1,90.0000;:mode:pos 1;:dem:pos 1,90.0000\n"),
        (ACUTRONIC, Speed(1, 100.0), b":lim:rate pos,1,100.000\n"),
        (ACUTRONIC, AskPosition(1), b":read:pos? 1\n"),
    ],
)
def test_what_is_sent_is_what_public_programs_send(dialect: str, command: object, line: bytes) -> None:
    codec = TableCodec(load_dialect(dialect, 1.0))
    assert codec.encode_command(command) == line  # type: ignore[arg-type]
    assert codec.decode_command(line.strip()) == command


@pytest.mark.parametrize("dialect", rate_dialects())
def test_a_table_of_this_dialect_goes_to_angles_and_turns_on_and_on(dialect: str) -> None:
    bench = Bench(dialect)
    assert bench.axis.identify()
    bench.home()
    bench.axis.start_move(90.0)
    bench.clock.sleep(60.0)
    state = bench.axis.state()
    assert (state.is_moving, state.fault) == (False, "")
    assert state.position_deg == pytest.approx(90.0, abs=0.01)
    for rate_dps in (25.0, -150.0):
        bench.axis.start_rate(rate_dps)
        bench.clock.sleep(10.0)
        assert bench.axis.state().is_moving
        first = bench.axis.turn_look(bench.clock)
        bench.clock.sleep(30.0)  # more than ten turns
        assert measured_rate(first, bench.axis.turn_look(bench.clock)).rate_dps == pytest.approx(rate_dps, rel=1e-3)
    bench.axis.stop()
    bench.clock.sleep(20.0)
    assert bench.true_dps == 0.0
    assert not bench.axis.state().is_moving


@pytest.mark.parametrize("dialect", rate_dialects())
def test_the_stop_guard_s_bytes_stop_a_turning_table_whoever_sends_them(dialect: str) -> None:
    bench = Bench(dialect)
    bench.home()
    bench.axis.start_rate(50.0)
    bench.clock.sleep(5.0)
    for step in bench.axis.stop_steps():
        bench.twin.receive(step.send, bench.clock.monotonic_s())
    bench.clock.sleep(5.0)
    assert bench.true_dps == 0.0


STOP_WITHIN_S = 2.0
"""The twin slows down from 50 °/s in less."""


def _turning(*, obeys_bare: bool) -> Bench:
    bench = Bench(IDEAL, obeys_bare=obeys_bare)
    bench.home()
    bench.axis.start_rate(50.0)
    bench.clock.sleep(5.0)
    assert bench.axis.state().is_moving
    assert bench.true_dps == pytest.approx(50.0)
    return bench


@pytest.mark.parametrize("obeys_bare", [True, False])
def test_a_stop_is_obeyed_as_a_bare_word_and_at_the_end_of_its_line(*, obeys_bare: bool) -> None:
    # IA1 sends STO without an end: a controller that reads lines would join it to the next question, as STOMCO1.
    bench = _turning(obeys_bare=obeys_bare)
    bench.axis.stop()
    bench.clock.sleep(STOP_WITHIN_S)
    assert bench.true_dps == 0.0
    bench = _turning(obeys_bare=obeys_bare)
    for step in bench.axis.stop_steps():  # as the stop guard sends it
        bench.twin.receive(step.send, bench.clock.monotonic_s())
    bench.clock.sleep(STOP_WITHIN_S)
    assert bench.true_dps == 0.0


def test_a_stop_is_no_later_where_the_bare_word_is_enough() -> None:
    bench = _turning(obeys_bare=True)
    (step,) = bench.axis.stop_steps()
    for byte in step.send[: len(b"STO")]:
        assert bench.true_dps == pytest.approx(50.0)
        bench.twin.receive(bytes([byte]), bench.clock.monotonic_s())
    bench.clock.sleep(STOP_WITHIN_S)
    assert bench.true_dps == 0.0


@pytest.mark.parametrize("obeys_bare", [True, False])
def test_what_is_said_late_to_a_stop_is_not_taken_for_an_answer(*, obeys_bare: bool) -> None:
    bench = _turning(obeys_bare=obeys_bare)
    late = {0: faults.delay(0.1), 1: faults.delay(0.2)}  # the prompt, and then the position
    bench.faults.reads = {bench.faults.taken + location: fault for location, fault in late.items()}
    bench.axis.stop()
    bench.clock.sleep(0.05)
    assert bench.axis.turn_look(bench.clock).angle_deg == pytest.approx(
        bench.world.axes["pitch"].table_deg(bench.clock.monotonic_s()), abs=10.0
    )
    assert bench.axis._table._exchange.counts.nonsense == 0


def test_a_bare_stop_with_an_answer_of_its_own_is_refused(tmp_path: Path) -> None:
    text = GENERIC.read_text(encoding="utf-8").replace('{axis} STOP", reply', '{axis} STOP", bare = true, reply')
    path = tmp_path / "both.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DescriptionError, match="what a bare stop answers is thrown away"):
        load_dialect(str(path), 1.0)


def test_an_answer_that_comes_with_the_next_command_is_no_position() -> None:
    # IA1: after JOG no prompt at once, the answer comes with the next command; it sends STA and throws lines away.
    bench = Bench(IDEAL)
    bench.home()
    now_s = bench.clock.monotonic_s()
    bench.twin.receive(b"JOG30\r\n", now_s)
    assert bench.twin.transmit(now_s) == b""
    bench.twin.receive(b"STA\r\n", now_s)
    assert bench.twin.transmit(now_s) == b"JOG30\r\n>\r\n0\r\n>\r\n"
    late = {2: faults.delay(0.05), 3: faults.delay(0.1)}  # state and position, then what STA fetches, then an angle
    bench.faults.reads = {bench.faults.taken + location: fault for location, fault in late.items()}
    bench.axis.start_rate(30.0)
    at_deg = bench.axis.turn_look(bench.clock).angle_deg
    assert at_deg == pytest.approx(bench.world.axes["pitch"].table_deg(bench.clock.monotonic_s()), abs=4.0)
    assert bench.axis._table._exchange.counts.nonsense == 0
    assert bench.axis.state().is_moving


def test_a_rate_that_the_dialect_would_round_is_refused() -> None:
    # IA1 sends integers to JOG: whether it takes a fraction is not known.
    bench = Bench(IDEAL)
    bench.home()
    with pytest.raises(
        RequestRefused, match=r"turn at 12.5 °/s: the dialect ideal-aerosmith-1270vs would write 'JOG12'"
    ):
        bench.axis.start_rate(12.5)
    assert bench.true_dps == 0.0


@pytest.mark.parametrize(
    ("line", "is_refused"),
    [
        (b"ERROR 12", True),
        (b"Error: limit", True),
        (b"?", True),
        (b"VEL20?", True),
        (b"", False),  # a prompt alone
        (b"VEL20", False),  # IA2: the echo of the command
    ],
)
def test_a_speed_that_the_table_refuses_is_followed_by_no_motion(line: bytes, *, is_refused: bool) -> None:
    bench, sent = Bench(IDEAL, homed_before=True), list[bytes]()
    receive, transmit = bench.twin.receive, bench.twin.transmit

    def answered(now_s: float) -> bytes:
        said = transmit(now_s)
        return line + bench.codec.reply_terminator if said and sent[-1].startswith(b"VEL") else said

    bench.twin.receive = lambda data, now_s: (sent.append(data), receive(data, now_s))[1]  # type: ignore[method-assign]
    bench.twin.transmit = answered  # type: ignore[method-assign]
    if is_refused:
        with pytest.raises(
            DeviceRefused, match=rf"refused Speed\(axis=1, speed_dps=20.0\): '{re.escape(line.decode())}'"
        ):
            bench.axis.start_move(90.0)
    else:
        bench.axis.start_rate(30.0)
    assert any(data.startswith((b"MOV", b"JOG")) for data in sent) is not is_refused


def test_a_demand_is_sent_before_the_mode_in_which_it_acts() -> None:
    # AC1: "mode: if activated and with loaded demand value, it will move."
    codec = TableCodec(load_dialect(ACUTRONIC, 1.0))
    for command in (Rate(1, 5.0), Stop(1), Move(1, 5.0)):
        line = codec.encode_command(command)
        assert line.index(b":dem:") < line.index(b":mode:")


def test_the_motor_is_switched_on_and_the_speed_set_before_the_first_motion_and_again_with_each_home() -> None:
    bench = Bench("generic-rate-table")
    recorded: list[bytes] = []
    receive = bench.twin.receive
    bench.twin.receive = lambda data, now_s: (recorded.append(data), receive(data, now_s))[1]  # type: ignore[method-assign]
    bench.home()
    bench.axis.start_move(10.0)
    commands = [line for line in recorded if b"?" not in line]
    assert commands[:3] == [b"1 ON\r\n", b"1 SPEED 20.0000\r\n", b"1 HOME\r\n"]
    assert recorded.count(b"1 ON\r\n") == 1
    bench.clock.sleep(10.0)
    bench.home()
    assert recorded.count(b"1 ON\r\n") == 2


def test_a_motor_that_is_off_is_told() -> None:
    bench = Bench("generic-rate-table")
    bench.twin.receive(b"1 HOME\r\n", 0.0)
    assert bench.twin.transmit(0.0) == b"1 ERR MOTOR OFF\r\n"
    bench.home()
    bench.twin.power_cycle(bench.clock.monotonic_s())
    with pytest.raises(RequestRefused, match="not homed"):
        bench.axis.start_rate(10.0)


def test_positions_that_begin_again_after_a_turn_go_on(tmp_path: Path) -> None:
    shipped = GENERIC.read_text(encoding="utf-8")
    path = tmp_path / "wraps.toml"
    path.write_text("position_wraps = true\n" + shipped, encoding="utf-8")
    bench = Bench(str(path))
    bench.home()
    bench.axis.start_move(-90.0)
    bench.clock.sleep(20.0)
    assert bench.axis.state().position_deg == pytest.approx(-90.0, abs=1e-3)
    bench.axis.start_rate(-40.0)
    for pause_s in [0.1] * 50 + [6.0] * 5:  # at speed it is seen after more than half a turn, and known all the same
        bench.clock.sleep(pause_s)
        bench.axis.state()
    true_deg = bench.world.axes["pitch"].table_deg(bench.clock.monotonic_s())
    assert true_deg < -800.0
    assert bench.axis.state().position_deg == pytest.approx(true_deg, abs=0.1)


def test_a_table_whose_positions_begin_again_stands_where_it_rests_however_long_nobody_looks(tmp_path: Path) -> None:
    path = tmp_path / "wraps.toml"
    path.write_text("position_wraps = true\n" + GENERIC.read_text(encoding="utf-8"), encoding="utf-8")
    bench = Bench(str(path))
    bench.home()
    bench.axis.start_move(-170.0)
    while bench.axis.state().is_moving:
        bench.clock.sleep(0.5)
    for pause_s in (30.0, 3000.0):  # as far as it would have gone on at the speed of the move, and farther
        bench.clock.sleep(pause_s)
        assert bench.axis.state().position_deg == pytest.approx(-170.0, abs=1e-3)


def test_a_dialect_that_turns_and_cannot_be_stopped_is_refused(tmp_path: Path) -> None:
    shipped = GENERIC.read_text(encoding="utf-8")
    path = tmp_path / "runs.toml"
    path.write_text("\n".join(line for line in shipped.splitlines() if not line.startswith("stop")), encoding="utf-8")
    with pytest.raises(DescriptionError, match="a machine that turns on and on needs a stop"):
        load_dialect(str(path), 1.0)


def test_a_dialect_without_a_rate_only_positions() -> None:
    bench = Bench("dual-axis-1deg")
    with pytest.raises(RequestRefused, match="has no command for a rate"):
        bench.axis.check_rate(10.0)
