"""Rates or positions of gyros that are written with the opposite sign: no residual shows it, the polarities do."""

import calrig
import numpy as np
import pandas as pd
import pytest
from turned_gyros import COLUMNS, gyros

STATED = {"rate_uncertainty_ppm": 10.0, "direction_uncertainty_arcsec": 5.0, "largest_g_sensitivity_dps_per_g": 1e-4}


def contradicted(table: pd.DataFrame) -> tuple[str, dict[str, str]]:
    """The verdict, and by axis what is said of its polarity."""
    document = calrig.fit(table, COLUMNS, model="gyro", **STATED).document
    found = {
        axis: finding["text"]
        for axis, section in document["axes"].items()
        for finding in section["findings"]
        if finding["kind"] == "axis-contradicted"
    }
    return document["verdict"], found


@pytest.mark.parametrize(("column", "odd"), [("roll_rate_dps", "x"), ("roll_deg", "y")])
def test_one_sign_of_a_file_is_told_of_the_gyro_that_reads_otherwise_than_the_others(column: str, odd: str) -> None:
    table, _ = gyros(5)
    verdict, said = contradicted(table.assign(**{column: -table[column]}))
    assert (verdict, list(said)) == ("usable", [odd])
    assert f"output {odd} of the opposite polarity" in said[odd]
    assert "the signs of its rates" in said[odd]


def test_an_output_that_is_wired_the_other_way_round_is_told_and_three_of_them_are_believed() -> None:
    table, _ = gyros(6)
    reversed_z = table.assign(z_v=-table["z_v"])
    assert list(contradicted(reversed_z)[1]) == ["z"]
    all_reversed = table.assign(**{column: -table[column] for column in COLUMNS.values()})
    assert contradicted(all_reversed) == ("sound", {})


def test_clean_campaigns_of_gyros_are_told_nothing_of_signs() -> None:
    told = [contradicted(gyros(seed)[0])[1] for seed in range(40)]
    assert told == [{}] * 40
    assert np.isfinite(gyros(0)[1]).all()
