"""Terms of second and third order that change with temperature, in outputs that are drawn here and not by the library.

Seven pitch and six roll angles, eight visits of plateaus at 15, 20, 25 and 20 °C, 20 µV a dwell at 2.5 V/g.
"""

from collections.abc import Callable

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.analysis.diagnostics.beliefs import CURVATURE, LAG, TERMS_OVER_TEMPERATURE
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration, Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.models.thermal import TemperatureCoefficients
from ams.observations import Observations

NOISE_V, SENSITIVITY_V_PER_G = 2e-5, 2.5
PLATEAUS_DEGC = (15.0, 20.0, 25.0, 20.0) * 2
ESTIMATE = CalibrationRequest(temperature="estimate", reference_temperature_degc=20.0)
Added = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Of (N,) replication, (N,) rise above 20 °C and (N, 3) specific force: (N,) volts."""


def _rows(seed: int, added: Added) -> Observations:
    chance = np.random.default_rng(seed)
    pitch, roll = (grid.ravel() for grid in np.meshgrid(np.arange(-60, 61, 20), np.arange(-180, 180, 60)))
    point = np.concatenate([chance.permutation(pitch.size) for _ in PLATEAUS_DEGC])
    replication = np.repeat(np.arange(len(PLATEAUS_DEGC)), pitch.size)
    rise = np.array(PLATEAUS_DEGC)[replication] - 20.0 + 0.05 * chance.normal(size=point.size)
    a, r = np.deg2rad(pitch[point].astype(float)), np.deg2rad(roll[point].astype(float))
    force = np.stack([np.sin(a), -np.cos(a) * np.sin(r), -np.cos(a) * np.cos(r)], axis=1)
    sensed = SENSITIVITY_V_PER_G * force @ np.array([1.0, 0.004, -0.006])
    output = 0.005 + 1e-5 * rise + sensed * (1.0 - 3e-5 * rise) + added(replication, rise, force)
    time_s = 20000.0 * replication + 60.0 * np.tile(np.arange(pitch.size), len(PLATEAUS_DEGC))
    return Observations(
        replication + 1, point + 1, a, r, {"x": output + NOISE_V * chance.normal(size=point.size)},
        temperature_degc=20.0 + rise, time_s=time_s,
    )  # fmt: skip


def _nothing(replication: FloatArray, rise: FloatArray, force: FloatArray) -> FloatArray:
    return np.zeros_like(rise)


def _solved(seed: int, added: Added, request: CalibrationRequest = ESTIMATE) -> Calibration:
    return calibrate(_rows(seed, added), request)


def _significant(axis: AxisCalibration) -> dict[str, Finding]:
    return {str(found.details["test"]): found for found in axis.findings if found.is_significant}


@pytest.mark.parametrize(
    ("term", "said"),
    [
        (lambda force: force[:, 0] ** 2, "K₂ by "),
        (lambda force: force[:, 1] * force[:, 2], "K_po by "),
        (lambda force: force[:, 0] ** 3, "K₃ by "),
    ],
)
def test_a_term_that_changes_by_eight_micro_g_a_degree_is_told_by_its_name_and_the_result_is_not_usable(
    term: Callable[[FloatArray], FloatArray], said: str
) -> None:
    for seed in range(4):
        found = _solved(seed, lambda _, rise, force: 2e-5 * rise * term(force))
        significant = _significant(found.axes["x"])
        assert list(significant) == [TERMS_OVER_TEMPERATURE]
        finding = significant[TERMS_OVER_TEMPERATURE]
        assert finding.kind == "temperature-curvature"
        assert f"change with temperature: {said}" in finding.text
        value, within = finding.text.split(said)[1].split(" µg/g")[0].split(" ± ")
        assert abs(float(value) - 8.0) < 2.0 * float(within)
        assert float(within) < 3.0
        assert found.verdict == "not usable"
        assert finding.text in found.axes["x"].warnings


def test_where_no_term_changes_nothing_is_told_of_one() -> None:
    for seed in range(8):
        found = _solved(seed, _nothing)
        assert TERMS_OVER_TEMPERATURE not in _significant(found.axes["x"])
        assert any(entry.details["test"] == TERMS_OVER_TEMPERATURE for entry in found.axes["x"].findings)


@pytest.mark.thorough
def test_the_test_by_itself_rings_no_more_often_than_its_level() -> None:
    p_values = [
        entry.p_value
        for seed in range(300)
        for entry in _solved(100 + seed, _nothing).axes["x"].findings
        if entry.details["test"] == TERMS_OVER_TEMPERATURE
    ]
    assert len(p_values) == 300
    assert np.mean(np.array(p_values) <= 0.05) < 0.08


def test_a_lag_and_a_bend_over_temperature_are_told_as_what_they_are() -> None:
    for name, size, test in (("temperature-lag", 0.3, LAG), ("temperature-curvature", 1.0, CURVATURE)):
        drawn = campaigns(name, size, np.random.default_rng(3), 1, axes="x")
        schedule = drawn.schedule
        rows = rows_of(drawn)
        seen = Observations(
            rows.replication, rows.point, rows.pitch_rad, rows.roll_rad, {"x": columns_of(drawn, "x")[:, 0]},
            temperature_degc=drawn.grid(drawn.temperature_degc).reshape(-1),
            time_s=schedule.time_s[schedule.grid_rows()].ravel(),
        )  # fmt: skip
        assert list(_significant(calibrate(seen, ESTIMATE).axes["x"])) == [test]


def test_what_a_term_does_by_chance_from_visit_to_visit_is_not_put_on_temperature() -> None:
    """A fixture that is clamped anew for every replication: 80 µg/g² of scatter, whatever the temperature."""
    for seed in range(4):
        of_visit = 2e-4 * np.random.default_rng(50 + seed).normal(size=len(PLATEAUS_DEGC))
        found = _solved(seed, lambda at, _, force, sizes=of_visit: sizes[at] * force[:, 1] * force[:, 2])
        assert TERMS_OVER_TEMPERATURE not in _significant(found.axes["x"])


@pytest.mark.parametrize(
    "request_",
    [
        CalibrationRequest(),
        CalibrationRequest(
            temperature="apply",
            reference_temperature_degc=20.0,
            known_temperature={"x": TemperatureCoefficients(1e-5, -3e-5)},
        ),
    ],
)
def test_without_coefficients_to_estimate_the_tests_are_those_that_they_were(request_: CalibrationRequest) -> None:
    found = _solved(0, _nothing, request_)
    assert all(entry.details.get("test") != TERMS_OVER_TEMPERATURE for entry in found.axes["x"].findings)
