"""Names of parameters as people read them: the quantity in words, and the unit as it is printed."""

import re
from decimal import Decimal

import pytest

from ams.units import in_words, label_and_unit, signed_in_words


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


@pytest.mark.parametrize("unit", ["v", "V/g²", "dps", "counts", "°", "ppm"])
def test_a_size_in_a_sentence_has_no_exponent_at_any_decade(unit: str) -> None:
    in_unit = {"v": 1e6, "V/g²": 1e6, "°": 3600.0}.get(unit, 1.0)
    for exponent in range(-9, 7):
        for sign in (1.0, -1.0):
            value = sign * 1.2345 * 10.0**exponent
            for text, digits in ((in_words(value, unit), 2), (signed_in_words(value, unit, 3), 3)):
                number = re.match(r"[+−]?\d+(\.\d+)?(?=[ ″])", text)
                assert number is not None, text
                read = float(Decimal(number[0].replace("−", "-")))
                assert read == pytest.approx(in_unit * value, rel=0.5 * 10.0 ** (1 - digits)), text
    assert (in_words(1.2e-5, "V/g²"), signed_in_words(-0.0021, "°", 3)) == ("12 µV/g²", "−7.56″")
