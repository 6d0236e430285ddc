"""A stream where a readout is asked for: so many of its samples on demand, while the package rests."""

from collections.abc import Mapping

import numpy as np

from procedures.run.dwell.stream_recorder import recording
from rig.abilities.abilities import Burst, Stream, Wait
from rig.clock import Clock

_MARGIN_SAMPLES = 0.5


class StreamedReadout:
    """A :class:`rig.abilities.abilities.Readout` of the channels of one stream."""

    def __init__(self, stream: Stream, clock: Clock) -> None:
        self.name = stream.name
        self.channels = stream.channels
        self._stream = stream
        self._clock = clock

    def identify(self) -> str:
        return self._stream.identify()

    def prepare(self) -> None:
        """Do nothing: a stream is set up anew whenever it is started."""

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:  # noqa: ARG002
        """Read the next ``samples`` samples. Raises as :class:`procedures.run.dwell.stream_recorder.Recorder`."""
        with recording({self.name: self._stream}, self._clock, wait) as recorder:
            recorder.start()
            while (left := samples - recorder.samples(self.name)) > 0:
                recorder.wait((left + _MARGIN_SAMPLES) / self._stream.rate_hz)
            recorded = recorder.stop()[self.name].part(0, samples)
        started_s = float(recorded.polled_s[0]) if recorded.polled_s.size else self._clock.monotonic_s()
        values = recorded.values[channel]
        overload, unit = np.zeros(values.size, dtype=np.bool_), self._stream.units[channel]
        return Burst(channel, values, overload, started_s, 1.0 / self._stream.rate_hz, unit)

    def reading_s(self, nplc: float | None = None) -> float:  # noqa: ARG002
        return 1.0 / self._stream.rate_hz

    def checks(self) -> Mapping[str, float]:
        return {}
