"""The beat of a streaming twin: which samples are due, at most as many as a line's buffer would still hold."""

BACKLOG_S = 30.0
"""Samples older than this that nobody took are lost, as in a buffer that overflows."""


class Metronome:
    """Samples at k / ``rate_hz`` behind the start, counted from 0."""

    def __init__(self) -> None:
        self._start_s: float | None = None
        self._rate_hz = 1.0
        self._next = 0

    @property
    def is_running(self) -> bool:
        return self._start_s is not None

    def start(self, now_s: float, rate_hz: float) -> None:
        self._start_s, self._rate_hz, self._next = now_s, rate_hz, 0

    def stop(self) -> None:
        self._start_s = None

    def due(self, now_s: float) -> list[tuple[int, float]]:
        """Return number and instant of every sample that came due since the last look."""
        if self._start_s is None:
            return []
        last = int((now_s - self._start_s) * self._rate_hz + 1e-9)
        first = max(self._next, last - int(BACKLOG_S * self._rate_hz))
        self._next = max(self._next, last + 1)
        return [(number, self._start_s + number / self._rate_hz) for number in range(first, last + 1)]

    def next_s(self) -> float | None:
        return None if self._start_s is None else self._start_s + self._next / self._rate_hz
