"""A rest at the beginning of a motion, taken as its rows come: the zeros of the gyros are then what they read in it."""

import numpy as np

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.zero_at_rest import ZeroAtRest, zero_at_rest


class RestAtStart:
    """The rows of a rest, and what they tell when it is over."""

    def __init__(self, package: GyroPackage, rest_s: float) -> None:
        self.package, self.rest_s = package, rest_s
        self.zero: ZeroAtRest | None = None
        """None before the rest is over, and without one."""
        self._outputs_v: list[FloatArray] = []
        self._taken = 0

    def take(self, outputs_v: FloatArray, interval_s: float) -> int:
        """Return how many of the (3, n) rows lie in the rest; find the zero when it is over.

        Raises: OutsideValidity where too few of them are readings.
        """
        due = round(self.rest_s / interval_s) - self._taken
        if due <= 0:
            return 0
        taken = min(due, int(outputs_v.shape[1]))
        self._outputs_v.append(outputs_v[:, :taken])
        self._taken += taken
        if taken == due:
            self._find_zero(np.concatenate(self._outputs_v, axis=1))
            self._outputs_v = []
        return taken

    def offset_v(self, frame_rate_rad_s: FloatArray) -> FloatArray:
        """Return the (3,) offsets, less what gyros at rest read of a turn of the frame, (3,) along package axes."""
        assert self.zero is not None
        bent_v = self.package.at_rest_v - self.package.offset_v
        return np.asarray(self.zero.mean_v - self.package.k_v_per_rad_s @ frame_rate_rad_s - bent_v)

    def zero_covariance(self) -> FloatArray:
        """Return the (3, 3) covariance of the rates by these offsets, gravity at other attitudes in it."""
        assert self.zero is not None
        inverse = np.linalg.inv(self.package.k_v_per_rad_s)
        return np.asarray(inverse @ self.zero.covariance_v2 @ inverse.T + self.package.force_covariance())

    def _find_zero(self, outputs_v: FloatArray) -> None:
        is_there = np.isfinite(outputs_v)
        good = outputs_v[:, is_there.all(axis=0)]
        if good.shape[1] < 2:
            counts = is_there.sum(axis=1).tolist()
            by_column = ", ".join(
                f"{count} of {column}" for column, count in zip(self.package.columns.values(), counts, strict=True)
            )
            raise OutsideValidity(
                f"{self.package.coefficients.sensor}: at rest: got {good.shape[1]} readings of all three axes in "
                f"{outputs_v.shape[1]} rows ({by_column}), needed two or more; nothing was computed; an output that "
                "repeats one number is taken as missing: see whether it is connected, or let the package rest longer"
            )
        self.zero = zero_at_rest(good, self.package.reading_sd())
