"""A motor with an encoder behind a motion controller: what the twins of such controllers turn.

It ramps to angles, spins at rates, runs to its home and stops; its read-back counts from where power came on until
the home is found, so a lost home makes it wrong by what the axis stood away from it.
"""

import math

from rig.twins.physics.motion import AxisBody
from rig.twins.physics.ramp import Path, Ramp, Runaway, Spin
from rig.twins.physics.world import World

RUNAWAY_DPS2 = 2.0
SEARCH_S = 0.5
"""The least that a search for a home switch and an index mark takes, also where the axis stands on them."""
ACCELERATION_DPS2 = 40.0
"""Of every motor here: a table is at its speed within a fraction of a second."""


class ServoAxis:
    """One axis of a controller. Angles are table angles in degrees, by the read-back unless named true."""

    def __init__(self, body: AxisBody, world: World, *, is_homed: bool = False) -> None:
        self.speed_dps = body.speed_dps
        self.acceleration_dps2 = ACCELERATION_DPS2
        self._body = body
        self._world = world
        self._lost_deg = 0.0
        """True table angle minus read-back."""
        self._homed_from_s = -math.inf if is_homed else math.inf
        self._rest_from_s = -math.inf
        self._home_reads_deg = 0.0

    def is_moving(self, now_s: float) -> bool:
        return now_s < self._rest_from_s

    def is_homed(self, now_s: float) -> bool:
        return now_s >= self._homed_from_s

    def position_deg(self, now_s: float) -> float:
        return self._body.table_deg(now_s) - self._off_deg(now_s)

    def rate_dps(self, now_s: float) -> float:
        return self._body.rate_dps(now_s)

    def move(self, target_deg: float, now_s: float) -> None:
        """Go to a read-back; without a home that is somewhere else."""
        self._ramp(target_deg + self._off_deg(now_s), now_s)

    def spin(self, rate_dps: float, now_s: float) -> None:
        """Turn at a rate until told otherwise."""
        errors = self._body.errors
        path: Path = Spin(
            self._body.table_deg(now_s),
            rate_dps * (1.0 + errors.rate_error),
            now_s,
            speed=self.rate_dps(now_s),
            acceleration=self.acceleration_dps2,
        )
        if errors.runaway_after_s is not None:
            path = Runaway(path, now_s + errors.runaway_after_s, RUNAWAY_DPS2)
        self._follow(path)

    def home(self, now_s: float, reads_deg: float = 0.0) -> None:
        """Run to the home; homed when it is reached. One that has a zero counts from it until then, as a drive does.

        ``reads_deg``: what its read-back is there from then on.
        """
        if self.is_homed(now_s):
            self._lost_deg = self._off_deg(now_s)
        self._home_reads_deg = reads_deg
        self._homed_from_s = math.inf
        self._ramp(0.0, now_s)
        self._rest_from_s = max(self._rest_from_s, now_s + SEARCH_S)
        self._homed_from_s = self._rest_from_s

    def stop(self, now_s: float) -> None:
        """Brake. A home that was on its way is none."""
        if not self.is_moving(now_s):
            return
        if self._homed_from_s > now_s:
            self._homed_from_s = math.inf
        rate_dps = self.rate_dps(now_s)
        brake_deg = 0.5 * rate_dps * abs(rate_dps) / self.acceleration_dps2
        self._ramp(self._body.table_deg(now_s) + brake_deg, now_s)

    def power_cycle(self, now_s: float, *, is_absolute: bool = False) -> None:
        """Lose power and get it back: the axis stands.

        It has no home and reads 0 from then on, but where its encoder ``is_absolute``.
        """
        here_deg = self._body.table_deg(now_s)
        is_homed = self.is_homed(now_s)
        self._follow(Ramp(here_deg, here_deg, now_s, math.inf))
        if not (is_absolute and is_homed):
            self._homed_from_s = math.inf
        if not is_absolute:
            self._lost_deg = here_deg

    def _off_deg(self, now_s: float) -> float:
        """Return true table angle minus read-back."""
        return -self._home_reads_deg if self.is_homed(now_s) else self._lost_deg

    def _ramp(self, true_deg: float, now_s: float) -> None:
        path = Ramp(
            self._body.table_deg(now_s),
            true_deg,
            now_s,
            self.speed_dps,
            speed=self.rate_dps(now_s),
            acceleration=self.acceleration_dps2,
        )
        self._follow(path)

    def _follow(self, path: Path) -> None:
        self._rest_from_s = self._world.follow(self._body.name, path)
