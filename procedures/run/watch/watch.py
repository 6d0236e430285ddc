"""The look around where a run stands still, between two dwells or longer: bands, disk, lines, clocks, resting axes.

Nothing is decided here about the run; what is found is an :class:`procedures.run.judgement.alarm.Alarm`. Values that
a dwell has just brought are used as they are, everything else is read.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import inf

from procedures.records.dwells import Measurement
from procedures.run.dwell.measure import OpenRig
from procedures.run.judgement.alarm import LOST, Alarm
from procedures.run.judgement.interlocks import Interlock, Watched, look_at
from procedures.run.judgement.run_limits import RunLimits
from procedures.run.watch.clock_watch import ClockChange, ClockWatch
from procedures.run.watch.disk_space import MB
from rig.abilities.abilities import AxisState, Wait
from rig.abilities.chamber_alarms import TellsAlarms, alarm_clause
from rig.abilities.setpoint_memory import KeepsSetpointMemory
from rig.errors import DeviceNonsense, DeviceRefused, DeviceSilent
from rig.link.counts import ExchangeCounts

CHAMBER = "chamber"
"""The event of what a chamber did not take at once, or tells of itself."""
ALARMS_EVERY_S = 30.0
"""Rig seconds between two questions for the alarms of chambers, at the least."""
FEWEST_QUESTIONS = 200
"""So many on a line before its error rate means anything; the rate is of the last one to two thousand."""
WINDOW = 1000
WARN_RATE = 0.001
VOLTAGE_S = 10.0
"""Between two readings of a voltage that keeps its band, where the run stands still: a scanner's relays wear."""


class Watch:
    """Of one process, over all its epochs."""

    def __init__(
        self,
        rig: OpenRig,
        run_limits: RunLimits,
        wait: Wait,
        record: Callable[[str, Mapping[str, object]], None],
        tell: Callable[[str, str], None],
    ) -> None:
        """``record`` journals an event, ``tell`` tells people one."""
        self._tell = tell
        self._alarms: dict[str, tuple[str, ...]] = {}
        self._mute: set[str] = set()
        """Chambers that have no answer to the question for alarms."""
        self._alarms_read_s = -inf
        self._rig = rig
        self._run_limits = run_limits
        self._wait = wait
        self._record = record
        self._clocks = ClockWatch(rig.clock)
        self._bands: dict[str, Watched] = {}
        self._brought: dict[str, float] = {}
        self._read_s: dict[str, float] = {}
        """When an interlock was read, rig seconds."""
        self._rest_deg: dict[str, float] = {}
        self._taken: set[str] = set()
        """Axes that were brought somewhere since they were homed."""
        most_within = run_limits.rejected
        self._rejections: deque[bool] = deque(maxlen=most_within[1] if most_within else 1)
        self._counted: dict[str, ExchangeCounts] = {}

    @property
    def is_in_doubt(self) -> bool:
        """True while what was measured since may yet be void, or an order that was lost on its way may yet come.

        A value is outside its band, and its delay has not passed.
        """
        is_outside = any(seen.outside_since_s is not None and not seen.is_alarmed for seen in self._bands.values())
        return is_outside or self._rig.motion.waiting_settles(self._rig.axes)

    def rests_at(self, positions_deg: Mapping[str, float]) -> None:
        """Note where axes were left; from now on they have no reason to be elsewhere."""
        self._rest_deg.update(positions_deg)
        self._taken.update(positions_deg)

    def forget_positions(self) -> None:
        """Forget where axes rest, before homing."""
        self._rest_deg.clear()
        self._taken.clear()
        self._counted.clear()

    def saw(self, measured: Measurement, *, is_accepted: bool) -> None:
        """Note what a dwell brought."""
        self._rejections.append(not is_accepted)
        if is_accepted:
            self.rests_at({name: state.position_deg for name, state in measured.after.axes.items()})
        else:
            self._rest_deg.clear()  # it may be rejected for just that; the next attempt approaches anew
        self._brought = {f"environment.{name}": degc for name, degc in measured.after.temperature_degc.items()}
        self._brought |= {channel: reading.mean for channel, reading in measured.readings.items()}

    def clock_change(self) -> ClockChange:
        """Look at the clocks; a step of the wall clock is recorded and harms nothing."""
        change = self._clocks.look()
        if change.is_step:
            self._record("clock_step", {"step_s": round(change.step_s, 3)})
        return change

    def look(self, free_bytes: float, needed_bytes: float, announce: Callable[[], None]) -> Alarm | None:
        """Return the first thing that is not as it should be.

        ``announce`` tells the twins that interlocks are read.

        Raises: RigError of a device that cannot be asked.
        """
        return next(self._findings(free_bytes, needed_bytes, announce), None)

    def at_rest(self, announce: Callable[[], None]) -> dict[str, Callable[[], Iterator[Alarm]]]:
        """Return what is looked at where the run stands still, by name: one that cannot be asked keeps no other.

        Each raises RigError of its device.
        """
        axes = {
            f"axes.{name}": partial(self._axis if name in self._taken else self._idle_axis, name)
            for name in self._rig.axes
        }
        bands = {lock.name: partial(self._band_at_rest, lock, read, announce) for lock, read in self._locks()}
        return {"clock": self._suspension, "chambers": self._chambers, **axes, **bands}

    def goes_on(self, alarm: Alarm, free_bytes: float, needed_bytes: float) -> bool:
        """Return whether what holds a run until it is over goes on: no room on the disk, or a band that is left.

        Another band that is left by then is a cause of its own: it holds the run anew, and says so.
        """
        if alarm.cause == "disk":
            return any(True for _ in self._disk(free_bytes, needed_bytes))
        return self._bands[alarm.band].is_alarmed

    def _findings(self, free_bytes: float, needed_bytes: float, announce: Callable[[], None]) -> Iterator[Alarm]:
        yield from self._suspension()
        yield from self._chambers()
        for name in self._rest_deg:
            yield from self._axis(name)
        yield from self._disk(free_bytes, needed_bytes)
        yield from self._bands_kept(announce)
        yield from self._rejected()
        yield from self._lines()

    def _chambers(self) -> Iterator[Alarm]:
        """Tell what a chamber had to be told twice, and the alarms that it tells, when they change."""
        now_s = self._rig.clock.monotonic_s()
        asks_alarms = now_s >= self._alarms_read_s + ALARMS_EVERY_S
        self._alarms_read_s = now_s if asks_alarms else self._alarms_read_s
        for name, chamber in self._rig.environments.items():
            if isinstance(chamber, KeepsSetpointMemory):
                for sentence in chamber.setpoint_memory.take_corrections():
                    self._record(CHAMBER, {"environment": name, "told": sentence})
            if asks_alarms and isinstance(chamber, TellsAlarms) and name not in self._mute:
                self._ask_alarms(name, chamber)
        yield from ()

    def _ask_alarms(self, name: str, chamber: TellsAlarms) -> None:
        """Tell alarms that came or went. A chamber that has no answer is told, and asked no more: it ends no run."""
        before = self._alarms.get(name, ())
        try:
            alarms = chamber.alarms()
        except (DeviceNonsense, DeviceRefused, DeviceSilent) as error:
            self._mute.add(name)
            sentence = f"{name}: the chamber does not tell its alarms, and is asked for them no more: {error}"
        else:
            if alarms == before:
                return
            self._alarms[name] = alarms
            sentence = f"{name}: the chamber tells {' and '.join(alarms) or 'no alarm any more'}"
        self._record(CHAMBER, {"environment": name, "told": sentence})
        self._tell(CHAMBER, sentence)

    def _suspension(self) -> Iterator[Alarm]:
        change = self.clock_change()
        if change.is_suspension:
            yield suspended(change)

    def _axis(self, name: str) -> Iterator[Alarm]:
        """Yield what an axis tells twice: a digit that the line turned over is no motion. Told once, it is recorded."""
        axis, rest_deg = self._rig.axes[name], self._rest_deg.get(name)
        first = _axis_alarm(name, axis.state(), rest_deg, axis.arrival_tolerance_deg)
        if first is None:
            return
        alarm = _axis_alarm(name, axis.state(), rest_deg, axis.arrival_tolerance_deg)
        if alarm is None:
            self._record("unconfirmed", {"axis": name, "told": first.reason})
        else:
            yield alarm

    def _idle_axis(self, name: str) -> Iterator[Alarm]:
        """Look at an axis that this run brings nowhere: none may move, and nothing else is asked of it."""
        with suppress(*LOST):
            self._rig.axes[name].state()
        yield from ()

    def _disk(self, free_bytes: float, needed_bytes: float) -> Iterator[Alarm]:
        needed_bytes += self._run_limits.min_free_mb * MB
        if free_bytes < needed_bytes:
            room = f"{free_bytes / MB:.1f} MB are free, what is left to measure needs {needed_bytes / MB:.1f} MB"
            yield Alarm(
                "disk", f"disk: {room} (rig file: interlocks.min_free_mb); it goes on when there is room", "hold"
            )

    def _locks(self) -> Iterator[tuple[Interlock, Callable[[], float]]]:
        """Yield every interlock with what reads it."""
        for name, lock in self._run_limits.temperatures:
            yield lock, self._rig.environments[name].temperature_degc
        for channel, lock in self._run_limits.voltages:
            yield lock, partial(self._single_reading_v, channel)

    def _bands_kept(self, announce: Callable[[], None]) -> Iterator[Alarm]:
        locks = list(self._locks())
        if not locks:
            return
        announce()
        for lock, read in locks:
            yield from self._band(lock, read)

    def _band_at_rest(
        self, lock: Interlock, read: Callable[[], float], announce: Callable[[], None]
    ) -> Iterator[Alarm]:
        seen, read_s = self._bands.get(lock.name, Watched()), self._read_s.get(lock.name)
        is_kept = seen.outside_since_s is None and not seen.is_alarmed
        is_early = read_s is not None and self._rig.clock.monotonic_s() - read_s < VOLTAGE_S
        if lock.unit == "V" and is_kept and is_early:
            return
        announce()
        yield from self._band(lock, read)

    def _band(self, lock: Interlock, read: Callable[[], float]) -> Iterator[Alarm]:
        brought = self._brought.pop(lock.name, None)
        value = read() if brought is None else brought
        now_s, before = self._rig.clock.monotonic_s(), self._bands.get(lock.name, Watched())
        seen = look_at(lock, before, value, now_s)
        self._bands[lock.name], self._read_s[lock.name] = seen, now_s
        if seen.is_alarmed:
            alarms = alarm_clause(self._rig.environments.get(lock.name.removeprefix("environment.")))
            yield Alarm("interlock", f"{lock.sentence(value)}{alarms}", lock.action, seen.kept_until_s, lock.name)

    def _single_reading_v(self, channel: str) -> float:
        burst = self._rig.readouts[channel.partition(".")[0]].read(channel, 1, self._wait)
        return float("nan") if burst.overload[0] else float(burst.samples[0])

    def _rejected(self) -> Iterator[Alarm]:
        limit = self._run_limits.rejected
        if limit is not None and (found := sum(self._rejections)) > limit[0]:
            within = len(self._rejections)
            self._rejections.clear()
            sentence = (
                f"{found} of the last {within} dwells were rejected, allowed {limit[0]} (rig file: interlocks.rejected)"
            )
            yield Alarm(
                "noise", f"{sentence}; look for vibration, a loose cable, a failing sensor; then continue", "ask"
            )

    def _lines(self) -> Iterator[Alarm]:
        for name, now in self._rig.link_counts().items():
            before = self._counted.setdefault(name, ExchangeCounts())
            sent, errors = now.questions - before.questions, now.errors - before.errors
            if sent < FEWEST_QUESTIONS:
                continue
            limit = self._run_limits.max_link_error_rate
            if sent >= WINDOW or errors > limit * sent:
                self._counted[name] = replace(now)
            if sent >= WINDOW and errors > WARN_RATE * sent:
                self._record("link_quality", {"line": name, "asked": sent, "errors": errors})
            if errors > limit * sent:
                text = f"{name}: {errors} of the last {sent} questions had no good answer, allowed {limit:.2g} of them"
                yield Alarm(
                    "link quality",
                    f"{text} (rig file: interlocks.max_link_error_rate); check cable, earth and adapter; then continue",
                    "ask",
                )


def suspended(change: ClockChange) -> Alarm:
    """Return the alarm after a suspension: nothing is known of lines, positions and temperatures."""
    return Alarm("suspend", f"the machine was suspended for {change.suspended_s:.0f} s", "restart")


def _axis_alarm(name: str, state: AxisState, rest_deg: float | None, tolerance_deg: float) -> Alarm | None:
    if state.fault:
        return Alarm("device", f"{name}: {state.fault} while it should rest; clear it at the machine", "trip")
    if not state.is_homed:
        return Alarm("home", f"{name}: the axis has lost its home, so its position is not known", "restart")
    if rest_deg is None:  # its dwell was rejected, maybe for where it stood: the next attempt approaches anew
        return None
    if state.is_moving or abs(state.position_deg - rest_deg) > 2.0 * tolerance_deg:
        what = "moves" if state.is_moving else "was moved"
        return Alarm(
            "motion",
            f"{name}: {what}, though nothing told it to: left at {rest_deg:g}°, now at {state.position_deg:g}°, "
            f"allowed within {2.0 * tolerance_deg:g}°; see who or what moved it",
            "trip",
        )
    return None
