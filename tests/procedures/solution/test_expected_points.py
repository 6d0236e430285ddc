"""What is told of points beforehand is what their solution says afterwards, with everything that the rig declares."""

from math import hypot, sqrt
from pathlib import Path

import pytest
from stored_runs import DATA, StoredCase

from procedures.journal.journal_reader import JournalReader
from procedures.kinds.expected_lines import forecast_of_points
from procedures.kinds.points import PointKind
from procedures.kinds.registry import KINDS
from procedures.kinds.solve import solve_record
from procedures.solution.expected_points import Solver, by_lines, by_model, expected_points
from procedures.solution.record import RunRecord, read_record
from rig.description.rig_file import RigDescription

FEW_DEGREES = 2.5
"""Stored runs have one to three replications: a standard uncertainty of so few degrees of freedom is off by so much."""


def _record(kind: str, folder: Path) -> RunRecord:
    with JournalReader.open(StoredCase(DATA / "runs_0_1_0" / kind).copy("finished", folder / "run")) as reader:
        return read_record(reader)


def _expected(record: RunRecord, rig: RigDescription, solver: Solver) -> dict[str, dict[str, float]]:
    """Return sensor axis to parameter to its standard uncertainty."""
    return {
        f"{name}.{axis}": {item.name: item.standard_uncertainty or 0.0 for item in found.solution.parameters}
        for name, sensor in record.plan.sensors.items()
        for axis, found in expected_points(rig, record.plan, name, sensor, solver).items()
    }


@pytest.mark.parametrize(
    ("kind", "solver"),
    [("rates_gyro", by_model), ("rates_linear", by_lines), ("two_level", by_lines), ("tumble_up_down", by_lines)],
)
def test_the_solution_of_a_run_states_what_was_expected(tmp_path: Path, kind: str, solver: Solver) -> None:
    """Root mean squares over the axes, parameter by parameter; an azimuth's depends on a coning angle that is small."""
    record = _record(kind, tmp_path)
    expected, solved = _expected(record, record.rig, solver), solve_record(record)
    ratios: dict[str, list[float]] = {}
    for label, parameters in expected.items():
        name, _, axis = label.partition(".")
        calibration = solved[name].calibration
        assert calibration is not None
        for item in calibration.axes[axis].parameters:
            assert item.standard_uncertainty is not None
            kept = ratios.setdefault(item.name, [])
            kept.append(item.standard_uncertainty / parameters[item.name])
    for parameter, of_axes in ratios.items():
        if parameter != "azimuth_deg":
            assert 1.0 / FEW_DEGREES < sqrt(sum(ratio**2 for ratio in of_axes) / len(of_axes)) < FEW_DEGREES, parameter


@pytest.mark.parametrize("u_ut", [0.4, 2.0])
def test_a_coil_s_error_of_scale_is_expected_in_the_gain(tmp_path: Path, u_ut: float) -> None:
    """u(A)/A = u_B/B beside everything else; 0.4 µT of 40 µT cost a hundredth of the gain."""
    record = _record("two_level", tmp_path)
    coil = record.rig.field["coil"]
    largest_ut = max(abs(dwell.applied.field_ut) for dwell in record.plan.dwells if dwell.applied is not None)
    without, declared = (
        _expected(
            record,
            record.rig.model_copy(update={"field": {"coil": coil.model_copy(update={"uncertainty_ut": each})}}),
            by_lines,
        )
        for each in (0.0, u_ut)
    )
    assert without
    for label, parameters in declared.items():
        scale = u_ut / largest_ut
        assert parameters["gain_ut_per_ut"] == pytest.approx(hypot(without[label]["gain_ut_per_ut"], scale), rel=0.02)


@pytest.mark.parametrize("kind", ["static", "profile_harmonic", "profile_ramp"])
def test_of_rows_that_nobody_knows_before_the_run_nothing_is_told(tmp_path: Path, kind: str) -> None:
    """A long rest draws no line, and the rows of a motion are made from what it was."""
    record = _record(kind, tmp_path)
    own = KINDS[record.plan.kind]
    assert isinstance(own, PointKind)
    assert forecast_of_points(record.rig, record.plan, own.forecast_solver(record.plan)).expected == ()
