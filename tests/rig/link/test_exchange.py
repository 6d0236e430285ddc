from itertools import cycle

import pytest
from gpib_rig import virtual_clock
from hypothesis import given, settings
from hypothesis import strategies as st

from rig.errors import DeviceNonsense, DeviceSilent, LinkClosed, LinkLost
from rig.link import faults
from rig.link.exchange import Exchange, Patience
from rig.link.faults import Fault, FaultScript
from rig.link.memory import MemoryStream

PATIENCE = Patience(timeout_s=1.0, quiet_s=0.2, quiet_limit_s=2.0, attempts=3)


class Echo:
    """Answers each line with its own text and the number of the question: no two answers are equal."""

    def __init__(self) -> None:
        self.questions: list[bytes] = []
        self._input = b""
        self._output = b""

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, self._input = (self._input + data).split(b"\r\n")
        for line in lines:
            self.questions.append(line)
            self._output += b"%s=%d\r\n" % (line, len(self.questions))

    def transmit(self, now_s: float) -> bytes:
        output, self._output = self._output, b""
        return output

    def next_event_s(self) -> float | None:
        return None


class Babbler(Echo):
    """Never falls quiet: says something every ``pause_s``, and answers beside."""

    def __init__(self, pause_s: float, *says: bytes) -> None:
        super().__init__()
        self.pause_s = pause_s
        self.says = cycle(says or (b"noise ",))
        self.next_s = 0.0

    def transmit(self, now_s: float) -> bytes:
        if now_s < self.next_s:
            return super().transmit(now_s)
        self.next_s = now_s + self.pause_s
        return super().transmit(now_s) + next(self.says)

    def next_event_s(self) -> float | None:
        return self.next_s


def answer_to(question: bytes) -> object:
    def parse(line: bytes) -> int:
        text, _, number = line.partition(b"=")
        if text != question or not number.isdigit():
            raise DeviceNonsense("the echo repeats the question")
        return int(number)

    return parse


def exchange_over(device: Echo, script: FaultScript | None = None) -> Exchange:
    clock = virtual_clock()
    return Exchange(MemoryStream(device, clock, "echo", script), patience=PATIENCE)


def ask(exchange: Exchange, question: bytes, *, idempotent: bool = True) -> int:
    return exchange.ask(question + b"\r\n", answer_to(question), idempotent=idempotent)  # type: ignore[arg-type]


def test_an_answer_belongs_to_its_question() -> None:
    exchange = exchange_over(Echo())
    assert [ask(exchange, b"A"), ask(exchange, b"B")] == [1, 2]
    assert exchange.counts.questions == 2
    assert exchange.counts.repeated == 0


def test_what_waits_before_the_first_question_is_no_answer() -> None:
    device = Echo()
    device.receive(b"A\r\n", 0.0)
    exchange = exchange_over(device)
    assert ask(exchange, b"A") == 2
    assert exchange.counts.stale_bytes == len(b"A=1\r\n")


def test_a_late_answer_never_becomes_the_answer_to_the_next_question() -> None:
    exchange = exchange_over(Echo(), FaultScript(reads={0: faults.delay(1.1)}))
    with pytest.raises(DeviceSilent, match="within 1 s"):
        ask(exchange, b"A", idempotent=False)
    assert ask(exchange, b"A") == 2
    assert exchange.counts.stale_bytes == len(b"A=1\r\n")


@pytest.mark.parametrize("length", [1, 4])
def test_more_bytes_than_a_reply_of_known_length_are_no_reply(length: int) -> None:
    with pytest.raises(DeviceNonsense, match="more bytes than one reply"):
        exchange_over(Echo()).ask(b"A\r\n", bytes, idempotent=True, length=length)  # it answers A=1 CR LF


def test_a_doubled_answer_is_dropped_before_the_next_question() -> None:
    exchange = exchange_over(Echo(), FaultScript(reads={0: faults.duplicate(0.01)}))
    assert ask(exchange, b"A") == 1
    exchange.stream.clock.sleep(0.1)
    assert ask(exchange, b"A") == 2
    assert exchange.counts.stale_bytes == len(b"A=1\r\n")


def test_two_answers_at_once_are_none() -> None:
    exchange = exchange_over(Echo(), FaultScript(reads={0: faults.duplicate()}))
    with pytest.raises(DeviceNonsense, match="more than one reply"):
        ask(exchange, b"A", idempotent=False)


def test_a_cut_answer_is_not_taken() -> None:
    exchange = exchange_over(Echo(), FaultScript(reads={0: faults.truncate(3)}))
    with pytest.raises(DeviceSilent, match="got b'A=1'"):
        ask(exchange, b"A", idempotent=False)


def test_an_answer_in_pieces_is_put_together() -> None:
    exchange = exchange_over(Echo(), FaultScript(reads={0: faults.split(2, 0.5)}))
    assert ask(exchange, b"A", idempotent=False) == 1


def test_only_what_may_be_repeated_is_repeated_and_counted() -> None:
    device = Echo()
    exchange = exchange_over(device, FaultScript(writes={0: faults.drop, 1: faults.drop}))
    assert ask(exchange, b"A") == 1
    assert (exchange.counts.repeated, exchange.counts.silent) == (2, 2)
    exchange = exchange_over(device, FaultScript(writes={0: faults.drop}))
    with pytest.raises(DeviceSilent):
        ask(exchange, b"B", idempotent=False)
    assert exchange.counts.repeated == 0
    assert device.questions == [b"A"]


def test_attempts_end() -> None:
    exchange = exchange_over(Echo(), FaultScript(writes=dict.fromkeys(range(9), faults.drop)))
    with pytest.raises(DeviceSilent):
        ask(exchange, b"A")
    assert exchange.counts.questions == PATIENCE.attempts


@pytest.mark.parametrize("pause_s", [0.0, 0.1])
def test_a_line_that_never_falls_quiet_is_refused(pause_s: float) -> None:
    exchange = exchange_over(Babbler(pause_s))
    with pytest.raises(DeviceNonsense, match="does not fall quiet within 2 s"):
        ask(exchange, b"A")
    assert exchange.stream.clock.monotonic_s() <= PATIENCE.quiet_limit_s + PATIENCE.quiet_s


def test_what_is_lawfully_said_unasked_breaks_no_silence_whole_or_in_pieces() -> None:
    """A stage that sends alerts on and on is asked as soon as no late answer can come."""
    for pause_s, *says in (
        (0.02, b"!idle\r\n"),
        (0.15, b"!idle\r\n!idle\r\n"),
        (0.02, b"dle\r\n!i", b"dle\r\n", b"!i"),
    ):
        stream = MemoryStream(Babbler(pause_s, *says), virtual_clock(), "stage")
        exchange = Exchange(stream, patience=PATIENCE, is_aside=lambda line: line.startswith(b"!"))
        exchange.wait_for_quiet()
        assert stream.clock.monotonic_s() < PATIENCE.quiet_limit_s / 2.0, says
    stream = MemoryStream(Babbler(0.02, b"!idle\r\n"), virtual_clock(), "stage")
    assert ask(Exchange(stream, patience=PATIENCE, is_aside=lambda line: line.startswith(b"!")), b"A") == 1


def test_a_stop_is_written_at_once_where_the_line_is_in_doubt_and_once_where_it_is_not() -> None:
    device = Babbler(0.05)
    exchange = exchange_over(device)
    exchange.write_in_doubt(b"STOP\r\n")
    assert device.questions == [b"STOP"]
    assert exchange.stream.clock.monotonic_s() == 0.0
    quiet = Echo()
    exchange = exchange_over(quiet)
    ask(exchange, b"A")
    exchange.write_in_doubt(b"STOP\r\n")
    assert quiet.questions == [b"A"]


def test_a_lost_line_is_not_asked_again() -> None:
    exchange = exchange_over(Echo(), FaultScript(writes={0: faults.hang_up}))
    with pytest.raises(LinkLost, match="hung up"):
        ask(exchange, b"A")
    assert exchange.counts.questions == 1


def test_a_closed_line_says_so() -> None:
    exchange = exchange_over(Echo())
    exchange.stream.close()
    with pytest.raises(LinkClosed, match="echo: used after it was closed"):
        ask(exchange, b"A")


def fault_within_the_quiet_time() -> st.SearchStrategy[Fault]:
    """Answers lost, cut, doubled at once, or late by less than time-out and quiet time together."""
    latest_s = 0.99 * (PATIENCE.timeout_s + PATIENCE.quiet_s)
    return st.one_of(
        st.sampled_from([faults.intact, faults.drop, faults.duplicate()]),
        st.floats(0.0, latest_s).map(faults.delay),
        st.integers(0, 6).map(faults.truncate),
    )


@settings(max_examples=200)
@given(st.dictionaries(st.integers(0, 9), fault_within_the_quiet_time()), st.lists(st.sampled_from([b"A", b"B"])))
def test_whatever_the_line_loses_or_delays_no_answer_is_of_an_earlier_question(
    script: dict[int, Fault], questions: list[bytes]
) -> None:
    device = Echo()
    exchange = exchange_over(device, FaultScript(reads=script))
    for question in questions:
        asked_before = len(device.questions)
        try:
            assert ask(exchange, question, idempotent=False) == asked_before + 1
        except (DeviceSilent, DeviceNonsense):
            continue
