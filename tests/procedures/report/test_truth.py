from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from report_journal import EXAMPLE_RIG
from report_scene import Scene, run_view
from stored_runs import DATA, StoredCase

from ams.calibration_result import AxisCalibration
from ams.observations import Observations
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_record
from procedures.report.truth import truth_of
from procedures.solution.record import read_record
from rig.description.read import read_rig
from rig.description.rig_file import Mount, RigDescription


def _solved(degc: float | None = None) -> tuple[Observations, AxisCalibration]:
    sensor = run_view(Scene(axes=("x",))).sensors[0]
    rows = sensor.observations
    assert rows is not None
    warm = None if degc is None else np.full(rows.rows, degc)
    return replace(rows, temperature_degc=warm), sensor.axes[0].calibration


def _rig(**truth: object) -> RigDescription:
    """The example rig with its x axis changed."""
    rig = read_rig(EXAMPLE_RIG)
    assert rig.twin is not None
    changed = rig.twin.truth["SN1047"]["x"].model_copy(update=truth)
    twin = rig.twin.model_copy(update={"truth": {"SN1047": {"x": changed}}})
    return rig.model_copy(update={"twin": twin})


def test_the_truth_is_that_of_the_rig_file() -> None:
    truth = truth_of(_rig(), "SN1047", "x", *_solved())
    assert (truth["offset_v"], truth["sensitivity_v_per_g"]) == (0.005, 2.5)
    assert (truth["coning_deg"], truth["azimuth_deg"]) == (0.5, 35.0)


def test_the_truth_is_stated_at_the_temperature_of_the_run() -> None:
    rig = _rig(offset_tc_v_per_degc=1e-4, sensitivity_tc_per_degc=2e-5)
    truth = truth_of(rig, "SN1047", "x", *_solved(degc=23.0))
    assert truth["offset_v"] == pytest.approx(0.005 + 3e-4)
    assert truth["sensitivity_v_per_g"] == pytest.approx(2.5 * (1 + 6e-5))


def test_what_drifts_has_no_single_truth() -> None:
    truth = truth_of(_rig(offset_drift_v_per_replication=1e-6), "SN1047", "x", *_solved())
    assert "offset_v" not in truth
    assert "sensitivity_v_per_g" in truth


def test_a_package_mounted_turned_and_a_real_rig_have_no_truth_to_show() -> None:
    rig = _rig()
    sensor = rig.sensors["SN1047"].model_copy(update={"mount": Mount(x="+y", y="-x")})
    assert truth_of(rig.model_copy(update={"sensors": {"SN1047": sensor}}), "SN1047", "x", *_solved()) == {}
    assert truth_of(rig.model_copy(update={"twin": None}), "SN1047", "x", *_solved()) == {}


@pytest.mark.parametrize("kind", ["rates_gyro", "profile_harmonic", "grid"])
def test_the_truth_of_every_angle_and_sensitivity_lies_where_it_was_found(kind: str, tmp_path: Path) -> None:
    run = StoredCase(DATA / "runs_0_1_0" / kind).copy("finished", tmp_path / "run")
    with JournalReader.open(run) as reader:
        record = read_record(reader)
    [(name, solved)] = solve_record(record).items()
    assert solved.calibration is not None
    for label, axis in solved.calibration.axes.items():
        truth = truth_of(record.rig, name, label, solved.observations, axis)
        found = {parameter.name: parameter.value for parameter in axis.parameters}
        sensitivity = next(parameter for parameter in found if parameter.startswith("sensitivity_v_per_"))
        for parameter, within in {"offset_v": 5e-4, sensitivity: 1e-3, "coning_deg": 0.01, "azimuth_deg": 1.0}.items():
            assert truth[parameter] == pytest.approx(found[parameter], abs=within), (label, parameter)
