"""Without the extras: `check` says what a run would not leave, the run leaves all else, and nothing is a defect."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from job_files import job
from made_once import made_once

from ams.exports.optional_libraries import EXTRA_OF
from procedures.cli.main import run_command

ROOT = Path(__file__).parents[3]
STEPS = """
import io, json, sys
from contextlib import redirect_stderr, redirect_stdout
sys.modules |= dict.fromkeys(BLOCKED)
from procedures.cli.main import make_app, run_command
told = {}
def command(name, *words):
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = run_command(list(words))
    told[name] = [int(status), out.getvalue(), err.getvalue()]
procedure, rig, folder = sys.argv[1:]
command("check", "check", procedure, "--rig", rig, "--out", folder, "--json")
command("run", "run", procedure, "--rig", rig, "--out", folder, "--json")
command("plot", "design", "--kind", "D", "--pitch=-30:30:3", "--roll", "4", "--plot", folder + "/x.svg")
command("console", "console", "--out", folder)
command("people", "console", "people", "list")
def helps(app, *words):
    for name in app:
        if not name.startswith("-"):
            command(" ".join(["help of", *words, name]), *words, name, "--help")
            helps(app[name], *words, name)
helps(make_app())
print(json.dumps(told))
"""


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> dict[str, Any]:
    folder = made_once("extras", _take_every_step, tmp_path_factory, request.config)
    return dict(json.loads((folder / "told.json").read_text(encoding="utf-8")))


def _take_every_step(folder: Path) -> None:
    small = {"step = 60.0": "step = 120.0", "replications = 2": "replications = 1", '["csv", "mat"]': '["csv", "hdf5"]'}
    procedure, rig = job(folder, small)
    script = STEPS.replace("BLOCKED", repr(sorted(EXTRA_OF)))
    command = [sys.executable, "-c", script, procedure, rig, str(folder)]
    done = subprocess.run(command, capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    (folder / "told.json").write_text(done.stdout.splitlines()[-1], encoding="utf-8")


def test_check_tells_what_will_not_be_delivered(outcomes: dict[str, Any]) -> None:
    status, out, _ = outcomes["check"]
    assert status == 0
    found = json.loads(out)["undelivered"]
    by = "install it by: pip install 'calrig"
    assert found == [
        f"report.html: needs matplotlib, which is not installed; {by}[report]'",
        f"report.pdf: needs matplotlib, which is not installed; {by}[report]'",
        f"report.pdf: needs typst, which is not installed; {by}[report]'",
        f"report.pdf: needs lxml, which is not installed; {by}[certificate]'",
        f"export hdf5: needs h5py, which is not installed; {by}[export]'",
    ]


def test_the_run_leaves_everything_else(outcomes: dict[str, Any]) -> None:
    status, out, err = outcomes["run"]
    document = json.loads(out)
    assert (status, document["state"], len(document["sets"])) == (1, "finished", 1)
    assert document["delivery"]["set"] == document["delivery"]["archive"] == "done"
    assert "needs matplotlib, which is not installed" in document["delivery"]["html"]
    assert "needs h5py, which is not installed" in document["delivery"]["exports"]
    assert "defect" not in err


def test_a_command_that_needs_an_extra_says_which(outcomes: dict[str, Any]) -> None:
    status, _, err = outcomes["plot"]
    assert status == 2
    assert err == (
        "calrig: needs matplotlib, which is not installed; nothing was done; install it by: pip install "
        "'calrig[report]'\n"
    )


def test_the_console_says_which_extra_serves_it(outcomes: dict[str, Any]) -> None:
    status, out, err = outcomes["console"]
    assert (status, out) == (2, "")
    assert err == (
        "calrig: needs uvicorn, which is not installed; nothing was done; install it by: pip install "
        "'calrig[console]'\n"
    )
    assert outcomes["people"][0] == 0, "accounts need no extra"


def test_the_help_of_every_command_needs_no_extra(outcomes: dict[str, Any]) -> None:
    helps = {name: outcome for name, outcome in outcomes.items() if name.startswith("help of ")}
    assert {"help of console", "help of console people add", "help of run", "help of archive sign"} <= set(helps)
    assert {name: outcome for name, outcome in helps.items() if outcome[0] != 0 or outcome[2]} == {}


def test_with_the_extras_nothing_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    procedure, rig = job(tmp_path)
    assert run_command(["check", procedure, "--rig", rig, "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["undelivered"] == []


def test_every_library_of_an_extra_is_in_the_extra_that_is_told() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras: dict[str, list[str]] = project["optional-dependencies"]
    brought = {**extras, "certificate": [*extras["certificate"], *extras["report"]]}
    assert [
        name for name, extra in EXTRA_OF.items() if not any(entry.startswith(name) for entry in brought[extra])
    ] == []
    every = extras["all"][0].removeprefix("calrig[").removesuffix("]").split(",")
    assert sorted(every) == sorted(set(extras) - {"all"})
    needed = {entry.partition(">")[0].partition("=")[0] for entry in project["dependencies"]}
    assert needed.isdisjoint(EXTRA_OF)
