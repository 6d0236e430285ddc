"""A line in a field that is switched: both senses tell the offset from what stands beside the coil."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest
from ams.models.field_line import FieldLine
from ams.observations import Observations

GAIN, OFFSET_UT, BESIDE_UT = 0.997, -1.69, 43.0


def _rows(seed: int, replications: int = 5, noise: float = 0.02) -> Observations:
    sense = np.tile([1.0, -1.0, 1.0, -1.0], replications)
    level = np.tile([0.0, 0.0, 40.0, -40.0], replications)
    real = level + BESIDE_UT * sense
    reading = (real - OFFSET_UT) / GAIN + np.random.default_rng(seed).normal(0.0, noise, real.size)
    nothing = np.zeros(real.size)
    return Observations(
        replication=np.repeat(np.arange(1, replications + 1), 4),
        point=np.tile([1, 2, 3, 4], replications),
        pitch_rad=sense * np.pi / 2.0,
        roll_rad=nothing,
        outputs={"x": reading},
        units={"x": "ut"},
        reference_level=level,
    )


def _solved(rows: Observations) -> dict[str, tuple[float, float]]:
    request = CalibrationRequest(nominal_axes={"x": "x"}, models={"x": FieldLine("x", "ut", "ut")}, extended="no")
    estimates = calibrate(rows, request).axes["x"].parameters
    return {
        estimate.name: (float(estimate.value or np.nan), float(estimate.standard_uncertainty or np.nan))
        for estimate in estimates
    }


def test_without_noise_gain_offset_and_surroundings_are_exact() -> None:
    found = _solved(_rows(1, noise=1e-12))
    assert found["gain_ut_per_ut"][0] == pytest.approx(GAIN, rel=1e-11)
    assert found["offset_ut"][0] == pytest.approx(OFFSET_UT, rel=1e-9)
    assert found["surroundings_ut"][0] == pytest.approx(BESIDE_UT, rel=1e-10)


def test_the_stated_uncertainties_hold_the_scatter_of_many_calibrations() -> None:
    """They also hold a lack of fit that one point too many can only hint at, so they are larger, but not by much."""
    found = [_solved(_rows(seed)) for seed in range(200)]
    for name in ("gain_ut_per_ut", "offset_ut", "surroundings_ut"):
        scatter = float(np.std([entry[name][0] for entry in found], ddof=1))
        stated = float(np.sqrt(np.mean([entry[name][1] ** 2 for entry in found])))
        assert 0.9 * scatter < stated < 1.7 * scatter, name


def test_the_jacobian_is_that_of_the_complex_step() -> None:
    model, primary = FieldLine("x", "ut", "v"), np.array([1.7, 1.003, 43.1])
    steps = [model.parameters(primary + 1e-30j * unit).imag / 1e-30 for unit in np.eye(3)]  # type: ignore[arg-type]
    np.testing.assert_allclose(model.parameters_jacobian(primary), np.stack(steps, axis=-1), rtol=1e-12)
    assert model.parameter_names == ("gain_ut_per_v", "offset_ut", "surroundings_ut")


def test_a_sensor_that_does_not_follow_has_no_gain() -> None:
    rows = _rows(1)
    rows.outputs["x"][:] = np.random.default_rng(2).normal(5.0, 1.0, rows.rows)  # type: ignore[index]
    request = CalibrationRequest(nominal_axes={"x": "x"}, models={"x": FieldLine("x", "ut", "ut")}, extended="no")
    axis = calibrate(rows, request).axes["x"]
    assert [parameter.value for parameter in axis.parameters] == [None, None, None]
    assert any("does not follow the reference" in warning for warning in axis.warnings)
