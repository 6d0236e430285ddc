"""TP's figures 6 to 20: how uncertain inferred angles are, and where they are singular."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ams.attitude.static import pitch_roll_from_three, pitch_roll_from_two, pitch_with_known_roll
from ams.frames import specific_force
from ams.inference.package.calibrated import CalibratedSensor
from ams.models.accelerometer import vector_from_angles
from ams.sets.sensed_quantity import PER_G
from procedures.report.canvas import SERIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
SIGMA = 1e-6
PITCH_DEG, ROLL_DEG = np.linspace(-89.0, 89.0, 357), np.linspace(-179.5, 179.5, 720)
PITCHES_DEG, ROLLS_DEG = (0.0, 20.0, 40.0, 60.0, 80.0), (0.0, 30.0, 60.0, 90.0)
Drawing = Callable[["Figure"], None]


def sensor(axis: str, coning_deg: float, azimuth_deg: float, ratio: float = 1.0) -> CalibratedSensor:
    k = vector_from_angles(axis, 1.0, np.deg2rad(coning_deg), np.deg2rad(azimuth_deg))
    return line(k, np.zeros((4, 4)), ratio * SIGMA)


def line(k: FloatArray, covariance: FloatArray, reading_sd: float) -> CalibratedSensor:
    """Return a sensor without offset; the (4, 4) covariance is of offset and k."""
    return CalibratedSensor(("offset_v", *PER_G), np.array([0.0, *k]), covariance, reading_sd, np.zeros(1))


def outputs(sensors: Sequence[CalibratedSensor], pitch_deg: FloatArray, roll_deg: FloatArray) -> FloatArray:
    force = specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
    return np.stack([force @ axis.k_v_per_g for axis in sensors], axis=-1)


def one_axis(ratio: float, pitch_deg: FloatArray, roll_deg: FloatArray, coning_deg: float = 1.0) -> FloatArray:
    """Return σ(pitch)/σ of one axis with Ω_x and A_x = 90°, the roll known to ``ratio`` of it."""
    along = sensor("x", coning_deg, 90.0)
    read = outputs([along], pitch_deg, roll_deg)[:, 0]
    return pitch_with_known_roll(along, read, np.deg2rad(roll_deg), ratio * SIGMA).pitch_sd_rad / SIGMA


def by_two(
    axes: str, coning_deg: float, azimuths_deg: tuple[float, float], ratio: float, pitch_deg: float
) -> tuple[FloatArray, FloatArray]:
    """Return σ(pitch)/σ_x and σ(roll)/σ of the other axis over ``ROLL_DEG``."""
    pair = [sensor(a, coning_deg, azimuth, r) for a, azimuth, r in zip(axes, azimuths_deg, (1.0, ratio), strict=True)]
    upright = np.abs(ROLL_DEG) < 90.0
    pitch_sd, roll_sd = np.empty_like(ROLL_DEG), np.empty_like(ROLL_DEG)
    for side in (True, False):
        rows = upright == side
        read = outputs(pair, np.full(rows.sum(), pitch_deg), ROLL_DEG[rows])
        found = pitch_roll_from_two(pair, read, upright=side)
        pitch_sd[rows], roll_sd[rows] = found.pitch_sd_rad, found.roll_sd_rad
    return pitch_sd / SIGMA, roll_sd / SIGMA / ratio


def by_three(coning_deg: float, ratio: float, pitch_deg: FloatArray, roll_deg: FloatArray) -> tuple[FloatArray, ...]:
    """Return σ(pitch)/σ_x and σ(roll)/σ_y."""
    sensors = [
        sensor(a, coning_deg, azimuth, r) for a, azimuth, r in zip("xyz", (90, 0, 0), (1, ratio, ratio), strict=True)
    ]
    found = pitch_roll_from_three(sensors, outputs(sensors, pitch_deg, roll_deg))
    return found.pitch_sd_rad / SIGMA, found.roll_sd_rad / SIGMA / ratio


def determinant(axes: str, coning_deg: float, azimuths_deg: tuple[float, float]) -> tuple[FloatArray, ...]:
    """Return pitch, roll and the determinant (k × k′)·f that :mod:`ams.attitude.few_axes` divides by."""
    pitch, roll = np.meshgrid(np.linspace(-90.0, 90.0, 361), np.linspace(-180.0, 180.0, 721))
    k = np.stack([sensor(a, coning_deg, azimuth).k_v_per_g for a, azimuth in zip(axes, azimuths_deg, strict=True)])
    force = specific_force(np.deg2rad(pitch.ravel()), np.deg2rad(roll.ravel()))
    return pitch, roll, (force @ np.cross(k[0], k[1])).reshape(pitch.shape)


def furthest_from_roll_90(azimuth_deg: float) -> float:
    """Return how far from R = ±90° the locus of an x-y package with Ω = 1° lies at pitch 80°, degrees."""
    pitch, roll, value = determinant("xy", 1.0, (azimuth_deg, 90.0))
    column = int(np.argmin(np.abs(pitch[0] - 80.0)))
    crossed = np.flatnonzero(np.diff(np.sign(value[:, column])) != 0)
    return float(np.max(np.abs(np.abs(roll[crossed, column] + 0.25) - 90.0)))


def draw_one_axis(figure: "Figure") -> None:
    left, right = figure.subplots(1, 2)
    left.plot(PITCH_DEG, one_axis(0.0, PITCH_DEG, np.zeros(PITCH_DEG.size), 0.0), "k:", label="figure 6: no roll")
    for ratio, colour in ((1.0, SERIES[0]), (10.0, SERIES[1])):
        curve = one_axis(ratio, PITCH_DEG, np.full(PITCH_DEG.size, 0.0))
        left.plot(PITCH_DEG, curve, color=colour, label=f"figure 7: σ_R = {ratio:g} σ_x")
    roll = ROLL_DEG[ROLL_DEG >= 0.0]
    for ratio, colour in ((1.0, SERIES[0]), (10.0, SERIES[1]), (100.0, SERIES[2])):
        right.plot(roll, one_axis(ratio, np.zeros(roll.size), roll), color=colour, label=f"σ_R = {ratio:g} σ_x")
    _dress(left, "one axis over pitch", "pitch (degrees)", 6.0)
    _dress(right, "figure 8: over roll at pitch 0°", "roll (degrees)", 3.0)


def draw_loci(figure: "Figure") -> None:
    panels = figure.subplots(2, 2)
    for row, (axes, number, second) in enumerate((("xy", 9, 90.0), ("xz", 11, 0.0))):
        for column, first in enumerate((0.0, 90.0)):
            panel = panels[row, column]
            for coning, colour in ((0.1, SERIES[0]), (1.0, SERIES[1])):
                pitch, roll, value = determinant(axes, coning, (first, second))
                panel.contour(pitch, roll, value, levels=[0.0], colors=[colour])
            panel.set(
                title=f"figure {number}: {axes[0]} and {axes[1]}, A_x = {first:g}° (blue Ω = 0.1°, red 1°)",
                xlabel="pitch (degrees)", ylabel="roll (degrees)",
            )  # fmt: skip


def draw_two_axes(figure: "Figure") -> None:
    panels = figure.subplots(4, 2)
    cases = (("a", 0.1, 90.0, 1.0), ("b", 0.1, 90.0, 10.0), ("c", 1.0, 90.0, 10.0), ("d", 0.1, 0.0, 10.0))
    for (letter, coning, azimuth, ratio), (left, right) in zip(cases, panels, strict=True):
        for pitch, colour in zip(PITCHES_DEG, SERIES, strict=False):
            of_pitch, of_roll = by_two("xy", coning, (azimuth, 0.0), ratio, pitch)
            left.plot(ROLL_DEG, of_pitch, color=colour, label=f"α = {pitch:g}°")
            right.plot(ROLL_DEG, of_roll, color=colour)
        caption = f"figure 10({letter}): Ω = {coning:g}°, A_x = {azimuth:g}°, σ_y = {ratio:g} σ_x"
        _dress(left, f"{caption}, pitch", "roll (degrees)", 8.0)
        _dress(right, "roll", "roll (degrees)", 30.0)


def rank_of_figure_12() -> tuple[float, float]:
    """Return |det K| of three axes with Ω = 45° and A = 90°, and the least singular value within pitch ±85°."""
    k = np.stack([sensor(axis, 45.0, 90.0).k_v_per_g for axis in "xyz"])
    pitch, roll = (grid.ravel() for grid in np.meshgrid(np.linspace(-85.0, 85.0, 171), np.linspace(-180.0, 180.0, 181)))
    return float(abs(np.linalg.det(k))), float(weakest_direction(pitch, roll).min())


def weakest_direction(pitch_deg: FloatArray, roll_deg: FloatArray, coning_deg: float = 45.0) -> FloatArray:
    """Return the smallest singular value of the three outputs' slopes along the two turns, (n,)."""
    k = np.stack([sensor(axis, coning_deg, 90.0).k_v_per_g for axis in "xyz"])
    alpha, roll = np.deg2rad(pitch_deg), np.deg2rad(roll_deg)
    step = 1e-6
    by_pitch = (specific_force(alpha + step, roll) - specific_force(alpha - step, roll)) / (2.0 * step)
    by_roll = (specific_force(alpha, roll + step) - specific_force(alpha, roll - step)) / (2.0 * step)
    slopes = np.stack([by_pitch @ k.T, (by_roll / np.cos(alpha)[:, None]) @ k.T], axis=-1)
    return np.linalg.svd(slopes, compute_uv=False)[:, -1]


def draw_45(figure: "Figure") -> None:
    panel = figure.subplots()
    pitch, roll = np.meshgrid(np.linspace(-89.0, 89.0, 179), np.linspace(-180.0, 180.0, 181))
    value = weakest_direction(pitch.ravel(), roll.ravel()).reshape(pitch.shape)
    shown = panel.contourf(pitch, roll, value, levels=np.linspace(0.0, 1.0, 11), cmap="viridis")
    figure.colorbar(shown, ax=panel, label="smallest singular value (0: singular)")
    panel.set(title="figure 12: three axes, Ω = 45°, A = 90°", xlabel="pitch (degrees)", ylabel="roll (degrees)")


def draw_three_axes(figure: "Figure") -> None:
    panels = figure.subplots(4, 4)
    cases = ((13, 0.1, 10.0), (15, 1.0, 10.0), (17, 1.0, 1.0), (19, 5.0, 10.0))
    for (number, coning, ratio), row in zip(cases, panels, strict=True):
        for roll, colour in zip(ROLLS_DEG, SERIES, strict=False):
            of_pitch, of_roll = by_three(coning, ratio, PITCH_DEG, np.full(PITCH_DEG.size, roll))
            row[0].plot(PITCH_DEG, of_pitch, color=colour, label=f"R = {roll:g}°")
            row[1].plot(PITCH_DEG, of_roll, color=colour)
        over = ROLL_DEG[ROLL_DEG >= 0.0]
        for pitch, colour in zip(PITCHES_DEG, SERIES, strict=False):
            of_pitch, of_roll = by_three(coning, ratio, np.full(over.size, pitch), over)
            row[2].plot(over, of_pitch, color=colour, label=f"α = {pitch:g}°")
            row[3].plot(over, of_roll, color=colour)
        caption = f"Ω = {coning:g}°, σ_y = {ratio:g} σ_x"
        _dress(row[0], f"{number}: pitch, {caption}", "pitch (degrees)", 11.0 if ratio > 1.0 else 2.0)
        _dress(row[1], f"{number}: roll", "pitch (degrees)", 6.0)
        _dress(row[2], f"{number + 1}: pitch", "roll (degrees)", 11.0 if ratio > 1.0 else 2.0)
        _dress(row[3], f"{number + 1}: roll", "roll (degrees)", 6.0)


def _dress(panel: "Axes", title: str, along: str, highest: float) -> None:
    panel.set(title=title, xlabel=along, ylabel="σ, relative", ylim=(0.0, highest))
    if panel.get_legend_handles_labels()[0]:
        panel.legend()


PICTURES: dict[str, tuple[float, Drawing]] = {
    "tp-06-to-08.png": (3.0, draw_one_axis),
    "tp-09-and-11.png": (6.0, draw_loci),
    "tp-10.png": (9.0, draw_two_axes),
    "tp-12.png": (3.2, draw_45),
    "tp-13-to-20.png": (9.0, draw_three_axes),
}
