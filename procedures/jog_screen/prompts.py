"""The numbers that the jog screen asks for, and the requests that they become."""

from collections.abc import Callable
from dataclasses import dataclass

from procedures.jog_screen.values import AxisView, BenchView, GoTo, HoldTemperature, Pulse, Request, Turn


@dataclass(frozen=True, slots=True)
class Prompt:
    title: str
    make: Callable[[float], Request]

    def request_of(self, text: str) -> Request | str:
        """Return the request, or a sentence about what was typed."""
        try:
            return self.make(float(text.replace("−", "-")))
        except ValueError:
            return f"{self.title}: got {text!r}, allowed is a number; nothing moved"


def prompt_for(what: str, axis: AxisView, view: BenchView, set_held_rate: Callable[[float], None]) -> Prompt | str:
    """Return the prompt, or a sentence why there is none for this axis or rig."""
    low_deg, high_deg = axis.limits_deg
    if what == "goto":
        return Prompt(f"{axis.name}: go to, {low_deg:g} to {high_deg:g}°", lambda number: GoTo(axis.name, number))
    if what == "rate":
        return _rate(axis, set_held_rate)
    if what == "pulse":
        if axis.pulse_us is None:
            return f"{axis.name}: is no servo and has no pulses"
        return Prompt(f"{axis.name}: pulse in µs", lambda number: Pulse(axis.name, number))
    if not view.chambers:
        return "this rig has no chamber"
    chamber = view.chambers[0]
    low_degc, high_degc = chamber.limits_degc
    title = f"{chamber.name}: hold, {low_degc:g} to {high_degc:g} °C"
    return Prompt(title, lambda number: HoldTemperature(chamber.name, number))


def _rate(axis: AxisView, set_held_rate: Callable[[float], None]) -> Prompt | str:
    if axis.top_rate_dps <= 0.0:
        return f"{axis.name}: this axis only goes to positions"

    def turn(rate_dps: float) -> Request:
        set_held_rate(rate_dps)
        return Turn(axis.name, rate_dps, is_held=False)

    return Prompt(f"{axis.name}: turn, up to ±{axis.top_rate_dps:g} °/s, while this terminal answers", turn)
