"""Every derivative of every model against a complex step, to 1e-12 of its largest element.

A complex step h has no difference to lose digits in: f(x + ih) = f(x) + ih f'(x) − …, so that Im f / h is exact at
h = 1e-30 (Squire & Trapp, SIAM Review 40, 1998). The derived parameters are written out here in functions that take
complex numbers, and are first held against the models' own.
"""

from collections.abc import Callable

import numpy as np
import pytest

from ams.models.accelerometer import PitchOnly
from ams.models.drifting import WithTime
from ams.models.extended import ExtendedPitchRoll
from ams.models.model import Model
from ams.models.registry import MODELS, model_named
from ams.models.remounted import Remounted
from ams.models.straight_line import StraightLine
from ams.models.thermal import TemperatureCoefficients, WithTemperature
from ams.observations import Observations

H = 1e-30
ROWS = 60
RNG = np.random.default_rng(3)
PITCH, YAW, ROLL = RNG.uniform(-1.4, 1.4, (3, ROWS)) * np.array([[1.0], [0.4], [2.0]])
RATES = RNG.uniform(-1.0, 1.0, (ROWS, 3))
KNOWN = TemperatureCoefficients(3e-5, -2e-4)
BENT = TemperatureCoefficients(3e-5, -2e-4, offset_tc2_v_per_degc2=4e-6, sensitivity_tc2_per_degc2=1e-5)
AXES = {"pitch-only": "xz"}
OWN = (0.031, -0.4, 1.9, 0.7)
CENTRING = tuple(tuple(row) for row in RNG.uniform(-1.0, 1.0, (6, 4)).tolist())
Q = (1e-3, -2e-3, 5e-4, 3e-3, -1e-3)

Derived = Callable[[np.ndarray], np.ndarray]


def named() -> dict[str, Model]:
    return {f"{name} {axis}": model_named(name, axis) for name in MODELS for axis in AXES.get(name, "xyz")}


def models() -> dict[str, Model]:
    """All of the package's, with what can be put around them."""
    found = named()
    for base in ("pitch-roll y", "pitch-only z", "pitch-yaw-roll-model x", "linear-accelerometer z"):
        found[f"{base}, temperature applied"] = WithTemperature(found[base], 20.0, KNOWN)
        found[f"{base}, temperature estimated"] = WithTemperature(found[base], 20.0)
        found[f"{base}, temperature of second order"] = WithTemperature(found[base], 20.0, estimated_order=2)
        found[f"{base}, second order applied"] = WithTemperature(found[base], 20.0, BENT)
        found[f"{base}, time"] = WithTime(found[base], 1800.0)
    found["pitch-roll x, temperature and time"] = WithTime(WithTemperature(found["pitch-roll x"], 20.0), 1800.0)
    found |= {f"terms without their linear part {axis}": ExtendedPitchRoll(axis, CENTRING) for axis in "xyz"}
    found |= {f"remounted {axis}": Remounted(axis, (1, 2)) for axis in "xyz"}
    found["straight line"] = StraightLine("x", "ut", "counts")
    return found


MODELS_HERE = models()


def rows(model: Model, **moved: np.ndarray) -> Observations:
    is_flat = isinstance(getattr(model, "base", model), PitchOnly)
    return Observations(
        replication=np.ones(ROWS, dtype=np.int64),
        point=np.arange(ROWS),
        pitch_rad=moved.get("pitch", PITCH),
        roll_rad=moved.get("roll", np.zeros(ROWS) if is_flat else ROLL),
        outputs={},
        yaw_rad=moved.get("yaw", YAW),
        temperature_degc=np.linspace(15.0, 27.0, ROWS),
        time_s=np.linspace(0.0, 3600.0, ROWS),
        euler_rate_rad_s=RATES,
        reference_level=np.linspace(-50.0, 50.0, ROWS),
        mounting=np.repeat([1, 2, 3], ROWS // 3),
    )


def primary_of(model: Model) -> np.ndarray:
    sizes = {"offset_tc_v_per_degc": 3e-5, "sensitivity_tc_per_degc": -2e-4, "offset_drift_v_per_h": 4e-5}
    sizes |= dict(zip((n for n in model.primary_names if n.startswith("q_")), Q, strict=False))
    own = iter((*OWN, 0.02, -0.03, 0.01, 0.04))
    return np.array([sizes[name] if name in sizes else next(own) for name in model.primary_names])


def agree(given: np.ndarray, exact: np.ndarray) -> None:
    np.testing.assert_allclose(given, exact, rtol=1e-12, atol=1e-12 * max(float(np.abs(exact).max()), 1e-300))


@pytest.mark.parametrize("name", MODELS_HERE)
def test_derivatives_by_the_parameters_are_those_of_a_complex_step(name: str) -> None:
    model, here = MODELS_HERE[name], rows(MODELS_HERE[name])
    primary = primary_of(model)
    if model.fixed:
        primary[-2:] = (KNOWN.offset_tc_v_per_degc, KNOWN.sensitivity_tc_per_degc)
    steps = [np.imag(model.predict(primary + 1j * H * unit, here)) / H for unit in np.eye(primary.size)]
    agree(model.jacobian(primary, here), np.stack(steps, axis=1))


@pytest.mark.parametrize("name", MODELS_HERE)
def test_derivatives_by_the_angles_are_those_of_a_complex_step(name: str) -> None:
    model = MODELS_HERE[name]
    primary, here = primary_of(model), rows(MODELS_HERE[name])
    for angle, slope in model.angle_jacobian(primary, here).items():
        still = angle == "roll" and not np.any(here.roll_rad)
        at = getattr(here, f"{angle}_rad")
        exact = np.zeros(ROWS) if still else np.imag(model.predict(primary, rows(model, **{angle: at + 1j * H}))) / H
        agree(slope, exact)


def turned(axis: str, k: np.ndarray) -> np.ndarray:
    """S, Ω and A (degrees) of k; the quarter of A that arctan does not know has no derivative."""
    i, j, m = ("xyz".index(axis) + index for index in range(3))
    along, first, second = k[i], k[j % 3], k[m % 3]
    sign = np.sign(along.real)
    across = np.sqrt(first**2 + second**2)
    quarter = np.pi if sign * first.real < 0.0 else 0.0
    azimuth = np.arctan(second / first) + quarter
    sensitivity = sign * np.sqrt(along**2 + across**2)
    return np.array([sensitivity, np.rad2deg(1.0) * np.arctan(across / (sign * along)), np.rad2deg(1.0) * azimuth])


def of_vector(axis: str) -> Derived:
    return lambda p: np.concatenate([p[:1], turned(axis, p[1:4]), p[4:]])


def of_extended(axis: str) -> Derived:
    """With the offset once more: nothing is taken off the terms of a model that is made by its name."""
    return lambda p: np.concatenate([of_vector(axis)(p), p[:1]])


def of_pitch_only(axis: str) -> Derived:
    def derived(p: np.ndarray) -> np.ndarray:
        along, across = (p[1], p[2]) if axis == "x" else (p[2], -p[1])
        length = np.sign(along.real) * np.sqrt(along**2 + across**2)
        return np.array([p[0], length, np.rad2deg(1.0) * np.arctan(across / along)])

    return derived


def of_line(_axis: str) -> Derived:
    return lambda p: np.array([1.0 / p[1], -p[0] / p[1]])


DERIVED = {
    "pitch-only": of_pitch_only,
    "pitch-roll-extended": of_extended,
    "linear-accelerometer": of_line,
    "linear": of_line,
}


@pytest.mark.parametrize("name", named())
@pytest.mark.parametrize("polarity", [1.0, -1.0])
def test_derivatives_of_the_derived_parameters_are_those_of_a_complex_step(name: str, polarity: float) -> None:
    model = MODELS_HERE[name]
    derived = DERIVED.get(model.name, of_vector)(model.nominal_axis)
    primary = polarity * primary_of(model)
    turns = (derived(primary + 0j).real - model.parameters(primary)) / 90.0
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-12, err_msg="not the same function")
    steps = [derived(primary + 1j * H * unit).imag / H for unit in np.eye(primary.size)]
    agree(model.parameters_jacobian(primary), np.stack(steps, axis=1))


@pytest.mark.parametrize("axis", "xyz")
def test_derivatives_of_earlier_mountings_are_those_of_a_complex_step(axis: str) -> None:
    model = Remounted(axis, (1, 2))
    primary = primary_of(model)

    def derived(p: np.ndarray) -> np.ndarray:
        mounted = [model._mounted(p, location)[1:] for location in (0, 1)]
        return np.concatenate([p[:1], turned(axis, p[1:4]), *(turned(axis, k)[1:] for k in mounted)])

    steps = [derived(primary + 1j * H * unit).imag / H for unit in np.eye(primary.size)]
    agree(model.parameters_jacobian(primary), np.stack(steps, axis=1))


def test_what_is_put_around_a_model_leaves_its_derived_parameters_alone() -> None:
    base = MODELS_HERE["pitch-roll x"]
    model = MODELS_HERE["pitch-roll x, temperature and time"]
    primary = primary_of(model)
    found = model.parameters_jacobian(primary)
    np.testing.assert_array_equal(found[:4, :4], base.parameters_jacobian(primary[:4]))
    order = [model.parameter_names.index(name) for name in model.primary_names[4:]]
    np.testing.assert_array_equal(found[np.ix_(order, [4, 5, 6])], np.eye(3))
