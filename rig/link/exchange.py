"""One request, one reply: be quiet, send, collect to the terminator by one overall deadline, judge the whole line.

The danger on a line without sequence numbers is the late reply: after a time-out a naive driver takes it for the
answer to the next question, and every later answer is shifted by one. So bytes that wait before a question are
never an answer; after any doubt the line must first fall silent (or answer a sentinel) before the next question;
more bytes than one reply are refused; and only questions that may be asked twice are asked again, and counted.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from rig.errors import DeviceNonsense, DeviceSilent, LineNotQuiet
from rig.link.byte_stream import ByteStream
from rig.link.counts import counts_of
from rig.link.symptoms import remedy

Reply = TypeVar("Reply")

LONGEST_REPLY = 65536
"""Bytes without a terminator after which it is noise and no reply."""


@dataclass(frozen=True, slots=True)
class Patience:
    """How long an exchange waits, in seconds of the stream's clock."""

    timeout_s: float = 1.0
    """From sending to the reply's terminator."""
    quiet_s: float = 0.2
    """A silence this long after a doubt means that nothing more is on the way: at least the device's worst latency."""
    quiet_limit_s: float = 5.0
    """A line that is not quiet within this time streams or is noise."""
    attempts: int = 3
    """Times a question that may be repeated is asked in all."""


def not_quiet(stream: ByteStream, patience: Patience, taken: int, last: bytes) -> LineNotQuiet:
    """Return what is raised where ``taken`` bytes came on a line that was to fall quiet, the last of them ``last``."""
    return LineNotQuiet(
        f"{stream.name}: the line does not fall quiet within {patience.quiet_limit_s:g} s: {taken} bytes came, the last"
        f" {last[-40:]!r}; nothing was sent; check what else talks on it"
    )


class Exchange:
    """Questions and answers over one stream.

    ``resynchronise`` replaces the wait for silence after a doubt where the device offers something surer, such as
    a question whose answer is known. ``is_aside`` tells lines that a device lawfully says unasked: they are skipped.
    """

    def __init__(
        self,
        stream: ByteStream,
        *,
        terminator: bytes = b"\r\n",
        patience: Patience | None = None,
        resynchronise: Callable[[], None] | None = None,
        is_aside: Callable[[bytes], bool] | None = None,
    ) -> None:
        self.stream = stream
        self.counts = counts_of(stream)
        self.patience = patience or Patience()
        self._terminator = terminator
        self._resynchronise = resynchronise or self.wait_for_quiet
        self._is_aside = is_aside or (lambda _line: False)
        self._is_in_doubt = True  # until the line was quiet once: a boot banner or an old stream may be waiting

    def tell(self, request: bytes) -> None:
        """Send what has no reply. Raises: LinkLost, LinkClosed, DeviceNonsense (a line that does not fall quiet)."""
        self._clear_the_line()
        self.stream.write(request)

    def write_in_doubt(self, stop: bytes) -> None:
        """Write a stop on a line in doubt before it is quiet, which it may never be; nothing where it goes at once.

        It is told again as any request. Raises: LinkLost, LinkClosed.
        """
        if self._is_in_doubt:
            self.stream.write(stop)

    def ask(
        self,
        request: bytes,
        parse: Callable[[bytes], Reply],
        *,
        idempotent: bool,
        timeout_s: float | None = None,
        length: int | None = None,
        lines: int = 1,
    ) -> Reply:
        """Send ``request`` and return what ``parse`` makes of the reply without its terminator.

        ``length`` is the reply's where it has that many bytes and no terminator; ``lines``: the reply has so many and
        ``parse`` gets them with the terminators between. ``parse`` raises DeviceNonsense for a reply that cannot be the
        answer. ``idempotent`` says that asking twice does no harm: only then is the question
        repeated. Raises: DeviceSilent, DeviceNonsense, LinkLost, LinkClosed.
        """
        attempts = self.patience.attempts if idempotent else 1
        for attempt in range(1, attempts + 1):
            try:
                self._clear_the_line()
                return self._ask_once(
                    request, parse, self.patience.timeout_s if timeout_s is None else timeout_s, length, lines
                )
            except (DeviceSilent, DeviceNonsense) as error:
                self._is_in_doubt = True
                self._count(error)
                if attempt == attempts or isinstance(error, LineNotQuiet):
                    raise
                self.counts.repeated += 1
        raise AssertionError("a question is asked at least once")

    def hear(self, request: bytes, parse: Callable[[bytes], Reply], timeout_s: float) -> Reply:
        """Return what ``parse`` makes of the reply to ``request``, which was told before; never repeated.

        Raises: DeviceSilent, DeviceNonsense, LinkLost, LinkClosed.
        """
        self.counts.questions += 1
        try:
            return self._parsed(request, parse, self.read_line(timeout_s, request))
        except (DeviceSilent, DeviceNonsense) as error:
            self._is_in_doubt = True
            self._count(error)
            raise

    def take_waiting(self) -> bytes:
        """Take bytes nobody asked for, and count them."""
        waiting = self.stream.discard_input()
        self.counts.stale_bytes += len(waiting)
        return waiting

    @property
    def is_in_doubt(self) -> bool:
        """Whether the line is brought to a known state before the next question."""
        return self._is_in_doubt

    def doubt(self) -> None:
        """Doubt the line: the next question must first bring it to a known state.

        Something went wrong above this exchange.
        """
        self._is_in_doubt = True

    def wait_for_quiet(self) -> None:
        """Take and count what still arrives until the line has been silent for ``quiet_s``. Raises: LineNotQuiet.

        Whole lines that a device lawfully says unasked are no answers that come late, and break no silence.
        """
        clock, quiet_s = self.stream.clock, self.patience.quiet_s
        silent_since_s = clock.monotonic_s()
        limit_s = silent_since_s + self.patience.quiet_limit_s
        taken, rest = 0, b""
        while stale := self.stream.read(quiet_s + (clock.monotonic_s() if rest else silent_since_s)):
            taken += len(stale)
            self.counts.stale_bytes += len(stale)
            *lines, rest = (rest + stale).split(self._terminator)
            if not all(map(self._is_aside, lines)):
                silent_since_s = clock.monotonic_s()
            if clock.monotonic_s() >= limit_s or taken > LONGEST_REPLY:
                raise not_quiet(self.stream, self.patience, taken, stale)

    def skip_to(self, sentinel: bytes, timeout_s: float, waited_for: bytes) -> None:
        """Take bytes until ``sentinel`` came whole; all others are counted as stale.

        ``waited_for``: the question that it answers, for messages. Raises: DeviceSilent.
        """
        deadline_s = self.stream.clock.monotonic_s() + timeout_s
        buffer = b""
        while sentinel not in buffer:
            more = self.stream.read(deadline_s)
            if not more:
                raise self._silence(waited_for, buffer, timeout_s)
            buffer = buffer[-LONGEST_REPLY:] + more
            self.counts.stale_bytes += len(more)
        self.counts.stale_bytes -= len(sentinel)

    def read_line(self, timeout_s: float, waited_for: bytes, lines: int = 1) -> bytes:
        """Read the next line, or so many lines, without the last terminator (``waited_for`` is for messages).

        Raises: DeviceSilent, DeviceNonsense.
        """
        deadline_s = self.stream.clock.monotonic_s() + timeout_s
        buffer = b""
        while True:
            buffer += self._more(buffer, deadline_s, timeout_s, waited_for)
            *whole, rest = buffer.split(self._terminator)
            answers = [line for line in whole if not self._is_aside(line)]
            if len(answers) > lines:
                raise self._nonsense(waited_for, buffer, "more than one reply to one question")
            if len(answers) == lines and not rest:
                return self._terminator.join(answers)
            if len(buffer) > LONGEST_REPLY:
                raise self._nonsense(waited_for, buffer, f"no terminator {self._terminator!r} in {len(buffer)} bytes")

    def read_bytes(self, length: int, timeout_s: float, waited_for: bytes) -> bytes:
        """Read a reply of so many bytes (``waited_for`` is for messages).

        Raises: DeviceSilent, DeviceNonsense.
        """
        deadline_s = self.stream.clock.monotonic_s() + timeout_s
        buffer = b""
        while len(buffer) < length:
            buffer += self._more(buffer, deadline_s, timeout_s, waited_for)
        if len(buffer) > length:
            raise self._nonsense(waited_for, buffer, "more bytes than one reply")
        return buffer

    def _more(self, buffer: bytes, deadline_s: float, timeout_s: float, waited_for: bytes) -> bytes:
        more = self.stream.read(deadline_s)
        if not more:
            raise self._silence(waited_for, buffer, timeout_s)
        return more

    def _ask_once(
        self, request: bytes, parse: Callable[[bytes], Reply], timeout_s: float, length: int | None, lines: int
    ) -> Reply:
        self.counts.questions += 1
        self.stream.write(request)
        if length is None:
            reply = self.read_line(timeout_s, request, lines)
        else:
            reply = self.read_bytes(length, timeout_s, request)
        return self._parsed(request, parse, reply)

    def _parsed(self, request: bytes, parse: Callable[[bytes], Reply], reply: bytes) -> Reply:
        try:
            return parse(reply)
        except DeviceNonsense as error:
            raise self._nonsense(request, reply, str(error)) from error

    def _clear_the_line(self) -> None:
        if self._is_in_doubt:
            self._resynchronise()
            self._is_in_doubt = False
        else:
            self.take_waiting()

    def _count(self, error: DeviceSilent | DeviceNonsense) -> None:
        if isinstance(error, DeviceSilent):
            self.counts.silent += 1
        else:
            self.counts.nonsense += 1

    def _silence(self, request: bytes, received: bytes, timeout_s: float) -> DeviceSilent:
        return DeviceSilent(
            f"{self.stream.name}: no complete reply to {shown(request)}: got {shown(received)} within {timeout_s:g} s;"
            f" nothing was taken from it; {remedy(request, received, 'check power, address, cable and terminator')}"
        )

    def _nonsense(self, request: bytes, received: bytes, why: str) -> DeviceNonsense:
        return DeviceNonsense(
            f"{self.stream.name}: no answer to {shown(request)}: got {shown(received)}: {why};"
            " nothing was taken from it;"
            f" {remedy(request, received, 'check the line settings and that this is the right device')}"
        )


def shown(data: bytes, longest: int = 60) -> str:
    """Return bytes for a message: printable and short."""
    return repr(data) if len(data) <= longest else f"{data[:longest]!r}… ({len(data)} bytes)"
