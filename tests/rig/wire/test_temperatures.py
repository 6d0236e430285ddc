"""Fixed points of two scales: water freezes and boils, and −40 is the same in both."""

import pytest

from rig.wire.temperatures import degc_of, of_degc


@pytest.mark.parametrize(("degc", "degf"), [(0.0, 32.0), (100.0, 212.0), (-40.0, -40.0), (37.0, 98.6)])
def test_a_temperature_is_the_same_in_both_units_and_back(degc: float, degf: float) -> None:
    assert degc_of(degf, is_fahrenheit=True) == pytest.approx(degc)
    assert of_degc(degc, is_fahrenheit=True) == pytest.approx(degf)
    assert (degc_of(degc, is_fahrenheit=False), of_degc(degc, is_fahrenheit=False)) == (degc, degc)
