"""What the rows of a file cannot tell of its outputs is said at its end, and in a document."""

import json
from pathlib import Path

import numpy as np
import pytest
from command import call
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, accelerometer_v
from package_outputs import TRUTH, output_v
from solved_sets import package_set, tp_set

import ams
from ams.exports.formats import export_set

SHORT_DEG = [(pitch, 0.3, 0.0) for pitch in np.linspace(-4.0, 4.0, 8)]


def written(path: Path, outputs: dict[str, list[float]], noise_v: float = 0.0) -> Path:
    chance, rows = np.random.default_rng(2), np.column_stack(list(outputs.values()))
    np.savetxt(
        path, rows + noise_v * chance.standard_normal(rows.shape), "%.9g", ",", header=",".join(outputs), comments=""
    )
    return path


def short_sweep(folder: Path) -> tuple[Path, Path, Path]:
    """Return the sets of a sting and a model package, and their rows at little pitch and less yaw."""
    sets = [folder / f"{name}.json" for name in ("sting", "model")]
    for name, path in zip(("sting", "model"), sets, strict=True):
        export_set(package_set(name), "json", path)
    outputs = {f"{a}_v": [accelerometer_v(a, TABLE_3_STING[a], e, "sting") for e in SHORT_DEG] for a in "xyz"}
    outputs |= {f"model_{a}_v": [accelerometer_v(a, TABLE_3_MODEL[a], e, "model") for e in SHORT_DEG] for a in "xyz"}
    return sets[0], sets[1], written(folder / "data.csv", outputs, 2e-5)


def test_a_short_sweep_of_two_packages_says_which_errors_it_does_not_show(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sting, model, data = short_sweep(tmp_path)
    out = tmp_path / "angles.csv"
    told = call(capsys, "attitude", sting, data, "--model-set", model, "--reading-sd-v", "2e-5", "--out", out, "--json")
    said = [line for line in told.err.splitlines() if "what 8 rows do not show" in line]
    assert len(said) == 1
    assert "° of y of the sting package, " in said[0]
    assert "a dead y of the sting package (no flag in " in said[0]
    document = json.loads(told.out)
    assert document["rows"] == 8
    assert document["unseen"]["text"] == said[0]
    assert document["unseen"]["found_share"] == 0.95
    outputs = {(o["package"], o["axis"]): o for o in document["unseen"]["outputs"]}
    assert list(outputs) == [(package, axis) for package in ("sting", "model") for axis in "xyz"]
    level, upright = outputs["sting", "y"], outputs["sting", "z"]
    assert level["found_arcsec"] > 50.0 * upright["found_arcsec"]
    assert level["dead_found_share"] < 0.2
    assert upright["dead_found_share"] == 1.0
    assert {c["angle"]: c["change_deg"] > c["expanded_uncertainty_deg"] for c in level["changes"]}["yaw"]
    assert "redundancy" not in out.read_text(), "the rows themselves are good and have no flag"


def test_the_same_file_says_the_same_twice_and_in_python(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sting, model, data = short_sweep(tmp_path)
    options = ("--model-set", model, "--reading-sd-v", "2e-5", "--out", tmp_path / "a.csv", "--json")
    first, second = (call(capsys, "attitude", sting, data, *options).out for _ in range(2))
    assert first == second
    package = ams.load(sting, model, reading_sd_v=2e-5)
    unseen = package.unseen(np.loadtxt(data, delimiter=",", skiprows=1), np.random.default_rng(0))
    assert unseen is not None
    in_document = json.loads(first)["unseen"]["outputs"]
    assert [output.found_v for output in unseen.outputs] == pytest.approx([o["found_v"] for o in in_document], rel=1e-6)


def test_rows_that_prove_a_fault_and_outputs_that_nothing_tests_say_nothing_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stored, out = tmp_path / "tp.json", tmp_path / "a.csv"
    export_set(tp_set(), "json", stored)
    attitudes = [(p, 2.0 * p) for p in np.linspace(-30.0, 30.0, 40)]
    outputs = {f"{axis}_v": [output_v(axis, TRUTH[axis], *at) for at in attitudes] for axis in "xyz"}
    good = written(tmp_path / "good.csv", outputs, 1e-5)
    wrong = written(tmp_path / "wrong.csv", outputs | {"z_v": [1.05 * value for value in outputs["z_v"]]}, 1e-5)
    given = ("--reading-sd-v", "1e-5", "--out", out, "--json")
    assert json.loads(call(capsys, "attitude", stored, good, *given).out)["unseen"]["rows"] == 40
    told = call(capsys, "attitude", stored, wrong, *given)
    assert "z is the faulty axis" in told.err
    assert "do not show" not in told.err
    assert json.loads(told.out)["unseen"] is None
    two = call(capsys, "attitude", stored, good, "--axis", "x=x_v", "--axis", "y=y_v", *given)
    assert json.loads(two.out)["unseen"] is None
    assert "do not show" not in two.err


@pytest.mark.parametrize("options", [(), ("--out", "a.csv", "--view")])
def test_a_document_has_standard_output_for_itself(
    stored: Path, data: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...]
) -> None:
    told = call(capsys, "attitude", stored, data, "--json", *options)
    assert told.status != 0
    assert "--json: standard output is for it alone: give --out, and no --view; nothing was read" in told.err
