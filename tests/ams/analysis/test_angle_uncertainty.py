"""Laws of U95: it is 1.96 times the scatter of angles that are inferred by solving the sensors' own equations."""

import numpy as np
import pytest

from ams.analysis.angle_uncertainty import ADDED, READING, KnownAxis, UsageBox, angle_uncertainties
from ams.calibration_result import VarianceComponent
from ams.frames import Attitude
from ams.models.accelerometer import PitchOnly, PitchRoll

PRIMARY = {"x": [0.01, 2.5, 0.02, -0.01], "y": [-0.02, 0.01, 2.4, 0.02], "z": [0.0, -0.02, 0.01, 2.6]}
BOX = UsageBox((np.deg2rad(-40.0), np.deg2rad(40.0)))


def _axes(reading_v: float = 2e-5) -> list[KnownAxis]:
    return [KnownAxis(PitchRoll(axis), np.array(primary), reading_v) for axis, primary in PRIMARY.items()]


def _component(name: str, sd: float, dof: float = np.inf, seed: int = 0) -> VarianceComponent:
    root = sd * np.random.default_rng(seed).standard_normal((12, 12)) / np.sqrt(12.0)
    return VarianceComponent(name, root @ root.T, dof)


def _solved(outputs: np.ndarray, primaries: np.ndarray, start: np.ndarray) -> np.ndarray:
    """(n, 2) angles that give the (n, 3) outputs by the (n, 3, 4) coefficients, by Gauss-Newton on TP (2) to (5)."""
    angles = start.copy()
    for _ in range(4):
        p, r = angles.T
        force = np.stack([np.sin(p), -np.cos(p) * np.sin(r), -np.cos(p) * np.cos(r)], axis=1)
        by_p = np.stack([np.cos(p), np.sin(p) * np.sin(r), np.sin(p) * np.cos(r)], axis=1)
        by_r = np.stack([0.0 * p, -np.cos(p) * np.cos(r), np.cos(p) * np.sin(r)], axis=1)
        left = outputs - primaries[..., 0] - np.einsum("nas,ns->na", primaries[..., 1:], force)
        slopes = np.stack([np.einsum("nas,ns->na", primaries[..., 1:], by) for by in (by_p, by_r)], axis=2)
        moments = np.swapaxes(slopes, 1, 2) @ slopes
        angles += np.linalg.solve(moments, np.swapaxes(slopes, 1, 2) @ left[..., None])[..., 0]
    return angles


def test_it_is_the_scatter_of_inferred_angles() -> None:
    chance, trials, part = np.random.default_rng(3), 200, _component("table", 3e-5)
    found = angle_uncertainties(_axes(), [part], BOX)
    attitude = BOX.attitudes(is_level=False)
    exact = np.stack([PitchRoll(axis).predict(np.array(k), attitude) for axis, k in PRIMARY.items()], axis=1)
    true = np.stack([attitude.pitch_rad, attitude.roll_rad], axis=1)
    squares = np.zeros_like(true)
    for error in chance.multivariate_normal(np.zeros(12), part.covariance, trials):
        primaries = np.array(list(PRIMARY.values())) + error.reshape(3, 4)
        read = exact + 2e-5 * chance.standard_normal(exact.shape)
        squares += (_solved(read, np.broadcast_to(primaries, (len(true), 3, 4)), true) - true) ** 2 / trials
    for index, name in enumerate(("pitch", "roll")):
        assert found[name].counted == 1.0
        assert found[name].u95_rad == pytest.approx(1.96 * np.sqrt(squares[:, index].mean()), rel=0.08)


def test_the_squares_of_the_shares_add_up() -> None:
    axes = [KnownAxis(axis.model, axis.primary, 1e-5, ("k_z_v_per_g",)) for axis in _axes()]
    parts = [_component("replications", 1e-5, 3.0, 1), _component("table", 2e-5, seed=2)]
    for angle_uncertainty in angle_uncertainties(axes, parts, BOX).values():
        assert set(angle_uncertainty.shares_rad) == {"replications", "table", ADDED, READING}
        assert sum(np.sign(s) * s**2 for s in angle_uncertainty.shares_rad.values()) == pytest.approx(
            angle_uncertainty.u95_rad**2
        )
        assert angle_uncertainty.calibration_rad < angle_uncertainty.u95_rad


def test_one_axis_tells_pitch_alone_and_a_model_without_roll_is_never_asked_at_one() -> None:
    axis = KnownAxis(PitchOnly("x"), np.array([0.0, 2.5, 0.01]), 2e-5)
    nothing = VarianceComponent("table", np.zeros((3, 3)), np.inf)
    found = angle_uncertainties([axis], [nothing], BOX)
    assert set(found) == {"pitch"}
    pitch = BOX.attitudes(is_level=True).pitch_rad
    slope = PitchOnly("x").angle_jacobian(axis.primary, Attitude(pitch, 0.0 * pitch))["pitch"]
    assert found["pitch"].u95_rad == pytest.approx(1.96 * 2e-5 * np.sqrt(np.mean(1.0 / slope**2)), rel=1e-4)


def test_where_an_angle_moves_nothing_it_is_not_counted() -> None:
    """x and y alone tell no roll at ±90° of it."""
    axes = _axes()[:2]
    part = VarianceComponent("table", np.zeros((8, 8)), np.inf)
    found = angle_uncertainties(axes, [part], BOX)
    assert 0.5 < found["roll"].counted < 1.0
    assert np.isfinite(found["roll"].u95_rad)
