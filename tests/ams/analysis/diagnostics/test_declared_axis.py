"""A sign of pitch or yaw the other way round leaves axes of CR's packages that read with gravity and against it."""

from dataclasses import replace

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

GRID = np.deg2rad([(pitch, yaw) for pitch in range(-30, 31, 10) for yaw in range(-20, 21, 10)])
K_V_PER_G = np.array([[2.5, 0.02, -0.01], [-0.015, 2.48, 0.02], [0.01, -0.02, 2.51]])
REQUEST = CalibrationRequest(model="pitch-yaw-roll-sting")


def rows(polarity: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Observations:
    """Three replications of a sting package; gravity by its definition, forward, right and down."""
    pitch, yaw = np.tile(GRID, (3, 1)).T
    gravity = np.stack([-np.sin(pitch) * np.cos(yaw), np.sin(pitch) * np.sin(yaw), np.cos(pitch)], axis=-1)
    outputs_v = np.array(polarity) * (0.01 + gravity @ K_V_PER_G.T)
    outputs_v += 2e-5 * np.random.default_rng(1).standard_normal(outputs_v.shape)
    return Observations(
        np.repeat([1, 2, 3], len(GRID)), np.tile(np.arange(len(GRID)), 3), pitch, np.zeros_like(pitch),
        dict(zip("xyz", outputs_v.T, strict=True)), yaw_rad=yaw,
    )  # fmt: skip


def told(observations: Observations, request: CalibrationRequest = REQUEST) -> list[str]:
    return [text for text in calibrate(observations, request).warnings if "do not read with one polarity" in text]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_one_polarity_of_all_three_is_not_contradicted(sign: float) -> None:
    assert not told(rows((sign, sign, sign)))


@pytest.mark.parametrize(
    ("angle", "words"), [("yaw_rad", "x and z with gravity, y against it"), ("pitch_rad", "z with gravity, x and y")]
)
def test_a_sign_of_an_angle_the_other_way_round_is_told(angle: str, words: str) -> None:
    plain = rows()
    (text,) = told(replace(plain, **{angle: -getattr(plain, angle)}))
    assert words in text


def test_a_polarity_that_is_declared_is_counted() -> None:
    declared = {axis: DeclaredDirection(axis, 1, -1 if axis == "y" else 1) for axis in "xyz"}
    assert told(rows((1.0, -1.0, 1.0)))
    assert not told(rows((1.0, -1.0, 1.0)), replace(REQUEST, declared=declared))
    assert told(rows(), replace(REQUEST, declared=declared))


@pytest.mark.parametrize(("axes", "angle"), [("xz", "pitch_rad"), ("yz", "pitch_rad"), ("xy", "yaw_rad")])
def test_two_axes_tell_it_as_three_do(axes: str, angle: str) -> None:
    plain = rows()
    plain = replace(plain, outputs={axis: plain.outputs[axis] for axis in axes})
    assert not told(plain)
    (text,) = told(replace(plain, **{angle: -getattr(plain, angle)}))
    assert f"{axes[1]} with gravity, {axes[0]}" in text or f"{axes[0]} with gravity, {axes[1]}" in text
