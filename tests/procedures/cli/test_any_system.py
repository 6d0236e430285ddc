"""A whole job without anything that only POSIX systems have: every command works, or refuses with a sentence."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from job_files import job
from made_once import made_once

STEPS = """
import json, sys
sys.path[:0] = SUPPORT
from without_posix import take_away_posix
take_away_posix()

import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from procedures.cli.main import run_command
from reports_left_out import reports_left_out
from rig.assembly.simulate import write_rig
import calrig

told = {}
def command(name, *words):
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = run_command([str(word) for word in words])
    told[name] = [int(status), out.getvalue(), err.getvalue()]

folder = Path(sys.argv[1])
kept = folder / "kept.txt"
with kept.open("w"):
    for act in (kept.unlink, lambda: kept.replace(folder / "other"), lambda: procedure_file.replace(kept)):
        procedure_file = folder / "procedure.toml"
        try:
            act()
        except PermissionError:
            continue
        raise AssertionError("an open file was replaced")
kept.unlink()
procedure, rig, ported = folder / "procedure.toml", folder / "rig.toml", folder / "ported.toml"
with reports_left_out():
    command("run", "run", procedure, "--rig", rig, "--out", folder / "runs ü", "--json")
    command("status", "status", "--out", folder / "runs ü", "--json")
    command("solve", "solve", "--out", folder / "runs ü", "--json")
command("data", "data", "--runs", folder / "runs ü", "--json")
command("devices", "devices", "--json")
command("pty", "simulate", rig, "--pty")
with calrig.simulate(rig, time_factor=50.0) as addresses:
    write_rig(rig, addresses, 50.0, ported)
    command("home", "jog", "--rig", ported, "--axis", "pitch", "--home", "--json")
    command("jog", "jog", "--rig", ported, "--axis", "pitch", "--to", "10", "--json")
    command("read", "jog", "--rig", ported, "--read", "--json")
command("attach", "attach", "--out", folder / "runs ü")
print(json.dumps(told))
"""


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> dict[str, Any]:
    """Name of a step to what it left with: status, standard output, standard error."""
    folder = made_once("any system", _take_every_step, tmp_path_factory, request.config)
    return dict(json.loads((folder / "told.json").read_text(encoding="utf-8")))


def _take_every_step(folder: Path) -> None:
    job(folder, {"step = 60.0": "step = 120.0", "replications = 2": "replications = 1", '["csv", "mat"]': "[]"})
    support = [str(Path(__file__).parents[2] / "support"), str(Path(__file__).parents[3])]
    script = STEPS.replace("SUPPORT", repr(support))
    done = subprocess.run([sys.executable, "-c", script, str(folder)], capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    (folder / "told.json").write_text(done.stdout.splitlines()[-1], encoding="utf-8")


@pytest.mark.parametrize("step", ["run", "status", "solve", "data", "devices", "home", "jog", "read"])
def test_a_command_works(outcomes: dict[str, Any], step: str) -> None:
    status, out, err = outcomes[step]
    assert (status, "defect" in err) == (0, False), err
    json.loads(out)


def test_the_run_is_whole(outcomes: dict[str, Any]) -> None:
    document = json.loads(outcomes["run"][1])
    assert document["state"] == "finished"
    assert document["dwells_done"] == document["dwells_planned"] > 0
    assert document["delivery"]["set"] == document["delivery"]["archive"] == "done"
    assert json.loads(outcomes["solve"][1])["sensors"] == document["sensors"]


def test_an_axis_moves_and_it_is_said_that_nobody_guards_it(outcomes: dict[str, Any]) -> None:
    _, out, err = outcomes["jog"]
    assert json.loads(out)["position_deg"] == pytest.approx(10.0, abs=0.01)
    assert "this system has no stop guard" in err


@pytest.mark.parametrize(
    ("step", "sentence"),
    [
        ("pty", "pseudo-terminals: this system has none; nothing was served; leave --pty out"),
        ("attach", "no process runs this run, it is finished"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(outcomes: dict[str, Any], step: str, sentence: str) -> None:
    status, _, err = outcomes[step]
    assert status == 2
    assert sentence in err
