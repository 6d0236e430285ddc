"""Applying a set: shapes, refusals, and back from outputs to the specific force."""

import subprocess
import sys

import numpy as np
import pytest
from solved import provenance, solved_package

from ams.errors import OutsideValidity
from ams.inference.inference import Package, inference
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.vectors import inferred_force

RNG = np.random.default_rng(5)


@pytest.fixture(scope="module")
def coefficients() -> CoefficientSet:
    return build_set(solved_package(), provenance(pitch_range_deg=(-30.0, 30.0), roll_range_deg=(-180.0, 150.0)))


def test_outputs_have_the_shape_that_the_inputs_broadcast_to(coefficients: CoefficientSet) -> None:
    outputs_v = apply(coefficients, np.zeros((3, 1)), np.zeros(4))
    assert {name: values.shape for name, values in outputs_v.items()} == {"x": (3, 4), "y": (3, 4), "z": (3, 4)}


def test_an_empty_request_gives_an_empty_answer(coefficients: CoefficientSet) -> None:
    assert apply(coefficients, np.zeros(0), np.zeros(0))["x"].shape == (0,)


def test_the_force_comes_back_from_the_outputs(coefficients: CoefficientSet) -> None:
    pitch, roll = RNG.uniform(-0.5, 0.5, 50), RNG.uniform(-3.0, 2.5, 50)
    f = inferred_force(coefficients.axes, apply(coefficients, pitch, roll), None)
    expected = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=-1)
    assert f == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(30.0, 150.0), (-30.0, -180.0), (0.0, 180.0), (0.0, 510.0)])
def test_the_ends_of_the_validity_belong_to_it_and_roll_is_a_circle(
    coefficients: CoefficientSet, pitch_deg: float, roll_deg: float
) -> None:
    apply(coefficients, np.radians(pitch_deg), np.radians(roll_deg))


def test_pitch_beyond_the_validity_is_refused(coefficients: CoefficientSet) -> None:
    sentence = "SN1047: pitch outside the validity of the set: got 31°, calibrated from -30 to 30°; nothing was"
    with pytest.raises(OutsideValidity, match=sentence):
        apply(coefficients, np.radians([0.0, 31.0]), 0.0)
    with pytest.raises(OutsideValidity, match=r"got 30\.0000001°, calibrated from -30 to 30°"):
        apply(coefficients, np.radians(30.0000001), 0.0)


def test_roll_in_the_gap_of_the_validity_is_refused(coefficients: CoefficientSet) -> None:
    with pytest.raises(OutsideValidity, match="roll outside the validity of the set: got 165°"):
        apply(coefficients, 0.0, np.radians(165.0))


@pytest.mark.parametrize("roll_deg", [-180.0, -20.0, 149.9, 165.0, 179.0])
def test_what_apply_refuses_is_flagged_where_angles_are_told(coefficients: CoefficientSet, roll_deg: float) -> None:
    outputs_v = apply(coefficients, 0.1, np.radians(roll_deg), beyond_validity=True)
    readings = {f"{axis}_v": np.full(2, values) for axis, values in outputs_v.items()}
    columns = {axis: f"{axis}_v" for axis in "xyz"}
    (flag, _) = inference(Package(coefficients, columns), reading_sd_v=1e-6).infer(readings)["flag"]
    try:
        apply(coefficients, 0.1, np.radians(roll_deg))
    except OutsideValidity:
        assert flag == "roll outside the validity of the set"
    else:
        assert flag == ""


def test_temperature_beyond_the_validity_is_refused(coefficients: CoefficientSet) -> None:
    with pytest.raises(OutsideValidity, match="temperature outside the validity of the set: got 22 °C"):
        apply(coefficients, 0.0, 0.0, 22.0)


def test_beyond_the_validity_is_computed_when_the_caller_says_so(coefficients: CoefficientSet) -> None:
    assert apply(coefficients, np.pi / 2, 0.0, beyond_validity=True)["x"] == pytest.approx(2.5049, abs=1e-4)


@pytest.mark.parametrize("pitch", [np.nan, np.inf])
def test_an_input_that_is_not_finite_is_refused_always(coefficients: CoefficientSet, pitch: float) -> None:
    with pytest.raises(OutsideValidity, match="pitch: 1 of 1 values are not finite"):
        apply(coefficients, pitch, 0.0, beyond_validity=True)


def test_applying_loads_nothing_heavy() -> None:
    code = (
        "import sys, ams\n"
        "ams.apply, ams.load_set, ams.verify, ams.export_set\n"
        "heavy = {'scipy', 'sqlalchemy', 'alembic', 'jsonschema', 'pandas', 'pydantic'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
