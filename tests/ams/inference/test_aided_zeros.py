"""Zeros of gyros that are not those of the calibration, beside accelerometers: angles cover, or their rows say why not.

The truth is made here: attitudes and rates by scipy's rotations, the Earth's turn by geography.
"""

from collections.abc import Iterable
from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from solved_sets import gyro_set, tp_set

from ams.attitude.earth_rate import EarthRate
from ams.errors import OutsideValidity
from ams.inference.gyros.aided_rates import AidedAngles, Aiding
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import Motion
from ams.inference.inference import Package
from ams.inference.rows.angle_stream import Answer
from ams.inputs.shared_errors import SHIFTS

GYROS, FORCE = gyro_set(), tp_set()
GYRO_V, FORCE_V = {a: f"{a}_v" for a in "xyz"}, {a: f"f{a}_v" for a in "xyz"}
NOISE_V, FORCE_SD_G, RATE_HZ = 0.02, 0.003, 20.0
SIDEREAL_DPS = 360.0 / 86164.1
NAMES = ("pitch", "yaw", "roll")


@dataclass
class Scene:
    """A package that rests and then rolls, pitches and yaws slowly, and what its sensors read."""

    seed: int
    seconds: float = 60.0
    zeros_dps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    earth: tuple[float, float] | None = None
    """Latitude and heading, degrees."""
    rest_s: float = 0.0

    def __post_init__(self) -> None:
        chance = np.random.default_rng(self.seed)
        self.time_s = np.arange(round(self.seconds * RATE_HZ)) / RATE_HZ
        self._size_deg = chance.uniform(5, 25, 3)
        self._omega = 2 * np.pi * chance.uniform(0.02, 0.05, 3)
        self.angles_deg = self._angles_deg(self.time_s)
        attitude, step_s = self._attitude(self.time_s), 1e-4
        turned = self._attitude(self.time_s - step_s).inv() * self._attitude(self.time_s + step_s)
        rates_dps = np.rad2deg(turned.as_rotvec()) / (2 * step_s) + self.zeros_dps
        if self.earth is not None:
            latitude, heading = np.deg2rad(self.earth)
            north, down = SIDEREAL_DPS * np.cos(latitude), -SIDEREAL_DPS * np.sin(latitude)
            rates_dps += attitude.inv().apply([north * np.cos(heading), -north * np.sin(heading), down])
        self.force_g = attitude.inv().apply([0.0, 0.0, -1.0])
        self.readings = {}
        for axis, numbers in GYROS.axes.items():
            clean = numbers.primary["offset_v"] + rates_dps @ numbers.direction
            self.readings[GYRO_V[axis]] = clean + NOISE_V * chance.normal(size=self.time_s.size)
        self._noise_g = FORCE_SD_G * chance.normal(size=self.force_g.shape)
        self.push(np.zeros_like(self.force_g))

    def push(self, acceleration_g: np.ndarray) -> None:
        """Let the accelerometers feel (n, 3) in package axes beside gravity."""
        felt = self.force_g + self._noise_g + acceleration_g
        for axis, numbers in FORCE.axes.items():
            self.readings[FORCE_V[axis]] = numbers.primary["offset_v"] + felt @ numbers.direction_v_per_g

    def _angles_deg(self, time_s: np.ndarray) -> np.ndarray:
        moving_s = np.clip(time_s - self.rest_s, 0.0, None)[:, None]
        swing = 1.0 - np.cos(self._omega * moving_s)  # begins without a jerk
        return self._size_deg / 2.0 * swing

    def _attitude(self, time_s: np.ndarray) -> Rotation:
        return Rotation.from_euler("YZX", self._angles_deg(time_s), degrees=True)

    def within_two_sd(self, found: Answer, name: str) -> np.ndarray:
        off = np.abs(found.columns[f"{name}_deg"] - self.angles_deg[:, NAMES.index(name)])
        return off <= 2.0 * found.columns[f"{name}_sd_deg"] + 1e-9


def aided(motion: Motion | None = None, zero_sd_dps: float | None = None) -> AidedAngles:
    gyros = GyroPackage(GYROS, GYRO_V, NOISE_V)
    aiding = Aiding(FORCE_SD_G, 1e-6, zero_sd_dps)
    return AidedAngles(gyros, Package(FORCE, FORCE_V), motion or STARTED, aiding)


def is_clean(flags: Iterable[str]) -> bool:
    """Whether nothing is flagged but what the gate of a row refuses by chance, with the half second behind it."""
    said = list(flags)
    refused = [flag for flag in said if flag.startswith("force not used: a zero")]
    return set(said) <= {"", *refused} and len(refused) < 0.06 * len(said)


STARTED = Motion(RATE_HZ, start_deg=(0.0, 0.0, 0.0), start_sd_deg=0.01)


@pytest.mark.parametrize("earth", [None, (45.0, 30.0), (-70.0, 200.0)], ids=str)
@pytest.mark.parametrize("shift_dps", [0.0, 0.01, 0.03, 0.1])
def test_angles_cover_where_nothing_states_how_far_the_zeros_went(
    shift_dps: float, earth: tuple[float, float] | None
) -> None:
    zeros_dps = (shift_dps, -0.6 * shift_dps, 0.4 * shift_dps)
    inside: dict[str, list[np.ndarray]] = {name: [] for name in NAMES}
    for seed in range(8):
        scene = Scene(seed, 40.0, zeros_dps, earth)
        found = aided().answer(scene.readings)
        assert is_clean(found.flags)
        for name in NAMES:
            inside[name].append(scene.within_two_sd(found, name))
    for name in NAMES:
        assert np.mean(inside[name]) >= 0.93, name


def test_the_earth_is_taken_off_where_latitude_and_heading_are_stated() -> None:
    motion = replace(STARTED, earth=EarthRate(45.0, 30.0))
    inside, widest_deg = [], 0.0
    for seed in range(6):
        scene = Scene(seed, 100.0, earth=(45.0, 30.0))
        found = aided(motion, zero_sd_dps=1e-4).answer(scene.readings)
        inside += [scene.within_two_sd(found, name) for name in NAMES]
        widest_deg = max(widest_deg, float(found.columns["yaw_sd_deg"].max()))
    assert np.mean(inside) >= 0.93
    assert widest_deg < 0.12  # the Earth turns by 0.3° about the vertical meanwhile


@pytest.mark.parametrize("earth", [(45.0, 30.0), (-70.0, 200.0), (0.0, 300.0)], ids=str)
@pytest.mark.parametrize("rest_s", [0.0, 10.0])
def test_the_earth_that_is_not_taken_off_is_in_the_standard_deviations(
    earth: tuple[float, float], rest_s: float
) -> None:
    """Zeros that are known otherwise, as stated or by a rest: the share of an axis changes as the package turns."""
    motion, zero_sd_dps = (replace(STARTED, rest_s=rest_s), None) if rest_s else (STARTED, 1e-4)
    inside: dict[str, list[np.ndarray]] = {name: [] for name in NAMES}
    for seed in range(6):
        scene = Scene(seed, 100.0, earth=earth, rest_s=rest_s + 0.5 if rest_s else 0.0)
        found = aided(motion, zero_sd_dps).answer(scene.readings)
        for name in NAMES:
            inside[name].append(scene.within_two_sd(found, name))
    for name in NAMES:
        assert np.mean(inside[name]) >= 0.93, name


@pytest.mark.parametrize("is_told", [True, False])
def test_a_rest_measures_zeros_with_the_earth_and_without(is_told: bool) -> None:
    motion = replace(STARTED, rest_s=15.0, earth=EarthRate(45.0, 30.0) if is_told else None)
    inside = []
    for seed in range(6):
        scene = Scene(seed, 60.0, (0.5, -0.3, 0.2), (45.0, 30.0), rest_s=15.5)
        stream = aided(motion)
        parts = [{n: v[part] for n, v in scene.readings.items()} for part in np.array_split(np.arange(1200), 7)]
        answers = [stream.answer(part) for part in parts]
        flags = [flag for answer in answers for flag in answer.flags]
        assert all(flag.startswith("at rest: attitude of the start") for flag in flags[:300])
        assert is_clean(flags[300:])
        assert stream.rest.zero is not None
        assert stream.rest.zero.is_still
        for index, name in enumerate(NAMES):
            off = np.abs(np.concatenate([a.columns[f"{name}_deg"] for a in answers]) - scene.angles_deg[:, index])
            sds = np.concatenate([a.columns[f"{name}_sd_deg"] for a in answers])
            inside.append(off <= 2.0 * sds + 1e-9)
            assert sds.max() < 0.5  # 0.1 °/s of a zero turn by 4.5° in this time
    assert np.mean(inside) >= 0.93


def test_zeros_far_from_what_is_stated_are_flagged_found_and_named() -> None:
    """Gravity is no longer shut out for good by a filter that is sure of its zeros, and the cause is not motion."""
    scene = Scene(3, 90.0, (0.3, -0.2, 0.1), (45.0, 30.0))
    stream = aided(zero_sd_dps=1e-4)
    found = stream.answer(scene.readings)
    flags = found.flags
    seconds = np.arange(len(flags)) / RATE_HZ
    flagged = np.array([flag != "" for flag in flags])
    assert flagged[seconds > 4.0].all()
    assert not any("package accelerates" in flag and "zero" not in flag for flag in flags)
    for name in ("pitch", "roll"):
        off = np.abs(found.columns[f"{name}_deg"] - scene.angles_deg[:, NAMES.index(name)])
        assert off[-400:].max() < 0.3, name
        assert scene.within_two_sd(found, name)[-600:].mean() >= 0.9, name
    assert "of x, y, z more than was stated" in stream.consistency()


def test_a_package_that_accelerates_for_a_while_is_not_taken_for_a_zero() -> None:
    """0.06 g along the horizon is not in the length of a force: the cause is left open, and what follows is clean."""
    scene = Scene(4, 60.0)
    push = np.zeros((1200, 3))
    across = np.cross(scene.force_g[400:500], [1.0, 0.0, 0.0])
    push[400:500] = 0.06 * across / np.linalg.norm(across, axis=1, keepdims=True)
    scene.push(push)
    stream = aided(zero_sd_dps=1e-3)
    flags = stream.answer(scene.readings).flags
    assert sum("a zero of the gyros is not as stated, or the package accelerates" in f for f in flags[400:500]) >= 98
    assert is_clean(flags[:400])
    assert is_clean(flags[-500:])


def test_a_slow_push_below_the_gate_of_a_row_is_told() -> None:
    """Half of what the gate of a row needs, for twenty seconds."""
    scene = Scene(5, 60.0)
    push = np.zeros((1200, 3))
    push[400:800, 1] = 0.006
    scene.push(push)
    flags = aided(zero_sd_dps=1e-4).answer(scene.readings).flags
    assert is_clean(flags[:400])
    assert sum("gravity contradicts the gyros" in flag for flag in flags[400:800]) > 100


def test_forces_as_assumed_contradict_nothing() -> None:
    for seed in range(25):
        shift = np.random.default_rng(seed).normal(0.0, 0.03, 3)
        flags = aided(zero_sd_dps=0.03).answer(Scene(seed, 60.0, tuple(shift.tolist())).readings).flags
        assert not any("gravity contradicts" in flag for flag in flags)


def test_a_set_that_counts_the_shift_of_its_zeros_needs_no_other() -> None:
    document = deepcopy(dict(GYROS.document))
    components = document["package"]["components"]
    first = next(iter(components.values()))
    nothing = {**first, "covariance": np.zeros(np.shape(first["covariance"])).tolist()}
    components[SHIFTS[0]] = nothing
    counted = GyroPackage(replace(GYROS, document=document), GYRO_V, NOISE_V)
    plain = GyroPackage(GYROS, GYRO_V, NOISE_V)
    assert (counted.counts_shift, plain.counts_shift) == (True, False)
    scene = Scene(6, 10.0)
    last_deg = [
        AidedAngles(gyros, Package(FORCE, FORCE_V), STARTED, Aiding(FORCE_SD_G)).answer(scene.readings)
        .columns["yaw_sd_deg"][-1]
        for gyros in (counted, plain)
    ]  # fmt: skip
    assert last_deg[0] < 0.5 * last_deg[1]


def test_a_rest_and_a_stated_zero_are_one_too_many() -> None:
    with pytest.raises(OutsideValidity, match="got 5 s at rest, which measure the zeros"):
        aided(Motion(RATE_HZ, rest_s=5.0), 0.01)
    with pytest.raises(OutsideValidity, match="allowed is a number of 0 or more"):
        Aiding(zero_sd_dps=-0.1)
