"""What a package feels at the points of a design: the columns of every model of an accelerometer.

On a gimbal the axes are pitch, yaw, roll from outside in; the force is that of :mod:`ams.frames`.
"""

from collections.abc import Sequence

import numpy as np

from ams.arrays import FloatArray
from ams.frames import Attitude, specific_force
from ams.models.model import Model
from procedures.plan.designs import Design, DesignPoint


def package_specific_force(points: Sequence[DesignPoint], package: str = "model") -> FloatArray:
    """Return (K, 3) specific force in package axes, local g; roll does not reach a sting package."""
    stands = attitude_of(points)
    roll = stands.roll_rad if package == "model" else np.zeros_like(stands.roll_rad)
    return specific_force(stands.pitch_rad, roll, stands.yaw_rad)


def attitude_of(points: Sequence[DesignPoint]) -> Attitude:
    """Return the (K,) angles of points, radians."""
    pitch, roll, yaw = (
        np.deg2rad([getattr(point, f"{name}_deg") for point in points]) for name in ("pitch", "roll", "yaw")
    )
    return Attitude(pitch, roll, yaw)


def columns_of(model: Model, points: Sequence[DesignPoint], nominal_v_per_g: float) -> FloatArray:
    """Return (K, P) the columns of a model at rest, for a sensor of that sensitivity along its nominal axis.

    Raises: DesignError where the model cannot be asked at such attitudes.
    """
    attitude = attitude_of(points)
    if model.basis_key is not None:
        return model.basis(attitude)
    output_v = nominal_v_per_g * package_specific_force(points)[:, "xyz".index(model.nominal_axis)]
    return model.jacobian(model.start(attitude, output_v), attitude)


def equivalent_rad(points: Sequence[DesignPoint], package: str = "model") -> tuple[FloatArray, FloatArray]:
    """Return (K,) pitch and roll without yaw at which the package feels the same: a yaw is a turn of the package."""
    force = package_specific_force(points, package)
    pitch = np.arctan2(force[:, 0], np.hypot(force[:, 1], force[:, 2]))
    return pitch, np.arctan2(-force[:, 1], -force[:, 2])


def attitudes_rad(design: Design) -> tuple[FloatArray, FloatArray]:
    """(K,) pitch and roll of the points; on a gimbal those without yaw at which a model package feels the same."""
    if len(design.yaw_values_deg) > 1:
        return equivalent_rad(design.points)
    pitch, roll = ([getattr(point, key) for point in design.points] for key in ("pitch_deg", "roll_deg"))
    return np.deg2rad(np.array(pitch)), np.deg2rad(np.array(roll))
