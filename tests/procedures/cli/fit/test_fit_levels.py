"""What known levels are wrong by: no residual of a straight line shows it, so it is stated, or the result says so."""

from datetime import date
from pathlib import Path

import calrig
import numpy as np
import pandas as pd
import pytest
from command import call

from ams.archive.sign_offs import SignOff
from ams.exports.formats import load_set
from ams.sets.stated_findings import LEVELS_NOT_COUNTED
from procedures.certificate.grounds import Grounds, gaps_of
from procedures.errors import RequestError

LEVELS_UT = (-50.0, -25.0, 0.0, 25.0, 50.0)
COUNTS_PER_UT = 20.0
SCALE_PPM, ZERO_UT = 1000.0, 0.5
AXES = {axis: f"m{axis}_counts" for axis in "xyz"}
STATED = {"reference_uncertainty_ppm": SCALE_PPM, "reference_zero_uncertainty": ZERO_UT}


def cage(seed: int, *, scale_ppm: float, zero_ut: float) -> tuple[pd.DataFrame, np.ndarray, np.ndarray]:
    """A triad in a cage of three coils, each a part too strong, in a field that stands there besides.

    Second and third: the true gain (µT a count) and offset (µT) of x, y and z. Half a count of noise.
    """
    chance = np.random.default_rng(seed)
    zero, slope = chance.normal(0.0, 30.0, 3), COUNTS_PER_UT * (1.0 + 0.01 * chance.standard_normal(3))
    wrong, stands_ut = 1e-6 * scale_ppm * chance.standard_normal(3), zero_ut * chance.standard_normal(3)
    rows = []
    for replication in range(1, 5):
        applied = [axis * level for axis in np.eye(3) for level in LEVELS_UT]
        for point, reference_ut in enumerate(applied, start=1):
            field_ut = reference_ut * (1.0 + wrong) + stands_ut
            read = zero + slope * field_ut + 0.5 * chance.standard_normal(3)
            rows.append((replication, point, *reference_ut, *read))
    names = ["replication", "point", *(f"reference_{axis}_ut" for axis in "xyz"), *AXES.values()]
    return pd.DataFrame(rows, columns=names), 1.0 / slope, -zero / slope


def within(stated: dict[str, float]) -> dict[str, float]:
    """Share of the axes of 40 campaigns whose truth lies in the stated 95 %."""
    inside = {"gain_ut_per_counts": [], "offset_ut": []}
    for seed in range(40):
        table, *truth = cage(seed, scale_ppm=SCALE_PPM, zero_ut=ZERO_UT)
        axes = calrig.fit(table, AXES, model="linear", **stated).document["axes"]
        for name, values in zip(inside, truth, strict=True):
            for axis, true in zip("xyz", values, strict=True):
                low, high = axes[axis]["parameters"][name]["interval_95"]
                inside[name].append(low <= true <= high)
    return {name: float(np.mean(found)) for name, found in inside.items()}


def test_a_cage_that_is_wrong_in_scale_and_zero_is_held_where_both_are_stated_and_not_where_none_is() -> None:
    held = within(STATED)
    assert min(held.values()) > 0.9
    assert max(within({}).values()) < 0.3


def test_what_is_stated_of_the_levels_is_the_uncertainty_of_gain_and_offset_and_stands_in_the_budget() -> None:
    table, gain, _ = cage(1, scale_ppm=0.0, zero_ut=0.0)
    bare, counted = (calrig.fit(table, AXES, model="linear", **stated).document["axes"]["x"] for stated in ({}, STATED))
    parameters = counted["parameters"]
    of_scale = 1e-6 * SCALE_PPM * gain[0]
    assert parameters["gain_ut_per_counts"]["standard_uncertainty"] == pytest.approx(of_scale, rel=0.05)
    assert parameters["offset_ut"]["standard_uncertainty"] == pytest.approx(ZERO_UT, rel=0.01)
    for name, entry in bare["parameters"].items():
        assert entry["value"] == pytest.approx(parameters[name]["value"], rel=1e-9)
    lines = {line["source"]: line for line in counted["budget"]["lines"]}
    assert lines["scale of the known levels"]["stated"] == "u 1000 ppm"
    assert lines["zero of the known levels"]["standard_uncertainty"]["offset_ut"] == pytest.approx(ZERO_UT, rel=1e-9)


@pytest.mark.parametrize(
    ("stated", "lacks"),
    [((), "(scale and zero)"), (("--reference-uncertainty-ppm", "1000"), "(zero)"),
     (("--reference-zero-uncertainty", "0.5"), "(scale)")],
)  # fmt: skip
def test_levels_of_which_something_is_not_stated_are_usable_at_best_and_their_set_has_no_certificate(
    stated: tuple[str, ...], lacks: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, *_ = cage(2, scale_ppm=0.0, zero_ut=0.0)
    table.to_csv(tmp_path / "cage.csv", index=False)
    line = ("fit", tmp_path / "cage.csv", "--model", "linear", *(f"--axis={axis}={AXES[axis]}" for axis in AXES))
    stored = tmp_path / "cage.json"
    document = call(capsys, *line, *stated, "--set", stored, "--sensor", "M1", "--json").document
    assert document["verdict"] == "usable"
    for axis in document["axes"].values():
        (warning,) = (text for text in axis["warnings"] if LEVELS_NOT_COUNTED in text)
        assert lacks in warning
    entry = load_set(stored)
    gaps = list(gaps_of(Grounds("1", date(2026, 3, 2), entry, None, SignOff(entry.sha256, (), ()))))
    assert any(LEVELS_NOT_COUNTED in gap for gap in gaps)


def test_levels_that_are_stated_in_full_are_sound() -> None:
    table, *_ = cage(2, scale_ppm=SCALE_PPM, zero_ut=ZERO_UT)
    found = calrig.fit(table, AXES, model="linear", **STATED)
    assert found.document["verdict"] == "sound"
    assert LEVELS_NOT_COUNTED not in str(found.document)


def test_two_levels_once_say_it_too() -> None:
    table, *_ = cage(2, scale_ppm=0.0, zero_ut=0.0)
    two = table[table["point"].isin([1, 5]) & (table["replication"] == 1)]
    warnings = calrig.fit(two, {"x": AXES["x"]}, model="linear").document["axes"]["x"]["warnings"]
    assert any(LEVELS_NOT_COUNTED in text for text in warnings)


def test_an_uncertainty_of_levels_belongs_to_straight_lines_and_is_above_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, *_ = cage(2, scale_ppm=0.0, zero_ut=0.0)
    with pytest.raises(RequestError, match=r"fit: reference_zero_uncertainty: belongs to fit: model linear, not to"):
        calrig.fit(table, AXES, model="gyro", reference_zero_uncertainty=0.5)
    table.to_csv(tmp_path / "cage.csv", index=False)
    line = ("fit", tmp_path / "cage.csv", "--model", "linear", "--axis", "x=mx_counts")
    asked = call(capsys, *line, "--reference-uncertainty-ppm", "0")
    assert asked.status == 2
    assert "--reference-uncertainty-ppm: got 0, allowed above 0 and below 100000 ppm" in asked.err
