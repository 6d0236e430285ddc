"""The wheel alone in new environments: bare, with each extra by itself, and with all of them.

Needs a package index; `make soak` runs it, and weekly CI. With ``CALRIG_INSTALLED_SIZES=FILE`` the installed sizes are
written there, which is where the table of docs/decisions/0002 comes from.
"""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
from pathlib import Path
from typing import Any

import pytest
from example_files import EXAMPLE_RIG
from job_files import job
from programs import require_program

pytestmark = [pytest.mark.soak, pytest.mark.timeout(1800)]

ROOT = Path(__file__).parents[2]
EXTRAS: dict[str, list[str]] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "optional-dependencies"
]
HELD_BY = {
    "report": {"report.html", "report.pdf"},
    "certificate": {"report.html", "report.pdf"},
    "export": {"export hdf5"},
    "all": {"report.html", "report.pdf", "export hdf5"},
}
"""What a run of this test leaves with an extra and not without it."""
FACADE = """
import json, sys
import calrig
run = calrig.read_run(sys.argv[1])
solved = run.solve()
found = calrig.fit(sys.argv[2], {"x": "sx_v", "y": "sy_v", "z": "sz_v"})
planned = calrig.plan({"procedure": {"title": "t", "kind": "grid", "replications": 2}}, sys.argv[3], points=[
    (pitch, roll) for pitch in (-60, -30, 0, 30, 60) for roll in (-180, -90, 0, 90)])
print(json.dumps({
    "parameters": solved.parameters.to_dict("records"),
    "mean": run.readings["mean"].tolist(),
    "steps": len(planned.steps),
    "fitted": len(found.parameters),
    "html": all(one._repr_html_() for one in (run, solved, found, planned)),
}))
"""
NOTEBOOKS = """
import pathlib, sys
import nbformat
from nbclient import NotebookClient
folder = pathlib.Path(sys.argv[1])
for path in sorted(folder.glob("*.ipynb")):
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    print(path.name)
"""
AMS_ALONE = """
import sys
import ams
found = ams.load_set(sys.argv[1])
assert ams.verify(sys.argv[1]).forward_vectors > 0
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, made from the sdist as an index would; made twice it is the same to the last byte."""
    folders = [tmp_path_factory.mktemp(f"dist{number}") for number in (1, 2)]
    for folder in folders:
        subprocess.run([*UV, "build", "--quiet", "--sdist", "--wheel", "--out-dir", str(folder), str(ROOT)], check=True)
    first, second = ([*folder.glob("*.whl"), *folder.glob("*.tar.gz")] for folder in folders)
    assert [entry.read_bytes() for entry in first] == [entry.read_bytes() for entry in second]
    return first[0]


UV = (sys.executable, "-m", "uv")


class Installation:
    """One environment that holds the wheel and what an extra brings."""

    def __init__(self, folder: Path, wheel: Path, extra: str, *beside: str) -> None:
        """``beside``: other distributions that are installed with it."""
        self.folder, self.extra = folder, extra
        venv.create(folder)
        self.bin = folder / ("Scripts" if os.name == "nt" else "bin")
        text = f"{wheel}[{extra}]" if extra else str(wheel)
        index = [*UV, "pip", "install", "--quiet", "--python", str(self.bin / "python"), text, *beside]
        subprocess.run(index, check=True)

    def run(self, *words: object, statuses: tuple[int, ...] = (0,)) -> str:
        """Run a program of this environment outside the checkout; returns its standard output."""
        program = str(self.bin / str(words[0]))
        done = subprocess.run(
            [program, *map(str, words[1:])],
            capture_output=True,
            encoding="utf-8",
            cwd=self.folder,
            env={name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))},
        )
        assert done.returncode in statuses, (words, done.returncode, done.stderr)
        assert "defect" not in done.stderr, done.stderr
        return done.stdout

    def json(self, *words: object, statuses: tuple[int, ...] = (0,)) -> Any:
        return json.loads(self.run("calrig", *words, "--json", statuses=statuses))

    @property
    def size_mb(self) -> float:
        """Of what is installed, compiled modules left out."""
        files = (path for path in (self.folder / "lib").rglob("*") if path.is_file() and path.suffix != ".pyc")
        return sum(path.stat().st_size for path in files) / 1e6


@pytest.fixture(scope="module", params=["", *EXTRAS], ids=lambda extra: extra or "bare")
def installation(request: pytest.FixtureRequest, wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installation:
    return Installation(tmp_path_factory.mktemp("environment") / "env", wheel, request.param)


def test_the_whole_job_with_what_is_installed(installation: Installation, tmp_path: Path) -> None:
    _note_size(installation)
    libraries = installation.json("--version")["extras"]
    brought = {name for name, version in libraries.items() if version is not None}
    assert (brought == set(libraries)) == (installation.extra == "all"), brought

    procedure, rig = job(tmp_path, {'["csv", "mat"]': '["csv", "hdf5"]'})
    runs = tmp_path / "runs"
    undelivered = installation.json("check", procedure, "--rig", rig, "--out", runs)["undelivered"]
    missing = {line.partition(":")[0] for line in undelivered}
    assert missing == HELD_BY["all"] - HELD_BY.get(installation.extra, set())

    text = installation.json("run", procedure, "--rig", rig, "--out", runs, statuses=(0, 1))
    run = Path(text["run"])
    assert text["state"] == "finished"
    assert {name for name in ("report.html", "report.pdf") if not (run / name).exists()} == missing - {"export hdf5"}

    document = json.loads((run / "coefficients" / "SN1047.json").read_text(encoding="utf-8"))
    facade = json.loads(installation.run("python", "-c", FACADE, run, ROOT / "examples" / "observations.csv", rig))
    _is_the_set(facade, document)
    assert facade["html"]
    assert facade["steps"] > 40
    assert facade["fitted"] > 12
    if (run / "report.html").exists():
        _numbers_stand_in_the_page(run, document)

    tables = tmp_path / "tables"
    installation.run("calrig", "data", run, "--out", tables)
    with (tables / "readings.csv").open(encoding="utf-8", newline="") as stream:
        assert [float(row["mean"]) for row in csv.DictReader(stream)] == facade["mean"]
    formats = ("parquet", "hdf5", "xarray")
    wanted = (0,) if installation.extra in ("export", "all") else (2,)
    for name in formats:
        installation.run("calrig", "data", run, "--to", name, "--out", tmp_path / name, statuses=wanted)


def test_the_run_of_the_demo_is_the_same_by_page_and_by_data_door(wheel: Path, tmp_path: Path) -> None:
    installation = Installation(tmp_path / "env", wheel, "all")
    text = installation.json("demo", "--out", tmp_path / "demo")
    run = Path(text["run"])
    document = json.loads((run / "coefficients" / "SN1047.json").read_text(encoding="utf-8"))
    facade = json.loads(
        installation.run("python", "-c", FACADE, run, ROOT / "examples" / "observations.csv", EXAMPLE_RIG)
    )
    _is_the_set(facade, document)
    _numbers_stand_in_the_page(run, document)
    tables = tmp_path / "tables"
    installation.run("calrig", "data", run, "--out", tables)
    with (tables / "readings.csv").open(encoding="utf-8", newline="") as stream:
        assert [float(row["mean"]) for row in csv.DictReader(stream)] == facade["mean"]


def test_the_notebooks_run(wheel: Path, tmp_path: Path) -> None:
    """With the report's libraries alone, which draw their pictures."""
    installation = Installation(tmp_path / "env", wheel, "report", "ipykernel", "nbclient", "nbformat")
    shutil.copytree(installation.folder / "share" / "calrig" / "examples", tmp_path / "examples")
    folder = tmp_path / "examples" / "notebooks"
    shown = installation.run("python", "-c", NOTEBOOKS, folder)
    assert shown.split() == sorted(path.name for path in folder.glob("*.ipynb"))


@pytest.mark.parametrize(
    "statement",
    [
        "print(ams.apply(found, 0.1, 0.2))",
        "print(ams.load(sys.argv[1]).attitude([[-0.007528, 0.001411, -2.511941]]))",
    ],
    ids=["a set and its volts", "angles"],
)
def test_ams_needs_numpy_alone(wheel: Path, tmp_path: Path, statement: str) -> None:
    environment = tmp_path / "env"
    venv.create(environment)
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    into = [*UV, "pip", "install", "--quiet", "--python", str(python)]
    subprocess.run([*into, "--no-deps", str(wheel)], check=True)
    subprocess.run([*into, "numpy"], check=True)
    one_set = ROOT / "tests" / "data" / "coefficient_set_v1.json"
    code = f"{AMS_ALONE}\n{statement}"
    done = subprocess.run([str(python), "-c", code, one_set], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def test_the_manual_page_and_the_examples_come_along(wheel: Path, tmp_path: Path) -> None:
    environment = tmp_path / "env"
    venv.create(environment)
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    subprocess.run([*UV, "pip", "install", "--quiet", "--python", str(python), "--no-deps", str(wheel)], check=True)
    assert (environment / "share/calrig/examples/rig.toml").exists()
    page = environment / "share/man/man1/calrig.1"
    shown = subprocess.run(
        [require_program("man"), "--warnings", "--local-file", str(page)], capture_output=True, text=True
    )
    assert (shown.returncode, shown.stderr) == (0, "")
    assert "calrig check" in shown.stdout


def _is_the_set(facade: dict[str, Any], document: dict[str, Any]) -> None:
    """What the facade solves from the journal is the coefficient set that the run left, to the last bit."""
    solved = {(row["axis"], row["parameter"]): row["value"] for row in facade["parameters"]}
    stated = {
        (axis, name): parameter["value"]
        for axis, section in document["axes"].items()
        for name, parameter in section["parameters"].items()
    }
    assert stated
    assert {key: solved[key] for key in stated} == stated


def _numbers_stand_in_the_page(run: Path, document: dict[str, Any]) -> None:
    """The sensitivities of the set are those that the page prints, to the digits that it prints."""
    text = re.sub(r"<[^>]+>|[\s\u2009\u202f]", "", (run / "report.html").read_text(encoding="utf-8"))
    for section in document["axes"].values():
        value = section["parameters"]["sensitivity_v_per_g"]["value"]
        assert f"{value:.4f}" in text, value


def _note_size(installation: Installation) -> None:
    named = os.environ.get("CALRIG_INSTALLED_SIZES")
    if named:
        with Path(named).open("a", encoding="utf-8") as stream:
            stream.write(f"{installation.extra or 'calrig alone'}: {installation.size_mb:.0f} MB\n")
