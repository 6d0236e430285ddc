"""Every misprint found in the three reports: the right form holds, and the printed one would not have passed.

The truth is never the corrected formula itself: it is explicit rotations, a complex step, a numerical integral, the
normal matrix of the design, or arithmetic on the printed columns.
"""

import numpy as np
import pytest
from cr_by_hand import jacobian, predict_v
from scipy.integrate import dblquad
from scipy.stats import f as f_distribution
from tp_bias import t_bias

from ams.analysis.design_variance import gradient
from ams.attitude.quaternion import from_turn, multiply
from ams.attitude.two_package import angles_from_gravity
from ams.frames import specific_force
from ams.models.accelerometer import PitchRoll, vector_from_angles
from ams.models.cr import model_gravity_g, sting_gravity_g
from ams.models.linear import Line
from ams.solve.gauss_newton import gauss_newton

sin, cos = np.sin, np.cos
ALPHA, ROLL, OMEGA, AZIMUTH = 0.7, -1.1, 0.3, 2.0
H = 1e-30


def turn_x(a):
    return np.array([[1, 0, 0], [0, cos(a), sin(a)], [0, -sin(a), cos(a)]])


def turn_y(a):
    return np.array([[cos(a), 0, -sin(a)], [0, 1, 0], [sin(a), 0, cos(a)]])


def turn_z(a):
    return np.array([[cos(a), sin(a), 0], [-sin(a), cos(a), 0], [0, 0, 1]])


def tp_output(axis, s, omega, a, alpha, roll):
    """TP (113) to (116): nothing but rotations."""
    g_m = turn_x(roll) @ turn_y(alpha) @ np.array([0.0, 0.0, -1.0])
    sensed = {
        "x": turn_z(omega) @ turn_x(a) @ g_m,
        "y": turn_x(omega) @ turn_y(a) @ g_m,
        "z": turn_y(omega) @ turn_z(a) @ g_m,
    }[axis]
    return s * sensed["xyz".index(axis)]


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_tp_2_4_5_as_we_have_them_are_the_rotations(axis):
    ours = specific_force(np.array([ALPHA]), np.array([ROLL])) @ vector_from_angles(axis, -2.5, OMEGA, AZIMUTH)
    assert ours[0] == pytest.approx(tp_output(axis, -2.5, OMEGA, AZIMUTH, ALPHA, ROLL), abs=1e-14)


def test_tp_37_the_sine_is_of_omega_z():
    truth = tp_output("z", 1.0, OMEGA + 1j * H, AZIMUTH, ALPHA, ROLL).imag / H
    rest = cos(OMEGA) * (cos(AZIMUTH) * sin(ALPHA) - sin(AZIMUTH) * cos(ALPHA) * sin(ROLL))
    assert sin(OMEGA) * cos(ALPHA) * cos(ROLL) + rest == pytest.approx(truth, abs=1e-14)
    omega_y = 0.1
    assert sin(omega_y) * cos(ALPHA) * cos(ROLL) + rest != pytest.approx(truth, abs=1e-3)


def test_tp_75_the_derivative_by_roll_is_negative():
    truth = tp_output("x", 2.5, OMEGA, AZIMUTH, ALPHA, ROLL + 1j * H).imag / H
    magnitude = 2.5 * sin(OMEGA) * cos(ALPHA) * cos(ROLL + AZIMUTH)
    assert -magnitude == pytest.approx(truth, abs=1e-14)
    assert magnitude != pytest.approx(truth, abs=1e-3)


def test_tp_74_divides_by_the_calibrations_variance():
    # A prediction interval with independent roll, by Monte Carlo, with a reading much noisier than the calibration.
    rng = np.random.default_rng(1)
    sigma_e, sigma_0, sigma_r = 1e-5, 6e-5, 1e-3
    pitch, roll = (g.ravel() for g in np.meshgrid(np.linspace(-1.5, 1.5, 7), np.linspace(-3, 3, 7)))
    X = PitchRoll("x").basis(_at(pitch, roll))
    truth = np.concatenate([[0.01], vector_from_angles("x", 2.5, OMEGA, AZIMUTH)])
    phi = np.concatenate([[1.0], specific_force(np.array([ALPHA]), np.array([ROLL]))[0]])
    by_roll = tp_output("x", 2.5, OMEGA, AZIMUTH, ALPHA, ROLL + 1j * H).imag / H
    q = phi @ np.linalg.inv(X.T @ X) @ phi
    estimates = truth[:, None] + np.linalg.pinv(X) @ rng.normal(0, sigma_e, (X.shape[0], 20000))
    new = phi @ truth + rng.normal(0, sigma_0, 20000) + by_roll * rng.normal(0, sigma_r, 20000)
    spread = np.std(new - phi @ estimates)
    extra = sigma_0**2 + by_roll**2 * sigma_r**2
    assert sigma_e * np.sqrt(q + extra / sigma_e**2) == pytest.approx(spread, rel=0.02)
    assert sigma_e * np.sqrt(q + extra / sigma_0**2) != pytest.approx(spread, rel=0.5)  # σ_y: that of the output


def test_tp_44_has_the_sign_of_the_residuals_curvature_lost():
    # R is the second derivative of half the sum of squares; with the H_E of (45) in it print has R = F'F + H_E.
    t = np.linspace(0.0, 2.0, 15)
    observed = np.exp(-0.8 * t) + 0.3 * np.sin(7.0 * t)

    def half_square(c):
        return 0.5 * np.sum((observed - c[0] * np.exp(-c[1] * t)) ** 2)

    found = gauss_newton(
        lambda c: c[0] * np.exp(-c[1] * t),
        lambda c: np.stack([np.exp(-c[1] * t), -c[0] * t * np.exp(-c[1] * t)], axis=1),
        np.ones(2),
        observed,
        ("a", "b"),
        residual_curvature=True,
    )
    h, e = 1e-4, np.eye(2)
    signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    around = [
        [[half_square(found.estimate + h * (s * e[i] + r * e[j])) for s, r in signs] for j in (0, 1)] for i in (0, 1)
    ]
    truth = np.array(around) @ np.prod(signs, axis=1) / (4 * h * h)
    a, b = found.estimate
    F = np.stack([np.exp(-b * t), -a * t * np.exp(-b * t)], axis=1)
    H = found.residual_curvature
    np.testing.assert_allclose(F.T @ F - H, truth, rtol=1e-5, atol=1e-6)
    assert not np.allclose(F.T @ F + H, truth, rtol=0.02)


def _at(pitch, roll):
    from ams.frames import Attitude

    return Attitude(np.asarray(pitch), np.asarray(roll))


def test_tp_67_has_the_sum_of_cos_alpha_in_both_places():
    alphas = np.linspace(-0.6, 0.6, 13)
    X = np.column_stack([np.ones(13), sin(alphas), -cos(alphas)])
    phi = np.array([1.0, sin(0.4), -cos(0.4)])
    truth = phi @ np.linalg.inv(X.T @ X) @ phi
    n, c_1, c_2 = 13, np.sum(cos(alphas)), np.sum(cos(2 * alphas))

    def form(middle, squared):
        top = (n + c_2) / 2 - 2 * middle * cos(0.4) + n * cos(0.4) ** 2
        return top / (n * (n + c_2) / 2 - squared**2) + 2 * sin(0.4) ** 2 / (n - c_2)

    assert form(c_1, c_1) == pytest.approx(truth, rel=1e-9)
    assert form(c_2, c_2) != pytest.approx(truth, rel=0.02)


def gamma_a(a):
    return np.block(
        [[np.eye(2), np.zeros((2, 2))], [np.zeros((2, 2)), np.array([[cos(a), -sin(a)], [sin(a), cos(a)]])]]
    )


def test_tp_136_z_has_the_sine_of_alpha():
    # φ_Ω of the z sensor is −sinΩ g_S − cosΩ g_Ω by TP (137), (139); the truth is its derivative by Ω.
    truth = tp_output("z", 1.0, OMEGA + 1j * H, AZIMUTH, ALPHA, ROLL).imag / H
    g_s, common = -cos(ALPHA) * cos(ROLL), sin(AZIMUTH) * cos(ALPHA) * sin(ROLL)
    right, printed = -cos(AZIMUTH) * sin(ALPHA) + common, -cos(AZIMUTH) * cos(ALPHA) + common
    assert -sin(OMEGA) * g_s - cos(OMEGA) * right == pytest.approx(truth, abs=1e-14)
    assert -sin(OMEGA) * g_s - cos(OMEGA) * printed != pytest.approx(truth, abs=1e-3)


def test_tp_148_h_z_ends_with_cos_alpha_sin_roll():
    g = np.array(
        [
            1.0,
            -cos(ALPHA) * cos(ROLL),
            -cos(AZIMUTH) * sin(ALPHA) + sin(AZIMUTH) * cos(ALPHA) * sin(ROLL),
            -sin(AZIMUTH) * sin(ALPHA) - cos(AZIMUTH) * cos(ALPHA) * sin(ROLL),
        ]
    )
    last_column_turned = np.diag([1.0, 1.0, 1.0, -1.0])
    right = np.array([1.0, -cos(ALPHA) * cos(ROLL), -sin(ALPHA), cos(ALPHA) * sin(ROLL)])
    printed = np.array([1.0, -cos(ALPHA) * cos(ROLL), -sin(ALPHA), -cos(ALPHA) * cos(ROLL)])
    np.testing.assert_allclose(right @ gamma_a(AZIMUTH) @ last_column_turned, g, atol=1e-15)
    for sign in (last_column_turned, np.eye(4)):
        assert not np.allclose(printed @ gamma_a(AZIMUTH) @ sign, g, atol=1e-3)
    # and h must span offset and specific force, which the printed row does not
    angles = np.random.default_rng(0).uniform(-3, 3, (2, 20))
    rows = [[1, -cos(a) * cos(r), -sin(a), -cos(a) * cos(r)] for a, r in angles.T]
    assert np.linalg.matrix_rank(np.array(rows)) == 3


def test_tp_159_the_last_term_stands_outside_the_fraction():
    alphas, rolls = np.linspace(-0.4, 0.9, 8), -np.pi + 2 * np.pi * np.arange(12) / 12
    pitch, roll = (g.ravel() for g in np.meshgrid(alphas, rolls, indexing="ij"))
    X, phi = gradient(pitch, roll), gradient(np.array([0.5]), np.array([1.3]))[0]
    truth = phi @ np.linalg.inv(X.T @ X) @ phi
    s_1, c_2, n, m = np.sum(sin(alphas)), np.sum(cos(2 * alphas)), 8, 12
    r_bb, r_bs, r_ss, rho = m * n, m * s_1, m * (n - c_2) / 2, m * (n + c_2) / 4
    D = r_bb * r_ss - r_bs**2
    top = r_ss - 2 * r_bs * sin(0.5) + r_bb * sin(0.5) ** 2
    assert top / D + cos(0.5) ** 2 / rho == pytest.approx(truth, rel=1e-11)
    assert top / (D + cos(0.5) ** 2 / rho) != pytest.approx(truth, rel=0.1)


BOX = (-0.3, 0.9, -1.0, 2.0)


def integral(f):
    a, b, c, d = BOX
    return dblquad(lambda roll, alpha: f(alpha, roll), a, b, c, d)[0]


def test_tp_220_has_a_quarter():
    a, b, c, d = BOX
    truth = integral(lambda alpha, roll: -0.5 * sin(2 * alpha) * cos(roll))
    product = (cos(2 * b) - cos(2 * a)) * (sin(d) - sin(c))
    assert product / 4 == pytest.approx(truth, rel=1e-9)
    assert product / 2 != pytest.approx(truth, rel=0.1)


def test_tp_222_is_negative():
    a, b, c, d = BOX
    truth = integral(lambda alpha, roll: 0.5 * cos(alpha) ** 2 * sin(2 * roll))
    product = ((b - a) + (sin(2 * b) - sin(2 * a)) / 2) * (cos(2 * d) - cos(2 * c))
    assert -product / 8 == pytest.approx(truth, rel=1e-9)
    assert product / 8 != pytest.approx(truth, rel=0.1)


# TP table 2: figure, σ_bias, σ_prec (10⁻⁴ degrees), T_bias, K and n as the designs of the text have them, L.
TABLE_2 = {
    "22": (0.431, 1.54, 0.407, 73, 6, 3),
    "24": (2.62, 1.79, 11.0, 145, 6, 3),
    "28(a)": (3.54, 6.90, 1.33, 325, 6, 4),
    "28(b)": (3.54, 1.56, 26.2, 325, 6, 4),
    "34": (2.45, 16.4, 0.113, 325, 6, 4),
    "35": (3.97, 1.54, 36.2, 53, 6, 4),
    "37": (4.71, 1.31, 39.4, 325, 4, 4),
    "42": (4.17, 13.5, 0.289, 325, 4, 4),
    "44(b)": (4.17, 1.54, 37.3, 247, 6, 4),
    "47(b)": (5.08, 1.23, 85.9, 481, 6, 4),
    # the three rows of figure 53 were computed with L = 3, as without roll: L = 4 would give 27.8, 106 and 18.9
    "53(x)": (3.78, 1.65, 27.3, 73, 6, 3),
    "53(y)": (5.51, 1.23, 104, 73, 6, 3),
    "53(z)": (4.23, 2.24, 18.5, 73, 6, 3),
}


@pytest.mark.parametrize("figure", TABLE_2)
def test_tp_table_2_t_bias_follows_from_its_columns_with_the_corrections(figure):
    sigma_bias, sigma_prec, printed, points, n, parameters = TABLE_2[figure]
    half_a_digit = 0.5 * 10.0 ** (-2 if sigma_prec < 10 else -1)
    rounding = 2 * (half_a_digit / sigma_prec + (5e-4 if sigma_bias < 1 else 5e-3) / sigma_bias) + 5e-3
    assert t_bias(sigma_bias, sigma_prec, points, n, parameters) == pytest.approx(printed, rel=rounding)


def test_tp_table_2_printed_values_do_not_fit():
    assert t_bias(2.45, 1.64, 325, 6, 4) > 10  # row 34 with σ_prec 1.64 against T = 0.113
    assert t_bias(4.17, 13.5, 325, 6, 4) > 0.45  # row 42 with 6 replications against T = 0.289
    assert t_bias(0.431, 1.54, 325, 6, 3) < 0.397  # row 22 with 325 points against T = 0.407
    assert np.hypot(2.45, 16.4) * np.sqrt(6 * 325 / (6 * 325 - 4)) == pytest.approx(16.6, abs=0.05)  # σ_E of row 34
    assert np.hypot(2.45, 1.64) < 3  # … and with the printed σ_prec


def test_tp_table_2_counts_are_those_of_the_texts_designs():
    up_and_down = lambda step, limit: 2 * len(range(-limit, limit + 1, step)) - 1  # noqa: E731
    assert up_and_down(2, 36) == 73  # row 22, printed 325
    assert up_and_down(5, 180) == 145  # row 24, printed 325
    assert len(range(-30, 31, 5)) * len(range(-180, 181, 15)) == 325  # rows 28 to 34, printed 365


@pytest.mark.parametrize(
    ("points", "n", "parameters", "printed", "fits"),
    [
        (325, 6, 4, 2.22, True),
        (325, 4, 4, 2.61, True),
        (6, 6, 4, 3.11, True),
        (73, 6, 3, 1.35, False),
        (145, 6, 3, 1.24, False),
        (4, 6, 3, 4.75, False),
        (73, 6, 4, 1.59, False),
    ],
)
def test_tp_table_2_the_drift_limit_is_that_of_n_minus_1_and_n_times_k_minus_l(points, n, parameters, printed, fits):
    limit = f_distribution.ppf(0.95, n - 1, n * (points - parameters))
    assert bool(abs(limit - printed) < 0.011) is fits


@pytest.mark.parametrize(
    ("sigma_b", "t_b", "t_s", "right", "printed"),
    [(41.0, 102, 919, 123, 1.23), (281, 5850, 1570, 145, 1.45), (8.53, 3.52, 8.89, 13.5, 1.35)],
)
def test_tp_table_2_sensitivity_spread_follows_from_its_test(sigma_b, t_b, t_s, right, printed):
    # σ_j² = T_j S_w² with one S_w for offset and sensitivity
    sigma_s = sigma_b / np.sqrt(t_b) * np.sqrt(t_s)
    assert sigma_s == pytest.approx(right, rel=0.01)
    assert sigma_s != pytest.approx(printed, rel=0.5)


def test_cr_iv_a_30_takes_each_component_of_gravity_once():
    p = np.array([1.2, 0.53, 0.9, 0.4])
    _, _, a, c = p
    gravity = sting_gravity_g(np.array([0.5]), np.array([0.8]))
    g_x, g_y, g_z = gravity[0]
    field = model_gravity_g(gravity, np.array([0.6]))
    truth = predict_v("z", p + np.array([0, 1j * H, 0, 0]), field).imag[0] / H
    first, second = sin(a) * sin(c), -cos(a) * sin(c) * cos(0.6) - cos(c) * sin(0.6)
    third = -cos(a) * sin(c) * sin(0.6) + cos(c) * cos(0.6)
    assert first * g_x + second * g_y + third * g_z == pytest.approx(truth, abs=1e-14)
    assert first * g_y + second * g_y + third * g_x != pytest.approx(truth, abs=1e-2)
    assert jacobian("z", p, field)[0, 1] == pytest.approx(truth, abs=1e-14)


def test_cr_appendix_b_asks_for_a_step_that_double_precision_does_not_have():
    rng = np.random.default_rng(3)
    pitch, yaw = rng.uniform(-1.4, 1.4, (2, 200))
    field = sting_gravity_g(pitch, yaw)
    output = predict_v("x", np.array([1.25, 0.51, 0.3, 0.2]), field) + rng.normal(0, 1e-4, 200)

    def iterate(rows):
        p, steps = np.array([1.23, 0.45, 0.2, 0.1]), []
        for _ in range(100):
            Z, D = jacobian("x", p, field[rows]), output[rows] - predict_v("x", p, field[rows])
            step = np.linalg.solve(Z.T @ Z, Z.T @ D)
            p = p + step
            steps.append(np.linalg.norm(step))
        return p, min(steps)

    everything, smallest = iterate(slice(None))
    assert smallest > 1e-32  # the listing always runs its hundred rounds
    without_last, _ = iterate(slice(0, -1))
    assert np.max(np.abs(everything - without_last)) > 1e-9  # and 'nData-1' throws a measurement away


def test_cr_appendix_c_closed_form_has_the_sign_of_minus_g_x():
    for pitch, yaw in ((0.2, 0.3), (-0.2, 0.3), (0.4, -0.5)):
        (g_x, g_y, g_z), roll = sting_gravity_g(pitch, yaw), 0.1
        gravity = np.array([[g_x, g_y, g_z]])
        found = angles_from_gravity(gravity, model_gravity_g(gravity, np.array([roll])))
        assert (found.pitch_rad[0], found.yaw_rad[0]) == pytest.approx((pitch, yaw), abs=1e-12)
        psi = np.arctan2(g_y, -g_x)
        theta = np.arctan(np.hypot(g_x, g_y) / g_z) * np.sign(g_x / cos(psi))
        assert (theta, psi) != pytest.approx((pitch, yaw), abs=1e-3)


def test_cr_listings_lost_a_minus_in_the_model_packages_y_row():
    p = np.array([0.0, 1.0, 0.9, 0.4])
    phi, g_y = 0.6, np.array([[0.0, 1.0, 0.0]])
    truth = predict_v("y", p, model_gravity_g(g_y, np.array([phi])))[0]
    _, _, a, c = p
    assert cos(c) * cos(phi) - sin(c) * sin(a) * sin(phi) == pytest.approx(truth, abs=1e-15)
    assert cos(c) * cos(phi) * sin(c) * sin(a) * sin(phi) != pytest.approx(truth, abs=1e-2)  # read as a product


def test_sr_1_needs_the_half_and_two_other_signs():
    # SR prints the scalar first: rows of q = (q_s, q_x, q_y, q_z).
    w = np.array([0.3, -0.7, 1.1])
    w_1, w_2, w_3 = w
    printed = np.array([[0, -w_1, -w_2, -w_3], [w_1, 0, w_3, -w_2], [w_2, -w_3, 0, -w_1], [w_3, w_2, w_1, 0]])
    right = np.array([[0, -w_1, -w_2, -w_3], [w_1, 0, w_3, -w_2], [w_2, -w_3, 0, w_1], [w_3, w_2, -w_1, 0]])
    q = np.array([0.1, 0.5, -0.3, 0.8])
    q /= np.linalg.norm(q)
    h = 1e-6
    truth = (multiply(q, from_turn(w * h)) - multiply(q, from_turn(-w * h))) / (2 * h)
    scalar_first = np.roll(q, 1)
    np.testing.assert_allclose(np.roll(0.5 * right @ scalar_first, -1), truth, atol=1e-9)
    assert not np.allclose(np.roll(0.5 * printed @ scalar_first, -1), truth, atol=1e-3)
    assert not np.allclose(np.roll(right @ scalar_first, -1), truth, atol=1e-3)
    # a rate turns by itself only if Ω² = −|ω|² 1: the printed matrix keeps the length but bends the turn
    assert not np.allclose(printed @ printed, -(w @ w) * np.eye(4))
    np.testing.assert_allclose(right @ right, -(w @ w) * np.eye(4), atol=1e-15)


def test_sr_magnetometer_axes_have_each_their_own_line():
    # SR appendix A, 4.4: (0.9999 raw + 28.97)/31.45 and (1.0000 raw − 313.9050)/31.45.
    x = Line(0.9999 / 31.45, 28.97 / 31.45)
    y = Line(1.0 / 31.45, -313.9050 / 31.45)
    shared = Line(0.997 / 31.24, -52.865 / 31.24)  # the conversion table prints this for both
    raw = np.array([700.0])
    assert x(raw)[0] == pytest.approx((0.9999 * 700 + 28.97) / 31.45, rel=1e-14)
    assert y(raw)[0] == pytest.approx((700 - 313.9050) / 31.45, rel=1e-14)
    assert abs(x(raw)[0] - y(raw)[0]) > 10  # µT: no one line can serve both
    assert min(abs(shared(raw)[0] - x(raw)[0]), abs(shared(raw)[0] - y(raw)[0])) > 2
