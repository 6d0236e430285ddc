"""Who is under suspicion: dwells that do not fit those before them, and sensors that spoil every attempt.

A sensor whose readings alone are why a dwell was rejected as often as it may be is dropped from the run, where others
remain: its channels are read no more, the others go on, and it gets no result. A run of one sensor is held instead.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from procedures.plan.plan import Plan
from procedures.records.declared_supply import at_declared
from procedures.records.dwells import DwellRecord
from procedures.run.judgement.history import History
from procedures.run.judgement.running_fit import Doubt, RunningFit
from rig.description.rig_file import Sensor
from rig.description.signal_chain import Chain


class Suspects:
    """Of one epoch."""

    def __init__(
        self, plan: Plan, history: History, increments_deg: Mapping[str, float], chains: Mapping[str, Chain]
    ) -> None:
        self.plan = plan
        """With the channels that are still read."""
        self._chains = chains
        self._dropped: set[str] = set()
        for name in history.dropped:
            self.drop(name)
        self._fit = RunningFit(_followed(plan), increments_deg)
        for dwell in () if plan.soaks else _comparable(history):
            self.learn(dwell)

    @property
    def remaining(self) -> Mapping[str, object]:
        """The sensors that are still measured."""
        return {name: sensor for name, sensor in self.plan.sensors.items() if name not in self._dropped}

    def examine(self, record: DwellRecord) -> tuple[DwellRecord, Doubt | None]:
        """Return the dwell, rejected where it fits not those before it. Those of the check set are not judged here."""
        doubt = (
            None if record.reasons or record.purpose == "check" else self._fit.doubt(at_declared(record, self._chains))
        )
        return (record, None) if doubt is None else (replace(record, accepted=False, reasons=doubt.reasons), doubt)

    def learn(self, record: DwellRecord) -> None:
        self._fit.learn(at_declared(record, self._chains))

    def forget(self) -> None:
        """Temperature changes everything."""
        self._fit.forget()

    def alone_to_blame(self, reasons: Sequence[str]) -> str | None:
        """Return the sensor that all reasons are about.

        None where there are several, another matter, or no other sensor.
        """
        blamed = {self._owner(reason) for reason in reasons}
        if len(blamed) != 1 or len(self.remaining) < 2:
            return None
        (name,) = blamed
        return name

    def drop(self, name: str) -> None:
        """Read its channels no more."""
        self._dropped.add(name)
        kept = {channel for other in self.remaining for channel in _channels(self.plan, other)}
        gone = set(_channels(self.plan, name)) - kept
        channels = tuple(channel for channel in self.plan.channels if channel not in gone)
        settle = self.plan.settle_channel if self.plan.settle_channel in channels else channels[0]
        self.plan = replace(self.plan, channels=channels, settle_channel=settle)

    def _owner(self, reason: str) -> str | None:
        channel = reason.partition(": ")[0]
        return next((name for name in self.remaining if channel in _channels(self.plan, name)), None)


def _followed(plan: Plan) -> dict[str, Sensor]:
    """Return the sensors whose readings follow from the attitude: accelerometers of declared sensitivity, at rest."""
    if not plan.is_at_rest:
        return {}
    return {name: sensor for name, sensor in plan.sensors.items() if sensor.is_sensitivity_declared}


def _comparable(history: History) -> Iterator[DwellRecord]:
    """Yield accepted dwells of this mounting since the last step that a person accepted."""
    since = history.baseline_epoch or 0
    yield from history.baseline.values()
    yield from (dwell for dwell in history.visits if dwell.purpose != "check" and dwell.epoch >= since)


def _channels(plan: Plan, sensor: str) -> tuple[str, ...]:
    """Return a sensor's outputs and its own thermometer."""
    described = plan.sensors[sensor]
    temperature_channel = () if described.temperature is None else (described.temperature.channel,)
    return (*described.channels.values(), *temperature_channel)
