"""The lines of an open rig: each port opened once, each adapter shared by its instruments, twins in memory."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import asdict

from rig.clock import Clock, SystemClock
from rig.description.device_settings import TWIN_PORT
from rig.lines.lock import canonical
from rig.lines.recording import LineSource
from rig.link.byte_stream import ByteStream
from rig.link.counts import CountedStream, ExchangeCounts
from rig.link.gpib import GpibBus, GpibResource
from rig.link.lively_stream import LivelyStream, SignOfLife
from rig.link.memory import MemoryStream
from rig.link.ports import open_stream
from rig.link.prologix import PrologixBus
from rig.link.serial_stream import LineSettings, SerialStream
from rig.link.socket_stream import SocketStream
from rig.link.visa import VisaBus
from rig.twins.twin import Twin


class Lines:
    """Opens what drivers ask for and gives it back when ``opened`` closes. Keys are tables such as ``axes.pitch``."""

    def __init__(
        self,
        clock: Clock,
        twins: Mapping[str, Twin],
        source: LineSource | None,
        opened: ExitStack,
        sign_of_life: SignOfLife | None = None,
    ) -> None:
        """``sign_of_life``: called while real lines are listened to, but for streams, to which a thread listens."""
        self._clock = clock
        self._twins = twins
        self._source = source or _as_it_is
        self._opened = opened
        self._sign_of_life = sign_of_life
        self._streams: dict[str, ByteStream] = {}
        self._counted: dict[str, CountedStream] = {}
        """By the table that opened the line."""
        self._opened_ports: dict[str, ByteStream] = {}
        """By canonical port."""
        self._buses: dict[tuple[str, str], GpibBus] = {}

    def stream(
        self,
        key: str,
        port: str,
        baud_rate: int = 9600,
        *,
        parity: str = "N",
        rts_cts: bool = False,
        data_bits: int = 8,
        stop_bits: float = 1.0,
        dtr_low: bool = False,
        rts_low: bool = False,
    ) -> ByteStream:
        """Return the line to ``port``; a twin's is in memory and its own.

        Raises: LinkLost, RigBusy, RequestRefused.
        """
        name = f"twin of {key}" if port == TWIN_PORT else canonical(port)
        if name not in self._streams:
            line = LineSettings(baud_rate, data_bits, parity, stop_bits, rts_cts, dtr_low, rts_low)
            stream = CountedStream(self._source(key, lambda: self._open(key, port, line)))
            self._opened.callback(stream.close)
            self._streams[name] = stream
            self._counted[key] = stream
        return self._streams[name]

    def is_any_lost(self) -> bool:
        """Return whether one of them was found to be gone; asks nothing."""
        return any(stream.is_lost for stream in self._counted.values())

    def counts(self) -> dict[str, ExchangeCounts]:
        """Return what happened so far, by the table that opened the line.

        It is by device where there are several on it.
        """
        return {name: counts for key, stream in self._counted.items() for name, counts in stream.by_slave(key).items()}

    def descriptor(self, port: str) -> int | None:
        """Return what the system knows an open port by; None where it is none of the system's (a twin, a terminal)."""
        stream = self._opened_ports.get(canonical(port))
        return stream.descriptor() if isinstance(stream, SerialStream | SocketStream) else None

    def bus(self, key: str, resource: GpibResource) -> GpibBus:
        """Return the controller that carries an instrument.

        Raises as :meth:`stream`, and DeviceSilent, DeviceNonsense.
        """
        bus_key = (key if resource.carrier == "twin" else resource.carrier, resource.port)
        if bus_key not in self._buses:
            self._buses[bus_key] = self._open_bus(key, resource)
            self._opened.callback(self._buses[bus_key].close)
        return self._buses[bus_key]

    def _open(self, key: str, port: str, line: LineSettings) -> ByteStream:
        if port == TWIN_PORT:
            return MemoryStream(self._twins[key], self._clock, f"twin of {key}")
        stream = open_stream(port, clock=SystemClock(), **asdict(line), owner=key)
        self._opened_ports[canonical(port)] = stream
        if self._sign_of_life is None or key.startswith("streams."):
            return stream
        return LivelyStream(stream, self._sign_of_life)

    def _open_bus(self, key: str, resource: GpibResource) -> GpibBus:
        if resource.carrier == "visa":
            return VisaBus(resource.port, SystemClock(), sign_of_life=self._sign_of_life)
        return PrologixBus(self.stream(key, resource.port))


def _as_it_is(_key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
    return open_line()
