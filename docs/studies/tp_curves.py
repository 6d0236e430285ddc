"""TP's figures 7, 10 and 13 to 20 (standard deviations of inferred angles) redrawn, with what agrees with TP's text and
what does not.

    python docs/studies/tp_curves.py OUTPUT_FOLDER

Figures 1 to 5 and 22 to 54 are those of ``performance.py``.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from ams.attitude.static import pitch_roll_from_three, pitch_roll_from_two, pitch_with_known_roll
from ams.frames import specific_force
from ams.inference.lines import SensorLine
from ams.models.accelerometer import vector_from_angles

DEG = np.pi / 180
SIGMA = 1e-6
PITCH_DEG = np.linspace(-89.0, 89.0, 179)


def sensor(axis, coning_deg, azimuth_deg, sd):
    k = vector_from_angles(axis, 1.0, coning_deg * DEG, azimuth_deg * DEG)
    return SensorLine(0.0, k, np.zeros((4, 4)), sd)


def outputs(sensors, pitch_deg, roll_deg):
    force = specific_force(*np.broadcast_arrays(np.asarray(pitch_deg) * DEG, np.asarray(roll_deg) * DEG))
    return np.stack([force @ s.k_v_per_g for s in sensors], axis=-1)


def single_axis_curves(axis):
    """Figure 7: pitch from one axis, roll known to 1, 10 and 100 times the sensor's own uncertainty, at A = 0."""
    one = sensor("x", 1.0, 0.0, SIGMA)
    for ratio in (1, 10, 100):
        v = outputs([one], PITCH_DEG, 0.0)[:, 0]
        found = pitch_with_known_roll(one, v, np.zeros(PITCH_DEG.size), ratio * SIGMA)
        axis.plot(PITCH_DEG, found.pitch_sd_rad / SIGMA, label=f"σ_R = {ratio} σ_x")
    axis.set(title="figure 7 at A = 0°: one axis, roll known", ylim=(0, 6))


def two_axis_curves(axis):
    """Figure 10: x-y package, Ω = 0.1°, σ_y = 10 σ_x, over roll at several pitch angles."""
    pair = [sensor("x", 0.1, 90.0, SIGMA), sensor("y", 0.1, 0.0, 10 * SIGMA)]
    roll = np.linspace(-88, 88, 177)
    for pitch in (0, 20, 40, 60, 80):
        found = pitch_roll_from_two(pair, outputs(pair, np.full(roll.size, pitch), roll))
        axis.plot(roll, found.pitch_sd_rad / SIGMA, label=f"α = {pitch}°")
    axis.set(title="figure 10: x-y package", ylim=(0, 12))


def three_axis_curves(axis):
    """Figures 13 to 20: three axes, σ_y = σ_z = 10 σ_x, Ω = 0.1°, 1°, 5° at roll 90°."""
    for coning in (0.1, 1.0, 5.0):
        sensors = [
            sensor("x", coning, 90, SIGMA),
            sensor("y", coning, 0, 10 * SIGMA),
            sensor("z", coning, 0, 10 * SIGMA),
        ]
        found = pitch_roll_from_three(sensors, outputs(sensors, PITCH_DEG, np.full(PITCH_DEG.size, 90.0)))
        axis.plot(PITCH_DEG, found.pitch_sd_rad / SIGMA, label=f"Ω = {coning:g}°")
    axis.plot(PITCH_DEG, np.hypot(np.cos(PITCH_DEG * DEG), 10 * np.sin(PITCH_DEG * DEG)), ":", label="TP (108)")
    axis.set_title("figures 13 to 20: three axes, roll 90°")


def main(folder):
    figure, axes = plt.subplots(2, 2, figsize=(10, 7.5), constrained_layout=True)
    single_axis_curves(axes[0, 0])
    two_axis_curves(axes[0, 1])
    three_axis_curves(axes[1, 0])
    axes[1, 1].axis("off")
    axes[1, 1].text(0.0, 0.95, REMARKS, va="top", wrap=True, fontsize=9)
    for axis in axes.flat[:3]:
        axis.legend(fontsize=7)
        axis.set_xlabel("roll, degrees" if "10" in axis.get_title() else "pitch, degrees")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "tp_curves.svg")
    print(folder / "tp_curves.svg")


REMARKS = """Agrees with the text of TP: 15 % more at 30° than at 0° from one axis;
bounded pitch error of the x-y package near roll ±90°.

Differs: TP (108) is the spread of ordinary least squares. With the
weights that TP assumes for figures 13 to 20 pitch is better:
1/√(cos²α/σ_x² + sin²α/σ_y²).

At Ω = 5° and roll 90° pitch worsens by 34 %, where the text says
'approximately 50 percent'."""

if __name__ == "__main__":
    main(Path(sys.argv[1]))
