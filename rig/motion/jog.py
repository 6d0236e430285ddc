"""Motion by hand and a look at the readings: the same limits, the same arrival, no screen.

Every function needs an open rig, so the lock is held; every wait is the caller's, so a stop reaches the axis.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from rig.abilities.abilities import Axis, AxisState, Environment, RateAxis, Readout, TurnLook, Wait
from rig.abilities.rates import MeasuredRate, measured_rate
from rig.abilities.rest import band_deg
from rig.abilities.setpoint_memory import KeepsSetpointMemory
from rig.cables.cable import CableGuard
from rig.clock import Clock
from rig.description.device_settings import PulseDriven
from rig.description.rig_file import RigDescription
from rig.errors import DeviceFault, RequestRefused, RigError
from rig.motion.motion_memory import MotionMemory
from rig.motion.move import Tell, home_and_arrive, move_and_arrive, stop_all, trusted_state
from rig.motion.out_of_reach import stop_known, stopped_in_reach
from rig.motion.standstill import is_inside

WHOLE_TURN_DEG = 360.0
ROOM_S = 1.0
"""A rate axis with limits is stopped so long before it would pass one, with half a second to brake."""
RATE_PART = 0.01
"""By so much of the rate asked for a turn by hand may be off, and change within its second half, before it is told."""
_LOOK_S = 0.2


class OpenRig(Protocol):
    """What jogging needs of :class:`rig.assembly.open_rig.Rig`."""

    @property
    def description(self) -> RigDescription: ...
    @property
    def environments(self) -> Mapping[str, Environment]: ...
    @property
    def axes(self) -> Mapping[str, Axis]: ...
    @property
    def motion(self) -> MotionMemory: ...
    @property
    def readouts(self) -> Mapping[str, Readout]: ...
    @property
    def clock(self) -> Clock: ...
    def open_lost(self, until_s: float) -> str: ...
    def stranger_axes(self, names: Iterable[str]) -> Mapping[str, str]: ...
    def sign_of_life(self) -> None: ...


@dataclass(frozen=True, slots=True)
class Reading:
    """A channel as the bench sees it."""

    channel: str
    unit: str
    """Of mean and standard deviation, as it is written in a key."""
    mean: float
    """NaN where every reading was an overload."""
    standard_deviation: float
    """NaN below two readings."""
    samples: int
    overloads: int


@dataclass(frozen=True, slots=True)
class TurnByHand:
    """What a turn at a rate for a time came to."""

    measured: MeasuredRate
    """Of its second half: in the first an axis gathers speed. What it turned is of the whole."""
    doubt: str
    """In what that is not the rate asked for, or no constant one; empty where it is."""


@contextmanager
def seen_at_rest(rig: OpenRig, axis: str) -> Iterator[None]:
    """See an axis stand, however the motion inside ends. Raises: DeviceFault that tells of both where it does not.

    What was refused before anything moved is not stopped.
    """
    try:
        yield
    except RequestRefused:
        raise
    except RigError as error:
        try:
            stop_all({axis: _axis(rig, axis)}, rig.clock)
        except DeviceFault as moving:
            raise DeviceFault(f"{error}; {moving}") from error
        raise


@contextmanager
def doubt_named(rig: OpenRig, axis: str) -> Iterator[None]:
    """Let a motion end. Raises: DeviceFault where it failed and an order to the axis may still come, though it stands.

    Around :func:`seen_at_rest`: what is seen of the axis meanwhile may settle it.
    """
    try:
        yield
    except RigError as error:
        if in_doubt := in_doubt_in_words(rig.motion.in_doubt([axis])):
            raise DeviceFault(f"{error}; every axis that it concerns stands still{in_doubt}") from error
        raise


def in_doubt_in_words(in_doubt: Sequence[str]) -> str:
    """Return what follows "stands still": orders that may still come, and what a person does; empty without any."""
    if not in_doubt:
        return ""
    return (
        f", but {'; '.join(in_doubt)}; no stop ends that for certain: press the stop button or switch the drive off"
        " before hands go in, then switch off and on what lies on its line"
    )


def jog_to(rig: OpenRig, axis: str, target_deg: float, wait: Wait, tell: Tell = lambda _text: None) -> float:
    """Go to an attitude; returns the read-back at rest, degrees. ``tell`` hears why a move is made again.

    Raises as :func:`rig.motion.move.move_and_arrive`.
    """
    return move_and_arrive(_axis(rig, axis), target_deg, rig.clock, wait, tell)


def jog_by(rig: OpenRig, axis: str, step_deg: float, wait: Wait, tell: Tell = lambda _text: None) -> float:
    """Go ``step_deg`` further than the axis stands; it is sent as an absolute target."""
    device = _axis(rig, axis)
    here_deg = trusted_state(device).position_deg
    return move_and_arrive(device, round(here_deg + step_deg, 9), rig.clock, wait, tell)


def home(rig: OpenRig, axis: str, wait: Wait, tell: Tell = lambda _text: None) -> float:
    """Run the reference move; returns the read-back at rest, degrees. ``tell`` hears why it is made again."""
    return home_and_arrive(_axis(rig, axis), rig.clock, wait, tell)


def stop(rig: OpenRig, axis: str | None) -> list[str]:
    """Stop an axis, or every axis, and see it stand; returns which. Raises: DeviceFault, RequestRefused."""
    names = list(rig.axes) if axis is None else [_axis(rig, axis).name]
    stop_all({name: rig.axes[name] for name in names}, rig.clock)
    return names


def outside_limits(rig: OpenRig, axis: str, state: AxisState) -> str:
    """Say of an axis at rest that it is outside its limits; empty where it is inside, or nobody can tell.

    What has no home has none in its read-back, but a servo, whose pulse needs none. An axis that turns on and on has no
    limits where they are a whole turn or more apart.
    """
    device = _axis(rig, axis)
    is_located = state.is_homed or isinstance(rig.description.axes[axis], PulseDriven)
    low_deg, high_deg = device.limits_deg
    has_none = top_rate_dps(rig, axis) > 0.0 and high_deg - low_deg >= WHOLE_TURN_DEG
    if state.unknown or has_none or not is_located or is_inside(device, state.position_deg):
        return ""
    return (
        f"{axis}: stands outside its limits: at {state.position_deg:g}°, allowed {low_deg:g} to {high_deg:g}°"
        f" (axes.{axis}: limits_deg); see what moved it there, then home it"
    )


def position_deg(rig: OpenRig, axis: str) -> float:
    """Return where an axis that may be moved stands now. Raises: RequestRefused, DeviceFault."""
    return trusted_state(_axis(rig, axis)).position_deg


def hold(rig: OpenRig, chamber: str, setpoint_degc: float) -> None:
    """Write a chamber's setpoint, whatever somebody set there since, and see it read back. Raises: RequestRefused."""
    if chamber not in rig.environments:
        raise RequestRefused(f"no chamber {chamber!r} (allowed: {', '.join(rig.environments)}); nothing was changed")
    device = rig.environments[chamber]
    if isinstance(device, KeepsSetpointMemory):
        device.setpoint_memory.overrule()
    device.hold(setpoint_degc)


def top_rate_dps(rig: OpenRig, axis: str) -> float:
    """Return the largest rate of an axis; 0 where it only positions."""
    device = _axis(rig, axis)
    return float(getattr(device, "top_rate_dps", 0.0)) if hasattr(device, "start_rate") else 0.0


def rate_axis(rig: OpenRig, axis: str) -> RateAxis:
    """Return an axis that turns. Raises: RequestRefused where it only positions."""
    device = _axis(rig, axis)
    if top_rate_dps(rig, axis) <= 0.0:
        raise RequestRefused(
            f"{axis}: this axis only goes to positions (axes.{axis}: driver, top_rate_dps); nothing moved"
        )
    return device  # type: ignore[return-value]  # it has the methods: top_rate_dps looked


def require_room_to_turn(rig: OpenRig, axis: str, position_deg: float, rate_dps: float) -> None:
    """Refuse to turn an axis with limits on towards the one that it would soon pass. Raises: RequestRefused.

    Limits a whole turn or more apart are those of positions: an axis that turns on and on has none.
    """
    low_deg, high_deg = _axis(rig, axis).limits_deg
    ahead_deg = position_deg + rate_dps * ROOM_S
    if high_deg - low_deg < WHOLE_TURN_DEG and not low_deg <= ahead_deg <= high_deg:
        raise RequestRefused(
            f"{axis}: at {position_deg:g}°, {rate_dps:+g} °/s leads beyond the limits within {ROOM_S:g} s, allowed"
            f" {low_deg:g} to {high_deg:g}° (axes.{axis}: limits_deg); it is not turned on"
        )


def turn_for(rig: OpenRig, axis: str, rate_dps: float, duration_s: float, wait: Wait) -> TurnByHand:
    """Turn at a rate for a time, then stop and see the axis stand; returns the rate as measured, and its doubts.

    However it ends, the axis is stopped. Raises: RequestRefused before anything moved, DeviceFault, WaitEnded.
    """
    device = rate_axis(rig, axis)
    device.check_rate(rate_dps)
    require_room_to_turn(rig, axis, position_deg(rig, axis), rate_dps)
    if isinstance(device, CableGuard):
        device.require_room(rate_dps * duration_s)
    if strangers := rig.stranger_axes([axis]):  # who stops there must be who was told to turn
        raise DeviceFault(f"{strangers[axis]}; nothing moved")
    try:
        device.start_rate(rate_dps)
        begun_s = rig.clock.monotonic_s()
        looks = [device.turn_look(rig.clock)]
        while rig.clock.monotonic_s() - begun_s < duration_s:
            wait(min(_LOOK_S, duration_s))
            looks.append(device.turn_look(rig.clock))
            require_room_to_turn(rig, axis, looks[-1].angle_deg, rate_dps)
        if len(looks) == 1:  # its answer took as long as the whole turn
            looks.append(device.turn_look(rig.clock))
    finally:
        _stop_in_reach(rig, axis)
    second = _second_half(looks)
    measured = replace(measured_rate(second[0], second[-1]), turned_deg=looks[-1].angle_deg - looks[0].angle_deg)
    return TurnByHand(measured, _rate_doubt(second, rate_dps, rig.axes[axis].arrival_tolerance_deg))


def _stop_in_reach(rig: OpenRig, axis: str) -> None:
    """Stop an axis; where its line broke meanwhile, as soon as that can be opened again. Raises: DeviceFault."""

    def stop(_unopened: str) -> DeviceFault | None:
        try:
            stop_known(rig, [axis])
        except DeviceFault as error:
            return error
        return None

    failure, _ = stopped_in_reach(rig, stop, lambda failure: failure is not None)
    if failure is not None:
        raise failure


def _second_half(looks: Sequence[TurnLook]) -> Sequence[TurnLook]:
    """Return the last look before the middle of the time, and all behind it."""
    middle_s = 0.5 * (looks[0].taken_s + looks[-1].taken_s)
    first = max(number for number, look in enumerate(looks) if look.taken_s <= middle_s)
    return looks[first:]


def _rate_doubt(looks: Sequence[TurnLook], commanded_dps: float, tolerance_deg: float) -> str:
    """Return in what the rate was not that asked for, or changed while it was measured; empty where it was."""

    def slack_dps(*rates: tuple[TurnLook, TurnLook]) -> float:
        """Return what times and read-backs leave open."""
        return sum(
            measured_rate(*pair).uncertainty_dps + band_deg(tolerance_deg) / (pair[1].taken_s - pair[0].taken_s)
            for pair in rates
        )

    allowed_dps = RATE_PART * abs(commanded_dps)
    first, last = looks[0], looks[-1]
    middle = looks[len(looks) // 2]
    changes = ""
    if len(looks) > 2:
        early, late = (first, middle), (middle, last)
        early_dps, late_dps = measured_rate(*early).rate_dps, measured_rate(*late).rate_dps
        if abs(late_dps - early_dps) > allowed_dps + slack_dps(early, late):
            changes = f"it was not constant: {early_dps:+.4g} °/s, then {late_dps:+.4g} °/s"
    off_dps = measured_rate(first, last).rate_dps - commanded_dps
    is_off = abs(off_dps) > allowed_dps + slack_dps((first, last))
    missed = f"it was not reached, off by {off_dps:+.4g} °/s, allowed {allowed_dps:.3g} °/s" if is_off else ""
    why = "; ".join(part for part in (missed, changes) if part)
    return (
        f"asked for {commanded_dps:+g} °/s: {why}; turn for longer, or ask for what the machine reaches" if why else ""
    )


def wound_turns(rig: OpenRig, axis: str) -> float | None:
    """Return the revolutions that the cables of an axis are wound; None where none wind up, NaN where nobody knows."""
    device = _axis(rig, axis)
    if not isinstance(device, CableGuard):
        return None
    return math.nan if device.is_in_doubt else device.wound_deg / WHOLE_TURN_DEG


def pulse_of(rig: OpenRig, axis: str, attitude_deg: float) -> float | None:
    """Return the pulse of a servo at an attitude, microseconds; None where the axis is sent no pulses."""
    settings = rig.description.axes[axis]
    return settings.pulse_us(attitude_deg) if isinstance(settings, PulseDriven) else None


def attitude_of_pulse(rig: OpenRig, axis: str, pulse_us: float) -> float:
    """Return the attitude that a servo takes at a pulse: sent as such, under its limits. Raises: RequestRefused."""
    _axis(rig, axis)
    settings = rig.description.axes[axis]
    if not isinstance(settings, PulseDriven):
        raise RequestRefused(f"{axis}: is no servo and has no pulses (axes.{axis}: driver); nothing moved")
    low_us, high_us = settings.pulse_limits_us
    if not low_us <= pulse_us <= high_us:
        raise RequestRefused(
            f"{axis}: pulse {pulse_us:g} µs, allowed {low_us:g} to {high_us:g} µs (axes.{axis}: pulse_limits_us);"
            " nothing moved; ask for one inside"
        )
    return settings.pulse_attitude_deg(pulse_us)


def readings(rig: OpenRig, channels: Sequence[str], samples: int, wait: Wait) -> list[Reading]:
    """Read channels by full name (``dmm.x``). Raises: RequestRefused for a name the rig does not have."""
    known = {channel: readout for readout in rig.readouts.values() for channel in readout.channels}
    unknown = [channel for channel in channels if channel not in known]
    if unknown:
        raise RequestRefused(f"no channel {unknown[0]!r} (allowed: {', '.join(known)}); nothing was read")
    return [_reading(known[channel], channel, samples, wait) for channel in channels]


def _reading(readout: Readout, channel: str, samples: int, wait: Wait) -> Reading:
    burst = readout.read(channel, samples, wait)
    good = burst.samples[~burst.overload]
    return Reading(
        channel=channel,
        unit=burst.unit,
        mean=float(np.mean(good)) if good.size else float("nan"),
        standard_deviation=float(np.std(good, ddof=1)) if good.size > 1 else float("nan"),
        samples=int(burst.samples.size),
        overloads=int(np.count_nonzero(burst.overload)),
    )


def _axis(rig: OpenRig, name: str) -> Axis:
    if name not in rig.axes:
        raise RequestRefused(f"no axis {name!r} (allowed: {', '.join(rig.axes)}); nothing moved")
    return rig.axes[name]
