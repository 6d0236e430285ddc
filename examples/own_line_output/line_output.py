"""Send every moment of a run to InfluxDB, Telegraf or VictoriaMetrics: a line of line protocol, a UDP datagram each.

Only where ``CALRIG_LINE_OUTPUT`` names ``HOST:PORT``, such as a Telegraf with ``[[inputs.socket_listener]]
service_address = "udp://:8094"``. A datagram waits for nobody: what receives it may be slow, or gone.
"""

import os
import socket
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from procedures.observers.audience import ObserverKind
from procedures.records.progress import Progress, RunObserver
from rig.clock import Clock, SystemClock

VARIABLE = "CALRIG_LINE_OUTPUT"
_ESCAPED_TAG = str.maketrans({",": r"\,", "=": r"\=", " ": r"\ ", "\n": r"\ "})
_ESCAPED_TEXT = str.maketrans({'"': r"\"", "\\": r"\\", "\n": " "})


class LineOutput:
    """Sends and forgets."""

    def __init__(self, run: str, address: tuple[str, int], clock: Clock) -> None:
        self._family, _, _, _, self._address = socket.getaddrinfo(*address, type=socket.SOCK_DGRAM)[0]
        self._run = run
        self._clock = clock

    def on_event(self, progress: Progress) -> None:
        """Send one line; a network that refuses it is not told."""
        line = line_of(self._run, progress, self._clock.now_utc())
        with suppress(OSError), socket.socket(self._family, socket.SOCK_DGRAM) as sender:
            sender.setblocking(False)
            sender.sendto(line.encode("utf-8"), self._address)


def line_of(run: str, progress: Progress, now_utc: datetime) -> str:
    """Return one moment in line protocol: measurement and tags, fields, nanoseconds since 1970."""
    tags = f"calrig,event={progress.event.translate(_ESCAPED_TAG)},run={run.translate(_ESCAPED_TAG)}"
    fields = [
        f'state="{progress.state.translate(_ESCAPED_TEXT)}"',
        f"dwells_done={progress.dwells_done}i",
        f"dwells_planned={progress.dwells_planned}i",
        f"rejected={progress.rejected}i",
        f"replication={progress.replication}i",
    ]
    if progress.rate_per_min is not None:
        fields.append(f"rate_per_min={progress.rate_per_min!r}")
    if progress.message:
        fields.append(f'message="{progress.message.translate(_ESCAPED_TEXT)}"')
    return f"{tags} {','.join(fields)} {round(now_utc.timestamp() * 1e6) * 1000}\n"


def _make(run_dir: Path) -> RunObserver | None:
    named = os.environ.get(VARIABLE)
    if not named:
        return None
    host, _, port = named.rpartition(":")
    return LineOutput(run_dir.name, (host.strip("[]"), int(port)), SystemClock())


OBSERVER = ObserverKind("line-output", _make)
