"""CR's own iteration for two packages, (IV-B.12) to (IV-B.28), in one step for all three angles: slow and separate.

Unweighted Gauss-Newton over pitch, yaw and roll themselves, which the product does not use: it turns a unit vector.
"""

import numpy as np

from ams.models.cr import model_gravity_g, sting_gravity_g


def iterate_dwell(k_sting: np.ndarray, k_model: np.ndarray, mean_v: np.ndarray, start_rad: np.ndarray) -> np.ndarray:
    """Return pitch, yaw and roll, (3,), from six outputs without offsets; ``k``: (3, 3) volts per g of gravity."""
    angles = np.asarray(start_rad, dtype=float)
    for _ in range(50):
        predicted, slopes = predict(k_sting, k_model, angles)
        step = np.linalg.solve(slopes.T @ slopes, slopes.T @ (mean_v - predicted))
        angles = angles + step
        if np.max(np.abs(step)) < 1e-12:
            return angles
    raise AssertionError(f"no convergence from {start_rad}")


def covariance_rad2(k_sting: np.ndarray, k_model: np.ndarray, angles: np.ndarray, sd_v: float) -> np.ndarray:
    """Return the (3, 3) covariance of the angles for readings that are all uncertain by ``sd_v``."""
    _, slopes = predict(k_sting, k_model, angles)
    return np.asarray(np.linalg.inv(slopes.T @ slopes) * sd_v**2)


def predict(k_sting: np.ndarray, k_model: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return six outputs and their (6, 3) derivatives by pitch, yaw and roll."""
    pitch, yaw, roll = angles
    s_p, c_p, s_y, c_y = np.sin(pitch), np.cos(pitch), np.sin(yaw), np.cos(yaw)
    gravity = sting_gravity_g(pitch, yaw)
    by_pitch = np.array([-c_p * c_y, c_p * s_y, -s_p])
    by_yaw = np.array([s_p * s_y, s_p * c_y, 0.0])
    in_model = model_gravity_g(gravity, roll)
    by_roll = np.array([0.0, in_model[2], -in_model[1]])
    sting_rows = k_sting @ np.column_stack([by_pitch, by_yaw, np.zeros(3)])
    turned = [model_gravity_g(by_pitch, roll), model_gravity_g(by_yaw, roll), by_roll]
    outputs = np.concatenate([k_sting @ gravity, k_model @ in_model])
    return outputs, np.vstack([sting_rows, k_model @ np.column_stack(turned)])
