"""How the axes of a rate table lean: no residual of a gyro shows it: it is stated, or the verdict says so."""

from datetime import date
from pathlib import Path

import calrig
import numpy as np
import pytest
from command import call
from turned_gyros import COLUMNS, gyros

from ams.archive.sign_offs import SignOff
from ams.exports.formats import load_set
from ams.sets.stated_verdict import verdict_in_words
from ams.sets.verdict_conditions import NO_DIRECTIONS
from procedures.certificate.grounds import Grounds, gaps_of

LEANS_ARCSEC = 20.0
RATES_KNOWN = {"rate_uncertainty_ppm": 10.0, "largest_g_sensitivity_dps_per_g": 1e-4}


def held(campaigns: int = 30, *, is_stated: bool, **wrong: float) -> float:
    """Of the axes whose coning is told, the share whose true one lies in the stated 95 %."""
    stated = {"direction_uncertainty_arcsec": LEANS_ARCSEC} if is_stated else {}
    inside = []
    for seed in range(campaigns):
        table, coning_deg = gyros(seed, **wrong)
        axes = calrig.fit(table, COLUMNS, model="gyro", **RATES_KNOWN, **stated).document["axes"]
        for axis, true_deg in zip("xyz", coning_deg, strict=True):
            value_deg = axes[axis]["parameters"]["coning_deg"]["value"]
            if value_deg is not None:
                half_deg = axes[axis]["budget"]["expanded_uncertainty_95"]["coning_deg"]
                inside.append(abs(value_deg - true_deg) <= half_deg)
    return float(np.mean(inside))


@pytest.mark.parametrize("wrong", ["squareness_arcsec", "seats_arcsec"])
def test_the_coning_of_gyros_on_axes_that_lean_is_held_where_it_is_stated_and_not_where_it_is_not(wrong: str) -> None:
    assert held(is_stated=True, **{wrong: LEANS_ARCSEC}) > 0.93
    if wrong == "squareness_arcsec":  # seats that differ are shown by the points: tests/ams/calibration
        assert held(10, is_stated=False, **{wrong: LEANS_ARCSEC}) < 0.6


def test_what_is_stated_of_the_directions_is_in_the_coning_and_not_in_the_scale_factor() -> None:
    table, _ = gyros(3)
    bare, counted = (
        calrig.fit(table, COLUMNS, model="gyro", **RATES_KNOWN, **stated).document["axes"]["x"]["parameters"]
        for stated in ({}, {"direction_uncertainty_arcsec": LEANS_ARCSEC})
    )
    u_deg = {name: values["coning_deg"]["standard_uncertainty"] for name, values in (("bare", bare), ("with", counted))}
    assert 0.5 * LEANS_ARCSEC / 3600.0 < u_deg["with"] < 3.0 * LEANS_ARCSEC / 3600.0
    assert u_deg["bare"] < 0.1 * u_deg["with"]
    of_scale = [values["sensitivity_v_per_dps"]["standard_uncertainty"] for values in (bare, counted)]
    assert of_scale[1] == pytest.approx(of_scale[0], rel=0.05)


def test_directions_that_nobody_states_stand_in_verdict_set_and_certificate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, _ = gyros(4)
    table.to_csv(tmp_path / "g.csv", index=False)
    line = ("fit", tmp_path / "g.csv", "--model", "gyro", *(f"--axis={axis}={COLUMNS[axis]}" for axis in COLUMNS))
    line = (*line, "--rate-uncertainty-ppm", "10", "--set", tmp_path / "g.json", "--sensor", "G1", "--json")
    for stated in (False, True):
        document = call(capsys, *line, *(("--direction-uncertainty-arcsec", "5") if stated else ())).document
        entry = load_set(tmp_path / "g.json")
        words = verdict_in_words(entry.document)
        assert (document["verdict"], words == verdict_in_words(document)) == ("sound", True)
        assert ("without the directions of the table's axes, which is not declared" in str(words)) == (not stated)
        gaps = list(gaps_of(Grounds("1", date(2026, 3, 2), entry, None, SignOff(entry.sha256, (), ()))))
        assert sum(gap.startswith(NO_DIRECTIONS) for gap in gaps) == (not stated)
        kinds = [finding["kind"] for finding in document["axes"]["x"]["findings"]]
        assert ("table-undeclared" in kinds) == (not stated)
