"""Laws of the control address: an announcement is whole or refused, and known before it is acknowledged."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from table_bench import virtual_clock

from rig.errors import DeviceNonsense, DeviceSilent
from rig.link.faults import FaultScript, drop, replace
from rig.link.memory import MemoryStream
from rig.twins.serving.control import ControlTwin, RemoteChance


class Heard:
    def __init__(self) -> None:
        self.announced: list[tuple[int, str, int, float]] = []

    def announce(self, step: int, phase: str, attempt: int, replications: float) -> None:
        self.announced.append((step, phase, attempt, replications))


def _answer(line: bytes) -> tuple[object, Heard]:
    heard = Heard()
    twin = ControlTwin(heard)
    twin.receive(line, 0.0)
    return json.loads(twin.transmit(0.0)), heard


def test_an_announcement_is_one_json_line() -> None:
    answer, heard = _answer(b'{"announce": [17, "read", 1, 0.25]}\n')
    assert answer == {"ok": True}
    assert heard.announced == [(17, "read", 1, 0.25)]


@pytest.mark.parametrize(
    "line",
    [
        b"{}",
        b"[]",
        b"announce",
        b'{"announce": [17, "read", 1]}',
        b'{"announce": ["17", "read", 1, 0.0]}',
        b'{"announce": [17, "read", true, 0.0]}',
        b'{"announce": [17, "read", 1, NaN]}',
        b'{"announce": [17, "read", 1, 0.0], "extra": 1}',
    ],
)
def test_anything_else_is_refused_and_announces_nothing(line: bytes) -> None:
    answer, heard = _answer(line + b"\n")
    assert isinstance(answer, dict)
    assert answer["ok"] is False
    assert heard.announced == []


@given(st.binary(max_size=80))
def test_rubbish_announces_nothing(rubbish: bytes) -> None:
    heard = Heard()
    ControlTwin(heard).receive(rubbish + b"\n", 0.0)
    assert heard.announced == []


def test_the_remote_chance_returns_when_the_twins_know() -> None:
    heard = Heard()
    chance = RemoteChance(MemoryStream(ControlTwin(heard), virtual_clock(), "control"))
    chance.announce(3, "settle", 0, 1.5)
    chance.announce(3, "read", 0, 1.5)
    assert heard.announced == [(3, "settle", 0, 1.5), (3, "read", 0, 1.5)]


def test_silent_or_confused_twins_are_an_error() -> None:
    for fault, kind in ((drop, DeviceSilent), (replace(b'{"ok": false}\n'), DeviceNonsense)):
        stream = MemoryStream(ControlTwin(Heard()), virtual_clock(), "control", FaultScript(reads={0: fault}))
        with pytest.raises(kind, match="step 3"):
            RemoteChance(stream).announce(3, "read", 0, 0.0)
