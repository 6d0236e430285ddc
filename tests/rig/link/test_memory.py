import pytest
from gpib_rig import virtual_clock

from rig.errors import LinkClosed, LinkLost
from rig.link import faults
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream


class Slow:
    """Answers ``delay_s`` after it was asked, with what it was asked."""

    def __init__(self, delay_s: float) -> None:
        self.delay_s = delay_s
        self.due: list[tuple[float, bytes]] = []

    def receive(self, data: bytes, now_s: float) -> None:
        self.due.append((now_s + self.delay_s, data))

    def transmit(self, now_s: float) -> bytes:
        ready = b"".join(data for due_s, data in self.due if due_s <= now_s)
        self.due = [(due_s, data) for due_s, data in self.due if due_s > now_s]
        return ready

    def next_event_s(self) -> float | None:
        return min((due_s for due_s, _ in self.due), default=None)


def stream_to(peer: Slow, script: FaultScript | None = None) -> MemoryStream:
    return MemoryStream(peer, virtual_clock(), "memory", script)


def test_reading_lets_the_clock_run_to_the_answer_and_no_further() -> None:
    stream = stream_to(Slow(0.3))
    stream.write(b"hello")
    assert stream.read(10.0) == b"hello"
    assert stream.clock.monotonic_s() == pytest.approx(0.3, abs=1e-12)


def test_silence_lasts_exactly_to_the_deadline() -> None:
    stream = stream_to(Slow(5.0))
    stream.write(b"hello")
    assert stream.read(2.5) == b""
    assert stream.clock.monotonic_s() == pytest.approx(2.5, abs=1e-12)


def test_what_waits_is_taken_without_waiting() -> None:
    stream = stream_to(Slow(0.3))
    stream.write(b"hello")
    assert stream.discard_input() == b""
    stream.clock.sleep(0.3)
    assert stream.discard_input() == b"hello"


@pytest.mark.parametrize(
    ("fault", "arrives"),
    [
        (faults.intact, b"hello"),
        (faults.drop, b""),
        (faults.duplicate(), b"hellohello"),
        (faults.truncate(2), b"he"),
        (faults.prepend(b"stale "), b"stale hello"),
        (faults.replace(b"other"), b"other"),
        (faults.flip_bit(0, 0), b"iello"),
        (faults.flip_bit(-1, 7), b"hell\xef"),
    ],
)
@pytest.mark.parametrize("direction", ["writes", "reads"])
def test_a_fault_of_the_line_changes_what_arrives(direction: str, fault: faults.Fault, arrives: bytes) -> None:
    stream = stream_to(Slow(0.0), FaultScript(**{direction: {0: fault}}))
    stream.write(b"hello")
    assert stream.read(1.0) == arrives


@pytest.mark.parametrize("direction", ["writes", "reads"])
def test_a_delayed_piece_arrives_late(direction: str) -> None:
    stream = stream_to(Slow(0.1), FaultScript(**{direction: {0: faults.delay(0.5)}}))
    stream.write(b"hello")
    assert stream.read(0.55) == b""
    assert stream.read(10.0) == b"hello"
    assert stream.clock.monotonic_s() == pytest.approx(0.6, abs=1e-9)


@pytest.mark.parametrize(("fault", "first"), [(faults.delay(0.5), b"two"), (faults.stall(0.5), b"one two")])
def test_a_delayed_piece_is_overtaken_a_stalled_line_keeps_its_order(fault: faults.Fault, first: bytes) -> None:
    stream = stream_to(Slow(0.0), FaultScript(reads={0: fault}))
    stream.write(b"one ")
    assert stream.read(0.1) == b""
    stream.write(b"two")
    assert stream.read(10.0) == first


def test_only_the_named_piece_is_touched() -> None:
    stream = stream_to(Slow(0.0), FaultScript(writes={1: faults.drop}))
    for text in (b"one", b"two", b"three"):
        stream.write(text)
    assert stream.read(1.0) == b"onethree"


def test_a_line_that_hangs_up_says_so() -> None:
    with pytest.raises(LinkLost, match="hung up with 5 bytes"):
        stream_to(Slow(0.0), FaultScript(writes={0: faults.hang_up})).write(b"hello")


def test_a_closed_line_is_not_used() -> None:
    stream = stream_to(Slow(0.0))
    stream.close()
    for use in (lambda: stream.write(b"x"), lambda: stream.read(1.0), stream.discard_input):
        with pytest.raises(LinkClosed, match="memory: used after it was closed"):
            use()
