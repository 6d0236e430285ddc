"""Any start comes to the branch Ω ≤ 90° with signed S, and the printed start of CR to its table 3."""

import numpy as np
import pytest
from cr_by_hand import jacobian, predict_v, sensor_from_linear

from ams.frames import AXES, specific_force
from ams.models.cr import sensitive_axis, sting_gravity_g
from ams.solve.gauss_newton import gauss_newton

DEG = np.pi / 180
NAMES = ("bias_v", "sensitivity", "azimuth_rad", "coning_rad")
PITCH, ROLL = np.meshgrid(np.arange(-90, 91, 15) * DEG, np.arange(-180, 181, 30) * DEG)
FIELD = -specific_force(PITCH.ravel(), ROLL.ravel())


def iterate(axis, output, start, field=FIELD):
    return gauss_newton(lambda p: predict_v(axis, p, field), lambda p: jacobian(axis, p, field), start, output, NAMES)


def on_branch(axis, estimate):
    return sensor_from_linear(axis, np.array([estimate[0], *(estimate[1] * sensitive_axis(axis, *estimate[2:]))]))


def draw(rng):
    truth = np.array(
        [
            rng.normal(0, 0.05),
            rng.choice([-1, 1]) * rng.uniform(1, 3),
            rng.uniform(-np.pi, np.pi),
            rng.uniform(0.2, 3) * DEG,
        ]
    )
    start = np.array([rng.normal(0, 1), rng.normal(0, 3), *rng.uniform(-np.pi, np.pi, 2)])
    return truth, start


@pytest.mark.parametrize("starts", [250, pytest.param(1000, marks=pytest.mark.soak)])
def test_every_one_of_many_random_starts_reaches_the_branch(starts):
    rng, reached = np.random.default_rng(0), 0
    for n in range(starts):
        axis, (truth, start) = AXES[n % 3], draw(rng)
        output = predict_v(axis, truth, FIELD) + rng.normal(0, 2e-5, FIELD.shape[0])
        sensor = on_branch(axis, iterate(axis, output, start).estimate)
        reached += bool(
            abs(sensor.sensitivity - truth[1]) < 1e-4
            and abs(sensor.coning_rad - truth[3]) < 1e-4
            and np.cos(sensor.azimuth_rad - truth[2]) > 0.999
            and 0 <= sensor.coning_rad <= np.pi / 2
        )
    assert reached == starts


def test_the_undamped_iteration_of_the_reports_does_not():
    # CR (IV-A.6) as listed in appendix B: full steps only, and no branch afterwards.
    rng, reached = np.random.default_rng(0), 0
    for n in range(200):
        axis, (truth, p) = AXES[n % 3], draw(rng)
        output = predict_v(axis, truth, FIELD)
        for _ in range(100):
            p = p + np.linalg.lstsq(jacobian(axis, p, FIELD), output - predict_v(axis, p, FIELD), rcond=None)[0]
        reached += bool(np.all(np.abs(p[[1, 3]] - truth[[1, 3]]) < 1e-4))
    assert reached < 140


# CR table 3, sting package and CR appendix B's printed start: B 1.23 V, S 0.45 V/g, Om 0.06°, A 0.07°.
@pytest.mark.parametrize(
    ("axis", "specified"),
    [("x", (1.25, 0.51, 0.05, 0.06)), ("y", (1.27, 0.47, 0.12, 0.15)), ("z", (1.19, 0.54, 0.11, 0.11))],
)
def test_table_3_is_reached_from_its_printed_start(axis, specified):
    angle = np.linspace(0.0, 10.0, 1001) * DEG
    field = sting_gravity_g(angle, angle)
    unit = np.array([1.0, 1.0, DEG, DEG])
    output = predict_v(axis, np.array(specified) * unit, field)
    found = iterate(axis, output, np.array([1.23, 0.45, 0.07 * DEG, 0.06 * DEG]), field)
    assert [f"{v:.4f}" for v in found.estimate / unit] == [f"{v:.4f}" for v in specified]
    assert found.convergence.reason in ("step", "rounding")
    assert found.convergence.iterations < 50
