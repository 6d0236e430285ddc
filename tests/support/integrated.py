"""Rates integrated by the scan that streams run, fed once and finished."""

import numpy as np

from ams.attitude.gyro import cr_angles_rad, quaternion_of_cr
from ams.attitude.rate_scan import Interpolation, Path, RatePath, RateScan


def integrated(
    rates_rad_s: np.ndarray,
    start: np.ndarray,
    interval_s: float,
    interpolation: Interpolation = "cubic",
    path: Path | None = None,
) -> RatePath:
    """Return the attitudes at all of (3, N) samples from the quaternion at the first."""
    scan = RateScan(start, interval_s, interpolation, path)
    first, last = scan.feed(rates_rad_s), scan.finish()
    return RatePath(
        np.concatenate([first.quaternion, last.quaternion], axis=1),
        np.concatenate([first.is_bridged, last.is_bridged]),
        np.concatenate([first.bridged_samples, last.bridged_samples]),
    )


def cr_angles(
    body_rate_rad_s: np.ndarray,
    start_rad: np.ndarray,
    interval_s: float,
    interpolation: Interpolation = "cubic",
    path: Path | None = None,
) -> np.ndarray:
    """Return pitch, yaw and roll, (N, 3), from (N, 3) rates in model axes and the angles at the first sample."""
    found = integrated(body_rate_rad_s.T, quaternion_of_cr(start_rad), interval_s, interpolation, path)
    return np.asarray(cr_angles_rad(found.quaternion, start_rad).T)
