"""What of the force is wrong alike in all rows, and turns an attitude that leans on it by as much.

A filter takes the errors of forces as new in every row, and its covariance falls with the rows. What the calibration of
the accelerometers leaves open, and what their set counts of their shifts since, is the same in all rows of an attitude:
the estimate settles where the wrong force says, whatever its covariance is by then. Source: TP (52), (73).
"""

from collections.abc import Mapping

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.kalman import Triple
from ams.attitude.rate_errors import rotation_matrices
from ams.attitude.three_axes import blocks
from ams.inference.inference import Package


def turn_by_lasting_force(
    package: Package, quaternion: FloatArray, readings: Mapping[str, FloatArray], field_ut: Triple | None
) -> FloatArray:
    """Return the (n, 3, 3) covariance of the turn of (4, n) attitudes, in reference axes, by lasting errors of force.

    ``field_ut``: the known field, by which the yaw of a tilted estimate is wrong as well; None: nothing holds the yaw.
    """
    found = np.zeros((quaternion.shape[1], 3, 3))
    by_tilt = _turn_by_force(field_ut)
    for block in blocks(len(found)):
        rotation = rotation_matrices(quaternion[:, block])
        of_rows = {name: values[block] for name, values in readings.items()}
        turn = by_tilt @ rotation
        found[block] = turn @ _covariance_g2(package, -rotation[:, 2, :], of_rows) @ np.swapaxes(turn, 1, 2)
    return found


def _turn_by_force(field_ut: Triple | None) -> FloatArray:
    """Return the (3, 3) turn in reference axes per g of an error of the force (0, 0, −1)."""
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    if field_ut is not None:
        north, east, down = field_ut
        level = north**2 + east**2
        # The field keeps its place across its level part: |h|² φ_z = B_z (h · φ).
        turn[2] = (down * north * turn[0] + down * east * turn[1]) / level if level > 0.0 else 0.0
    return turn


def _covariance_g2(package: Package, force: FloatArray, readings: Mapping[str, FloatArray]) -> FloatArray:
    """Return the (n, 3, 3) covariance of the force that the calibration leaves open at (n, 3) forces.

    A row without the temperature that the set needs counts as its neighbours do.
    """
    sensors = package.sensors(readings, 0.0)
    together = package.together(sensors)
    if together is not None:
        covariance_v2 = np.sum([part for part, _ in together.output_parts(force)], axis=0)
    else:
        variances = [np.sum([part for part, _ in sensor.calibration_parts(force)], axis=0) for sensor in sensors]
        covariance_v2 = np.stack(variances, axis=-1)[..., None] * np.eye(len(sensors))
    is_known = np.isfinite(covariance_v2).all(axis=(1, 2))
    if not is_known.all():
        covariance_v2[~is_known] = covariance_v2[is_known].mean(axis=0) if is_known.any() else 0.0
    inverse = np.linalg.pinv(np.stack([sensor.k_v_per_g for sensor in sensors]))
    return np.asarray(inverse @ covariance_v2 @ inverse.T)
