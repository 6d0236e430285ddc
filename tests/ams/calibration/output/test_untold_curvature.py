"""A bend that few temperatures do not tell: how far off it takes a result, and that result, verdict and set say so.

A three-axis package whose offset bends by s((T − 20 °C)/10 °C)², or to the third power, against its own truth.
"""

from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import OFFSET_V, Campaign
from solved import provenance

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.inputs.request import CalibrationRequest
from ams.models.thermal import TemperatureCoefficients
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.sets.stated_verdict import conditions_in_words
from ams.sets.verdict_conditions import CUBIC_BEND_UNDETERMINED, CURVATURE_UNDETERMINED, REFERENCE_NOT_MEASURED
from ams.statistics.intervals import t_quantile

TWO = (10.0, 30.0, 30.0, 10.0, 10.0, 30.0)
THREE = (10.0, 20.0, 30.0, 20.0, 10.0, 20.0, 30.0, 20.0)
FOUR = (10.0, 16.0, 24.0, 30.0, 24.0, 16.0, 10.0, 30.0)
GRID = {"pitch_deg": np.linspace(-60.0, 60.0, 5), "roll_deg": np.arange(-180.0, 180.0, 60.0)}
OFFSET_TC_V, ARCSEC_V = 3e-5, 1.2e-5


def measured(plateaus_degc: tuple[float, ...], bend_v: float = 0.0, power: int = 2, seed: int = 0) -> Observations:
    """A replication a visit, temperatures within 0.03 °C of their plateau."""
    chance = np.random.default_rng(seed)
    rows = Campaign(replications=len(plateaus_degc), noise_arcsec=1.0, **GRID).observe(chance)
    count = rows.rows // len(plateaus_degc)
    degc = np.repeat(plateaus_degc, count) + chance.uniform(-0.03, 0.03, rows.rows)
    moved = OFFSET_TC_V * (degc - 20.0) + bend_v * ((degc - 20.0) / 10.0) ** power
    outputs = {axis: output + moved for axis, output in rows.outputs.items()}
    return replace(rows, outputs=outputs, temperature_degc=degc, time_s=60.0 * np.arange(rows.rows))


def solved(rows: Observations, reference_degc: float | None = None, order: int = 1) -> Calibration:
    request = CalibrationRequest(
        temperature="estimate", temperature_order=order, reference_temperature_degc=reference_degc
    )
    return calibrate(rows, request)


def off_by(found: Calibration, axis: str, truth_v: float) -> float:
    """Error of the offset in expanded uncertainties."""
    part = found.axes[axis]
    u_v = float(np.sqrt(part.primary_covariance[0, 0]))
    return abs(float(part.primary[0]) - truth_v) / (u_v * float(t_quantile(0.95, float(part.primary_dof[0]))))


def reservations(found: Calibration) -> list[str]:
    return [text for text in found.warnings if text.startswith((REFERENCE_NOT_MEASURED, CURVATURE_UNDETERMINED))]


@pytest.mark.parametrize("bend_v", [8.0 * ARCSEC_V, 80.0 * ARCSEC_V])
def test_the_offset_at_a_temperature_between_two_is_off_by_the_whole_bend_and_the_result_says_so(bend_v: float) -> None:
    """The default reference, their mean, lies where nothing was measured."""
    found = solved(measured(TWO, bend_v))
    assert min(off_by(found, axis, OFFSET_V[axis]) for axis in "xyz") > 3.0, "or nothing had to be said"
    (said,) = reservations(found)
    assert said.startswith(f"{REFERENCE_NOT_MEASURED}: 20 °C lies 10 °C from the nearest temperature")
    assert "at 10 and 30 °C and nowhere between, which tells no curvature" in said
    assert found.verdict != "sound"


def test_the_offset_at_one_of_the_two_holds_and_what_lies_between_is_said() -> None:
    bend_v = 8.0 * ARCSEC_V
    found = solved(measured(TWO, bend_v), 10.0)
    truths = {axis: OFFSET_V[axis] - 10.0 * OFFSET_TC_V + bend_v for axis in "xyz"}
    assert max(off_by(found, axis, truth_v) for axis, truth_v in truths.items()) < 1.5
    (said,) = reservations(found)
    assert said.startswith(f"{CURVATURE_UNDETERMINED}: ")
    assert "up to 10 °C from the nearest" in said


def test_a_temperature_between_tells_the_bend_and_no_such_thing_is_said() -> None:
    plain, bent = solved(measured(THREE)), solved(measured(THREE, 8.0 * ARCSEC_V))
    assert reservations(plain) == reservations(bent) == []
    kinds = {
        found.details.get("test") for axis in bent.axes.values() for found in axis.findings if found.is_significant
    }
    assert kinds, "the bend is a finding"


@pytest.mark.parametrize("order", [1, 2])
def test_of_three_temperatures_the_verdict_says_that_nobody_looked_for_a_bend_of_third_order(order: int) -> None:
    """Zero at all three beside a line: the offsets between are off by 0.375 of it, and no residual has it."""
    bend_v = 80.0 * ARCSEC_V
    found = solved(measured(THREE, bend_v, power=3), 20.0, order)
    part = found.axes["x"]
    tc_v = float(part.primary[part.primary_names.index("offset_tc_v_per_degc")])
    between_v = part.primary[0] + 5.0 * tc_v - (OFFSET_V["x"] + 5.0 * OFFSET_TC_V + bend_v / 8.0)
    assert abs(between_v) == pytest.approx(0.375 * bend_v, rel=0.1)
    assert reservations(found) == []
    (said,) = [text for text in found.remarks if text.startswith(CUBIC_BEND_UNDETERMINED)]
    assert "(10, 20 and 30 °C): between, up to 5 °C from the nearest" in said
    document = build_set(found, provenance(temperature_range_degc=(10.0, 30.0))).document
    assert conditions_in_words(document).endswith("not tested for a bend of third order between the three temperatures")


@pytest.mark.parametrize("plateaus_degc", [FOUR, tuple(np.linspace(10.0, 30.0, 10)[[0, 9, 4, 2, 7, 1, 8, 3, 5, 6]])])
def test_of_four_temperatures_or_more_nothing_is_said(plateaus_degc: tuple[float, ...]) -> None:
    found = solved(measured(plateaus_degc))
    assert reservations(found) == []
    assert not any(text.startswith(CUBIC_BEND_UNDETERMINED) for text in found.remarks)


def test_a_reference_beyond_all_that_was_measured_is_said_of_any_number_of_temperatures() -> None:
    (said,) = reservations(solved(measured(FOUR), 45.0))
    assert said.startswith(f"{REFERENCE_NOT_MEASURED}: 45 °C lies 15 °C beyond 10 to 30 °C")


def test_known_coefficients_and_a_temperature_that_is_not_modelled_say_nothing_of_it() -> None:
    rows = measured(TWO)
    known = dict.fromkeys("xyz", TemperatureCoefficients(OFFSET_TC_V, 0.0, 1e-6, 1e-6))
    for request in (
        CalibrationRequest(temperature="apply", known_temperature=known, reference_temperature_degc=20.0),
        CalibrationRequest(),
    ):
        assert reservations(calibrate(rows, request)) == []
