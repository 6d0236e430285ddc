"""``[dwell.adaptive]`` while a run goes on: integrations are tried once, readings are counted anew for each dwell.

What is chosen follows from what the journal holds, so a resumed run reads as its uninterrupted brother: integrations
are taken from their event, and the noise is that of the same accepted dwells in the same order.
"""

from collections.abc import Mapping
from math import isfinite

from procedures.description.dwell_settings import AdaptiveDwell
from procedures.plan.adaptive import Reading, best_reading, noise_wanted_v, samples_of_next
from procedures.plan.steps import Dwell
from procedures.records.dwells import NoiseReference
from procedures.run.context import RunContext
from procedures.run.dwell.measure import read_channel, readout_of, settle_at
from procedures.run.judgement.history import INTEGRATION


class AdaptiveDwells:
    """Asked once before the first dwell and once before each."""

    def __init__(self, context: RunContext, noise: NoiseReference, integrations: Mapping[str, float]) -> None:
        self._context, self._noise = context, noise
        self._integrations = dict(integrations)
        limits, sensors = context.plan.dwell.adaptive, context.plan.sensors
        self._wanted_v = {} if limits is None else noise_wanted_v(limits, sensors)

    @property
    def is_untried(self) -> bool:
        """Whether there are integrations to choose from and none was chosen yet."""
        limits = self._context.plan.dwell.adaptive
        return limits is not None and limits.nplc is not None and not self._integrations

    def try_integrations(self, dwell: Dwell, replications: float) -> None:
        """Read every channel with every integration at the attitude of ``dwell``, choose, and record it.

        Raises: RunEnds where a stop is asked for, RigError of the readout.
        """
        limits = self._context.plan.dwell.adaptive
        if limits is None or limits.nplc is None or self._integrations:
            return
        rig, plan, wait = self._context.rig, self._context.plan, self._context.wait_unless_stopped
        rig.chance.announce(dwell.step, "settle-trial", 1, replications)
        settle_at(rig, plan, wait)
        rig.chance.announce(dwell.step, "trial", 1, replications)
        noise_v = {
            channel: {
                nplc: read_channel(rig, channel, plan.dwell.samples, wait, nplc).standard_deviation
                for nplc in limits.nplc
            }
            for channel in self._wanted_v
        }
        self._integrations = {channel: self._best(channel, limits, noise_v[channel]) for channel in noise_v}
        chosen = ", ".join(f"{channel} {nplc:g}" for channel, nplc in self._integrations.items())
        shown = {
            channel: {f"{nplc:g}": scatter_v if isfinite(scatter_v) else None for nplc, scatter_v in of_channel.items()}
            for channel, of_channel in noise_v.items()
        }
        text = f"power-line cycles of a reading, by the noise at each: {chosen}"
        self._context.progress_log.event(
            INTEGRATION, {"text": text, "nplc": dict(self._integrations), "noise_v": shown}
        )
        self._context.progress_log.tell("check", text)

    def readings(self) -> dict[str, Reading]:
        """Return what the next dwell reads of the channels that adapt; of the others ``[dwell]`` says it."""
        dwell = self._context.plan.dwell
        found = {}
        for channel, wanted_v in self._wanted_v.items():
            assert dwell.adaptive is not None
            samples = samples_of_next(self._noise.recent(channel), wanted_v, dwell, dwell.adaptive)
            found[channel] = Reading(samples, self._integrations.get(channel, dwell.nplc))
        return found

    def _best(self, channel: str, limits: AdaptiveDwell, noise_v: Mapping[float, float]) -> float:
        reading_s = readout_of(self._context.rig, channel).reading_s
        nplc = best_reading(noise_v, reading_s, self._wanted_v[channel], limits).nplc
        assert nplc is not None
        return nplc
