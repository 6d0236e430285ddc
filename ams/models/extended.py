"""The extended model: v = b + k·f + Σ q h̃(f), the terms of second and third order that every sensor has a little of.

h are the five elements of fᵀQf with tr Q = 0, f the specific force in package axes, and K₃f_i³ along the nominal axis.
fᵀQf is what a soft mount inside the package does (TP's figures 37 to 41), and K₂, K_ip, K_io, K_po of IEEE Std 1293;
at rest |f| = 1, so that tr Q acts as an offset and is left to it. K₃ is a magnet or an amplifier that begins to
saturate.

h̃ is h without its best linear approximation over the design, h̃ = h − (1, f)·c with the row c of ``centring``. So b
and k are those of the linear sensor that comes closest to this one over the points, and keep the intervals of a fit
without these terms, whether the terms are there or not; predictions pay for them. The offset with tr Q = 0 and
nothing taken off is stated beside b. A test that lets terms in where they are significant leaves 16 to 88 % coverage
near its threshold; the whole model always 94 to 96 %.

A roll-free sin 2α is also what a table axis does and a roll-free cos 2α what droop does: only a reversed mount tells
them apart, and it is said wherever the model is reported.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import ClassVar, Final

import numpy as np

from ams.arrays import Centring, FloatArray
from ams.frames import specific_force, specific_force_by_pitch, specific_force_by_roll
from ams.models.accelerometer import PITCH_ROLL_FORM, PITCH_ROLL_SOURCE, PITCH_ROLL_TEXT, PitchRoll
from ams.models.leverage import LEAST_LEVER, attitudes_between, least_lever
from ams.models.model import LinearModel, Stimulus
from ams.models.sensor_model import ACCELEROMETER_TEXT, SYMBOLS_TEXT, Equation, LowOrder, SensorModel
from ams.remembered import remembered

Q_NAMES: Final = ("q_xx_v_per_g2", "q_xy_v_per_g2", "q_xz_v_per_g2", "q_yy_v_per_g2", "q_yz_v_per_g2")
"""Elements of the symmetric Q; q_zz = −q_xx − q_yy."""
CUBIC_NAME: Final = "k3_v_per_g3"
TERM_NAMES: Final = (*Q_NAMES, CUBIC_NAME)
TRACELESS_NAME: Final = "offset_traceless_v"
"""The offset of the model written with h instead of h̃."""
CONFOUNDED: Final = (
    "a roll-free sin 2α may belong to the table's pitch axis and a roll-free cos 2α to droop of the table: "
    "only a second calibration with the package mounted the other way round tells them from the package"
)
LEAST_LEFT: Final = 3
"""Points that must be left over, for the terms to stand in a fit."""

_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}
_DETERMINED: Final = 1e-6
"""Of the longest column: what is left of it across the others."""
_EXCITED: Final = 1e-4
"""Of their lengths: what is left of the terms across the linear sensor, as singular values. It is twenty arc seconds:
what the table's listed errors turn a design by, or a reference of attitude reads beside it, excites no term."""


def quadratic_basis(force: FloatArray) -> FloatArray:
    """Return the (…, 5) derivatives of fᵀQf by the elements of ``Q_NAMES``, for (…, 3) specific force."""
    x, y, z = np.moveaxis(force, -1, 0)
    return np.stack([x * x - z * z, 2 * x * y, 2 * x * z, y * y - z * z, 2 * y * z], axis=-1)


def matrix_from_elements(q: FloatArray) -> FloatArray:
    """Return the (3, 3) symmetric traceless Q from its five elements in the order of ``Q_NAMES``."""
    xx, xy, xz, yy, yz = q
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, -xx - yy]])


def term_basis(force: FloatArray, nominal_axis: str) -> FloatArray:
    """Return the (…, 6) h, in the order of ``TERM_NAMES``."""
    cubic = force[..., "xyz".index(nominal_axis), None] ** 3
    return np.concatenate([quadratic_basis(force), cubic], axis=-1)


def centred_basis(force: FloatArray, nominal_axis: str, centring: Centring) -> FloatArray:
    """Return the (…, t) h̃: as many of the terms as ``centring`` has rows."""
    return np.asarray(term_basis(force, nominal_axis)[..., : len(centring)] - linear_part(force) @ np.array(centring).T)


def centring_of(stimulus: Stimulus, points: int, nominal_axis: str) -> Centring | None:
    """Return the best linear approximations of the terms over the rows: of all six, or of the five of Q.

    None where the points do not determine these beside the linear sensor and leave something over.
    """
    return _centring(stimulus.pitch_rad, stimulus.roll_rad, points, nominal_axis)


@remembered(32)
def _centring(pitch_rad: FloatArray, roll_rad: FloatArray, points: int, nominal_axis: str) -> Centring | None:
    return centring_over(specific_force(pitch_rad, roll_rad), points, nominal_axis)


def centring_over(force: FloatArray, points: int, nominal_axis: str) -> Centring | None:
    """Return the same over (N, 3) forces, whichever way the package was mounted at each.

    None too where the points have the terms by chance alone (:mod:`ams.models.leverage`).
    """
    linear, terms = linear_part(force), term_basis(force, nominal_axis)
    if points < linear.shape[1]:
        return None
    q, r = np.linalg.qr(linear)
    if np.abs(np.diag(r)).min() < _DETERMINED * np.linalg.norm(r):
        return None
    rows = np.linalg.solve(r, q.T @ terms).T
    length = np.linalg.norm(terms, axis=0)
    left = (terms - linear @ rows.T) / np.where(length > _DETERMINED * length.max(), length, np.inf)
    squares = left.T @ left
    for count in (len(TERM_NAMES), len(Q_NAMES)):
        smallest = float(np.linalg.eigvalsh(squares[:count, :count])[0])
        has_rows_left = points >= linear.shape[1] + count + LEAST_LEFT
        if has_rows_left and smallest > _EXCITED**2 and _lever(force, nominal_axis, rows[:count]) > LEAST_LEVER:
            return tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in rows[:count])
    return None


def _lever(force: FloatArray, nominal_axis: str, rows: FloatArray) -> float:
    """Return how much of the terms there is at (N, 3) forces, of what there is of them between these."""
    centring = tuple(map(tuple, rows.tolist()))
    at_points, between = (centred_basis(where, nominal_axis, centring) for where in (force, attitudes_between(force)))
    return least_lever(at_points, between)


def slope_of_terms(terms: FloatArray, force: FloatArray, nominal_axis: str, centring: Centring) -> FloatArray:
    """Return the (…, 3) derivatives of Σ q h̃ by the components of the (…, 3) specific force."""
    slope = 2.0 * force @ matrix_from_elements(terms[: len(Q_NAMES)]) - terms @ np.array(centring)[:, 1:]
    if len(terms) > len(Q_NAMES):
        along = "xyz".index(nominal_axis)
        slope[..., along] += 3.0 * terms[len(Q_NAMES)] * force[..., along] ** 2
    return np.asarray(slope)


def linear_part(force: FloatArray) -> FloatArray:
    """Return the (…, 4) basis of v = b + k·h at the (…, 3) field."""
    return np.concatenate([np.ones((*force.shape[:-1], 1)), force], axis=-1)


@remembered(8)
def _basis(nominal_axis: str, centring: Centring, pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    force = specific_force(pitch_rad, roll_rad)
    return np.concatenate([linear_part(force), centred_basis(force, nominal_axis, centring)], axis=1)


@dataclass(frozen=True)
class ExtendedPitchRoll(LinearModel):
    """TP's model with roll and the low-order terms beside it."""

    nominal_axis: str
    centring: Centring
    """(t, 4) what is taken off each term, t = 5 without the cubic one, else 6."""
    name: ClassVar[str] = "pitch-roll-extended"
    convention: ClassVar[str] = "TP"
    measured_unit: ClassVar[str] = "v"
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED

    @property
    def term_names(self) -> tuple[str, ...]:
        return TERM_NAMES[: len(self.centring)]

    @cached_property
    def primary_names(self) -> tuple[str, ...]:
        return (*PitchRoll.primary_names, *self.term_names)

    @cached_property
    def parameter_names(self) -> tuple[str, ...]:
        return (*PitchRoll.parameter_names, *self.term_names, TRACELESS_NAME)

    @property
    def basis_key(self) -> Hashable:
        return self.name, self.nominal_axis, self.centring

    def basis(self, stimulus: Stimulus) -> FloatArray:
        return _basis(self.nominal_axis, self.centring, stimulus.pitch_rad, stimulus.roll_rad)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        pitch, roll = stimulus.pitch_rad, stimulus.roll_rad
        force = specific_force(pitch, roll)
        slope = primary[1:4] + slope_of_terms(primary[4:], force, self.nominal_axis, self.centring)
        return {
            "pitch": np.sum(specific_force_by_pitch(pitch, roll) * slope, axis=-1),
            "roll": np.sum(specific_force_by_roll(pitch, roll) * slope, axis=-1),
        }

    def parameters(self, primary: FloatArray) -> FloatArray:
        found = np.empty((*primary.shape[:-1], primary.shape[-1] + 1))
        found[..., :4], found[..., 4:-1] = self._linear.parameters(primary[..., :4]), primary[..., 4:]
        found[..., -1] = primary[..., 0] - primary[..., 4:] @ self._traces
        return found

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        rows = self._of_terms.copy()
        rows[:4, :4] = self._linear.parameters_jacobian(primary[:4])
        return rows

    @cached_property
    def _linear(self) -> PitchRoll:
        return PitchRoll(self.nominal_axis)

    @cached_property
    def _of_terms(self) -> FloatArray:
        """(t + 5, t + 4) derivatives of the parameters, those of the linear sensor left as ones."""
        return np.vstack([np.eye(4 + self._traces.size), [1.0, 0.0, 0.0, 0.0, *-self._traces]])

    @cached_property
    def _traces(self) -> FloatArray:
        """(t,) what each term adds to the offset of the best linear sensor."""
        return np.array([constant for constant, *_ in self.centring])

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        return self._linear.undetermined(primary[:4], covariance[:4, :4])


@lru_cache(32)
def extended_model(nominal_axis: str, centring: Centring) -> ExtendedPitchRoll:
    """Return the model of an axis, one and the same for all packages that were measured at the same points."""
    return ExtendedPitchRoll(nominal_axis, centring)


_QUADRATIC_TEXT = (
    " + q_xx_v_per_g2*(f_x^2 - f_z^2) + 2*q_xy_v_per_g2*f_x*f_y + 2*q_xz_v_per_g2*f_x*f_z "
    "+ q_yy_v_per_g2*(f_y^2 - f_z^2) + 2*q_yz_v_per_g2*f_y*f_z"
)


_CENTRED_TEXT = (
    "; what multiplies each coefficient of second or third order, factors of 2 included, is taken without its best "
    "linear approximation c_0 + c_x*f_x + c_y*f_y + c_z*f_z (its row of centring, in this order), so that offset_v and "
    "k are those of the linear sensor that comes closest over the points of the calibration"
)


def _equation(nominal_axis: str) -> Equation | None:
    return _with_terms(nominal_axis, _QUADRATIC_TEXT)


def _centred_equation(nominal_axis: str, terms: int) -> Equation | None:
    cubic = f" + {CUBIC_NAME}*f_{nominal_axis}^3" if terms > len(Q_NAMES) else ""
    found = _with_terms(nominal_axis, _QUADRATIC_TEXT + cubic)
    return None if found is None else replace(found, primary=found.primary + _CENTRED_TEXT)


def _with_terms(nominal_axis: str, terms: str) -> Equation | None:
    if nominal_axis not in PITCH_ROLL_TEXT:
        return None
    derived = PITCH_ROLL_TEXT[nominal_axis] + terms + SYMBOLS_TEXT + "W = coning_deg, A = azimuth_deg"
    return Equation(PITCH_ROLL_SOURCE[nominal_axis], ACCELEROMETER_TEXT + terms, derived)


def _not_centred(nominal_axis: str) -> ExtendedPitchRoll:
    """Return the model with Q alone and nothing taken off, as it stands in sets of before."""
    return ExtendedPitchRoll(nominal_axis, ((0.0, 0.0, 0.0, 0.0),) * len(Q_NAMES))


_C_QUADRATIC = (
    "(f[0] * f[0] - f[2] * f[2])",
    "2.0 * f[0] * f[1]",
    "2.0 * f[0] * f[2]",
    "(f[1] * f[1] - f[2] * f[2])",
    "2.0 * f[1] * f[2]",
)


def _c_terms(nominal_axis: str) -> tuple[str, ...]:
    index = "xyz".index(nominal_axis)
    return (*_C_QUADRATIC, f"(f[{index}] * f[{index}] * f[{index}])")


EXTENDED = SensorModel(
    name="pitch-roll-extended",
    make=_not_centred,
    set_form=replace(
        PITCH_ROLL_FORM,
        equation=_equation,
        centred_equation=_centred_equation,
        quadratic=Q_NAMES,
        low_order=LowOrder(names=TERM_NAMES, basis=term_basis, c=_c_terms),
    ),
    is_offered=False,
)
