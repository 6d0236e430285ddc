"""Gyro attitude: the order of the method, the report's own profile, and what interpolation is worth."""

import numpy as np
import pytest
from integrated import cr_angles

from ams.attitude.gyro import path_by_butcher
from ams.attitude.rate_scan import path_by_turns
from ams.errors import ObservationsError, SolveError
from ams.frames import body_rates_rad_s

DEG = np.pi / 180


def report_motion(rate_hz, seconds=10.0):
    """Θ, Ψ, Φ = 10 sin 2πft degrees, f = 0.125, 0.0625, 0.25 Hz (CR IV-D)."""
    time_s = np.arange(int(seconds * rate_hz) + 1) / rate_hz
    omega = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = time_s[:, None] * omega
    euler = 10 * DEG * np.sin(phase)
    return euler, body_rates_rad_s(euler, 10 * DEG * omega * np.cos(phase))


def worst_error_deg(rate_hz, interpolation, seconds=10.0, path=path_by_turns):
    euler, body = report_motion(rate_hz, seconds)
    found = cr_angles(body, euler[0], 1 / rate_hz, interpolation, path)
    return np.max(np.abs(found - euler)) / DEG


def test_interpolation_is_worth_what_the_specification_says():
    assert worst_error_deg(100, "hold") == pytest.approx(0.16, abs=0.005)
    assert worst_error_deg(100, "linear") == pytest.approx(0.00024, abs=0.00001)
    assert worst_error_deg(100, "cubic") < 1e-7


def test_the_closed_form_is_met_to_a_billionth_of_a_degree_at_one_kilohertz():
    assert worst_error_deg(1000, "cubic", 100.0) < 1e-9


@pytest.mark.parametrize("interpolation", ["hold", "linear", "cubic"])
def test_the_scan_and_butchers_method_agree(interpolation):
    scan, butcher = (worst_error_deg(100, interpolation, path=path) for path in (path_by_turns, path_by_butcher))
    # Butcher holds Euler's rates' inputs, the scan the body's: the same samples, so the same answer but for rounding.
    assert scan == pytest.approx(butcher, rel=1e-3, abs=1e-8)


def test_angles_go_on_from_where_they_start():
    euler, body = report_motion(100)
    turned = np.array([2 * np.pi, 0.0, -4 * np.pi])
    found = cr_angles(body, euler[0] + turned, 0.01)
    np.testing.assert_allclose(found - turned, euler, atol=1e-8)
    over = cr_angles(np.tile([1.0, 0.0, 0.0], (1001, 1)), np.zeros(3), 0.01)
    np.testing.assert_allclose(over[:, 2], np.arange(1001) * 0.01, atol=1e-12)


def test_yaw_beyond_ninety_degrees_stays_on_its_side():
    start = np.array([0.2, np.pi - 0.1, 0.3])
    body = np.tile([0.3, 0.2, 0.1], (101, 1))
    scan, butcher = (cr_angles(body, start, 0.01, "linear", path) for path in (path_by_turns, path_by_butcher))
    np.testing.assert_allclose(scan, butcher, atol=1e-10)


def test_butchers_method_is_of_fifth_order():
    # ω constant about a tilted axis is a nonlinear problem in Euler angles whose rates need no interpolation.
    def end(steps):
        body = np.tile([0.5, 0.7, -0.4], (steps + 1, 1))
        return cr_angles(body, np.array([0.1, 0.2, 0.3]), 1.0 / steps, "linear", path_by_butcher)[-1]

    exact = end(400)
    errors = [np.max(np.abs(end(n) - exact)) for n in (5, 10, 20)]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(orders > 4.7)


def test_a_turn_about_a_fixed_axis_is_the_matrix_exponential():
    from scipy.spatial.transform import Rotation

    w = np.array([0.5, 0.7, -0.4])
    start = np.array([0.1, 0.2, 0.3])
    found = cr_angles(np.tile(w, (201, 1)), start, 0.01)[-1]

    def body_from_initial(euler):
        # frames turn by pitch about y, yaw about z, roll about x (CR III-B.3 to 5)
        return Rotation.from_euler("YZX", euler).inv()

    turned = Rotation.from_rotvec(-w * 2.0) * body_from_initial(start)
    assert (turned * body_from_initial(found).inv()).magnitude() < 1e-10


def test_yaw_of_ninety_degrees_is_refused_in_words():
    with pytest.raises(SolveError, match="integrate the quaternion"):
        cr_angles(np.tile([0.0, 0.0, 1.0], (400, 1)), np.zeros(3), 0.001 * np.pi * 2)
    with pytest.raises(SolveError, match="carried across"):  # a step that jumps over 90°
        cr_angles(np.tile([0.0, 0.0, 1.0], (400, 1)), np.zeros(3), 0.11)
    with pytest.raises(SolveError, match="sample 0"):
        cr_angles(np.zeros((5, 3)), np.array([0.0, np.pi / 2, 0.0]), 0.01)


@pytest.mark.parametrize(("count", "interval"), [(3, 0.01), (10, 0.0), (10, float("nan"))])
def test_too_few_samples_or_no_interval_are_refused(count, interval):
    with pytest.raises(ObservationsError, match="above 0 s"):
        cr_angles(np.zeros((count, 3)), np.zeros(3), interval)
