"""A set as a point of its sensor's history: the numbers that charts need, packed so that ten thousand are read at once.

One value holds, for each axis in the set's order, little-endian doubles: offset and k (4), their covariance (16, row by
row), and the part of it that every run draws anew (16). The document of the set remains the truth; this is its index.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ams.sets.coefficients import CoefficientSet
from ams.surveillance.characteristics import PackageNumbers, numbers_of

_DOUBLES = 4 + 16 + 16


def pack(numbers: PackageNumbers) -> bytes:
    """Return one calibration as bytes."""
    axes = len(numbers.axes)
    rows = [numbers.primary[0], numbers.covariance[0].reshape(axes, 16), numbers.scatter[0].reshape(axes, 16)]
    return np.concatenate(rows, axis=1).astype("<f8").tobytes()


def unpack(axes: Sequence[str], packed: Sequence[bytes], sensitivity_name: str) -> PackageNumbers:
    """Return the calibrations of packages with the same axes. Raises: ValueError for axes or numbers that are none."""
    if len(set(axes)) != len(axes) or not set(axes) <= set("xyz"):
        raise ValueError(f"axes of a point: got {','.join(axes)!r}, allowed are x, y and z, each once")
    count = len(packed)
    flat = np.frombuffer(b"".join(packed), dtype="<f8").reshape(count, len(axes), _DOUBLES)
    square = (count, len(axes), 4, 4)
    covariance, scatter = flat[..., 4:20].reshape(square), flat[..., 20:].reshape(square)
    return PackageNumbers(tuple(axes), flat[..., :4], covariance, scatter, sensitivity_name)


def point_row(coefficients: CoefficientSet, *, is_check: bool) -> dict[str, Any]:
    """Return the row of the table ``points``."""
    numbers = numbers_of(coefficients)
    return {
        "sha256": coefficients.sha256,
        "rig": str(coefficients.provenance["rig"]),
        "axes": ",".join(numbers.axes),
        "sensitivity_name": numbers.sensitivity_name,
        "check_sensor": is_check,
        "gravity_mps2": coefficients.gravity_mps2,
        "numbers": pack(numbers),
    }
