"""``import calrig``: quick, typed, and never another answer than the command's."""

import doctest
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Literal

import calrig
import pandas as pd
import pytest
from command import call
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, table_3_profile, write_package
from example_files import EXAMPLE_RIG
from finished_job import FinishedJob
from job_files import job
from stored_runs import CASES

from procedures.errors import RequestError, RunFailed

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "python.md"
OBSERVATIONS = ROOT / "examples" / "observations.csv"
PACKAGES = {"sting": TABLE_3_STING, "model": TABLE_3_MODEL}
AXES = {"x": "sx_v", "y": "sy_v", "z": "sz_v"}
GRID = next(case for case in CASES if case.folder.name == "grid")


def test_the_page_gives_what_it_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    GRID.copy("finished", tmp_path / "runs" / "a-small-run")
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    results = doctest.testfile(os.fspath(PAGE), module_relative=False, encoding="utf-8")
    assert results.attempted > 15
    assert results.failed == 0


def test_the_page_lists_every_name() -> None:
    text = PAGE.read_text(encoding="utf-8")
    functions = {name for name in calrig.__all__ if name.islower() and not name.startswith("_")}
    assert functions == {"fit", "load_set", "plan", "read_run", "run", "simulate"}
    assert [name for name in functions if f"| `calrig.{name}(" not in text] == []


def test_importing_it_loads_nothing_heavy_and_every_name_is_there() -> None:
    look = (
        "import sys, calrig; print(sorted(m for m in sys.modules if m.partition('.')[0] in "
        "('numpy', 'pandas', 'scipy', 'matplotlib', 'pydantic', 'ams', 'rig', 'procedures')))"
    )
    done = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[]"]
    assert dir(calrig) == sorted(calrig.__all__)
    assert [name for name in calrig.__all__ if not hasattr(calrig, name)] == []
    with pytest.raises(AttributeError, match="module 'calrig' has no attribute 'nothing'"):
        calrig.nothing  # type: ignore[attr-defined]  # noqa: B018


def test_fit_is_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    named = [word for axis, column in AXES.items() for word in ("--axis", f"{axis}={column}")]
    outcome = call(capsys, "fit", OBSERVATIONS, *named, "--rig", EXAMPLE_RIG, "--extended", "test", "--json")
    found = calrig.fit(str(OBSERVATIONS), AXES, rig=str(EXAMPLE_RIG), extended="test", sensor="SN1047")
    assert json.loads(json.dumps(found.document)) == outcome.document
    assert found.parameters["sensor"].unique().tolist() == ["SN1047"]


@pytest.mark.parametrize("package", ["sting", "model"])
def test_both_packages_are_fitted_as_the_command_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], package: Literal["sting", "model"]
) -> None:
    file = write_package(tmp_path / "obs.csv", package, PACKAGES[package], table_3_profile())
    named = [word for axis in "xyz" for word in ("--axis", f"{axis}={axis}_v")]
    outcome = call(capsys, "fit", file, "--model", "pitch-yaw-roll", "--package", package, *named, "--json")
    found = calrig.fit(file, {axis: f"{axis}_v" for axis in "xyz"}, model="pitch-yaw-roll", package=package)
    assert json.loads(json.dumps(found.document)) == outcome.document
    for given, said in ((None, "fit: package is missing"), ("stand", "fit: package got 'stand'")):
        with pytest.raises(RequestError, match=said):
            calrig.fit(file, {"x": "x_v"}, model="pitch-yaw-roll", package=given)
    with pytest.raises(RequestError, match="fit: package sting: belongs to fit: model pitch-yaw-roll"):
        calrig.fit(OBSERVATIONS, AXES, package="sting")


def test_a_standard_is_held_against_the_day_of_the_readings(tmp_path: Path) -> None:
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    rig = tmp_path / "rig.toml"
    rig.write_text(text.replace("due = 2027-06-30", "due = 2025-06-30"), encoding="utf-8")
    early, late = (calrig.fit(OBSERVATIONS, AXES, rig=rig, calibrated_on=day) for day in ("2025-06-30", "2025-07-01"))
    assert not any("2025-06-30" in text for text in early.warnings)
    assert any("due: 2025-06-30, before the readings of 2025-07-01" in text for text in late.warnings)


def test_a_table_is_refused_as_its_file_would_be() -> None:
    table = pd.read_csv(OBSERVATIONS)
    table.loc[3, "sx_v"] = float("nan")
    with pytest.raises(Exception, match=r"table: line 5: column sx_v: the cell is empty, allowed a finite number"):
        calrig.fit(table, AXES)
    with pytest.raises(RequestError, match=r"fit: model: got 'round', allowed are .*; nothing was solved"):
        calrig.fit(table, AXES, model="round")
    with pytest.raises(RequestError, match=r"fit: rig: .* not allowed with model 'linear'"):
        calrig.fit(table, {"x": "mx_counts"}, model="linear", rig=EXAMPLE_RIG)


def _levels(replications: int, levels: tuple[float, ...]) -> pd.DataFrame:
    """31.24 counts a microtesla about 12 counts, and a fixed scatter of a count."""
    rows = [(turn, point, level) for turn in range(1, replications + 1) for point, level in enumerate(levels, 1)]
    table = pd.DataFrame(rows, columns=["replication", "point", "reference_ut"])
    scatter = [((7 * index) % 11 - 5) / 5.0 for index in range(len(table))]
    table["mx_counts"] = 12.0 + 31.24 * table["reference_ut"] + scatter
    return table.assign(my_counts=-table["mx_counts"])


@pytest.mark.parametrize(("replications", "levels"), [(4, (-50.0, -25.0, 0.0, 25.0, 50.0)), (1, (-50.0, 50.0))])
def test_a_table_of_levels_is_solved_as_the_command_does(
    replications: int, levels: tuple[float, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = _levels(replications, levels)
    table.to_csv(tmp_path / "levels.csv", index=False)
    named = ["--axis", "x=mx_counts", "--axis", "y=my_counts", "--model", "linear"]
    outcome = call(capsys, "fit", tmp_path / "levels.csv", *named, "--json")
    found = calrig.fit(table, {"x": "mx_counts", "y": "my_counts"}, model="linear")
    assert json.loads(json.dumps(found.document)) == outcome.document
    assert found.document["axes"]["x"]["parameters"]["gain_ut_per_counts"]["value"] == pytest.approx(1 / 31.24, 1e-3)
    if replications > 1:
        assert found.parameters["parameter"].tolist() == 2 * ["gain_ut_per_counts", "offset_ut"]
        drawn = found.plot()
        assert [panel.get_xlabel() for panel in drawn.axes][-1] == "row"
        assert len(drawn.axes) == 2
    else:
        assert found.parameters.empty
        assert any("two levels once" in sentence for sentence in found.warnings)


def test_a_set_is_loaded_by_its_name_as_text_and_shows_itself() -> None:
    found = calrig.load_set(str(ROOT / "tests" / "data" / "coefficient_set_v1.json"))
    shown = found._repr_html_()
    assert found.sensor in shown
    for number in ("offset_v", str(found.document["axes"]["x"]["parameters"]["offset_v"]["value"])):
        assert number in shown


SAYS = "import json, sys; print('said', file=sys.stderr); print(json.dumps({'run': %r, 'state': %r}))"


def test_a_run_is_read_when_it_has_finished(
    finished_job: FinishedJob, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        "procedures.facade.rigs._COMMAND", (sys.executable, "-c", SAYS % (str(finished_job.run), "finished"))
    )
    done = calrig.run("procedure.toml", Path("rig.toml"), operator="A. Person")
    assert done.path == finished_job.run
    assert capsys.readouterr().err == "said\n"


def test_a_run_that_did_not_finish_says_how_it_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("procedures.facade.rigs._COMMAND", (sys.executable, "-c", SAYS % ("runs/r", "stopped")))
    with pytest.raises(RunFailed, match=r"runs/r: the run is stopped: said; calrig resume continues it"):
        calrig.run("procedure.toml", "rig.toml")


def test_a_run_that_cannot_begin_is_refused_in_the_sentence_of_the_command(tmp_path: Path) -> None:
    """All options are given, so that the command knows each."""
    options = {"out": tmp_path / "runs", "rehearse": True, "operator": "A. Person", "archive": "sqlite:///a.sqlite"}
    with pytest.raises(RequestError, match=r"^.*nowhere\.toml: "):
        calrig.run(tmp_path / "nowhere.toml", EXAMPLE_RIG, **options)


@pytest.mark.soak
def test_a_rehearsal_is_a_run_as_any_other(tmp_path: Path) -> None:
    procedure, rig = job(tmp_path)
    done = calrig.run(procedure, rig, out=tmp_path / "runs", rehearse=True, operator="A. Person")
    assert done.dwells["accepted"].all()
    assert done.path.parent == tmp_path / "runs"


COMPOSED = {
    "procedure": {"title": 'a "small" grid', "kind": "grid", "replications": 2},
    "design": {"kind": "D", "pitch_deg": range(-60, 61, 30), "roll_deg": {"from": -180.0, "to": 120.0, "step": 60.0}},
    "dwell": {"samples": 5, "settle": {"window_s": 1.0, "max_s": 30.0}},
}


def test_a_composed_plan_is_what_the_command_says_of_its_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    planned = calrig.plan(COMPOSED, str(EXAMPLE_RIG))
    outcome = call(
        capsys, "check", planned.save(tmp_path / "p.toml"), "--rig", EXAMPLE_RIG, "--out", tmp_path, "--json"
    )
    said = json.loads(json.dumps(planned.document))
    assert {key: outcome.document[key] for key in said} == said
    assert planned.preflight(tmp_path).refusals == ()
    steps = planned.steps
    assert len(steps) == said["dwells_planned"]
    assert steps["purpose"].value_counts().to_dict() == {"design": 60, "check": len(steps) - 60}
    assert planned.title in str(planned)
    assert "a &quot;small&quot; grid" in planned._repr_html_()
    assert len(planned.plot().axes) == 2


def test_points_are_visited_as_they_are_listed(tmp_path: Path) -> None:
    listed = [(10.0, 0.0), (-20.0, 90.0), (10.0, -90.0), (0.0, 0.0), (30.0, 180.0), (-50.0, 30.0)]
    table = pd.DataFrame(listed, columns=["pitch_deg", "roll_deg"], index=range(6, 0, -1))
    head = {"procedure": {"title": "mine", "kind": "grid", "replications": 2}, "solve": {"extended": "no"}}
    planned = calrig.plan(head, EXAMPLE_RIG, points=table)
    first = planned.steps.query("replication == 1 and purpose == 'design'")
    assert list(zip(first["pitch_deg"], first["roll_deg"], strict=True)) == listed
    saved = planned.save(tmp_path / "mine.toml")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine-points.csv", "mine.toml"]
    assert calrig.plan(saved, EXAMPLE_RIG).document == planned.document
    assert planned.save(saved) == saved
    with pytest.raises(RequestError, match=r"mine\.toml: is there already with another text; nothing was written"):
        calrig.plan(COMPOSED, EXAMPLE_RIG).save(saved)


def test_what_a_file_is_refused_for_a_composed_plan_is_refused_for() -> None:
    wrong = {**COMPOSED, "procedure": {**COMPOSED["procedure"], "replication": 3}}
    with pytest.raises(Exception, match=r"^composed procedure:5: procedure\.replication: .*replications"):
        calrig.plan(wrong, EXAMPLE_RIG)
    with pytest.raises(Exception, match=r"composed procedure:\d+: design.*pitch"):
        calrig.plan({**COMPOSED, "design": {"kind": "D", "pitch_deg": [-500.0, 0.0]}}, EXAMPLE_RIG)
    with pytest.raises(RequestError, match=r"plan: dwell\.samples: got <object object .*allowed are texts, numbers"):
        calrig.plan({**COMPOSED, "dwell": {"samples": object()}}, EXAMPLE_RIG)
    with pytest.raises(RequestError, match=r"points: got 'a', allowed are numbers in degrees"):
        calrig.plan(COMPOSED, EXAMPLE_RIG, points=[("a", 0.0)])  # type: ignore[list-item]


def test_a_plan_is_run_from_its_own_file(
    tmp_path: Path, finished_job: FinishedJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = f"import shutil, sys; shutil.copy(sys.argv[2], {str(tmp_path / 'asked.toml')!r}); "
    says = code + SAYS % (str(finished_job.run), "finished")
    monkeypatch.setattr("procedures.facade.rigs._COMMAND", (sys.executable, "-c", says, "run"))
    planned = calrig.plan(COMPOSED, EXAMPLE_RIG)
    assert calrig.run(planned).path == finished_job.run
    assert (tmp_path / "asked.toml").read_text(encoding="utf-8") == planned.text
    (tmp_path / "asked.toml").unlink()
    assert calrig.run(COMPOSED, EXAMPLE_RIG).path == finished_job.run
    assert (tmp_path / "asked.toml").read_text(encoding="utf-8") == planned.text
    with pytest.raises(RequestError, match="a plan knows its rig"):
        calrig.run(planned, EXAMPLE_RIG)
    with pytest.raises(RequestError, match="a procedure needs a rig file"):
        calrig.run("procedure.toml")
    saved = calrig.plan(planned.save(tmp_path / "p.toml"), EXAMPLE_RIG)
    saved.file.write_text("# another", encoding="utf-8")  # type: ignore[union-attr]
    with pytest.raises(RequestError, match=r"p\.toml: is not what was planned; nothing was begun; plan it again"):
        calrig.run(saved)


@pytest.mark.soak
def test_a_composed_plan_is_rehearsed(tmp_path: Path) -> None:
    planned = calrig.plan(COMPOSED, EXAMPLE_RIG)
    done = calrig.run(planned, out=tmp_path / "runs", rehearse=True, operator="A. Person")
    design = done.dwells.query("purpose == 'design' and accepted")
    request = planned.steps.query("purpose == 'design'")
    assert design["step"].tolist() == request.index.tolist()
    assert (abs(design["pitch_deg"].to_numpy() - request["pitch_deg"].to_numpy()) < 0.1).all()
