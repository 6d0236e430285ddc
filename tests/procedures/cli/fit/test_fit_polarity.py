"""Packages with an output the other way round: told where nobody states it, usable where the file's owner does.

Gyros on a rate table from physics, of which one is turned round by its wiring.
"""

import json
from pathlib import Path

import calrig
import pytest
from command import call
from turned_gyros import COLUMNS, gyros

from procedures.data.solved import Solved
from procedures.errors import RequestError

STATED = {
    "rate_uncertainty_ppm": 10.0,
    "direction_uncertainty_arcsec": 20.0,
    "largest_g_sensitivity_dps_per_g": 1e-9,
    "rates_include_earth": True,
}


def contradicted(polarity: dict[str, str], seed: int = 0, turned_round: str = "z") -> set[str]:
    """The axes that are said to read otherwise than declared."""
    table, _ = gyros(seed)
    table[COLUMNS[turned_round]] *= -1.0
    found = calrig.fit(table, COLUMNS, model="gyro", polarity=polarity, **STATED)
    axes = {
        label
        for label, axis in found.document["axes"].items()
        for finding in axis["findings"]
        if finding["kind"] == "axis-contradicted" and finding["significant"]
    }
    assert (found.document["verdict"] == "not usable") == any_is_held(found)
    return axes


def any_is_held(found: Solved) -> bool:
    """Whether an axis reads against a sign that was stated of itself."""
    return any(
        finding["kind"] == "axis-contradicted" and "declared" in finding["fact"] and finding["significant"]
        for axis in found.document["axes"].values()
        for finding in axis["findings"]
    )


@pytest.mark.parametrize("turned_round", "xyz")
def test_an_output_the_other_way_round_is_told_until_somebody_states_it(turned_round: str) -> None:
    as_wired = {axis: "-" if axis == turned_round else "+" for axis in "xyz"}
    assert contradicted({}, turned_round=turned_round) == {turned_round}
    assert contradicted(as_wired, turned_round=turned_round) == set()
    assert contradicted({turned_round: "-"}, turned_round=turned_round) == set()
    assert turned_round in contradicted({turned_round: "+"}, turned_round=turned_round), "stated, and wrong"


def test_the_command_takes_the_same_signs_and_its_warning_names_the_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, _ = gyros(1)
    table["z_v"] *= -1.0
    table.to_csv(tmp_path / "gyros.csv", index=False)
    words = ["fit", tmp_path / "gyros.csv", "--model", "gyro", "--rates-include-earth"]
    words += [word for axis, column in COLUMNS.items() for word in ("--axis", f"{axis}={column}")]
    silent = call(capsys, *words)
    assert (silent.status, "--polarity of calrig fit" in " ".join(silent.out.split())) == (0, True)
    stated = json.loads(call(capsys, *words, "--polarity", "z=-", "--json").out)
    kinds = {finding["kind"] for axis in stated["axes"].values() for finding in axis["findings"]}
    assert "axis-contradicted" not in kinds
    for given, what in (("w=-", "allowed is x=SIGN"), ("z=minus", "allowed are z=+ and z=-")):
        refused = call(capsys, *words, "--polarity", given)
        assert (refused.status, refused.out) == (2, "")
        assert what in refused.err


def test_a_sign_of_no_axis_or_of_a_straight_line_is_refused() -> None:
    table, _ = gyros(2)
    with pytest.raises(RequestError, match=r"fit: polarity y=-: no column is that axis; it has x; nothing was solved"):
        calrig.fit(table, {"x": "x_v"}, model="gyro", polarity={"y": "-"})
    with pytest.raises(RequestError, match=r"fit: polarity: belongs to fit: model gyro or .* not to fit: model linear"):
        calrig.fit(table, {"x": "x_v"}, model="linear", polarity={"x": "-"})
