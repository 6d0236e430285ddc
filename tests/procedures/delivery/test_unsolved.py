"""A defect in solving or showing a run costs no dwell, and the person who finds the run is told what to do."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest
from command import call
from small_run import Bench, bench, dwells_of

from ams.calibration import mountings
from ams.observations import Observations
from procedures.delivery.deliver import sensors_document, solve_run
from procedures.journal.journal_reader import JournalReader
from procedures.run.handover import handover
from procedures.solution import sufficient as sufficiency

SECOND = """
[sensors.SN2]
model = "three-axis package"
channels = { x = "dmm.u", y = "dmm.v", z = "dmm.w" }
nominal_sensitivity_v_per_g = 2.5
[twin]
seed = 7
[twin.truth.SN2]
x = { offset_v = 0.002, sensitivity_v_per_g = 2.5, coning_deg = 0.5, azimuth_deg = 15.0, noise_v = 2e-5 }
y = { offset_v = -0.001, sensitivity_v_per_g = 2.48, coning_deg = 0.3, azimuth_deg = -70.0, noise_v = 2e-5 }
z = { offset_v = 0.004, sensitivity_v_per_g = 2.52, coning_deg = 0.4, azimuth_deg = 100.0, noise_v = 2e-5 }
"""
MORE = ", ".join(f"{name} = {{ scanner = {index}, range_v = 10.0 }}" for index, name in enumerate("uvw", start=4))
LAST = "z = { scanner = 3, range_v = 10.0 }"
TWO = ((LAST, f"{LAST}, {MORE}"), ("[twin]\nseed = 7\n", SECOND))
KEPT = "every dwell of the run is kept in its journal: send the run's folder; calrig solve "


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("two"), rig=TWO)


@pytest.fixture(scope="module")
def measured(two: Bench) -> Path:
    """A finished run of two packages that nobody has solved yet."""
    two.run(two.folder / "measured")
    return two.folder / "measured"


@pytest.fixture
def run(measured: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for paper in ("write_paper", "_write_sensor_documents"):
        monkeypatch.setattr(f"procedures.delivery.deliver.{paper}", lambda *_: None)
    return Path(shutil.copytree(measured, tmp_path / "measured"))


def _singular(*_: object, **__: object) -> NoReturn:
    np.linalg.solve(np.zeros((2, 2)), np.ones(2))
    raise AssertionError


def _singular_at(monkeypatch: pytest.MonkeyPatch, sensor: str) -> None:
    """Let the linear algebra of one package end as that of an untried design does: in an error of numpy's."""
    whole = mountings.calibrate

    def calibrate(observations: Observations, *arguments: Any) -> object:
        if observations.source.endswith(sensor):
            _singular()
        return whole(observations, *arguments)

    monkeypatch.setattr(mountings, "calibrate", calibrate)


def _verdict(run: Path) -> dict[str, Any]:
    return dict(json.loads((run / "verdict.json").read_text(encoding="utf-8")))


def _next(run: Path) -> str:
    return handover(run).partition("\nnext       ")[2].partition("\n")[0]


def test_a_defect_at_one_package_is_told_everywhere_and_the_other_has_its_set(
    run: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = sensors_document(solve_run(run))
    with monkeypatch.context() as broken:
        _singular_at(broken, "SN1")
        told = call(capsys, "solve", run, "--json")
    sensors = json.loads(told.out)["sensors"]
    why = "a defect of calrig: LinAlgError: Singular matrix; it was not solved, and every dwell of the run is kept"
    assert told.status == 1
    assert f"SN1: {why}" in told.err
    assert "Traceback" not in told.err + told.out
    assert (sensors["SN1"]["axes"], sensors["SN1"]["verdict"]) == ({}, "not usable")
    assert sensors["SN2"]["axes"]["x"]["parameters"] == whole["SN2"]["axes"]["x"]["parameters"]
    assert sorted(path.name for path in (run / "coefficients").iterdir()) == ["SN2.json"]
    assert "Traceback" in (run / "defects.txt").read_text(encoding="utf-8")
    page = (run / "report.html").read_text(encoding="utf-8")
    assert "There is no result to use of SN1." in page
    assert "LinAlgError: Singular matrix; it was not solved" in page
    assert _verdict(run)["sentence"] == "There is no result to use of SN1."
    for said in ("SN1", "LinAlgError", "send the run", f"calrig solve {run} with a newer version of calrig"):
        assert said in _next(run)
    assert _next(run).count("calrig solve") == 1
    assert "verdict: There is no result to use of SN1." in call(capsys, "status", run).out
    again = call(capsys, "solve", run)
    assert (again.status, (run / "defects.txt").exists()) == (0, False)
    assert "newer version" not in handover(run)


def test_a_defect_in_what_all_packages_share_leaves_a_page_and_every_dwell(
    run: Path, measured: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("procedures.kinds.solve.judge_dwells", _singular)
    told = call(capsys, "solve", run)
    assert told.status == 1
    assert all(f"{name}: a defect of calrig: LinAlgError" in told.err for name in ("SN1", "SN2"))
    assert _verdict(run)["sentence"] == "There is no result to use of any sensor."
    assert not (run / "coefficients").exists()
    assert len(dwells_of(run)) == len(dwells_of(measured))


BROKEN: dict[str, tuple[str, Callable[..., NoReturn]]] = {
    "its visits": ("procedures.solution.record.judge_run", _singular),
    "its journal": ("procedures.delivery.deliver.read_record", _singular),
    "its picture": ("procedures.delivery.deliver.draw_report", _singular),
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_run_without_report_has_a_page_that_says_why_and_what_to_do(
    run: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    monkeypatch.setattr(*BROKEN[what])
    told = call(capsys, "solve", run)
    assert told.status == 1
    assert "Traceback" not in told.err + told.out
    assert "makes what is missing" not in told.err
    assert "Traceback" in (run / "defects.txt").read_text(encoding="utf-8")
    page = (run / "report.html").read_text(encoding="utf-8")
    assert "NO REPORT" in page
    assert "LinAlgError: Singular matrix; every dwell of the run is kept in its journal" in page
    assert _verdict(run)["trust"] == ("reserved" if what == "its picture" else "unusable")
    assert f"{KEPT}{run} with a newer version of calrig" in _next(run)
    assert _next(run).count("calrig solve") == 1
    with JournalReader.open(run) as reader:
        reader.verify()


def test_the_end_of_a_run_that_cannot_be_solved_is_told_in_a_sentence(
    two: Bench, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("procedures.delivery.deliver.read_record", _singular)
    files = two.folder / "procedure.toml", "--rig", two.folder / "rig.toml"
    told = call(capsys, "run", *files, "--out", tmp_path / "runs")
    (run,) = (tmp_path / "runs").iterdir()
    assert told.status == 1
    assert f"{run}: it could not be solved: a defect of calrig: LinAlgError" in told.err
    assert "this is a defect" not in told.err
    assert len(dwells_of(run)) > 24
    assert (run / "report.html").exists()


def test_a_defect_between_replications_ends_no_run(two: Bench, measured: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sufficiency, "_judged", _singular)
    found = sufficiency.sufficient(two.rig, two.plan, dwells_of(measured))
    assert not found.is_enough
    assert "not judged: a defect of calrig: LinAlgError: Singular matrix: one more" in found.text
