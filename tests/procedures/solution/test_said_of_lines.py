"""What nobody declared is said of straight lines as it is of models, and no line drops what its files ask for."""

from pathlib import Path

import numpy as np
import pytest
from command import call
from small_run import PROCEDURE, bench

from ams.calibration_result import Calibration
from procedures.delivery.deliver import SolvedRun, deliver, sets_of, solve_run
from procedures.kinds.read import read_procedure
from rig.errors import DescriptionError

GRID = PROCEDURE[PROCEDURE.index('kind = "grid"') : PROCEDURE.index("[dwell]")]
UP_AND_DOWN = 'kind = "tumble"\nreplications = 2\n[design]\nkind = "up-down"\n'
CHECK = PROCEDURE[PROCEDURE.index("[check]") :]
KNOWN = "{ offset_tc_v_per_degc = 1e-5, sensitivity_tc_per_degc = 0.0, reference_temperature_degc = 20.0 }"
LIMIT = ("increment_deg = 1.0", "increment_deg = 1.0\nuncertainty_arcsec = 1.0")
LEVEL = (
    "[twin]\n",
    "[level]\nuncertainty_arcsec = 1.0\nbefore = { about_pitch_arcsec = 1.0, about_roll_arcsec = 1.0 }\n[twin]\n",
)


def ran(folder: Path, *rig: tuple[str, str], solve: str = "") -> SolvedRun:
    """Return an up-and-down tumble of a package in volts on a table, solved as straight lines."""
    folder.mkdir()
    procedure = ((GRID, UP_AND_DOWN), (CHECK, f'[solve]\nmodel = "linear"\n{solve}\n'))
    made = bench(folder, rig, procedure)
    made.run(folder / "run")
    return solve_run(folder / "run")


def solved(folder: Path, *rig: tuple[str, str], solve: str = "") -> Calibration:
    ((_, sensor),) = ran(folder, *rig, solve=solve).sensors.items()
    assert sensor.calibration is not None, sensor.failure
    return sensor.calibration


def kinds(calibration: Calibration) -> set[str]:
    return {finding.kind for axis in calibration.axes.values() for finding in axis.findings}


def test_a_line_says_what_nobody_declared_of_table_and_base(tmp_path: Path) -> None:
    bare = solved(tmp_path / "bare")
    assert kinds(bare) >= {"table-undeclared", "level-undeclared", "meter-undeclared"}
    assert any("(pitch, roll)" in remark for remark in bare.remarks)
    declared = solved(tmp_path / "declared", LIMIT, LEVEL)
    assert kinds(declared).isdisjoint({"table-undeclared", "level-undeclared"})
    assert "meter-undeclared" in kinds(declared)


def test_a_drift_that_the_file_asks_for_is_in_a_line_its_budget_and_its_set(tmp_path: Path) -> None:
    """The twin's outputs drift by 1 mV a replication, which the numbers of a line knew nothing of."""
    drift = ("noise_v = 2e-5 }", "noise_v = 2e-5, offset_drift_v_per_replication = 1e-3 }")
    run = ran(tmp_path / "asked", drift, solve='time_term = "linear"')
    (sensor,) = run.sensors.values()
    assert sensor.calibration is not None, sensor.failure
    rates = {label: {item.name: item for item in axis.parameters} for label, axis in sensor.calibration.axes.items()}
    assert all(found["offset_drift_v_per_h"].value > 0.0 for found in rates.values())
    assert set(sensor.budgets) == set(rates)
    assert not deliver(run, f"sqlite:///{tmp_path / 'archive.sqlite'}").failures
    (entry,) = sets_of(run).values()
    assert "reference_time_s" in str(entry.document)
    plain = solved(tmp_path / "plain", drift)
    for label, axis in plain.axes.items():
        assert axis.parameters[0].value != rates[label][axis.parameters[0].name].value


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ('temperature = "estimate"', "has no term of temperature"),
        (
            f'temperature = "apply"\nknown_temperature."SN1.x" = {KNOWN}',
            "has no term of",
        ),
        ('extended = "test"', "has no terms of second and third order"),
    ],
)
def test_a_procedure_of_lines_refuses_what_no_line_is_solved_with(tmp_path: Path, key: str, words: str) -> None:
    text = PROCEDURE.replace(GRID, UP_AND_DOWN).replace(CHECK, f'[solve]\nmodel = "linear"\n{key}\n')
    (tmp_path / "procedure.toml").write_text(text, encoding="utf-8")
    with pytest.raises(DescriptionError) as caught:
        read_procedure(tmp_path / "procedure.toml")
    assert words in str(caught.value)
    assert f"solve.{key.split(' ', maxsplit=1)[0]}" in str(caught.value)
    (tmp_path / "procedure.toml").write_text(text.replace(key, 'extended = "no"'), encoding="utf-8")
    read_procedure(tmp_path / "procedure.toml")


@pytest.mark.parametrize(
    "options",
    [
        ("--temperature", "estimate"),
        ("--temperature", "apply", "--known-temperature", "x=1e-3,1e-4", "--reference-temperature-degc", "22"),
    ],
)
def test_a_file_of_levels_is_refused_with_a_term_that_no_line_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...]
) -> None:
    chance, rows = np.random.default_rng(3), ["replication,point,reference_ut,time_s,temperature_degc,x_v"]
    for row in range(20):
        level = -100.0 + 50.0 * (row % 5)
        read = 0.02 + 0.01 * level + 1e-4 * chance.standard_normal()
        rows.append(f"{row // 5 + 1},{row % 5 + 1},{level},{10 * row},{20.0 + chance.random():.2f},{read:.6f}")
    (tmp_path / "levels.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    answer = call(capsys, "fit", tmp_path / "levels.csv", "--model", "linear", "--axis", "x=x_v", *options)
    assert answer.status == 2
    assert "a straight line of known levels has no term of it; nothing was solved" in answer.err
    assert "defect" not in answer.err
