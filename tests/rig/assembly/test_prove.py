"""First contact: clean against the twins, and every planted difference is named."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from device_sets import AXIS, COMMON, DAQ, F4, STREAMS
from instrument_rigs import angle_meter_rig_file, meters_rig_file, rate_tables_rig_file, text_chambers_rig_file

from rig.assembly.prove import DeviceProof, document_of, prove
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock, VirtualClock
from rig.description.read import read_rig
from rig.drivers.driver import DRIVERS
from rig.drivers.twin_lines import twin_lines
from rig.errors import RequestRefused
from rig.lines.recording import replaying
from rig.link.byte_stream import ByteStream
from rig.link.memory import MemoryStream
from rig.link.transcript import read_transcript
from rig.twins.csv_imu import CsvImuTwin
from rig.twins.physics.world import World

Twins = Mapping[str, Any]


ESP301 = ""


def _rig_file(folder: Path, esp301: str = ESP301) -> Path:
    axes = (
        ("pitch", "indexing-table", "increment_deg = 1.0", 0.001),
        ("roll", "esp301", esp301, 0.001),
        ("yaw", "oriental-az", "step_deg = 0.01", 0.02),
    )
    described = "".join(
        AXIS.format(axis=axis, driver=driver, number=1, tolerance_deg=tolerance, extra=extra)
        for axis, driver, extra, tolerance in axes
    )
    path = folder / "rig.toml"
    path.write_text(COMMON.format(name="prove") + described + DAQ + F4 + STREAMS, encoding="utf-8")
    return path


class Line:
    """The wire to a twin that says something otherwise."""

    def __init__(self, twin: Any, change: Callable[[bytes], bytes]) -> None:
        self._twin, self._change = twin, change

    def receive(self, data: bytes, now_s: float) -> None:
        self._twin.receive(data, now_s)

    def transmit(self, now_s: float) -> bytes:
        said = self._twin.transmit(now_s)
        return self._change(said) if said else said

    def next_event_s(self) -> float | None:
        event_s: float | None = self._twin.next_event_s()
        return event_s


def _proven(
    folder: Path,
    plant: Callable[[dict[str, Any]], None] = lambda _twins: None,
    motion: str | None = None,
    esp301: str = ESP301,
) -> dict[str, DeviceProof]:
    """The rig of the file with devices that are twins of their own, after ``plant`` was at them."""
    return _proven_file(_rig_file(folder, esp301), folder, plant, motion)


def _proven_file(
    path: Path,
    folder: Path,
    plant: Callable[[dict[str, Any]], None] = lambda _twins: None,
    motion: str | None = None,
) -> dict[str, DeviceProof]:
    description = read_rig(path)
    world, clock = World(description), VirtualClock(datetime(2024, 3, 1, tzinfo=UTC))
    twins: dict[str, Any] = {key: line.twin for line in twin_lines(description, world) for key in line.keys}
    plant(twins)

    def source(key: str, _open_line: Callable[[], ByteStream]) -> ByteStream:
        return MemoryStream(twins[key], clock, key)

    proofs = prove(description, folder / "kept", motion=motion, clock=clock, line_source=source)
    return {proof.key: proof for proof in proofs}


def _told(proofs: Mapping[str, DeviceProof]) -> list[str]:
    return [
        f"{key}: {difference.field}: device says {difference.device}, twin says {difference.twin}"
        for key, proof in proofs.items()
        for difference in proof.differences
    ]


def test_the_same_command_against_the_twins_is_clean(tmp_path: Path) -> None:
    proofs = _proven(tmp_path)
    assert _told(proofs) == []
    assert set(proofs) == {
        "axes.pitch", "axes.roll", "axes.yaw", "readouts.dmm", "environment.air", "streams.imu", "streams.board",
    }  # fmt: skip
    assert document_of(tuple(proofs.values()))["differences"] == 0
    assert read_transcript(tmp_path / "kept" / "device" / "axes.roll.jsonl")


@pytest.mark.parametrize(
    "rig_file",
    [meters_rig_file, text_chambers_rig_file, rate_tables_rig_file, angle_meter_rig_file],
    ids=lambda made: made.__name__,
)
def test_the_twins_of_the_other_drivers_are_clean_as_well(rig_file: Callable[[Path], Path], tmp_path: Path) -> None:
    proofs = _proven_file(rig_file(tmp_path), tmp_path)
    assert _told(proofs) == []
    assert all("Error" not in proof.answers.compared["identity"] for proof in proofs.values())


def _fahrenheit(twins: dict[str, Any]) -> None:
    twins["environment.air"].is_fahrenheit = True


def _decimals(twins: dict[str, Any]) -> None:
    twins["environment.air"]._decimals, twins["environment.air"]._scale = 0, 1


def _mute(twins: dict[str, Any]) -> None:
    twins["axes.roll"] = Line(twins["axes.roll"], lambda said: b"" if said == b"360.000000\r\n" else said)


def _firmware(twins: dict[str, Any]) -> None:
    twins["axes.roll"].version = "ESP301 Version 3.0.1 6/1/99"


def _terminator(twins: dict[str, Any]) -> None:
    twins["axes.pitch"] = Line(twins["axes.pitch"], lambda said: said.replace(b"\r\n", b"\n"))


def _swapped(twins: dict[str, Any]) -> None:
    wiring = twins["readouts.dmm"].unit._wiring
    wiring[101], wiring[102] = wiring[102], wiring[101]


def _card(twins: dict[str, Any]) -> None:
    twins["readouts.dmm"].unit.cards[1] = "34902A"


def _wrapping(twins: dict[str, Any]) -> None:
    twins["axes.yaw"].units[1].wraps = True


def _digits(twins: dict[str, Any]) -> None:
    twins["axes.roll"] = Line(twins["axes.roll"], lambda said: said.replace(b"0.000000\r\n", b"0.00\r\n"))


def _unsigned(twins: dict[str, Any]) -> None:
    twins["readouts.dmm"] = Line(twins["readouts.dmm"], lambda said: said.replace(b"+", b""))


def _in_g(twins: dict[str, Any]) -> None:
    twin = twins["streams.imu"]
    fields = twin._fields
    twin._fields = lambda output, at_s: tuple(
        value / 9.80665 if index in (3, 4, 5) else value for index, value in enumerate(fields(output, at_s))
    )


def _slow(twins: dict[str, Any]) -> None:
    board: CsvImuTwin = twins["streams.board"]
    for name, value in vars(board).items():
        if value == 50.0:
            setattr(board, name, 25.0)


def _faulty(twins: dict[str, Any]) -> None:
    twins["axes.yaw"].units[1].alarm = 0x30


PLANTED: dict[str, tuple[Callable[[dict[str, Any]], None], str, tuple[str, str]]] = {
    "another unit": (_fahrenheit, "environment.air", ("steps of 0.1 degF", "steps of 0.1 degC")),
    "another scale": (_decimals, "environment.air", ("steps of 1 degC", "steps of 0.1 degC")),
    "a missing reply": (_mute, "axes.roll", ("DeviceSilent", "ESP301 Version 3.01")),
    "another firmware": (_firmware, "axes.roll", ("3.0.1 6/1/99", "3.01")),
    "another terminator": (_terminator, "axes.pitch", (r"\n", r"\r\n")),
    "swapped channels": (_swapped, "readouts.dmm", ("dmm.x and dmm.y", "they changed places")),
    "another card": (_card, "readouts.dmm", ("34902A in slot 1", "34901A in slot 1")),
    "wrap on": (_wrapping, "axes.yaw", ("wrap function is on", "wrap off")),
    "fewer decimals": (_digits, "axes.roll", ("says 'N.dd", "twin says 'N.dddddd")),
    "no plus signs": (_unsigned, "readouts.dmm", ("'N.dd", "'+N.dd")),
    "acceleration in g": (_in_g, "streams.imu", ("gravity: device says 1", "9.8")),
    "an alarm": (_faulty, "axes.yaw", ("alarm 0x30", "at rest")),
}


@pytest.mark.parametrize(("plant", "key", "words"), PLANTED.values(), ids=list(PLANTED))
def test_a_planted_difference_is_named_at_its_device(
    tmp_path: Path, plant: Callable[[dict[str, Any]], None], key: str, words: tuple[str, str]
) -> None:
    proofs = _proven(tmp_path, plant)
    found = _told(proofs)
    assert found
    assert {sentence.partition(":")[0] for sentence in found} == {key}
    for word in words:
        assert any(word in sentence for sentence in found), found


def _gone_round(twins: dict[str, Any]) -> None:
    wiring = twins["readouts.dmm"].unit._wiring
    wiring[101], wiring[102], wiring[103] = wiring[102], wiring[103], wiring[101]


def test_channels_that_went_round_are_named_in_their_order_and_no_two_of_them_changed_places(tmp_path: Path) -> None:
    (told,) = _told(_proven(tmp_path, _gone_round))
    assert told.startswith("readouts.dmm: channels dmm.x, dmm.y, dmm.z: device says ")
    assert told.endswith("each reads the signal of the next")


def test_a_channel_that_reads_anothers_signal_while_that_one_reads_none_did_not_change_places(tmp_path: Path) -> None:
    for one, other in ((101, 102), (102, 101)):

        def pulled(twins: dict[str, Any], one: int = one, other: int = other) -> None:
            wiring = twins["readouts.dmm"].unit._wiring
            wiring[one] = wiring.pop(other)

        folder = tmp_path / str(one)
        folder.mkdir()
        assert not [told for told in _told(_proven(folder, pulled)) if "places" in told or "the next" in told]


def test_an_identity_that_the_file_states_is_not_compared_with_the_twins(tmp_path: Path) -> None:
    stated = ESP301 + 'identity = "6/1/99"'
    assert [sentence for sentence in _told(_proven(tmp_path, _firmware, esp301=stated)) if "identity" in sentence] == []


def _homed_table(twins: dict[str, Any]) -> None:
    twins["axes.pitch"].axes[1].home(-100.0)


@pytest.mark.parametrize(("axis", "plant"), [("pitch", _homed_table), ("yaw", lambda _twins: None)])
def test_motion_is_within_five_degrees_and_back(
    tmp_path: Path, axis: str, plant: Callable[[dict[str, Any]], None]
) -> None:
    proofs = _proven(tmp_path, plant, motion=axis)
    assert _told(proofs) == []
    answers = proofs[f"axes.{axis}"].answers.compared
    assert answers["move"] == "arrived there and back"
    assert answers["stop"] == "stopped inside the move"
    assert answers["limits"] == "refused before anything is sent"


def test_a_start_that_is_ignored_is_named(tmp_path: Path) -> None:
    def ignoring(twins: dict[str, Any]) -> None:
        twins["axes.yaw"].units[1].ignores_starts = True

    (found,) = [sentence for sentence in _told(_proven(tmp_path, ignoring, motion="yaw")) if ": move:" in sentence]
    assert "does not start" in found


def test_an_axis_without_a_home_is_not_moved(tmp_path: Path) -> None:
    with pytest.raises(RequestRefused, match=r"yaw: the axis is not homed.*nothing moved"):
        _proven(tmp_path, lambda twins: twins["axes.yaw"].units[1].servo.power_cycle(0.0), motion="yaw")


def test_what_was_kept_is_a_transcript_that_answers_the_same(tmp_path: Path) -> None:
    first = _proven(tmp_path, _fahrenheit)
    clock = VirtualClock(datetime(2024, 3, 1, tzinfo=UTC))
    again = prove(
        read_rig(tmp_path / "rig.toml"),
        tmp_path / "again",
        clock=clock,
        line_source=replaying(tmp_path / "kept" / "device", clock),
    )
    found = {proof.key: proof for proof in again}
    request = [key for key in first if not key.startswith("streams.")]
    assert [(key, found[key].answers.compared) for key in request] == [
        (key, first[key].answers.compared) for key in request
    ]


def test_a_driver_without_a_twin_is_asked_and_recorded_and_its_neighbours_are_compared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig_file = meters_rig_file(tmp_path)
    with serve_rig(read_rig(rig_file), ScaledClock(100.0)) as served:
        at_ports = write_rig(rig_file, served.addresses, 100.0, tmp_path / "ports.toml")
        f4 = DRIVERS["watlow-f4"]
        assert f4.environment is not None
        alone = replace(f4, environment=replace(f4.environment, twin=None))
        monkeypatch.setitem(DRIVERS._parts, "watlow-f4", alone)
        proofs = {proof.key: proof for proof in prove(at_ports, tmp_path / "kept")}
    assert proofs["environment.air"].is_alone
    assert "Watlow F4" in proofs["environment.air"].answers.compared["identity"]
    assert read_transcript(tmp_path / "kept" / "device" / "environment.air.jsonl")
    assert not proofs["readouts.dmm"].is_alone
    assert _told(proofs) == []
