"""A run whose line breaks while an axis turns at a rate, and is back within seconds: what people are told of it."""

from collections.abc import Callable
from pathlib import Path

import pytest
from motion_runs import motion_run
from unattended_run import events

from procedures.errors import ExitStatus
from procedures.journal.requests.spool import Request, Spool
from procedures.journal.status.status import status
from procedures.records.states import State
from procedures.run.begin import begin
from rig.assembly.open_rig import open_rig
from rig.devices.zaber import ZaberAxis
from rig.errors import LinkLost
from rig.link.byte_stream import ByteStream

ONE_AXIS = {
    r"replications = 4": "replications = 1",
    r"pitch_dps = .*": "roll_dps = [40.0]",
    r"yaw_dps = .*\n": "",
    r"(?m)^roll_dps = \[10.0, 40.0\]\n": "",
    r'model = "gyro"': 'model = "linear"',
}
LOST = "axes.pitch at /dev/serial/by-id/usb-x: the port is gone; check cable and adapter"
LOOKS, REFUSALS = 20, 6


class _CutInTurn:
    """The line of the axes in memory: it breaks some looks behind the first order to turn."""

    def __init__(self, stream: ByteStream) -> None:
        self._stream, self._left = stream, -1
        self.name, self.clock = stream.name, stream.clock

    def write(self, data: bytes) -> None:
        if b"move vel" in data and self._left < 0:
            self._left = LOOKS
        self._left -= self._left > 0
        self._require()
        self._stream.write(data)

    def read(self, deadline_s: float) -> bytes:
        self._require()
        return self._stream.read(deadline_s)

    def discard_input(self) -> bytes:
        self._require()
        return self._stream.discard_input()

    def close(self) -> None:
        self._stream.close()

    def _require(self) -> None:
        if self._left == 0:
            raise LinkLost(LOST)


def test_a_run_whose_line_is_back_is_told_as_one_that_lost_it_and_stands(tmp_path: Path) -> None:
    small, openings = motion_run(tmp_path, "rate-table", "rates", ONE_AXIS), [0]

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        if key != "axes.pitch":
            return open_line()
        openings[0] += 1
        if 1 < openings[0] <= 1 + REFUSALS:
            raise LinkLost(LOST)
        return _CutInTurn(open_line()) if openings[0] == 1 else open_line()

    run_dir = tmp_path / "run"
    run_dir.mkdir()
    with open_rig(small.rig, line_source=source) as rig:
        outcome = begin(run_dir, small.header(run_dir), small.plan, rig)
    assert openings[0] == 2 + REFUSALS
    assert outcome.state is State.TRIPPED
    assert set(outcome.positions_deg) == {"pitch", "yaw", "roll"}
    assert outcome.reason.startswith(LOST)
    assert "and turned on until the line was opened again, 3 s after the first stop" in outcome.reason
    assert "not every axis is known to stand still" not in outcome.reason
    assert "use the stop button" not in outcome.reason
    (safe,) = [event for event in events(run_dir) if event.kind == "safe"]
    assert safe.detail["reopened"] in outcome.reason
    assert safe.detail["failures"] == []


def test_a_run_is_not_told_to_stand_where_another_device_answers_its_stop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The line is back, and leads elsewhere: what is stopped and seen at rest there is another stage."""
    small, openings = motion_run(tmp_path, "rate-table", "rates", ONE_AXIS), [0]

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        if key != "axes.pitch":
            return open_line()
        openings[0] += 1
        if openings[0] > 1:
            monkeypatch.setattr(ZaberAxis, "identify", lambda _: "Zaber, serial 99999")
        return _CutInTurn(open_line()) if openings[0] == 1 else open_line()

    run_dir = tmp_path / "run"
    run_dir.mkdir()
    with open_rig(small.rig, line_source=source) as rig:
        rig.identities()
        outcome = begin(run_dir, small.header(run_dir), small.plan, rig)
    assert outcome.state is State.TRIPPED
    assert "roll" not in outcome.positions_deg
    assert "not every axis is known to stand still: pitch: another device answers on its line: was " in outcome.reason
    (safe,) = [event for event in events(run_dir) if event.kind == "safe"]
    assert "reopened" not in safe.detail
    assert set(safe.detail["unknown"]) == {"pitch", "yaw", "roll"}


class _CutAtStop(_CutInTurn):
    """The line breaks as the stop is to go over it that an abort asks for in the midst of a turn."""

    def __init__(self, stream: ByteStream, abort: Callable[[], None]) -> None:
        super().__init__(stream)
        self._abort, self._is_asked = abort, False

    def write(self, data: bytes) -> None:
        if b"move vel" in data and self._left < 0:
            self._left = LOOKS
        self._left -= self._left > 1
        if self._left == 1 and not self._is_asked:
            self._is_asked = True
            self._abort()
        if self._is_asked and b"stop" in data:
            self._left = 0
        self._require()
        self._stream.write(data)


@pytest.mark.parametrize("comes_back", [True, False])
def test_an_abort_whose_stop_meets_a_lost_line_is_told_as_hers_and_with_the_line(
    tmp_path: Path, *, comes_back: bool
) -> None:
    small, openings = motion_run(tmp_path, "rate-table", "rates", ONE_AXIS), [0]
    run_dir = tmp_path / "run"
    run_dir.mkdir()

    def abort() -> None:
        Spool(run_dir).submit(Request("abort", "anna", "2026-03-01T12:00:00+00:00", "smoke"))

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        if key != "axes.pitch":
            return open_line()
        openings[0] += 1
        if openings[0] > 1 and not (comes_back and openings[0] > 1 + REFUSALS):
            raise LinkLost(LOST)
        return _CutAtStop(open_line(), abort) if openings[0] == 1 else open_line()

    with open_rig(small.rig, line_source=source) as rig:
        outcome = begin(run_dir, small.header(run_dir), small.plan, rig)
    last = events(run_dir)[-1]
    assert last.detail["by"] == "anna"
    assert "smoke" in outcome.reason
    assert "asked for by anna" in outcome.reason
    assert LOST in outcome.reason
    assert status(run_dir).state is outcome.state
    if comes_back:
        assert (outcome.state, outcome.exit_status) == (State.ABORTED, ExitStatus.ABORTED)
        assert outcome.reason.startswith(
            f"smoke; a stop on the way out failed: roll: {LOST}; roll turned when its line"
        )
        assert "use the stop button" not in outcome.reason
        assert set(outcome.positions_deg) == {"pitch", "yaw", "roll"}
    else:
        assert (outcome.state, outcome.exit_status) == (State.TRIPPED, ExitStatus.HELD)
        assert outcome.reason.startswith("the run was aborted 20")
        assert "not every axis is known to stand still" in outcome.reason
        assert outcome.positions_deg == {}
