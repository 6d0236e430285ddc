"""Opens real ports by their URL: a device path, ``socket://host:port``, ``rfc2217://host:port``, or ``terminal``."""

from rig.clock import Clock
from rig.link.byte_stream import ByteStream
from rig.link.serial_stream import LineSettings, SerialStream
from rig.link.socket_stream import SocketStream
from rig.link.terminal_stream import TERMINAL, TerminalStream

SOCKET_SCHEME = "socket://"


def open_stream(
    url: str,
    *,
    clock: Clock,
    baud_rate: int = 9600,
    data_bits: int = 8,
    parity: str = "N",
    stop_bits: float = 1.0,
    rts_cts: bool = False,
    dtr_low: bool = False,
    rts_low: bool = False,
    connect_timeout_s: float = 5.0,
    owner: str = "",
) -> ByteStream:
    """Open the stream behind ``url``; ``clock`` is the machine's (unscaled) clock.

    ``owner`` is what messages call the device behind it, such as ``axes.pitch``; ``parity`` is one of ``N E O M S``.
    The line settings matter to devices and ``rfc2217://`` only.
    Raises: LinkLost (missing, refused, broken), RigBusy (the device is open elsewhere), RequestRefused (no such URL).
    """
    if url == TERMINAL:
        return TerminalStream(clock)
    if url.startswith(SOCKET_SCHEME):
        return SocketStream(url, clock, connect_timeout_s, owner)
    line = LineSettings(baud_rate, data_bits, parity, stop_bits, rts_cts, dtr_low, rts_low)
    return SerialStream(url, clock, line, owner)
