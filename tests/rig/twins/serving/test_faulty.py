"""Laws of faulty lines: each kind does what it says, when it says, in memory and on real ports."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from table_bench import example_rig, rig_file, virtual_clock
from turning_rig import SERVO_FOR_PITCH, STAGE_FOR_ROLL

from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock, SystemClock
from rig.description.fault_plan import FaultPlan, FaultRule
from rig.description.read import read_rig
from rig.errors import DeviceFault, DeviceRefused, DeviceSilent, LinkLost, MotionBreach, RigError
from rig.link.memory import MemoryStream
from rig.motion.jog import home, jog_to
from rig.twins.physics.world import World
from rig.twins.serving.faulty import FaultyTwin, modbus_exception

FACTOR = 400.0


class Parrot:
    """Answers each piece with its own bytes, upper case."""

    def __init__(self) -> None:
        self.heard: list[bytes] = []
        self.power_cycles: list[float] = []
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard.append(data)
        self._due += data.upper()

    def transmit(self, now_s: float) -> bytes:
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def power_cycle(self, now_s: float) -> None:
        self.power_cycles.append(now_s)


class Still:
    """No axis here."""

    def stall(self, axis: str, for_s: float) -> None: ...

    def slip(self, axis: str, slip_deg: float, now_s: float, *, seen: bool) -> None: ...

    def lag(self, axis: str, lag_s: float) -> None: ...


class Line:
    """A conversation with a parrot over a faulty line."""

    def __init__(self, **rule: object) -> None:
        self.clock = virtual_clock()
        self.parrot = Parrot()
        self.messages: list[str] = []
        self.other = self._twin(Parrot(), {})
        self.twin = self._twin(self.parrot, {"it": FaultRule(line="axes.pitch", **rule)})
        self.stream = MemoryStream(self.twin, self.clock, "line")

    def _twin(self, parrot: Parrot, rules: dict[str, FaultRule]) -> FaultyTwin:
        chance = np.random.default_rng(1)
        return FaultyTwin(
            parrot, ["axes.pitch"], rules, chance, Still(), 0.0, lambda _key: self.other, self.messages.append
        )

    def say(self, text: str, within_s: float = 1.0) -> str:
        self.stream.write(text.encode())
        deadline_s = self.clock.monotonic_s() + within_s
        heard = b""
        while more := self.stream.read(deadline_s):
            heard += more
        return heard.decode("latin-1")


@pytest.mark.parametrize(
    ("rule", "answers"),
    [
        ({"kind": "drop"}, ["ONE", "", "THREE"]),
        ({"kind": "drop", "on": "question"}, ["ONE", "", "THREE"]),
        ({"kind": "delay", "delay_s": 1.5}, ["ONE", "", "THREETWO"]),
        ({"kind": "freeze", "delay_s": 1.5}, ["ONE", "", "TWOTHREE"]),
        ({"kind": "duplicate"}, ["ONE", "TWOTWO", "THREE"]),
        ({"kind": "duplicate", "delay_s": 1.5}, ["ONE", "TWO", "THREETWO"]),
        ({"kind": "truncate", "keep": 2}, ["ONE", "TW", "THREE"]),
        ({"kind": "split", "keep": 2, "delay_s": 1.5}, ["ONE", "TW", "THREEO"]),
        ({"kind": "flip-bit", "byte": -1, "bit": 0}, ["ONE", "TWN", "THREE"]),
        ({"kind": "flip-bit", "byte": 7, "bit": 0}, ["ONE", "TWO", "THREE"]),
        ({"kind": "stale", "text": "boot\xff"}, ["ONE", "boot\xffTWO", "THREE"]),
        ({"kind": "echo"}, ["ONE", "twoTWO", "THREE"]),
        ({"kind": "previous"}, ["ONE", "ONE", "THREE"]),
    ],
)
def test_what_travels(rule: dict[str, object], answers: list[str]) -> None:
    line = Line(nth=(2,), **rule)
    assert [line.say(text) for text in ("one", "two", "three")] == answers
    assert len(line.messages) == 1
    assert f"axes.pitch: it: {rule['kind']}, {rule.get('on', 'reply')} 2" in line.messages[0]


def test_a_wrong_baud_rate_leaves_nothing_of_the_text() -> None:
    line = Line(kind="garble", every=1)
    heard = line.say("a long enough question")
    assert len(heard) == 22
    assert sum(a == b for a, b in zip(heard, "A LONG ENOUGH QUESTION", strict=True)) < 4


@pytest.mark.parametrize(
    ("trigger", "struck"),
    [
        ({"nth": (1, 4)}, [1, 4]),
        ({"every": 3}, [3, 6]),
        ({"every": 2, "most": 2}, [2, 4]),
        ({"at_s": 2.5}, [4]),
        ({"probability": 1.0, "most": 1}, [1]),
    ],
)
def test_when_it_strikes(trigger: dict[str, object], struck: list[int]) -> None:
    line = Line(kind="drop", **trigger)
    assert [number for number in range(1, 8) if not line.say("x")] == struck


def test_a_chance_is_drawn_from_the_seed_and_as_often_as_it_says() -> None:
    def struck() -> list[bool]:
        line = Line(kind="drop", probability=0.2)
        return [not line.say("x", 0.0001) for _ in range(2000)]

    first = struck()
    assert first == struck()
    assert sum(first) == pytest.approx(400, abs=4 * math.sqrt(2000 * 0.2 * 0.8))  # binomial, 4 sigma


@pytest.mark.parametrize("kind", ["hang-up", "rename"])
def test_a_line_that_hangs_up_is_gone_for_its_time_whether_or_not_anybody_talks(kind: str) -> None:
    line = Line(kind=kind, at_s=2.0, away_s=3.0)
    assert line.say("one") == "ONE"  # till 1 s
    with pytest.raises(LinkLost, match=r"twin of axes.pitch: the line is gone"):
        line.say("two", 5.0)
    assert line.clock.monotonic_s() == 2.0
    with pytest.raises(LinkLost):
        line.say("three")
    line.clock.sleep(3.0)
    assert line.say("four") == "FOUR"


def test_a_device_without_power_is_silent_and_forgets() -> None:
    line = Line(kind="power-cycle", nth=(2,), on="question", away_s=1.5)
    assert [line.say(text) for text in ("one", "two", "three", "four")] == ["ONE", "", "", "FOUR"]
    assert line.parrot.power_cycles == [1.0]
    assert line.parrot.heard == [b"one", b"four"]


def test_swapped_lines_answer_for_each_other() -> None:
    line = Line(kind="swap", nth=(1,), other="axes.roll")
    line.say("one")
    line.say("two")
    assert line.parrot.heard == [b"one"]
    assert line.other.twin is line.parrot


def test_an_exception_is_framed_as_its_reply_was() -> None:
    # MODBUS over serial line V1.02: exception 02 to function 03 from unit 1; CRC C0 F1 low byte first.
    assert modbus_exception(bytes.fromhex("01 03 02 00 0a 38 43"), 2) == bytes.fromhex("01 83 02 c0 f1")
    tcp = bytes.fromhex("00 07 00 00 00 05 01 03 02 00 0a")
    assert modbus_exception(tcp, 6) == bytes.fromhex("00 07 00 00 00 03 01 83 06")


def _plan(**rules: dict[str, object]) -> FaultPlan:
    return FaultPlan(fault={name: FaultRule(**rule) for name, rule in rules.items()})  # type: ignore[arg-type]


def _rig(folder: Path, expected: list[str], **rules: dict[str, object]) -> Rig:
    rig = open_rig(read_rig(rig_file(folder)), faults=_plan(**rules), tell_fault=expected.append)
    for axis in rig.axes:
        home(rig, axis, rig.clock.sleep)
    return rig


def test_a_stalled_axis_is_noticed(tmp_path: Path) -> None:
    messages: list[str] = []
    with _rig(tmp_path, messages, it={"line": "axes.pitch", "kind": "stall", "at_s": 30.0, "for_s": 60.0}) as rig:
        rig.clock.sleep(30.0)
        assert not rig.axes["pitch"].state().is_moving
        assert len(messages) == 1
        rig.axes["pitch"].start_move(20.0)
        seen = [
            _looked_at(rig, "pitch", after_s) for after_s in (4.4, 30.0, 20.0, 20.0)
        ]  # lift 0.5 s, 20 deg at 5 deg/s
        assert seen == [(19.0, True), (19.0, True), (19.0, True), (20.0, False)]


def _looked_at(rig: Rig, axis: str, after_s: float) -> tuple[float, bool]:
    rig.clock.sleep(after_s)
    state = rig.axes[axis].state()
    return state.position_deg, state.is_moving


def test_a_seen_slip_is_read_back_and_an_unseen_one_is_not(tmp_path: Path) -> None:
    for seen in (True, False):
        rule = {"line": "axes.pitch", "kind": "slip", "at_s": 30.0, "slip_deg": 1.0, "seen": seen}
        with _rig(tmp_path, [], it=rule) as rig:
            for readout in rig.readouts.values():
                readout.prepare()
            before_v = rig.readouts["dmm"].read("dmm.x", 5, rig.clock.sleep).samples.mean()
            rig.clock.sleep(30.0)
            if seen:  # and what nothing told to move is a breach
                with pytest.raises(MotionBreach, match="left at 0°, now at 1°"):
                    rig.axes["pitch"].state()
            else:
                assert rig.axes["pitch"].state().position_deg == 0.0
            after_v = rig.readouts["dmm"].read("dmm.x", 5, rig.clock.sleep).samples.mean()
            assert after_v - before_v == pytest.approx(2.5 * math.radians(1.0), rel=0.01)  # S sin 1 deg


def test_power_of_the_table_takes_its_home_along(tmp_path: Path) -> None:
    messages: list[str] = []
    rule = {"line": "axes.roll", "kind": "power-cycle", "at_s": 30.0, "away_s": 30.0}
    with _rig(tmp_path, messages, it=rule) as rig:
        jog_to(rig, "pitch", 20.0, rig.clock.sleep)
        rig.clock.sleep(30.0)
        with pytest.raises(DeviceSilent, match=r"axes\.pitch"):
            rig.axes["roll"].state()
        rig.clock.sleep(30.0)
        assert not rig.axes["pitch"].state().is_homed
        assert messages == ["30.000 s: axes.pitch and axes.roll: it: power-cycle, at 30 s"] or messages[0].endswith(
            "at 30 s"
        )


def test_modbus_says_no_by_its_code(tmp_path: Path) -> None:
    rule = {"line": "environment.air", "kind": "exception", "every": 1, "code": 4}
    with _rig(tmp_path, [], it=rule) as rig, pytest.raises((DeviceRefused, DeviceFault), match=r"environment\.air"):
        rig.environments["air"].temperature_degc()


@pytest.mark.parametrize("kind", ["hang-up", "rename"])
@pytest.mark.parametrize("pty", [False, True], ids=["tcp", "pty"])
def test_on_ports_a_line_hangs_up_and_comes_back(tmp_path: Path, pty: bool, kind: str) -> None:
    links = tmp_path / "by-id"
    links.mkdir()
    rule = {"line": "environment.air", "kind": kind, "on": "question", "nth": 30, "away_s": 60.0}
    description = read_rig(rig_file(tmp_path))
    clock = ScaledClock(FACTOR)
    with serve_rig(description, clock, pty=pty, links=links, faults=_plan(it=rule)) as served:
        node = (links / "environment.air").resolve() if pty else None
        written = write_rig(tmp_path / "rig.toml", served.addresses, FACTOR, tmp_path / "ports.toml")
        with open_rig(written) as rig:
            with pytest.raises(LinkLost, match=r"environment\.air"):
                _for_ever(rig.environments["air"].temperature_degc)
            assert _in_the_end(rig, clock) == pytest.approx(20.0, abs=0.5)
        if pty:
            assert (links / "environment.air").resolve() != node
    assert not list(links.iterdir())


def _for_ever(ask: Callable[[], object]) -> None:
    for _ in range(200):
        ask()


def _in_the_end(rig: Rig, clock: ScaledClock) -> float:
    """The temperature when the line is back; the rig's own error is the reason to try again."""
    deadline_s = SystemClock().monotonic_s() + 10.0
    while True:
        try:
            rig.reconnect()
            return rig.environments["air"].temperature_degc()
        except RigError:
            assert SystemClock().monotonic_s() < deadline_s
            clock.sleep(10.0)


def test_what_lags_arrives_later_than_its_read_back() -> None:
    world = World(example_rig())
    world.lag("pitch", 3.0)
    arrival_s = world.rotate("pitch", 50.0, 0.0)  # 5 deg/s
    body = world.axes["pitch"]
    assert (arrival_s, body.table_deg(arrival_s)) == (10.0, 50.0)
    assert math.degrees(body.attitude_rad(arrival_s)) == pytest.approx(35.0, abs=0.001)
    assert math.degrees(body.attitude_rad(arrival_s + 3.0)) == pytest.approx(50.0, abs=0.001)
    assert body.still_from_s == 13.0


def test_power_that_fails_takes_pulses_of_servos_and_references_of_stages(tmp_path: Path) -> None:
    cut = {"kind": "power-cycle", "at_s": 100.0, "away_s": 1.0}
    plan = _plan(pitch={"line": "axes.pitch", **cut}, roll={"line": "axes.roll", **cut})
    with open_rig(read_rig(rig_file(tmp_path, SERVO_FOR_PITCH, STAGE_FOR_ROLL)), faults=plan) as rig:
        for axis in rig.axes:
            home(rig, axis, rig.clock.sleep)
            assert rig.axes[axis].state().is_homed
        rig.clock.sleep(102.0)
        assert not any(axis.state().is_homed for axis in rig.axes.values())
