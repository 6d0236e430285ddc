"""The Earth turns under the gyros of a file: it is in the uncertainties, or the rates are stated to include it."""

from pathlib import Path

import calrig
import numpy as np
import pandas as pd
import pytest
from command import call
from turned_gyros import COLUMNS, EARTH_DPS, OFFSET_V, ground_dps, gyros

from ams.analysis.diagnostics.declared.earth_on_gyros import EARTH_ON_RATES
from ams.exports.formats import load_set
from procedures.data.solved import Solved
from procedures.errors import RequestError

NAME = "Earth's rotation"
V_PER_DPS = 0.02
STATED = {"rate_uncertainty_ppm": 10.0, "direction_uncertainty_arcsec": 5.0, "largest_g_sensitivity_dps_per_g": 1e-9}


def solved(table: pd.DataFrame, *, included: bool) -> Solved:
    return calrig.fit(table, COLUMNS, model="gyro", **STATED, rates_include_earth=included)


def drawn(seed: int, latitude_deg: float, noise_v: float) -> pd.DataFrame:
    """Rows of a table that points anywhere."""
    heading_deg = float(np.random.default_rng([152, seed]).uniform(0.0, 360.0))
    return gyros(seed, noise_v=noise_v, ground=ground_dps(latitude_deg, heading_deg))[0]


def held(found: Solved) -> list[bool]:
    """Whether the stated 95 % of each axis have its true offset; of what is not usable nothing is asked."""
    if found.document["verdict"] == "not usable":
        return []
    return [
        abs(axis["parameters"]["offset_v"]["value"] - OFFSET_V) <= axis["budget"]["expanded_uncertainty_95"]["offset_v"]
        for axis in found.document["axes"].values()
    ]


def contributions(document: dict[str, object], axis: str) -> list[float]:
    """What the Earth does to the offset, as the budget of an axis says it."""
    lines = document["axes"][axis]["budget"]["lines"]  # type: ignore[index]
    return [line["standard_uncertainty"]["offset_v"] for line in lines if line["source"] == NAME]


@pytest.mark.parametrize("latitude_deg", [0.0, 35.0, 70.0])
def test_the_offsets_of_rates_that_lack_the_earth_are_held_at_every_noise(latitude_deg: float) -> None:
    """Of 90 axes 0.95 ± 0.023."""
    noise_v = np.geomspace(1e-6, 1e-3, 10)
    found = [solved(drawn(seed, latitude_deg, noise_v[seed % 10]), included=False) for seed in range(30)]
    assert [one.document["verdict"] for one in found].count("not usable") <= 3
    assert np.mean([inside for one in found for inside in held(one)]) > 0.88


def test_rates_that_include_the_earth_and_say_so_are_held_and_pay_nothing() -> None:
    inside = []
    for seed in range(30):
        table, _ = gyros(seed, noise_v=1e-4)
        stated, silent = solved(table, included=True), solved(table, included=False)
        inside += held(stated)
        for axis in "xyz":
            (of_earth_v,), nothing = contributions(silent.document, axis), contributions(stated.document, axis)
            assert (0.0 < of_earth_v < EARTH_DPS * V_PER_DPS, nothing) == (True, [])
    assert np.mean(inside) > 0.88


def test_rates_that_are_stated_to_include_the_earth_and_lack_it_are_told_so() -> None:
    """In no uncertainty, and plain beside 20 µV a dwell: as it was of every file."""
    for seed in range(6):
        found = solved(drawn(seed, 50.0, 2e-5), included=True)
        tests = {said.get("test") for axis in found.document["axes"].values() for said in axis["findings"]}
        assert (found.document["verdict"], EARTH_ON_RATES in tests) == ("not usable", True)
        silent = solved(drawn(seed, 50.0, 2e-5), included=False)
        assert silent.document["verdict"] == "sound"


def test_document_set_and_remark_of_command_and_python_say_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = drawn(1, 50.0, 1e-4)
    table.to_csv(tmp_path / "g.csv", index=False)
    line = ("fit", tmp_path / "g.csv", "--model", "gyro", *(f"--axis={axis}={COLUMNS[axis]}" for axis in COLUMNS))
    line = (*line, *(part for name, u in STATED.items() for part in (f"--{name.replace('_', '-')}", str(u))))
    for included in (False, True):
        flag = ("--rates-include-earth",) if included else ()
        document = call(capsys, *line, *flag, "--set", tmp_path / "g.json", "--sensor", "G1", "--json").document
        of_set, of_axis = load_set(tmp_path / "g.json").document, document["axes"]["x"]
        (said,), (in_set,) = ([text for text in each["remarks"] if "Earth" in text] for each in (of_axis, of_set))
        assert (said == in_set, "is in no uncertainty" in said) == (True, included)
        assert (NAME in str(of_set["package"])) != included
        axes = solved(table, included=included).document["axes"]
        assert axes["x"]["parameters"] == document["axes"]["x"]["parameters"]
        assert axes["x"]["budget"] == document["axes"]["x"]["budget"]


def test_of_what_is_no_gyro_it_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, _ = gyros(1)
    table.to_csv(tmp_path / "g.csv", index=False)
    asked = call(capsys, "fit", tmp_path / "g.csv", "--axis=x=x_v", "--rates-include-earth")
    assert asked.status == 2
    assert "--rates-include-earth: belongs to --model gyro, not to --model pitch-roll" in asked.err
    with pytest.raises(RequestError, match="fit: rates_include_earth: belongs to fit: model gyro"):
        calrig.fit(table, {"x": "x_v"}, rates_include_earth=True)
