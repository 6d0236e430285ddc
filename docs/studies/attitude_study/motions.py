"""CR's figures 9, 10 and 20 to 23 and SR's 23 to 30: gyros integrated, a table turned by hand, a flight and its filter.

CR and SR show recordings that are not printed: here the motion that their text tells is drawn, and what their sensors
would have read of it by the reports' own tables.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

from ams.attitude.attitude_filter import AttitudeFilter, FilteredPath, FilterSettings
from ams.attitude.gyro import cr_angles_rad, path_by_butcher, quaternion_of_cr
from ams.attitude.kalman import Estimate, GyroNoise
from ams.attitude.rate_scan import Interpolation, Path, RateScan
from ams.frames import body_rates_rad_s
from procedures.report.canvas import INK, SERIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
Drawing = Callable[["Figure"], None]
ANGLES = ("pitch", "yaw", "roll")


@dataclass(frozen=True)
class Construction:
    """CR's harmonic profile at one rate: the angles, and what the integration makes of them, (n, 3) degrees."""

    time_s: FloatArray
    exact_deg: FloatArray
    found_deg: FloatArray

    @property
    def worst_deg(self) -> float:
        return float(np.abs(self.found_deg - self.exact_deg).max())


@cache
def construction(rate_hz: float, interpolation: Interpolation = "cubic", method: str = "quaternion") -> Construction:
    """Θ = 10 sin(0.125·2πt), Ψ = 10 sin(0.0625·2πt), Φ = 10 sin(0.25·2πt) over ten seconds, CR IV-D."""
    time_s = np.arange(round(10.0 * rate_hz) + 1) / rate_hz
    omega = 2.0 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = time_s[:, None] * omega
    euler = np.deg2rad(10.0) * np.sin(phase)
    rates = body_rates_rad_s(euler, np.deg2rad(10.0) * omega * np.cos(phase))
    path = path_by_butcher if method == "butcher" else None
    found = integrated(rates.T, quaternion_of_cr(euler[0]), 1.0 / rate_hz, interpolation, path)
    return Construction(time_s, np.rad2deg(euler), np.rad2deg(cr_angles_rad(found, euler[0]).T))


def integrated(
    rates: FloatArray,
    start: FloatArray,
    interval_s: float,
    interpolation: Interpolation = "cubic",
    path: Path | None = None,
) -> FloatArray:
    """Return the (4, N) attitudes at all of (3, N) samples, as a stream gives them."""
    scan = RateScan(start, interval_s, interpolation, path)
    return np.concatenate([scan.feed(rates).quaternion, scan.finish().quaternion], axis=1)


def draw_construction(figure: "Figure") -> None:
    left, right = figure.subplots(1, 2)
    found = construction(1000.0)
    for index, (name, colour) in enumerate(zip(ANGLES, SERIES, strict=False)):
        left.plot(found.time_s, found.exact_deg[:, index], color=colour, label=name)
        left.plot(found.time_s[::500], found.found_deg[::500, index], "o", color=colour, markersize=2.5)
        right.plot(found.time_s, found.found_deg[:, index] - found.exact_deg[:, index], color=colour, label=name)
    left.set(title="figure 9: exact (line), integrated (points)", xlabel="time (s)", ylabel="angle (degrees)")
    right.set(title="figure 10: integrated less exact", xlabel="time (s)", ylabel="difference (degrees)")
    left.legend()


TABLE_RATE_HZ, REST_DEG, ADXL105_G_PER_SQRT_HZ = 100.0, -12.0, 225e-6
ENC03J_DRIFT_DPS, ENC03J_NOISE_DPS = 2.0, 0.5
"""Within the < 5 °/s of CR table 2; how noisy an ENC-03J is CR does not print."""


@dataclass(frozen=True)
class TurnedByHand:
    """A table at rest and turned by hand, and what its two sensors make of its angle, degrees."""

    time_s: FloatArray
    true_deg: FloatArray
    accelerometer_deg: FloatArray
    gyro_deg: FloatArray


@cache
def by_hand(is_moved: bool) -> TurnedByHand:
    """Seventeen seconds: at rest for eight, then to −12°, 0°, +12° and 0° in quick slews; or at rest throughout."""
    chance = np.random.default_rng(20)
    time_s = np.arange(round(17.0 * TABLE_RATE_HZ) + 1) / TABLE_RATE_HZ
    knots = np.array([0.0, 8.0, 8.4, 10.0, 10.4, 12.0, 12.4, 14.0, 14.4, 17.0])
    held = np.array([0.0, 0.0, REST_DEG, REST_DEG, 0.0, 0.0, -REST_DEG, -REST_DEG, 0.0, 0.0])
    true = PchipInterpolator(knots, held if is_moved else np.zeros_like(held))(time_s)
    noise_g = ADXL105_G_PER_SQRT_HZ * np.sqrt(TABLE_RATE_HZ / 2.0)
    sensed = np.sin(np.deg2rad(true)) + noise_g * chance.normal(size=time_s.size)
    rate = np.gradient(true, time_s) + _remembered(np.gradient(true, time_s))
    rate += ENC03J_NOISE_DPS * chance.normal(size=time_s.size)
    return TurnedByHand(time_s, true, np.rad2deg(np.arcsin(np.clip(sensed, -1.0, 1.0))),
                        np.cumsum(rate) / TABLE_RATE_HZ)  # fmt: skip


def _remembered(rate_dps: FloatArray) -> FloatArray:
    """Return a zero that lies on the side of the last turn, as CR saw it ('strong dependency on response history')."""
    last = np.zeros_like(rate_dps)
    side = 1.0
    for row, rate in enumerate(rate_dps.tolist()):
        side = np.sign(rate) if abs(rate) > 5.0 else side
        last[row] = side
    return ENC03J_DRIFT_DPS * last


def draw_by_hand(figure: "Figure") -> None:
    panels = figure.subplots(2, 2)
    for column, is_moved in enumerate((True, False)):
        found = by_hand(is_moved)
        for row, (values, name) in enumerate(((found.accelerometer_deg, "accelerometer"), (found.gyro_deg, "gyro"))):
            panel = panels[row, column]
            panel.plot(found.time_s, values, color=SERIES[row], linewidth=0.6, label=name)
            panel.plot(found.time_s, found.true_deg, color=INK, linewidth=0.8, label="table")
            if not is_moved:
                panel.axhspan(-0.1, 0.1, color="#e3e3e3", label="±0.1°")
            panel.set(title=f"figure {20 + 2 * row + column}: {name}, {'turned by hand' if is_moved else 'at rest'}",
                      xlabel="time (s)", ylabel="angle (degrees)")  # fmt: skip
            panel.legend()


FLIGHT_HZ, FLIGHT_ROWS = 1.0, 7200
FORCE_SD_G, FIELD_SD_UT = 0.01, 0.5
FIELD_UT = np.array([22.0, -3.0, 40.0])
SPIN_BIAS_DPS = (0.05, -0.04, 0.03)


@dataclass(frozen=True)
class Flight:
    """Two hours of a payload that turns about the vertical and swings, with what is made of it."""

    time_h: FloatArray
    true: Rotation
    by_gyro: Rotation
    quaternion_by_gyro: FloatArray
    filtered: FilteredPath

    def off_deg(self, found: Rotation) -> FloatArray:
        return np.asarray(np.rad2deg((found * self.true.inv()).magnitude()))

    @property
    def by_filter(self) -> Rotation:
        return Rotation.from_quat(self.filtered.quaternion.T)


@cache
def flight() -> Flight:
    """SR's sensors at one sample a second: ITG-3200 with a zero that is off, SCA3000, MicroMag3."""
    chance = np.random.default_rng(30)
    time_s = np.arange(FLIGHT_ROWS) / FLIGHT_HZ
    yaw = 1.2 * np.sin(2 * np.pi * time_s / 300.0) + 0.5 * np.sin(2 * np.pi * time_s / 970.0)
    pitch = np.deg2rad(4.0) * np.sin(2 * np.pi * time_s / 47.0)
    roll = np.deg2rad(9.0) * np.sin(2 * np.pi * time_s / 61.0 + 1.0)
    true = Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1))
    turns = (true[:-1].inv() * true[1:]).as_rotvec() * FLIGHT_HZ
    mean = np.concatenate([turns[:1], (turns[:-1] + turns[1:]) / 2.0, turns[-1:]])
    bias = np.deg2rad(SPIN_BIAS_DPS)
    gyro = (mean + bias + np.deg2rad(0.02) * chance.normal(size=mean.shape)).T
    force = true.inv().apply([0.0, 0.0, -1.0]).T + FORCE_SD_G * chance.normal(size=(3, FLIGHT_ROWS))
    field = true.inv().apply(FIELD_UT).T + FIELD_SD_UT * chance.normal(size=(3, FLIGHT_ROWS))
    by_gyro = integrated(np.ascontiguousarray(gyro), true[0].as_quat(), 1.0 / FLIGHT_HZ)
    settings = FilterSettings(
        1.0 / FLIGHT_HZ, GyroNoise(2e-3, 1e-6), FORCE_SD_G,
        field_reference_ut=(22.0, -3.0, 40.0), field_sd_ut=FIELD_SD_UT,
    )  # fmt: skip
    start = Estimate(true[0].as_quat(), np.zeros(3), np.diag([0.05**2] * 3 + [2e-3**2] * 3))
    filtered = AttitudeFilter(settings, start).run(gyro, force, field)
    return Flight(time_s / 3600.0, true, Rotation.from_quat(by_gyro.T), by_gyro, filtered)


def draw_quaternions(figure: "Figure") -> None:
    flown = flight()
    panels = figure.subplots(2, 2)
    for column, (found, label) in enumerate(
        ((flown.quaternion_by_gyro, "23, 24: gyros alone"), (flown.filtered.quaternion, "28, 29: filtered"))
    ):
        for row, pair in enumerate(((0, 1), (2, 3))):
            panel = panels[row, column]
            for component in pair:
                panel.plot(
                    flown.time_h, found[component], color=SERIES[component], linewidth=0.7, label=f"q{component + 1}"
                )
            panel.set(title=f"figures {label}", xlabel="time (hours)", ylim=(-1.1, 1.1))
            panel.legend()


def draw_euler(figure: "Figure") -> None:
    flown = flight()
    top, middle, bottom = figure.subplots(3, 1)
    for panel, found, label in ((top, flown.by_gyro, "26: gyros alone"), (middle, flown.by_filter, "30: filtered")):
        for index, name in enumerate(("yaw", "pitch", "roll")):
            angles = np.rad2deg(found.as_euler("ZYX")[:, index])
            panel.plot(flown.time_h, angles, color=SERIES[index], linewidth=0.6, label=name)
        panel.set(title=f"figure {label}", ylabel="degrees")
        panel.legend(loc="upper right")
    bottom.semilogy(flown.time_h, flown.off_deg(flown.by_gyro), color=SERIES[1], label="gyros alone")
    bottom.semilogy(flown.time_h, flown.off_deg(flown.by_filter), color=SERIES[0], linewidth=0.6, label="filtered")
    bottom.set(title="how far off the truth, which SR did not have", xlabel="time (hours)", ylabel="degrees")
    bottom.legend()


PICTURES: dict[str, tuple[float, Drawing]] = {
    "cr-09-and-10.png": (3.0, draw_construction),
    "cr-20-to-23.png": (5.0, draw_by_hand),
    "sr-23-to-29.png": (5.0, draw_quaternions),
    "sr-26-and-30.png": (6.5, draw_euler),
}
