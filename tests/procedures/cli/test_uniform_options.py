"""Laws of the command as a whole: one name and one meaning for an option, a grouped and quick help, no folder made."""

import inspect
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path

import pytest
from command import call
from example_files import EXAMPLE_RIG
from job_files import job
from run_folders import make_run

from procedures.cli import options
from procedures.cli.archive import archive, publish
from procedures.cli.main import GROUPS
from procedures.records.states import State

SHARED = {
    "json": (options.Json,),
    "archive": (options.Archive,),
    "operator": (options.Operator, options.NamedOperator),
    "run": (options.AnyRun, options.OnlyRun, options.NamedRun),
    "alerts": (options.Alerts,),
    "allow_network_folder": (options.AllowNetworkFolder,),
}
"""Name to the definitions that it may have."""
OTHERS = {("list_", "run"), ("note", "run")}
"""Of the same name with a meaning of its own: the identity of a run in the archive; TEXT where it stands alone."""


def commands() -> Iterator[Callable[..., object]]:
    for targets in GROUPS.values():
        for _, target, _ in targets:
            module, _, name = target.partition(":")
            if name != "app":
                yield getattr(import_module(f"procedures.cli.{module}"), name)
    for name in ("list_", "due", "search", "show", "compare", "history", "sign", "verify", "migrate"):
        yield getattr(archive, name)
    yield from (publish.publish, publish.demo)


def test_a_shared_option_is_defined_once() -> None:
    parameters = [
        (command.__name__, name, parameter.annotation)
        for command in commands()
        for name, parameter in inspect.signature(command, eval_str=True).parameters.items()
        if name in SHARED and (command.__name__, name) not in OTHERS
    ]
    assert len(parameters) > 40
    assert [parameter for parameter in parameters if parameter[2] not in SHARED[parameter[1]]] == []


def test_every_command_that_takes_a_run_takes_the_folder_of_runs() -> None:
    for command in commands():
        parameters = inspect.signature(command, eval_str=True).parameters
        if "run" in parameters and command.__name__ != "list_":
            name = "runs" if command.__name__ == "data" else "out"  # its --out takes the tables
            assert parameters[name].annotation == options.RunsFolder, command.__name__


@pytest.mark.parametrize("option", ["--out", "--runs"])
def test_the_folder_of_runs_goes_by_runs_in_every_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    """``--out`` is the folder of runs where a command writes nothing else; ``--runs`` is it everywhere."""
    make_run(tmp_path / "elsewhere" / "20260301T000000Z-one", State.FINISHED)
    assert call(capsys, "status", option, tmp_path / "elsewhere", "--json").document["state"] == "finished"
    outcome = call(capsys, "data", "--runs", tmp_path / "nowhere")
    assert (outcome.status, "nowhere" in outcome.err) == (2, True)


def test_the_help_lists_every_command_once_under_its_heading(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "--help").out
    rows = [line.strip("│╭─╮ ") for line in outcome.splitlines() if line.startswith(("│", "╭"))]
    names = {name for commands in GROUPS.values() for name, _, _ in commands}
    found = [row for row in rows if row in (*GROUPS, "Options") or row.split("  ")[0] in names]
    wanted = [line for heading, group in GROUPS.items() for line in (heading, *(name for name, _, _ in group))]
    assert [row.split("  ")[0] for row in found] == [*wanted, "Options"]


def test_the_help_loads_no_command_and_no_heavy_library() -> None:
    """It is asked for in a hurry: what a command needs is imported when it is called."""
    look = (
        "import sys; from procedures.cli.main import run_command; run_command(['--help']);"
        "print(sorted(m for m in sys.modules if m.partition('.')[0] in"
        "('numpy','scipy','pydantic','sqlalchemy','matplotlib','apsw','textual','pandas')"
        "or m.startswith('procedures.cli.')"
        " and m.rpartition('.')[2] not in ('main','failure','program_log','standard_streams','stop_at_once')))"
    )
    done = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_fit_loads_no_driver_and_no_archive() -> None:
    """A file needs neither, and they take half as long to load as all the rest."""
    look = (
        "import sys; from procedures.cli.main import run_command; run_command(['fit', '--help']);"
        "print(sorted(m for m in sys.modules if m == 'sqlalchemy'"
        "or m.startswith(('rig.drivers.', 'ams.archive.'))))"
    )
    done = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_command_tells_its_whole_text_when_asked_for_help(capsys: pytest.CaptureFixture[str]) -> None:
    text = " ".join(call(capsys, "void", "--help").out.split())
    assert "the journal keeps the dwells and says who took them back and why" in text


def test_check_takes_its_files_as_run_does(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    procedure, rig = job(tmp_path)
    assert call(capsys, "check", procedure, "--rig", rig, "--out", tmp_path, "--json").document["refusals"] == []
    assert "nothing wrong found" in call(capsys, "check", "--rig", rig, "--out", tmp_path).out
    assert call(capsys, "check", rig, procedure).status == 2


WRITING = (
    ("export", "SET", "--to", "csv", "--out", "FOLDER/x.csv"),
    ("fit", "DATA", "--axis", "x=x_v", "--sensor", "S", "--set", "FOLDER/x.json"),
    ("attitude", "SET", "DATA", "--out", "FOLDER/x.csv"),
    ("design", "--kind", "D", "--pitch=-30:30:3", "--roll", 4, "--csv", "FOLDER/x.csv"),
    ("design", "--kind", "D", "--pitch=-30:30:3", "--roll", 4, "--plot", "FOLDER/x.svg"),
    ("simulate", EXAMPLE_RIG, "--write", "FOLDER/x.toml"),
    ("certificate", "SN1", "--number", 7, "--out", "FOLDER"),
    ("archive", "history", "SN1", "--plot", "FOLDER/x.svg"),
    ("archive", "demo", "--out", "FOLDER/x.sqlite"),
    ("data", "RUN", "--out", "FOLDER"),
)


@pytest.mark.parametrize("command", WRITING, ids=lambda command: " ".join(map(str, command[:2])))
def test_a_folder_that_is_not_there_is_refused_before_anything_else_and_not_made(
    command: tuple[object, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "missing" / "deeper"
    refused = call(capsys, *(str(word).replace("FOLDER", str(missing)) for word in command))
    assert (refused.status, refused.out) == (2, "")
    assert str(missing) in refused.err
    assert "nothing was written; make the folder or give another" in refused.err
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_is_refused_is_not_told_by_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    procedure, rig = job(tmp_path)
    full = Path(rig)
    full.write_text(full.read_text(encoding="utf-8") + "\n[interlocks]\nmin_free_mb = 1e12\n", encoding="utf-8")
    refused = call(capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "runs")
    assert (refused.status, refused.out) == (2, "")
    assert len(refused.err.splitlines()) == 1
    assert "MB are free" in refused.err
    assert list((tmp_path / "runs").iterdir()) == []


def test_a_resume_that_is_refused_is_not_told_by_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = make_run(tmp_path / "run", State.FAILED)
    refused = call(capsys, "resume", run, "--operator", "anna", "--reason", "x")
    assert refused.status == 2
    assert [line for line in refused.err.splitlines() if not line.startswith("calrig: ")] == []
