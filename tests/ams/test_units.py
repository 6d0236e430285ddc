"""Names of parameters as people read them: the quantity in words, and the unit as it is printed."""

import pytest

from ams.units import label_and_unit


@pytest.mark.parametrize(
    ("name", "label", "unit"),
    [
        ("offset_v", "offset", "V"),
        ("sensitivity_v_per_g", "sensitivity", "V/g"),
        ("sensitivity_v_per_dps", "sensitivity", "V/(°/s)"),
        ("sensitivity_v_per_mps2", "sensitivity", "V/(m/s²)"),
        ("gain_ut_per_ut", "gain", "µT/µT"),
        ("q_xy_v_per_g2", "q xy", "V/g²"),
        ("sensitivity_tc_per_degc", "sensitivity tc", "1/°C"),
        ("reference_temperature_degc", "reference temperature", "°C"),
        ("coning_deg", "coning", "°"),
        ("offset", "offset", ""),
    ],
)
def test_a_name_is_told_as_quantity_and_unit(name: str, label: str, unit: str) -> None:
    assert label_and_unit(name) == (label, unit)
