from pathlib import Path

import pytest
from gpib_rig import gpib_rig, meter_settings, virtual_clock

from rig.devices.hp3458a import Hp3458aReadout
from rig.errors import DescriptionError, DeviceNonsense, LinkClosed
from rig.link.prologix import PrologixBus
from rig.link.transcript import Entry, Player, Recorder, read_transcript


def recorded(path: Path) -> list[float]:
    rig = gpib_rig()
    with path.open("w", encoding="utf-8") as file:
        stream = Recorder(rig.stream, lambda line: file.write(line + "\n"))
        readout = Hp3458aReadout("dmm", meter_settings(), PrologixBus(stream), rig.clock)
        readout.prepare()
        return list(readout.read("dmm.x", 3, rig.wait).samples)


def test_a_conversation_plays_back_without_the_device(tmp_path: Path) -> None:
    path = tmp_path / "meter.jsonl"
    values_v = recorded(path)
    clock = virtual_clock()
    player = Player(read_transcript(path), clock, "replay of meter.jsonl")
    readout = Hp3458aReadout("dmm", meter_settings(), PrologixBus(player), clock)
    readout.prepare()
    assert list(readout.read("dmm.x", 3, clock.sleep).samples) == values_v
    assert player.is_finished


def test_a_departure_names_the_line_and_both_sides(tmp_path: Path) -> None:
    path = tmp_path / "meter.jsonl"
    recorded(path)
    player = Player(read_transcript(path), virtual_clock(), "replay")
    with pytest.raises(
        DeviceNonsense, match=r"transcript line 2: .* goes on with write b'ID\?', recorded was read b''"
    ):
        player.write(b"ID?")


def test_an_other_text_than_recorded_is_a_departure() -> None:
    player = Player([Entry(2, 0.0, "write", b"ID?\r\n")], virtual_clock(), "replay")
    with pytest.raises(DeviceNonsense, match="line 2: the conversation departs: the driver writes b'RESET"):
        player.write(b"RESET\r\n")


def test_going_on_after_the_end_is_refused() -> None:
    player = Player([], virtual_clock(), "replay")
    with pytest.raises(DeviceNonsense, match="the transcript ends after 0 steps"):
        player.write(b"ID?")


def test_recorded_silence_lasts_to_the_deadline() -> None:
    clock = virtual_clock()
    assert Player([Entry(2, 0.0, "read", b"")], clock, "replay").read(1.5) == b""
    assert clock.monotonic_s() == 1.5


def test_all_bytes_survive(tmp_path: Path) -> None:
    path = tmp_path / "bytes.jsonl"
    lines: list[str] = []

    class Everything:
        name, clock = "all", virtual_clock()

        def write(self, data: bytes) -> None: ...
        def read(self, deadline_s: float) -> bytes:
            return bytes(range(256))

        def discard_input(self) -> bytes:
            return b"\xff"

        def close(self) -> None: ...

    recorder = Recorder(Everything(), lines.append)
    recorder.write(b"\r\n\x1b")
    recorder.read(1.0)
    recorder.discard_input()
    path.write_text("\n".join(lines), encoding="utf-8")
    assert [(entry.operation, entry.data) for entry in read_transcript(path)] == [
        ("write", b"\r\n\x1b"),
        ("read", bytes(range(256))),
        ("discard", b"\xff"),
    ]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", ":1: not a transcript"),
        ('{"transcript": 99}', ":1: not a transcript of version 1"),
        ("not json", ":1: not JSON"),
        ('{"transcript": 1}\n{"at_s": 0, "operation": "shout", "data": ""}', ":2: not a step"),
        ('{"transcript": 1}\n{"at_s": 0, "operation": "read", "data": "\\u20ac"}', ":2: not a step"),
        ('{"transcript": 1}\n{"at_s": 0, "oper', ":2: not JSON"),
    ],
)
def test_a_damaged_file_is_named_with_its_line(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "damaged.jsonl"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DescriptionError, match=complaint):
        read_transcript(path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"none\.jsonl: no transcript can be read"):
        read_transcript(tmp_path / "none.jsonl")


def test_a_closed_player_is_not_used() -> None:
    player = Player([], virtual_clock(), "replay")
    player.close()
    with pytest.raises(LinkClosed):
        player.discard_input()
