"""What a sensor changed since its calibration is counted, or said to be nowhere: whatever axes it has."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from changed_sets import write_changed
from command import call
from package_outputs import TRUTH, output_v
from solved_sets import gyro_set, tp_set

from ams.inputs.shared_errors import SHIFTS
from ams.sets.coefficients import CoefficientSet

KEYS = ("largest_offset_shift_v", "largest_sensitivity_shift")
NOWHERE = "what the sensor changed since its calibration is in no standard deviation and in no interval"


def counting(*names: str) -> Callable[[dict[str, Any]], object]:
    """Return the change of a document that adds parts without size for these shifts."""

    def change(document: dict[str, Any]) -> None:
        sections = [document.get("package"), *(axis["primary"] for axis in document["axes"].values())]
        for section in sections:
            if section is not None:
                size = len(section["order"])
                empty = {"covariance": np.zeros((size, size)).tolist(), "degrees_of_freedom": None}
                section["components"] |= dict.fromkeys(names, empty)

    return change


def resting_on(dof: float, *names: str) -> Callable[[dict[str, Any]], object]:
    """Return the change of a document whose scatter was taken from so many degrees of freedom, with these shifts."""

    def change(document: dict[str, Any]) -> None:
        counting(*names)(document)
        for section in [document["package"], *(axis["primary"] for axis in document["axes"].values())]:
            section["components"]["residuals"]["degrees_of_freedom"] = dof

    return change


def said_of(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    coefficients: CoefficientSet,
    change: Callable[[dict[str, Any]], object],
    *options: str,
) -> str:
    stored = write_changed(folder / "set.json", coefficients, change)
    axes = tuple(coefficients.axes)
    rows = [[*(float(output_v(a, TRUTH[a], pitch, 0.0)) for a in axes), 0.0] for pitch in (-1.0, 0.0, 1.0)]
    data, header = folder / "data.csv", ",".join([*(f"{axis}_v" for axis in axes), "roll_deg"])
    data.write_text(header + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    outcome = call(capsys, "attitude", stored, data, *options, "--out", folder / "a.csv")
    assert outcome.status == 0, outcome.err
    counted = json.loads(call(capsys, "attitude", stored, data, *options, "--json", "--out", folder / "a.csv").out)
    assert (NOWHERE in outcome.err) == bool(counted["undeclared_shifts"][coefficients.sensor])
    return outcome.err


@pytest.mark.parametrize("axes", ["x", "xy", "xyz"])
def test_accelerometers_say_what_no_limit_of_a_shift_was_declared_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], axes: str
) -> None:
    said = said_of(tmp_path, capsys, tp_set(axes), counting())
    assert f"TP1: {NOWHERE} ({' and '.join(KEYS)} are not declared)" in said
    assert ("only where it makes the outputs contradict one another" in said) == (axes == "xyz")
    offset = said_of(tmp_path, capsys, tp_set(axes), counting(SHIFTS[0]))
    assert f"{NOWHERE} ({KEYS[1]} is not declared)" in offset
    assert NOWHERE not in said_of(tmp_path, capsys, tp_set(axes), counting(*SHIFTS))


def test_gyros_say_it_of_their_sensitivities_and_tell_their_degrees_of_freedom(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    noisy = gyro_set(1e-3, np.random.default_rng(2))
    options = ("--rate-hz", "100", "--interpolation", "hold")
    said = said_of(tmp_path, capsys, noisy, resting_on(4.0), *options)
    assert f"G1: {NOWHERE} ({KEYS[1]} is not declared)" in said
    assert "the zeros are taken as those of the calibration" in said
    # Student's factor of 95 % for four degrees of freedom, as any table has it.
    assert "rests on 4 degrees of freedom" in said
    assert "95 % lie within 2.78 of it and not within 1.96" in said
    many = said_of(tmp_path, capsys, noisy, resting_on(60.0, *SHIFTS), *options)
    assert NOWHERE not in many
    assert "degrees of freedom" not in many


def test_a_filter_says_it_of_its_accelerometers_and_advises_no_narrower_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gyros = write_changed(tmp_path / "gyro.json", gyro_set(), counting(*SHIFTS))
    force = write_changed(tmp_path / "tp.json", tp_set(), counting())
    at_rest = [n.primary["offset_v"] for n in gyro_set().axes.values()]
    level = [float(output_v(axis, TRUTH[axis], 0.0, 0.0)) for axis in "xyz"]
    columns = [*(f"{a}_v" for a in "xyz"), *(f"accelerometer_{a}_v" for a in "xyz")]
    row = ",".join(map(repr, [float(value) for value in (*at_rest, *level)])) + "\n"
    (tmp_path / "still.csv").write_text(",".join(columns) + "\n" + 200 * row)
    given = ("--accelerometers", force, "--rate-hz", "50", "--reading-sd-v", "1e-4", "--out", tmp_path / "a.csv")
    outcome = call(capsys, "attitude", gyros, tmp_path / "still.csv", *given)
    assert outcome.status == 0
    assert f"TP1: {NOWHERE} ({' and '.join(KEYS)} are not declared)" in outcome.err
    assert f"G1: {NOWHERE}" not in outcome.err
    assert "less than assumed: the rows scatter less than --force-sd-g has it" in outcome.err
    assert "no reason for a narrower one" in outcome.err
