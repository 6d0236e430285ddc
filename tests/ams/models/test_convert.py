"""TP and CR describe the same sensor: outputs agree at every attitude and the conversion goes round."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ams.frames import AXES
from ams.models.convert import TpSensor, cr_from_tp, sensitivity_per_local_g, tp_from_cr
from ams.models.cr import model_gravity_g, sting_gravity_g


def tp_output(sensor, pitch, roll):
    """TP (2), (4), (5), as printed."""
    b, s, o, a = sensor.offset_v, sensor.sensitivity_v_per_g, sensor.coning_rad, sensor.azimuth_rad
    sin, cos = np.sin, np.cos
    return {
        "x": b + s * (cos(o) * sin(pitch) - sin(o) * cos(pitch) * sin(roll + a)),
        "y": b
        - s * (cos(o) * sin(roll) * cos(pitch) - sin(o) * (sin(a) * sin(pitch) - cos(a) * cos(roll) * cos(pitch))),
        "z": b
        - s * (cos(o) * cos(roll) * cos(pitch) - sin(o) * (cos(a) * sin(pitch) - sin(a) * sin(roll) * cos(pitch))),
    }[sensor.axis]


sensors = st.builds(
    TpSensor,
    axis=st.sampled_from(AXES),
    offset_v=st.floats(-10, 10),
    sensitivity_v_per_g=st.floats(0.01, 10) | st.floats(-10, -0.01),
    coning_rad=st.floats(0, np.pi / 2),
    azimuth_rad=st.floats(-np.pi, np.pi, exclude_min=True),
)


@given(sensors, st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi))
def test_both_conventions_give_the_same_output_at_every_attitude(sensor, pitch, roll):
    gravity = model_gravity_g(sting_gravity_g(np.array([pitch]), np.array([0.0])), np.array([roll]))
    cr = cr_from_tp(sensor)
    assert (cr.bias_v + gravity @ cr.k)[0] == pytest.approx(tp_output(sensor, pitch, roll), abs=1e-12)


@given(sensors)
def test_conversion_goes_round(sensor):
    back = tp_from_cr(cr_from_tp(sensor))
    assert (back.axis, back.offset_v, back.sensitivity_v_per_g, back.coning_rad) == (
        sensor.axis,
        sensor.offset_v,
        sensor.sensitivity_v_per_g,
        sensor.coning_rad,
    )
    turn = back.azimuth_rad - sensor.azimuth_rad
    assert np.cos(turn) == pytest.approx(1.0, abs=1e-14)
    assert -np.pi < back.azimuth_rad <= np.pi


def test_azimuth_keeps_its_branch_at_the_seam():
    assert cr_from_tp(TpSensor("x", 0.0, 1.0, 0.1, np.pi / 2)).azimuth_rad == np.pi
    assert cr_from_tp(TpSensor("x", 0.0, 1.0, 0.1, np.pi)).azimuth_rad == pytest.approx(-np.pi / 2)


def test_local_gravity_matters_as_much_as_the_specification_says():
    # Forgetting the site's g is 0.03 degrees at 30 degrees where g differs by 0.1 % (9.79826 against 9.80665 m/s²).
    local = sensitivity_per_local_g(2.5, 9.79826)
    error_deg = np.degrees(np.arcsin(2.5 / local * 0.5)) - 30.0
    assert error_deg == pytest.approx(0.0283, abs=5e-4)
