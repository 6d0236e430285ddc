"""What the bench looks at, in turn: axes several times a second, one burst of one channel, now and then the air.

A device that does not answer is shown with its sentence and looked at again; it keeps no other from being seen.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import cycle

from procedures.jog_screen.guard import Guard
from procedures.jog_screen.inferred import InferredAttitude
from procedures.jog_screen.statistics import Running
from procedures.jog_screen.values import AttitudeView, AxisView, ChamberView, ChannelView
from rig.abilities.abilities import Readout, TurnLook, Wait
from rig.abilities.rates import measured_rate
from rig.assembly.open_rig import Rig
from rig.clock import Clock
from rig.errors import DeviceFault, GuardLost, LinkLost, MotionBreach, RequestRefused, RigError, WaitEnded
from rig.motion import jog
from rig.motion.jog_steps import steps_deg
from rig.motion.standstill import stop_what_moves

_AXES_S, _CHAMBERS_S, _AGAIN_S = 0.2, 2.0, 5.0
_UNSEEN_S = 3.0
"""Machine seconds: so long an axis may turn without a look at it, where no limit is near."""
_BURST_S = 0.4
_RATE_OVER_S = 1.0
_MOST_SAMPLES = 10


@dataclass(frozen=True, slots=True)
class _Seen:
    """A turning axis at its last look."""

    angle_deg: float
    rate_dps: float
    rig_taken_s: float
    taken_s: float


class Polling:
    """Belongs to the thread that owns the devices; ``clock`` is the machine's; ``tell`` hears who falls silent."""

    def __init__(
        self, rig: Rig, guard: Guard, clock: Clock, inferred: InferredAttitude | None, tell: Callable[[str], None]
    ) -> None:
        self._rig = rig
        self._guard = guard
        self._tell = tell
        self._clock = clock
        self._inferred = inferred
        self._attitude: AttitudeView | None = None
        self._axes = {name: _first_view(rig, name) for name in rig.axes}
        self._chambers = {
            name: ChamberView(name, settings.limits_degc) for name, settings in rig.description.environment.items()
        }
        units = rig.description.channel_units()
        self._running = {
            channel: Running(channel, units[channel])
            for readout in rig.readouts.values()
            for channel in readout.channels
        }
        self._turn_looks: dict[str, list[TurnLook]] = {}
        self._seen: dict[str, _Seen] = {}
        """What turns, as it was last seen."""
        self.awaited = "the first look"
        """Whose answer is waited for now, or was last."""
        self.start_anew()

    def start_anew(self) -> None:
        """Forget what was seen before: the lines are open anew."""
        self._axes_due_s = self._chambers_due_s = 0.0
        self._silent_until_s: dict[str, float] = {}
        self._lost: LinkLost | None = None
        self._ready_from_s = dict.fromkeys(self._rig.readouts, 0.0)
        self._prepared: set[str] = set()
        self._channels = cycle([(name, channel) for name, it in self._rig.readouts.items() for channel in it.channels])

    def begin_anew(self) -> None:
        """Lines are open: forget what was seen before, and see every axis stand; what moved, or was moved, is told."""
        self.start_anew()
        self.awaited = "every axis to be seen at rest"
        try:
            sentences = stop_what_moves(self._rig.axes, self._rig.clock, self._rig.motion)
        except DeviceFault as error:
            sentences = [str(error)]
        for sentence in sentences:
            self._tell(sentence)

    def round(self, wait: Wait) -> None:
        """Poll everything that is due once. Raises: WaitEnded, LinkLost."""
        self.axes_now_and_then(is_patient=True)
        if self._lost is not None:
            lost, self._lost = self._lost, None
            raise lost
        self._look_at_chambers()
        self._look_at_a_channel(wait)
        if self._inferred is not None:
            temperatures = [view.temperature_degc for view in self._chambers.values()]
            means_v = {channel: running.view().mean for channel, running in self._running.items()}
            roll = self._axes.get("roll")
            state = None if roll is None else roll.state
            roll_deg = None if state is None or state.unknown else state.position_deg
            self._attitude = self._inferred.view(means_v, temperatures[0] if temperatures else None, roll_deg)

    def axes_now_and_then(self, *, is_patient: bool = False) -> None:
        """Look at every axis if that is due; at a silent one only where there is time to wait for it."""
        now_s = self._clock.monotonic_s()
        if now_s < self._axes_due_s:
            return
        self._axes_due_s = now_s + _AXES_S
        for name, view in self._axes.items():
            if view.silence and (not is_patient or now_s < self._silent_until_s.get(name, 0.0)):
                continue  # waiting for it would keep the others from being seen
            try:
                self._look_at_axis(name)
            except RigError as error:
                self._missed(name, error)

    def _missed(self, name: str, error: RigError) -> None:
        """Show an axis that does not answer as silent, and stop it: what nobody sees does not turn."""
        view = self._axes[name]
        if isinstance(error, MotionBreach | WaitEnded | GuardLost):
            self._guard.stop(str(error))  # not of this axis alone, which is not silent
            return
        self._silent_until_s[name] = self._clock.monotonic_s() + _AGAIN_S
        if view.set_rate_dps:
            self._guard.stop(str(error))
        if isinstance(error, LinkLost):
            self._lost = error  # for the next round to raise: in the middle of a wait nobody could mend it
        elif not view.silence:
            self._tell(str(error))
        self._axes[name] = replace(view, state=None, silence=str(error))

    def position_deg(self, axis: str) -> float:
        """Return what the axis says when asked now. Raises: RequestRefused where the axis has no home."""
        return jog.position_deg(self._rig, axis)

    def aim(self, axis: str | None, target_deg: float | None) -> None:
        """Show where an axis is being sent; None when nothing is."""
        for name, view in self._axes.items():
            self._axes[name] = replace(view, target_deg=target_deg if name == axis else None)
        self._axes_due_s = 0.0

    def turns(self, axis: str, rate_dps: float) -> None:
        self._turn_looks[axis] = []
        self._axes[axis] = replace(self._axes[axis], set_rate_dps=rate_dps, measured=None)
        self.clear_statistics()

    def turning(self) -> str:
        """Return which axes turn at a rate; empty where none does."""
        turning = [f"{name} at {view.set_rate_dps:+g} °/s" for name, view in self._axes.items() if view.set_rate_dps]
        return ", ".join(turning)

    def require_room(self, axis: str, rate_dps: float) -> None:
        """Refuse to turn further towards a limit from where the limit is near. Raises: RequestRefused."""
        here_deg = self.position_deg(axis)
        jog.require_room_to_turn(self._rig, axis, here_deg, rate_dps)
        self._see(axis, here_deg, rate_dps)

    def _see(self, axis: str, angle_deg: float, rate_dps: float) -> None:
        self._seen[axis] = _Seen(angle_deg, rate_dps, self._rig.clock.monotonic_s(), self._clock.monotonic_s())

    def why_unseen(self) -> str:
        """Return which axis may have come near its limit, or turned too long, since the last look; empty where none.

        The guard asks while this thread may be waiting for a meter: nothing is looked at here.
        """
        for axis, seen in list(self._seen.items()):
            if not self._axes[axis].set_rate_dps:
                continue
            unseen_s = self._clock.monotonic_s() - seen.taken_s
            turned_deg = seen.rate_dps * (self._rig.clock.monotonic_s() - seen.rig_taken_s)
            try:
                jog.require_room_to_turn(self._rig, axis, seen.angle_deg + turned_deg, seen.rate_dps)
            except RequestRefused:
                return f"{axis}: it may be near its limit, and was not looked at for {unseen_s:.1f} s"
            if unseen_s > _UNSEEN_S:
                return f"{axis}: it turns, and was not looked at for {unseen_s:.1f} s"
        return ""

    def all_stand(self) -> None:
        for name, view in self._axes.items():
            self._axes[name] = replace(view, set_rate_dps=None, measured=None, target_deg=None)
        self._turn_looks.clear()
        self._seen.clear()
        self._axes_due_s = 0.0

    def clear_statistics(self) -> None:
        for running in self._running.values():
            running.clear()

    def forget_chambers(self) -> None:
        self._chambers_due_s = 0.0

    def views(
        self,
    ) -> tuple[tuple[AxisView, ...], tuple[ChannelView, ...], tuple[ChamberView, ...], AttitudeView | None]:
        channels = tuple(running.view() for running in self._running.values())
        return tuple(self._axes.values()), channels, tuple(self._chambers.values()), self._attitude

    def _look_at_axis(self, name: str) -> None:
        self.awaited = f"axis {name}"
        state = self._rig.axes[name].state()
        view = self._axes[name]
        self._axes[name] = replace(
            view,
            state=state,
            silence="",
            pulse_us=None if state.unknown else jog.pulse_of(self._rig, name, state.position_deg),
            wound_turns=jog.wound_turns(self._rig, name),
        )
        if view.set_rate_dps:
            self._look_at_rate(name, view.set_rate_dps, is_moving=state.is_moving)

    def _look_at_rate(self, name: str, rate_dps: float, *, is_moving: bool) -> None:
        if not (self._guard.has_lease(name) or is_moving):
            self._axes[name] = replace(self._axes[name], set_rate_dps=None, measured=None)
            return
        looks = self._turn_looks.setdefault(name, [])
        looks.append(jog.rate_axis(self._rig, name).turn_look(self._rig.clock))
        self._see(name, looks[-1].angle_deg, rate_dps)
        while len(looks) > 2 and looks[-1].taken_s - looks[1].taken_s > _RATE_OVER_S:
            looks.pop(0)
        if len(looks) > 1:
            self._axes[name] = replace(self._axes[name], measured=measured_rate(looks[0], looks[-1]))
        try:
            jog.require_room_to_turn(self._rig, name, looks[-1].angle_deg, rate_dps)
        except RequestRefused as near:
            self._guard.stop(str(near))

    def _look_at_chambers(self) -> None:
        now_s = self._clock.monotonic_s()
        if now_s < self._chambers_due_s:
            return
        self._chambers_due_s = now_s + _CHAMBERS_S
        for name, chamber in self._rig.environments.items():
            view = self._chambers[name]
            self.awaited = f"chamber {name}"
            try:
                temperature_degc, setpoint_degc = chamber.temperature_degc(), chamber.setpoint_degc()
                view = replace(view, temperature_degc=temperature_degc, setpoint_degc=setpoint_degc, silence="")
            except LinkLost:
                raise
            except RigError as error:
                if not view.silence:
                    self._tell(str(error))
                view = replace(view, temperature_degc=None, setpoint_degc=None, silence=str(error))
            self._chambers[name] = view

    def _look_at_a_channel(self, wait: Wait) -> None:
        """Read one short burst of the next channel; pause where there is none to read now, or none at all."""
        name, channel = next(self._channels, ("", ""))
        if not name or self._clock.monotonic_s() < self._ready_from_s[name]:
            wait(_AXES_S / 4.0)
            return
        readout = self._rig.readouts[name]
        self.awaited = f"{name}, channel {channel}"
        try:
            if name not in self._prepared:
                readout.prepare()
                self._prepared.add(name)
            self._running[channel].add(readout.read(channel, _samples(readout), wait))
        except LinkLost:
            raise
        except RigError as error:
            if self._guard.is_stopping:
                raise
            if not self._running[channel].silence:
                self._tell(str(error))
            self._running[channel].silence = str(error)
            self._prepared.discard(name)
            self._ready_from_s[name] = self._clock.monotonic_s() + _AGAIN_S


def _first_view(rig: Rig, name: str) -> AxisView:
    axis = rig.axes[name]
    return AxisView(
        name=name,
        limits_deg=axis.limits_deg,
        steps_deg=steps_deg(axis, rig.description.axes[name]),
        top_rate_dps=jog.top_rate_dps(rig, name),
    )


def _samples(readout: Readout) -> int:
    return min(max(round(_BURST_S / readout.reading_s()), 1), _MOST_SAMPLES)
