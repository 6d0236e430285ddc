"""What of force and field is wrong alike in all rows, and turns an attitude that leans on them by as much.

A filter takes the errors of forces and fields as new in every row, and its covariance falls with the rows. What the
calibrations leave open, what the sets count of shifts since, and what disturbs the field or is wrong with the stated
one, is the same in all rows of an attitude: the estimate settles where force and field, each by its weight in the
filter, are least contradicted, whatever its covariance is by then. Source: TP (52), (73).
"""

from collections.abc import Mapping

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.attitude_filter import FilterSettings
from ams.attitude.kalman import known_direction
from ams.attitude.rate_errors import rotation_matrices
from ams.attitude.three_axes import blocks
from ams.inference.gyros.field_aid import FieldAid
from ams.inference.inference import Package
from ams.inference.package.calibrated import as_package


def turn_by_lasting_errors(
    accelerometers: Package,
    field: FieldAid | None,
    settings: FilterSettings,
    quaternion: FloatArray,
    readings: Mapping[str, FloatArray],
) -> FloatArray:
    """Return the (n, 3, 3) covariance of the turn of (4, n) attitudes, in reference axes, by lasting errors.

    ``settings``: the directions and weights of the filter. Without a field nothing holds the yaw, which is not in it.
    """
    found = np.zeros((quaternion.shape[1], 3, 3))
    by_force, by_field = _turns(settings)
    for block in blocks(len(found)):
        rotation = rotation_matrices(quaternion[:, block])
        of_rows = {name: values[block] for name, values in readings.items()}
        found[block] = _turned(by_force @ rotation, lasting_covariance(accelerometers, -rotation[:, 2, :], of_rows))
        if field is not None:
            sensed_ut = np.asarray(field.reference_ut) @ rotation
            covariance_ut2 = lasting_covariance(field.package, sensed_ut, of_rows) + field.sd_ut**2 * np.eye(3)
            found[block] += _turned(by_field @ rotation, covariance_ut2)
    return found


def lasting_covariance(package: Package, sensed: FloatArray, readings: Mapping[str, FloatArray]) -> FloatArray:
    """Return the (n, 3, 3) covariance, in package axes, that the calibration leaves open at (n, 3) forces or fields.

    A row without the temperature that the set needs counts as its neighbours do.
    """
    sensors = package.sensors(readings, 0.0)
    parts = as_package(sensors, package.together(sensors)).output_parts(sensed)
    covariance_v2 = np.sum([part for part, _ in parts], axis=0)
    is_known = np.isfinite(covariance_v2).all(axis=(1, 2))
    if not is_known.all():
        covariance_v2[~is_known] = covariance_v2[is_known].mean(axis=0) if is_known.any() else 0.0
    inverse = np.linalg.pinv(np.stack([sensor.k_v_per_g for sensor in sensors]))
    return np.asarray(inverse @ covariance_v2 @ inverse.T)


def _turns(settings: FilterSettings) -> tuple[FloatArray, FloatArray]:
    """Return the (3, 3) turns in reference axes per g of force and per µT of field, zero without one.

    The estimate rests where the corrections add up to nothing, Σ Hᵀ(H φ + e)/s² = 0.
    """
    of_force = known_direction(np.asarray(settings.force_reference_g), settings.force_sd_g)
    H = of_force.H[:, :3]
    weighed = H.T / of_force.sd**2
    if settings.field_reference_ut is None or settings.field_sd_ut is None:
        return np.asarray(-np.linalg.pinv(weighed @ H) @ weighed, dtype=float), np.zeros((3, 3))
    of_field = known_direction(np.asarray(settings.field_reference_ut), settings.field_sd_ut)
    H_field = of_field.H[:, :3]
    weighed_field = H_field.T * (settings.field_share / of_field.sd**2)
    together = weighed @ H + weighed_field @ H_field
    turns = np.asarray(-np.linalg.solve(together, np.hstack([weighed, weighed_field])), dtype=float)
    return turns[:, :3], turns[:, 3:]


def _turned(turn: FloatArray, covariance: FloatArray) -> FloatArray:
    return np.asarray(turn @ covariance @ np.swapaxes(turn, 1, 2))
