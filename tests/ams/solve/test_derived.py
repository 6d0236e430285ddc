"""What follows from offset and vector of sensitivities: an azimuth's interval is that of a direction, not of a line."""

import numpy as np
import pytest

from ams.models.accelerometer import PitchRoll
from ams.solve.components import ComponentColumns
from ams.solve.derived import derive

SD_V_PER_G = 1e-3
NORMAL_95 = 1.959963984540054


def halfwidths(across_v_per_g: float, sd_v_per_g: float = SD_V_PER_G) -> dict[str, float]:
    """Degrees, of a sensor along x whose vector leans to y, each component known to a certificate's ``sd``."""
    covariance = np.diag([0.0, *[sd_v_per_g**2] * 3])[None]
    known = ComponentColumns("table", covariance, np.array([np.inf]))
    primary = np.array([[0.005, 2.5, across_v_per_g, 0.0]])
    found = derive([PitchRoll("x")], primary, [known], covariance)
    return dict(zip(found.names, found.halfwidths_95[0].tolist(), strict=True))


@pytest.mark.parametrize("times", [4.5, 5.0, 8.0, 40.0])
def test_the_interval_of_an_azimuth_ends_where_the_truth_would_stand_two_deviations_across(times: float) -> None:
    """At its end the vector lies 1.96 standard deviations beside the direction that is asked about (Fieller 1954)."""
    end_rad = np.deg2rad(halfwidths(times * SD_V_PER_G)["azimuth_deg"])
    assert times * np.sin(end_rad) == pytest.approx(NORMAL_95, rel=1e-9)


def test_the_other_parameters_have_their_standard_uncertainty_times_students_factor() -> None:
    found = halfwidths(0.0179)
    length = np.hypot(2.5, 0.0179)
    assert found["sensitivity_v_per_g"] == pytest.approx(NORMAL_95 * SD_V_PER_G, rel=1e-9)
    assert found["coning_deg"] == pytest.approx(np.rad2deg(NORMAL_95 * SD_V_PER_G / length), rel=1e-9)
    assert np.isnan(found["offset_v"]), "an exact offset has no degrees of freedom"


def test_an_azimuth_that_is_not_told_has_no_interval() -> None:
    assert np.isnan(halfwidths(3.0 * SD_V_PER_G)["azimuth_deg"])
