"""Which terms beside the linear sensor the points show: each by itself, in the notation of IEEE Std 1293.

K₂ a_i², K_ip a_i a_p, K_io a_i a_o, K_po a_p a_o, K_pp − K_oo, K₃ a_i³, K₀′ sgn(a_i) and K₁′ |a_i|, i the nominal
axis and p and o those that follow it. K₂ is tested as a_i² less its mean over the sphere: at rest the three squares add
up to one. K₀′ and K₃, K₁′ and K₂ are nearly collinear over most designs, so each term is tested alone, with the power
that all together do not have; where one is significant it counts as known, and the others are tested beside it.

A gyro has K₂, K₃ and K₁′ of its rate about the nominal axis: nonlinearity and asymmetry of its scale factor as IEEE Std
528 has them, told in parts per million of the output at the largest rate, K₁′ of the scale factor itself.
"""

from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.finding_kinds import FindingKind
from ams.frames import specific_force
from ams.observations import Observations
from ams.remembered import remembered
from ams.solve.layout import Layout

_ORDER: Final = {"x": "xyz", "y": "yzx", "z": "zxy"}
TERMS: Final[tuple[tuple[str, FindingKind, str, str], ...]] = (
    ("K2", "quadratic", "K₂", "V/g²"),
    ("Kpp", "quadratic", "K_pp − K_oo", "V/g²"),
    ("Kip", "cross-coupling", "K_ip", "V/g²"),
    ("Kio", "cross-coupling", "K_io", "V/g²"),
    ("Kpo", "cross-coupling", "K_po", "V/g²"),
    ("K3", "cubic", "K₃", "V/g³"),
    ("K0'", "asymmetry", "K₀′", "V"),
    ("K1'", "asymmetry", "K₁′", "V/g"),
)
"""Name, kind of finding, symbol, unit of its coefficient."""
SYMBOLS: Final = {name: symbol for name, _, symbol, _ in TERMS}
IN_WORDS: Final = {
    "K2": "the output bends with the square of the acceleration along the axis",
    "Kpp": "the output takes the difference of the squares of the accelerations across the axis",
    "Kip": "the output takes the product of the accelerations along and across the axis",
    "Kio": "the output takes the product of the accelerations along and across the axis",
    "Kpo": "the output takes the product of the two accelerations across the axis",
    "K3": "the output bends with the third power of the acceleration along the axis, as one that begins to saturate",
    "K0'": "the offset differs between positive and negative acceleration",
    "K1'": "the sensitivity differs between positive and negative acceleration",
}


OF_GYROS: Final = ("K2", "K3", "K1'")
"""Names of the terms that a gyro is tested for."""
PPM: Final = "ppm"
GYROS_IN_WORDS: Final = {
    "K2": "nonlinearity of the scale factor: the output bends with the square of the rate",
    "K3": "nonlinearity of the scale factor: the output bends with the third power of the rate",
    "K1'": "asymmetry of the scale factor: it differs between the two senses of rotation",
}


def rate_columns(velocity_dps: FloatArray, nominal_axis: str, sensitivity_v_per_dps: float) -> FloatArray:
    """Return the (K, 8) terms of a gyro at (K, 3) angular velocity, in the order of ``TERMS``, volts a ppm."""
    along = velocity_dps[:, "xyz".index(nominal_axis)]
    largest = float(np.abs(along).max(initial=0.0))
    part = np.where(np.abs(along) > _STILL * largest, along, 0.0) / (largest or 1.0)
    columns = {"K2": part**2, "K3": part**3, "K1'": 0.5 * np.abs(part)}
    nothing = np.zeros_like(part)
    scale = 1e-6 * sensitivity_v_per_dps * largest
    return np.stack([scale * columns.get(name, nothing) for name, *_ in TERMS], axis=1)


def term_columns(force: FloatArray, nominal_axis: str) -> FloatArray:
    """Return the (K, 8) terms at (K, 3) specific force, in the order of ``TERMS``.

    A term that no attitude of the design excites is zero, not what rounding leaves of it.
    """
    acceleration = np.where(np.abs(force) > _ZERO, force, 0.0)
    along, after, last = (acceleration[:, "xyz".index(axis)] for axis in _ORDER[nominal_axis])
    return np.stack(
        [
            along**2 - 1.0 / 3.0,
            0.5 * (after**2 - last**2),
            along * after,
            along * last,
            after * last,
            along**3,
            0.5 * np.sign(along),
            0.5 * np.abs(along),
        ],
        axis=1,
    )


@remembered(16)
def term_columns_at(pitch_rad: FloatArray, roll_rad: FloatArray, nominal_axis: str) -> FloatArray:
    """Return the (K, 8) terms at (K,) attitudes."""
    return term_columns(specific_force(pitch_rad, roll_rad), nominal_axis)


def squareness_of_points(rows: Observations, layout: Layout, nominal_axis: str, primary: FloatArray) -> FloatArray:
    """Return the (K,) mean volts a radian by which the roll axis lies off the right angle to the pitch axis.

    It is turned about the vertical of the pitched plate, so that gravity along that axis, sin α, shows across it: an
    output along x sees none of it, and none is told. Near level it looks like K_po.
    """
    if nominal_axis == "x":
        return np.zeros(layout.points)
    return np.asarray(_across(layout, rows.pitch_rad, rows.roll_rad) @ primary[2:4])


@remembered(16)
def _across(layout: Layout, pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    across = np.sin(pitch_rad)
    return layout.mean_by_point(np.stack([across * np.cos(roll_rad), -across * np.sin(roll_rad)], axis=1))


_STILL: Final = 1e-3
"""Of the largest rate: what a table at rest, and the Earth, turn by."""
_ZERO: Final = 1e-9
"""Of g: what a rounded angle leaves of no acceleration."""
