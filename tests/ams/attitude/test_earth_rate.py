"""The Earth's turn taken off, against explicit rotations of scipy."""

import numpy as np
import pytest
from integrated import integrated
from scipy.spatial.transform import Rotation

from ams.attitude.earth_rate import EARTH_RATE_RAD_S, EarthRate
from ams.attitude.gyro import quaternion_of_cr
from ams.errors import ObservationsError


@pytest.mark.parametrize(
    ("latitude_deg", "heading_deg", "axes"),
    [(90.0, 0.0, (0.0, 0.0, -1.0)), (0.0, 0.0, (1.0, 0.0, 0.0)), (0.0, 90.0, (0.0, -1.0, 0.0))],
)
def test_the_share_of_each_axis_is_that_of_the_place(
    latitude_deg: float, heading_deg: float, axes: tuple[float, float, float]
) -> None:
    """At the north pole the Earth turns up, against z; at the equator along north: left of an x that looks east."""
    assert EarthRate(latitude_deg, heading_deg).rate_rad_s / EARTH_RATE_RAD_S == pytest.approx(axes, abs=1e-12)


def test_a_package_that_rests_for_a_day_rests_and_one_that_turns_is_where_scipy_says() -> None:
    earth, interval_s = EarthRate(37.09, 25.0), 60.0
    time_s = np.arange(1441) * interval_s
    start = quaternion_of_cr(np.deg2rad([10.0, -20.0, 30.0]))
    at_rest = Rotation.from_quat(start).inv().apply(earth.rate_rad_s)
    path = integrated(np.repeat(at_rest[:, None], time_s.size, axis=1), start, interval_s, "cubic")
    found = Rotation.from_quat(earth.against_earth(path.quaternion, time_s).T)
    assert (found * Rotation.from_quat(start).inv()).magnitude().max() < 1e-9
    own = 1e-4 * np.array([0.3, -1.0, 0.5])  # a turn of its own about a fixed direction of the Earth
    attitude = Rotation.from_rotvec(time_s[:, None] * own) * Rotation.from_quat(start)
    read = attitude.inv().apply(earth.rate_rad_s + own)
    path = integrated(read.T, start, interval_s, "cubic")
    found = Rotation.from_quat(earth.against_earth(path.quaternion, time_s).T)
    assert (found * attitude.inv()).magnitude().max() < 1e-7


def test_no_place_on_earth_is_refused() -> None:
    with pytest.raises(ObservationsError, match="got latitude 91° and heading 0°"):
        EarthRate(91.0, 0.0)
