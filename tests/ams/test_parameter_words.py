"""A parameter's name is told in words, with the symbol of the report that has one and its printed unit."""

import pytest

from ams.parameter_words import words_of


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("coning_deg", ("coning angle", "Ω", "°")),  # TP, list of symbols
        ("sensitivity_v_per_g", ("sensitivity", "S", "V/g")),
        ("sensitivity_v_per_dps", ("sensitivity", "S", "V/(°/s)")),
        ("k_y_v_per_dps", ("k right", "k_y", "V/(°/s)")),
        ("q_xz_v_per_g2", ("quadratic term xz", "q_xz", "V/g²")),
        ("gain_dps_per_dps", ("gain", "A", "(°/s)/(°/s)")),  # SR, table 1: the line's letters
        ("offset_ut", ("offset", "B", "µT")),
        ("bow_v_per_g3", ("bow", "", "V/g³")),  # of a model that somebody else wrote
        ("reading per unit", ("reading per unit", "", "")),
    ],
)
def test_a_name_is_told_in_words(name: str, expected: tuple[str, str, str]) -> None:
    assert words_of(name) == expected


def test_the_letters_of_a_line_stand_behind_its_words_and_no_others() -> None:
    names = ("gain_g_per_v", "offset_g", "azimuth_deg", "offset_v")
    assert [words_of(name).lettered for name in names] == ["gain A", "offset B", "azimuth", "offset"]
