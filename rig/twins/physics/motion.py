"""What turns: one axis of the twins' table as a body that moves at its speed and rests where its teeth are.

The controller's twin commands it in table angles; the world asks for the attitude that the package really has.
"""

import math
from dataclasses import dataclass

import numpy as np

from rig.twins.physics.chance import Chance
from rig.twins.physics.geometry import ARCSEC_RAD
from rig.twins.physics.ramp import Path

_STALL_LEAD_S = 0.2
"""How long before its arrival a move stalls."""
_CREEP_TAIL = 20.0
"""Time constants after which a creep is over: exp(−20) of it is 2e-9."""


@dataclass(frozen=True, slots=True)
class AxisErrors:
    """What the axis really is, besides what its controller believes."""

    index_half_width_arcsec: float = 0.0
    """Each tooth is off by a fixed amount within ± this (rectangular)."""
    index_harmonics: tuple[tuple[float, float, float], ...] = ()
    """Times a turn, amplitude (arcsec) and phase (degrees) of what the scale is off by at every angle."""
    index_list: tuple[tuple[float, float], ...] = ()
    """Angle (degrees) and error (arcsec), straight lines between."""
    zero_error_arcsec: float = 0.0
    creep_arcsec: float = 0.0
    creep_s: float = 1.0
    rate_error: float = 0.0
    """Part by which it turns too fast."""
    runaway_after_s: float | None = None

    def of_scale_arcsec(self, table_deg: float) -> float:
        """Return the smooth part of the index error at an angle of the machine."""
        error_arcsec = sum(
            amplitude_arcsec * math.sin(math.radians(times * table_deg + phase_deg))
            for times, amplitude_arcsec, phase_deg in self.index_harmonics
        )
        if self.index_list:
            angles, errors = zip(*self.index_list, strict=True)
            error_arcsec += float(np.interp(table_deg, angles, errors, period=360.0))
        return error_arcsec


@dataclass(frozen=True, slots=True)
class _Travel:
    """A :class:`rig.twins.physics.ramp.Path` at one speed; before its start the body rests where it begins."""

    from_deg: float
    to_deg: float
    start_s: float
    arrival_s: float

    def at(self, now_s: float) -> float:
        if now_s >= self.arrival_s:
            return self.to_deg
        if now_s <= self.start_s:
            return self.from_deg
        part = (now_s - self.start_s) / (self.arrival_s - self.start_s)
        return self.from_deg + part * (self.to_deg - self.from_deg)

    def speed_at(self, now_s: float) -> float:
        turning = self.start_s <= now_s < self.arrival_s
        return (self.to_deg - self.from_deg) / (self.arrival_s - self.start_s) if turning else 0.0


@dataclass(frozen=True, slots=True)
class _Paused:
    """A path that stands still for a while shortly before its end."""

    path: Path
    pause_s: float

    @property
    def arrival_s(self) -> float:
        return self.path.arrival_s + self.pause_s

    def at(self, now_s: float) -> float:
        return self.path.at(self._moment_s(now_s))

    def speed_at(self, now_s: float) -> float:
        moment_s = self._moment_s(now_s)
        return self.path.speed_at(moment_s) if moment_s in (now_s, now_s - self.pause_s) else 0.0

    def _moment_s(self, now_s: float) -> float:
        paused_s = self.path.arrival_s - _STALL_LEAD_S
        return min(now_s, max(paused_s, now_s - self.pause_s))


@dataclass(frozen=True, slots=True)
class _Displaced:
    """A path that runs beside another."""

    path: Path
    by_deg: float
    from_s: float

    @property
    def arrival_s(self) -> float:
        return self.path.arrival_s

    def at(self, now_s: float) -> float:
        return self.path.at(now_s) + (self.by_deg if now_s >= self.from_s else 0.0)

    def speed_at(self, now_s: float) -> float:
        return self.path.speed_at(now_s)


class AxisBody:
    """One axis: where its table really points at any time."""

    def __init__(
        self,
        name: str,
        chance: Chance,
        *,
        speed_dps: float,
        increment_deg: float,
        sign: int = 1,
        zero_deg: float = 0.0,
        errors: AxisErrors | None = None,
        stands_deg: float = 0.0,
    ) -> None:
        """Make the body; ``stands_deg``: at this table angle to begin with."""
        self.name = name
        self.speed_dps = speed_dps
        self.increment_deg = increment_deg
        self.reached_deg = (stands_deg, stands_deg)
        """Lowest and highest table angle that was ever commanded: what a limit test looks at."""
        self._sign, self._zero_deg = sign, zero_deg
        self._errors = errors or AxisErrors()
        self._chance = chance
        self._path: Path = _Travel(stands_deg, stands_deg, -math.inf, -math.inf)
        self._teeth: dict[int, float] = {}
        self._stall_s = self._lag_s = self._slip_deg = 0.0

    @property
    def still_from_s(self) -> float:
        """From this instant on the body is at rest, creep included."""
        creeping = self._errors.creep_arcsec != 0.0
        return self._path.arrival_s + self._lag_s + (_CREEP_TAIL * self._errors.creep_s if creeping else 0.0)

    @property
    def errors(self) -> AxisErrors:
        return self._errors

    def rotate(self, target_deg: float, start_s: float) -> float:
        """Turn to a table angle from where the body is at ``start_s``; returns the arrival in rig seconds."""
        here_deg = self.table_deg(start_s)
        arrival_s = start_s + abs(target_deg - here_deg) / self.speed_dps
        return self.follow(_Travel(here_deg, target_deg, start_s, arrival_s))

    def follow(self, path: Path) -> float:
        """Turn along a path of table angles, degrees, from now on; returns the arrival in rig seconds."""
        if math.isinf(path.arrival_s):
            self._path = path
            return math.inf
        self._path = _Paused(path, self._stall_s) if self._stall_s else path
        self._stall_s = 0.0
        end_deg = path.at(path.arrival_s)
        self.reached_deg = (min(self.reached_deg[0], end_deg), max(self.reached_deg[1], end_deg))
        return self._path.arrival_s

    def stall(self, for_s: float) -> None:
        """Let the next move to a place stand still for so long shortly before it arrives."""
        self._stall_s = for_s

    def slip(self, slip_deg: float, now_s: float, *, seen: bool) -> None:
        """Slip; unseen, the read-back goes on as if nothing had happened, else the next move takes it back."""
        if seen:
            self._path = _Displaced(self._path, slip_deg, now_s)
        else:
            self._slip_deg += slip_deg

    def lag(self, lag_s: float) -> None:
        """Let what is turned follow its read-back so much later from now on."""
        self._lag_s = lag_s

    def table_deg(self, now_s: float) -> float:
        """Return the nominal table angle."""
        return self._path.at(now_s)

    def rate_dps(self, now_s: float) -> float:
        """Return the rate of the table angle."""
        return self._path.speed_at(now_s)

    def attitude_rate_dps(self, now_s: float) -> float:
        """Return the true rate of the attitude angle."""
        return self._sign * self._path.speed_at(now_s - self._lag_s)

    def attitude_rad(self, now_s: float) -> float:
        """Return the true angle of this axis, its own errors included."""
        turned_s = now_s - self._lag_s
        nominal_deg = self._sign * (self.table_deg(turned_s) - self._zero_deg) + self._slip_deg
        scale_arcsec = self._errors.of_scale_arcsec(self.table_deg(turned_s)) + self._index_error_arcsec(turned_s)
        off_arcsec = self._errors.zero_error_arcsec + self._sign * scale_arcsec
        return math.radians(nominal_deg) + (off_arcsec + self._creep_arcsec(turned_s)) * ARCSEC_RAD

    def _index_error_arcsec(self, now_s: float) -> float:
        """Return the error of the tooth that the body rests on; none between teeth and on a continuous axis."""
        if now_s < self._path.arrival_s or self.increment_deg == 0.0:
            return 0.0
        tooth = round(self._path.at(now_s) / self.increment_deg) % round(360.0 / self.increment_deg)
        error = self._teeth.get(tooth)
        if error is None:
            half_width = self._errors.index_half_width_arcsec
            error = float(self._chance.fixed("tooth", self.name, tooth).uniform(-half_width, half_width))
            self._teeth[tooth] = error
        return error

    def _creep_arcsec(self, now_s: float) -> float:
        after_s = now_s - self._path.arrival_s
        if self._errors.creep_arcsec == 0.0 or not 0.0 <= after_s < _CREEP_TAIL * self._errors.creep_s:
            return 0.0
        return self._errors.creep_arcsec * math.exp(-after_s / self._errors.creep_s)


class Air:
    """The temperature of one environment: ramps to its setpoint, rests exactly there, drifts with the replications."""

    def __init__(
        self, start_degc: float, drift_degc_per_replication: float = 0.0, rate_degc_per_s: float = 0.05
    ) -> None:
        self._from_degc = self._setpoint_degc = start_degc
        self._start_s = self._arrival_s = -math.inf
        self._drift_degc_per_replication = drift_degc_per_replication
        self._rate_degc_per_s = rate_degc_per_s

    @property
    def setpoint_degc(self) -> float:
        return self._setpoint_degc

    @property
    def still_from_s(self) -> float:
        return self._arrival_s

    def hold(self, setpoint_degc: float, now_s: float) -> None:
        """Head for a setpoint."""
        self._from_degc = self._ramp_degc(now_s)
        self._setpoint_degc, self._start_s = setpoint_degc, now_s
        self._arrival_s = now_s + abs(setpoint_degc - self._from_degc) / self._rate_degc_per_s

    def temperature_degc(self, replications: float, now_s: float) -> float:
        return self._ramp_degc(now_s) + self._drift_degc_per_replication * replications

    def _ramp_degc(self, now_s: float) -> float:
        if now_s >= self._arrival_s:
            return self._setpoint_degc
        if now_s <= self._start_s:  # A streaming twin asks for samples of a moment ago.
            return self._from_degc
        part = (now_s - self._start_s) / (self._arrival_s - self._start_s)
        return self._from_degc + part * (self._setpoint_degc - self._from_degc)
