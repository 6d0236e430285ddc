"""What a scanner connects to a meter: one source alone, or several in parallel, of which the meter reads a mixture.

Source: Millman's theorem for parallel branches; 3499A programming instructions p. 18 and 24 (closed channel below 1 ohm
when new, for cards of the same relays). What a sensor's output has for resistance is an assumption where no load
resistor is declared.
"""

from collections.abc import Mapping
from types import MappingProxyType

from rig.twins.hp3488a import Hp3488aTwin
from rig.twins.physics.known_voltages import VoltageSource

OUTPUT_OHM, CONTACT_OHM = 100.0, 0.5


class ScannedInput:
    """What the scanner connects to the meter's terminals: all wired channels that are closed, in parallel.

    The terminals are at the mean of the open-circuit volts, each weighted by one over the resistance to it: the
    output's (``output_ohm``, by channel; :data:`OUTPUT_OHM` where it is not named) and that of the contacts. The
    meter's own input, above 10 gigohm, takes nothing; with nothing closed it reads 0 V.
    """

    def __init__(
        self,
        source: VoltageSource,
        scanner: Hp3488aTwin,
        wiring: Mapping[int, str],
        output_ohm: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        self._source = source
        self._scanner = scanner
        self._wiring = dict(wiring)
        self._output_ohm = output_ohm

    def __call__(self, now_s: float) -> float:
        closed = [self._wiring[number] for number in sorted(self._scanner.closed_channels()) if number in self._wiring]
        if len(closed) == 1:
            return self._source.read_voltage_v(closed[0], now_s)
        conductances = [1.0 / (self._output_ohm.get(channel, OUTPUT_OHM) + CONTACT_OHM) for channel in closed]
        currents_a = [
            conductance * self._source.read_voltage_v(channel, now_s)
            for conductance, channel in zip(conductances, closed, strict=True)
        ]
        return sum(currents_a) / sum(conductances) if closed else 0.0
