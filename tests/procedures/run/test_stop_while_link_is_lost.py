"""A run that is held for a lost link and then stopped by a person: what that person is told at two in the morning."""

import os
import socket
import tty
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from threading import Thread
from typing import Protocol

import pytest
from cut_line import cut_line
from small_run import bench
from unattended_run import UnattendedRun, asks, events

from procedures.errors import ExitStatus
from procedures.journal.header import make_header
from procedures.journal.status.status import status
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from procedures.run.handover import handover
from rig.assembly.open_rig import open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock, SystemClock
from rig.errors import LinkLost
from rig.link.byte_stream import ByteStream

FACTOR = 100.0
SHORT = (("step = 30.0", "step = 60.0"), ("replications = 2", "replications = 1"), ("samples = 5", "samples = 3"))
OURS = ("used after it was closed", "open it again", "[Errno", "LinkClosed", "DeviceFault")
"""What a programmer reads."""


class Line(Protocol):
    address: str

    def cut(self, refusals: int) -> None: ...


class _PulledPlug:
    """A pseudo-terminal in front of a twin at TCP, by a name that is gone when the plug is pulled."""

    def __init__(self, target: str, name: Path) -> None:
        host, _, port = target.removeprefix("socket://").rpartition(":")
        self._twin = socket.create_connection((host, int(port)))
        self._master, self._device = os.openpty()
        tty.setraw(self._device)
        name.symlink_to(os.ttyname(self._device))
        self._name, self.address = name, str(name)
        self._threads = [Thread(target=work, daemon=True) for work in (self._to_twin, self._from_twin)]
        for thread in self._threads:
            thread.start()

    def cut(self, refusals: int) -> None:
        self._name.unlink(missing_ok=True)
        self._twin.shutdown(socket.SHUT_RDWR)
        os.close(self._device)
        self._threads[1].join()
        os.close(self._master)
        self._twin.close()

    def _to_twin(self) -> None:
        try:
            while data := os.read(self._master, 4096):
                self._twin.sendall(data)
        except OSError:
            return

    def _from_twin(self) -> None:
        try:
            while data := self._twin.recv(4096):
                os.write(self._master, data)
        except OSError:
            return


@contextmanager
def _pulled_plug(target: str, folder: Path) -> Iterator[Line]:
    yield _PulledPlug(target, folder / "usb-table")


def _over_tcp(target: str, _folder: Path) -> AbstractContextManager[Line]:
    return cut_line(target)


def _stopped(
    folder: Path, kind: str, line_of: Callable[[str, Path], AbstractContextManager[Line]]
) -> tuple[Path, Outcome, str]:
    """Run on twins at ports until the table's line is cut, and ask while the run is held for it."""
    small = bench(folder, procedure=SHORT)
    run_dir, files = folder / "run", (folder / "served.toml", folder / "procedure.toml")
    run_dir.mkdir()
    with (
        serve_rig(small.rig, ScaledClock(FACTOR)) as served,
        line_of(served.addresses["axes.pitch"], folder) as line,
    ):
        unattended = UnattendedRun(run_dir, at={2000: asks(kind)}, after={3: lambda _run: line.cut(10**6)})
        addresses = {**served.addresses, "axes.pitch": line.address, "axes.roll": line.address}
        described = write_rig(folder / "rig.toml", addresses, FACTOR, files[0])
        plan = make_plan(described, read_procedure(files[1]))
        header = make_header("ports", plan, described, *files, "tester", SystemClock().now_utc())
        with open_rig(described) as rig:
            return run_dir, begin(run_dir, header, plan, rig, unattended, unattended), line.address


@pytest.mark.parametrize(
    ("line_of", "kind", "word"), [(_over_tcp, "stop", "stopped"), (_pulled_plug, "abort", "aborted")]
)
def test_fault_21_who_stops_a_run_with_a_lost_line_is_told_device_port_moment_motion_and_what_to_do(
    tmp_path: Path, line_of: Callable[[str, Path], AbstractContextManager[Line]], kind: str, word: str
) -> None:
    run_dir, outcome, address = _stopped(tmp_path, kind, line_of)
    assert (outcome.state, outcome.exit_status, outcome.cause) == (State.TRIPPED, ExitStatus.HELD, "standstill")
    assert outcome.reason.startswith(f"the run was {word} ")
    assert f": please {kind}; stop: " in outcome.reason
    assert f"axes.pitch at {address}" in outcome.reason
    assert "pitch was last read at rest at -30.0000°, " in outcome.reason
    assert "roll was last read at rest at 0.0000°, " in outcome.reason
    assert outcome.reason.count("nothing that moves it was sent since") == 2
    assert outcome.reason.endswith("(asked for by bert)")
    last = events(run_dir)[-1]
    assert (last.kind, last.detail["to"], last.detail["by"]) == ("state", "tripped", "bert")
    assert f"{last.detail['reason']} (asked for by bert)" == outcome.reason
    stands, page, shift = status(run_dir), (run_dir / "why.txt").read_text(encoding="utf-8"), handover(run_dir)
    assert (stands.state, stands.held_by) == (State.TRIPPED, last.detail["reason"])
    for told in (page, shift):
        assert "pitch was last read at rest at -30.0000°" in told
        assert "press its stop button" in told
        assert "--operator NAME --reason TEXT" in told
    assert not [word for word in OURS if word in outcome.reason + page + shift]


class _CutInMove:
    """The table's line in memory: it breaks for good behind the n-th order to move the pitch axis."""

    def __init__(self, stream: ByteStream, orders: int) -> None:
        self._stream, self._orders = stream, orders
        self.name, self.clock = stream.name, stream.clock
        self.is_cut = False

    def write(self, data: bytes) -> None:
        self._require()
        self._stream.write(data)
        self._orders -= data.startswith(b"1 MOVE")
        if self._orders == 0:
            self._stream.read(self.clock.monotonic_s() + 0.3)  # its acknowledgement, which nobody hears
            self.is_cut = True

    def read(self, deadline_s: float) -> bytes:
        self._require()
        return self._stream.read(deadline_s)

    def discard_input(self) -> bytes:
        self._require()
        return self._stream.discard_input()

    def close(self) -> None:
        self._stream.close()

    def _require(self) -> None:
        if self.is_cut:
            raise LinkLost("axes.pitch at /dev/serial/by-id/usb-x: the port is gone; check cable and adapter")


def test_fault_21_an_axis_that_was_on_its_way_when_the_line_broke_is_not_said_to_stand(tmp_path: Path) -> None:
    small, cut = bench(tmp_path, rig=(("speed_dps = 180.0", "speed_dps = 5.0"),)), []

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        if key != "axes.pitch":
            return open_line()
        if cut:
            raise LinkLost("axes.pitch at /dev/serial/by-id/usb-x: cannot be opened; check the cable and the path")
        cut.append(_CutInMove(open_line(), 3))
        return cut[0]

    unattended = UnattendedRun(tmp_path / "run", at={200: asks("stop")})
    unattended.run_dir.mkdir()
    with open_rig(small.rig, line_source=source) as rig:
        outcome = begin(unattended.run_dir, small.header(unattended.run_dir), small.plan, rig, unattended, unattended)
    assert outcome.state is State.TRIPPED
    assert "not every axis is known to stand still, since the lines cannot be opened: axes.pitch at" in outcome.reason
    assert "whether pitch stands is not known: it was told to move to " in outcome.reason
    assert "roll was last read at rest at" in outcome.reason
    assert not [word for word in OURS if word in outcome.reason]
