"""What a sensor truly is: offset, vector of sensitivities, its second and third order, its temperature coefficients.

All arrays have the shape (n, S, A): campaigns, sensors, axes of each. n, S or A may be 1 where all share one value.
"""

from dataclasses import dataclass

import numpy as np

from physics_scenes.designs import Setup
from physics_scenes.rotations import FloatArray, random_directions, sensitive_axis, specific_force

REFERENCE_DEGC = 20.0
NOMINAL_V_PER_G = 2.5


@dataclass(frozen=True)
class Package:
    """The truth of n campaigns of S sensors with A axes.

    e/S = K₀ + a_i + f·q·f + K₃a_i³ + ½K₀′sgn(a_i) + ½K₁′|a_i|, f in package axes in local g, a_i = u·f, k = S·u.
    The letters are those of IEEE Std 1293's model equation; what is left of it is in q.
    """

    axes: str
    offset_v: FloatArray
    vector_v_per_g: FloatArray
    """(n, S, A, 3): k = S·u"""
    q_per_g: FloatArray | None = None
    """(n, S, A, 3, 3), symmetric, against S; its trace is part of the physics and acts as an offset."""
    cubic_per_g2: FloatArray | float = 0.0
    offset_asymmetry_g: FloatArray | float = 0.0
    gain_asymmetry: FloatArray | float = 0.0
    offset_tc_v_per_degc: FloatArray | float = 0.0
    sensitivity_tc_per_degc: FloatArray | float = 0.0
    offset_tc2_v_per_degc2: FloatArray | float = 0.0
    sensitivity_tc2_per_degc2: FloatArray | float = 0.0

    @property
    def sensitivity_v_per_g(self) -> FloatArray:
        """(n, S, A)"""
        return np.linalg.norm(self.vector_v_per_g, axis=-1)

    @property
    def axis_direction(self) -> FloatArray:
        """(n, S, A, 3): u"""
        return self.vector_v_per_g / self.sensitivity_v_per_g[..., None]

    @property
    def traceless_offset_v(self) -> FloatArray:
        """Offset when the second order is written with tr Q = 0: at rest |f| = 1, and the trace is a constant."""
        if self.q_per_g is None:
            return self.offset_v
        return self.offset_v + self.sensitivity_v_per_g * np.trace(self.q_per_g, axis1=-2, axis2=-1) / 3.0

    def response_v(self, force_g: FloatArray, sensor_degc: FloatArray | float = REFERENCE_DEGC) -> FloatArray:
        """Return the output (n, D, S, A) without noise for specific forces (n, D, S, 3) and temperatures (n, D, S).

        The sign of S stands in u: an output is S·(K₀ + a_i + …) with S > 0.
        """
        along = dotted(force_g, self.axis_direction[:, None])
        shaped = along
        if self.q_per_g is not None:
            columns = [dotted(force_g, self.q_per_g[:, None, ..., column]) for column in range(3)]
            shaped = shaped + sum(column * force_g[..., None, i] for i, column in enumerate(columns))
        if np.any(self.cubic_per_g2):
            shaped = shaped + _on_dwells(self.cubic_per_g2) * along**3
        if np.any(self.offset_asymmetry_g):
            shaped = shaped + 0.5 * _on_dwells(self.offset_asymmetry_g) * np.sign(along)
        if np.any(self.gain_asymmetry):
            shaped = shaped + 0.5 * _on_dwells(self.gain_asymmetry) * np.abs(along)
        above = np.asarray(sensor_degc, dtype=np.float64) - REFERENCE_DEGC
        above = above[..., None] if above.ndim else above
        linear, square = _on_dwells(self.sensitivity_tc_per_degc), _on_dwells(self.sensitivity_tc2_per_degc2)
        gain = self.sensitivity_v_per_g[:, None] * (1.0 + linear * above + square * above**2)
        warmed = _on_dwells(self.offset_tc_v_per_degc) * above + _on_dwells(self.offset_tc2_v_per_degc2) * above**2
        return self.offset_v[:, None] + warmed + gain * shaped

    def output_v(self, pitch_deg: FloatArray, roll_deg: FloatArray, sensor_degc: float = REFERENCE_DEGC) -> FloatArray:
        """Return the true output (n, D, S, A) at true attitudes (D,): what a prediction interval has to cover."""
        return self.response_v(specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))[None, :, None], sensor_degc)

    def best_linear(self, pitch_deg: FloatArray, roll_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return offset (n, S, A) and k (n, S, A, 3) of the linear sensor closest to this one over a design.

        Without roll the component along y is not seen: the shortest solution leaves it at zero.
        """
        force = specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
        basis = np.concatenate([np.ones((force.shape[0], 1)), force], axis=1)
        solved = np.einsum("jd,ndsa->nsaj", np.linalg.pinv(basis), self.output_v(pitch_deg, roll_deg))
        return solved[..., 0], solved[..., 1:]


def draw_package(setup: Setup, campaigns: int, chance: np.random.Generator) -> Package:
    """Draw ordinary sensors: 2.5 V/g within 1 %, offsets of 10 mV, coned by up to 1° to any side."""
    shape = (campaigns, setup.sensors, len(setup.axes))
    sensitivity = NOMINAL_V_PER_G * (1.0 + 0.01 * chance.uniform(-1.0, 1.0, shape))
    coning, azimuth = np.deg2rad(chance.uniform(0.05, 1.0, shape)), chance.uniform(-np.pi, np.pi, shape)
    offset = 0.01 * chance.standard_normal(shape)
    return Package(setup.axes, offset, coned_vectors(setup.axes, sensitivity, coning, azimuth))


def coned_vectors(axes: str, sensitivity: FloatArray, coning_rad: FloatArray, azimuth_rad: FloatArray) -> FloatArray:
    """Return k (n, S, A, 3) of axes that lie off their nominal direction; all arguments are (n, S, A)."""
    units = [sensitive_axis(axis, coning_rad[..., i], azimuth_rad[..., i]) for i, axis in enumerate(axes)]
    return sensitivity[..., None] * np.stack(units, axis=-2)


def perpendicular_directions(direction: FloatArray, chance: np.random.Generator) -> FloatArray:
    """Draw unit vectors at right angles to the given ones (..., 3), to any side."""
    drawn = random_directions(chance, *direction.shape[:-1])
    across = drawn - (drawn * direction).sum(axis=-1, keepdims=True) * direction
    return across / np.linalg.norm(across, axis=-1, keepdims=True)


def mounted_force(setup: Setup, pitch_deg: FloatArray, roll_deg: FloatArray) -> FloatArray:
    """Return the specific force (D, S, 3) in the axes of every sensor at attitudes of the plate (D,)."""
    force = specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
    return np.einsum("sij,dj->dsi", setup.mount_matrices(), force)


def dotted(force: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return (n, D, S, A) from forces (n, D, S, 3) and vectors (n, 1 or D, S, A, 3), component by component."""
    total = force[..., None, 0] * vectors[..., 0]
    for i in (1, 2):
        total = total + force[..., None, i] * vectors[..., i]
    return total


def _on_dwells(value: FloatArray | float) -> FloatArray:
    """(n, S, A) to (n, 1, S, A)."""
    array = np.asarray(value, dtype=np.float64)
    return array[:, None] if array.ndim == 3 else array
