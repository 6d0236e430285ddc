"""What a meter meets in the twins' world: voltages, and for its checks a short, a reference and its own warmth."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from rig.description.twin_truth import TwinReadout

SHORT, REFERENCE = "checks:short", "checks:reference"
"""Channels of no sensor: a name with a colon is never one."""
OUTPUT_OHM: Mapping[str, float] = {SHORT: 0.01, REFERENCE: 0.1}
"""What each has for resistance, an assumption."""
_H_S = 3600.0


class VoltageSource(Protocol):
    """The physical world as a meter meets it."""

    def read_voltage_v(self, channel: str, now_s: float) -> float:
        """Take one reading of ``channel`` (such as ``dmm.x``), volts, with its noise; asking again draws again."""


@dataclass
class KnownVoltages:
    """A :class:`VoltageSource`: its own two channels, every other one is ``source``'s."""

    source: VoltageSource
    truth: TwinReadout
    reference_v: float = 0.0
    _began_s: float | None = field(default=None, init=False)

    def read_voltage_v(self, channel: str, now_s: float) -> float:
        if channel == SHORT:
            return self.truth.short_v
        if channel == REFERENCE:
            off_v = self.truth.reference_error_v + self.truth.reference_drift_v_per_h * self._hours(now_s)
            return self.reference_v + off_v
        return self.source.read_voltage_v(channel, now_s)

    def inside_degc(self, now_s: float) -> float:
        """Return the meter's own temperature."""
        return self.truth.own_temperature_degc + self.truth.own_temperature_drift_degc_per_h * self._hours(now_s)

    def _hours(self, now_s: float) -> float:
        """Return the hours since it was first asked."""
        self._began_s = now_s if self._began_s is None else self._began_s
        return (now_s - self._began_s) / _H_S
