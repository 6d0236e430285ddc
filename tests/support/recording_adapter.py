"""A GPIB adapter's twin behind a peer that keeps what the host writes."""

from rig.twins.prologix import PrologixTwin


class RecordingAdapter:
    """A peer that keeps what is written and passes it on."""

    def __init__(self, twin: PrologixTwin) -> None:
        self.twin = twin
        self.heard = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard += data
        self.twin.receive(data, now_s)

    def transmit(self, now_s: float) -> bytes:
        return self.twin.transmit(now_s)

    def next_event_s(self) -> float | None:
        return self.twin.next_event_s()

    @property
    def lines(self) -> list[bytes]:
        """What was written, line by line."""
        return [line for line in self.heard.split(b"\n") if line]
