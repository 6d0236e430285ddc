"""The budget of a calibration: it adds up to what is reported, GUM's rules hold in closed form, trials agree."""

from dataclasses import replace

import numpy as np
import pytest
from GTC import ureal
from simulated_campaign import ARCSEC, Campaign

from ams.analysis.calibration_budget import PER_SI, AxisBudget, Gravity, axis_budget
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.drifting import DRIFT_NAME

METER = (
    SharedError("multimeter zero", "reading", 2e-5, "limit", "standards.meter: limit 35 µV"),
    SharedError("multimeter gain", "gain", 3e-6),
)
GRAVITY = Gravity(9.79826, 2e-4, "survey")


def solved(replications: int = 6, *, with_meter: bool = True, **settings: float) -> AxisCalibration:
    observations = Campaign(replications=replications, **settings).observe(np.random.default_rng(2))
    shared = {"x": METER} if with_meter else {}
    table = TableUncertainty(ARCSEC, ARCSEC, "limit")
    request = CalibrationRequest(nominal_axes={"x": "x"}, table=table, shared_errors=shared, extended="no")
    return calibrate(observations, request).axes["x"]


@pytest.fixture(scope="module")
def axis() -> AxisCalibration:
    return solved()


@pytest.fixture(scope="module")
def budget(axis: AxisCalibration) -> AxisBudget:
    return axis_budget(axis, METER, GRAVITY, stated={"table": "pitch u 0.58″"}, trials=200_000, seed=4)


def test_the_budget_adds_up_to_what_is_reported(axis: AxisCalibration, budget: AxisBudget) -> None:
    for estimate in axis.parameters:
        squares = sum(line.contributions[estimate.name] ** 2 for line in budget.lines)
        assert np.sqrt(squares) == pytest.approx(estimate.standard_uncertainty, rel=1e-12)
        assert budget.combined[estimate.name] == pytest.approx(estimate.standard_uncertainty, rel=1e-12)
        assert estimate.interval_95 is not None
        half = 0.5 * (estimate.interval_95[1] - estimate.interval_95[0])
        assert budget.expanded_95[estimate.name] == pytest.approx(half, rel=1e-9)


def test_it_does_so_for_an_azimuth_that_is_hardly_told() -> None:
    """Coning of few standard uncertainties: its interval is wider than Student's factor makes it, here too."""
    axis = solved(with_meter=False, noise_arcsec=1500.0)
    estimate, found = axis.parameters[3], axis_budget(axis)
    assert estimate.interval_95 is not None
    half = 0.5 * (estimate.interval_95[1] - estimate.interval_95[0])
    assert half > 5.0
    assert found.expanded_95["azimuth_deg"] == pytest.approx(half, rel=1e-9)


def test_trials_hold_every_parameter_however_small_its_unit_makes_it() -> None:
    """Temperature coefficients are a millionth of a sensitivity in numbers, and scatter all the same."""
    observations = Campaign(replications=6, noise_arcsec=0.5).observe(np.random.default_rng(9))
    warmth = np.random.default_rng(8).uniform(15.0, 27.0, observations.rows)
    measured = replace(observations, temperature_degc=warmth)
    request = CalibrationRequest(nominal_axes={"x": "x"}, temperature="estimate", extended="no")
    axis = calibrate(measured, request).axes["x"]
    found = axis_budget(axis, trials=20_000, seed=1)
    assert found.monte_carlo is not None
    for name, checked in found.monte_carlo.parameters.items():
        dof = found.effective_degrees_of_freedom[name]
        tails = np.sqrt(dof / (dof - 2.0)) if dof > 3.0 else np.nan
        assert np.isnan(tails) or checked.standard_uncertainty == pytest.approx(tails * found.combined[name], rel=0.15)
        assert checked.standard_uncertainty > 0.9 * found.combined[name], name


def test_every_source_is_named_with_its_type_and_what_was_declared(budget: AxisBudget) -> None:
    found = {line.source: (line.type, line.stated) for line in budget.lines}
    assert found["scatter between replications (precision and drift)"] == ("A", "")
    assert found["indices of the table"] == ("B", "pitch u 0.58″")
    assert found["multimeter zero"] == ("B", "standards.meter: limit 35 µV")
    assert found["local gravity"][0] == "B"


def test_zero_and_gain_of_the_meter_reach_what_they_must(axis: AxisCalibration, budget: AxisBudget) -> None:
    """A zero moves the offset by itself and nothing else; a gain moves offset and sensitivity by their own parts."""
    by_source = {line.source: line.contributions for line in budget.lines}
    zero, gain = by_source["multimeter zero"], by_source["multimeter gain"]
    values = {estimate.name: estimate.value for estimate in axis.parameters}
    assert zero["offset_v"] == pytest.approx(2e-5, rel=1e-9)
    assert zero["sensitivity_v_per_g"] < 1e-12
    assert gain["sensitivity_v_per_g"] == pytest.approx(3e-6 * values["sensitivity_v_per_g"], rel=1e-5)
    assert gain["offset_v"] == pytest.approx(3e-6 * abs(values["offset_v"]), rel=1e-2)
    assert gain["coning_deg"] < 1e-9


def test_a_sensitivity_per_metre_per_second_squared_takes_gravity_as_an_independent_budget_does(
    axis: AxisCalibration, budget: AxisBudget
) -> None:
    """Against GTC, the budget calculator of MSL (ureal, division)."""
    stated = next(item for item in axis.parameters if item.name == "sensitivity_v_per_g")
    quotient = ureal(stated.value, stated.standard_uncertainty) / ureal(9.79826, 2e-4)
    assert budget.sensitivity_v_per_mps2 == pytest.approx(quotient.x, rel=1e-12)
    assert budget.combined[PER_SI] == pytest.approx(quotient.u, rel=1e-9)


def test_the_trials_find_the_rectangle_that_the_certificate_states() -> None:
    """Where a limit ±L outweighs all, 95 % of the trials lie within ±0.95 L (GUM S1 table 1), not within ±1.96 L/√3."""
    big = (SharedError("multimeter zero", "reading", 1e-2, "limit"),)
    observations = Campaign(replications=6).observe(np.random.default_rng(2))
    request = CalibrationRequest(nominal_axes={"x": "x"}, shared_errors={"x": big}, extended="no")
    found = axis_budget(calibrate(observations, request).axes["x"], big, trials=200_000)
    assert found.monte_carlo is not None
    low, high = found.monte_carlo.parameters["offset_v"].interval_95
    assert 0.5 * (high - low) == pytest.approx(0.95 * 3**0.5 * 1e-2, rel=5e-3)
    assert found.expanded_95["offset_v"] == pytest.approx(1.96e-2, rel=1e-3)
    assert found.monte_carlo.parameters["offset_v"].is_confirmed


def test_the_trials_have_students_tails_where_replications_are_few() -> None:
    """S1 6.4.9: u·√(ν/(ν−2)) is the spread of the trials; with six replications ν is five."""
    entry = solved(with_meter=False, noise_arcsec=5.0)
    found = axis_budget(entry, trials=400_000)
    assert found.monte_carlo is not None
    line = found.lines[0]
    rest = found.combined["offset_v"] ** 2 - line.contributions["offset_v"] ** 2
    wanted = np.sqrt(line.contributions["offset_v"] ** 2 * 5.0 / 3.0 + rest)
    assert found.monte_carlo.parameters["offset_v"].standard_uncertainty == pytest.approx(wanted, rel=2e-2)


def test_the_trials_are_those_of_the_seed(axis: AxisCalibration) -> None:
    entry, same, other = (axis_budget(axis, METER, trials=2_000, seed=seed).monte_carlo for seed in (1, 1, 2))
    assert entry == same
    assert entry != other


def test_a_null_parameter_has_no_line_and_hinders_no_other() -> None:
    entry = solved(4, noise_arcsec=7200.0)
    assert next(item for item in entry.parameters if item.name == "azimuth_deg").value is None
    found = axis_budget(entry, METER, GRAVITY, trials=2_000)
    assert "azimuth_deg" not in found.combined
    assert {"offset_v", "sensitivity_v_per_g", PER_SI} <= set(found.combined)


def test_a_time_term_has_a_budget_of_its_own_and_its_reference_time_none() -> None:
    from dataclasses import replace

    observations = Campaign(replications=4).observe(np.random.default_rng(2))
    timed = replace(observations, time_s=60.0 * np.arange(observations.rows))
    axis = calibrate(timed, CalibrationRequest(nominal_axes={"x": "x"}, time_term=True, extended="no")).axes["x"]
    found = axis_budget(axis)
    assert DRIFT_NAME in found.combined
    assert "reference_time_s" not in found.combined
