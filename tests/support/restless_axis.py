"""An axis from physics: a true angle that a brake lets creep, a read-back with noise and steps, stops that get lost.

Its machine says that it rests whatever it does, as several do of a rotation.
"""

from collections.abc import Callable

import numpy as np
from table_bench import virtual_clock

from rig.abilities.abilities import AxisState

Noise = Callable[[np.random.Generator], float]


def digits(step_deg: float) -> Noise:
    """A servo about one place: the last digit is one less, the same, or one more."""
    return lambda random: step_deg * float(random.integers(-1, 2))


def gaussian(sigma_deg: float) -> Noise:
    return lambda random: sigma_deg * float(random.standard_normal())


QUIET = gaussian(0.0)


class RestlessAxis:
    """It turns at ``rate_dps`` until a stop is heard, brakes at ``braking_dps2``, and creeps ever after."""

    def __init__(
        self,
        noise: Noise = QUIET,
        *,
        rate_dps: float = 0.0,
        creep_dps: float = 0.0,
        lost_stops: int = 0,
        braking_dps2: float = 200.0,
        step_deg: float = 1e-4,
        look_s: float = 0.0,
        seed: int = 0,
    ) -> None:
        self.name, self.limits_deg, self.speed_dps = "yaw", (-180.0, 180.0), 20.0
        self.increment_deg = self.approach_deg = 0.0
        self.arrival_tolerance_deg = 0.001
        self.clock = virtual_clock()
        self.true_deg = 0.0
        self.stops_s: list[float] = []
        self._noise, self._random = noise, np.random.default_rng(seed)
        self._rate_dps, self._creep_dps = rate_dps, creep_dps
        self._braking_dps2, self._step_deg = braking_dps2, step_deg
        self._lost_stops, self._look_s = lost_stops, look_s
        self._is_braked = False
        self._stepped_s = self.clock.monotonic_s()

    def stop(self) -> None:
        self._go_on()
        self.stops_s.append(self.clock.monotonic_s())
        self._is_braked = self._is_braked or len(self.stops_s) > self._lost_stops

    def identify(self) -> str:
        return "restless"

    def check_target(self, target_deg: float) -> None: ...

    def start_move(self, target_deg: float) -> None: ...

    def home(self) -> None: ...

    def state(self) -> AxisState:
        self.clock.sleep(self._look_s)
        self._go_on()
        shown_deg = self._step_deg * round((self.true_deg + self._noise(self._random)) / self._step_deg)
        return AxisState(shown_deg, is_moving=False, is_homed=True, is_seated=True, fault="")

    def _go_on(self) -> None:
        now_s = self.clock.monotonic_s()
        passed_s, self._stepped_s = now_s - self._stepped_s, now_s
        if not self._is_braked:
            self.true_deg += self._rate_dps * passed_s
            return
        braking_s = min(passed_s, self._rate_dps / self._braking_dps2)
        self.true_deg += self._rate_dps * braking_s - 0.5 * self._braking_dps2 * braking_s**2
        self._rate_dps -= self._braking_dps2 * braking_s
        self.true_deg += self._creep_dps * (passed_s - braking_s)
