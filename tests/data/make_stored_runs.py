"""Make the runs that ``tests/procedures/test_stored_runs.py`` reads: of every kind a finished and a killed one.

Run once for a version whose journals, sets, exports and archives are to stay readable, and never again: what is stored
is evidence of what that version wrote, so an existing folder is refused and nothing in it is ever refreshed.

    python tests/data/make_stored_runs.py        writes tests/data/runs_<version>/

A case is a folder with ``rig.toml`` and ``procedure.toml``, the ``finished`` run, the ``interrupted`` run (same files,
killed at a crash point) and ``numbers.json``: what that version solved from the finished run, to which the interrupted
one must come when it is resumed; where that version itself came to others, ``resumed.json`` has them. Beside the cases
stand ``archive.sqlite`` with every set, what that version's archive commands answered (``archive.json``), and what
``calrig demo`` printed (``demo.json``).
"""

import json
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

from procedures.delivery.deliver import sensors_document, solve_run
from procedures.run.resume import resume

DATA = Path(__file__).parent
EXAMPLES = DATA.parents[1] / "examples"
CALRIG = Path(sys.executable).with_name("calrig")
FORMATS = ("csv", "mat", "hdf5", "parquet", "c", "c-fixed", "epics", "dcc", "linear")
NOT_KEPT = ("report.html", "report.pdf", "figures")
"""Pages are made anew from the journal; nothing is read from them."""


@dataclass(frozen=True)
class Case:
    """An example's files with pieces replaced, and where the interrupted run is killed."""

    rig: str
    procedure: str
    crash: str
    """Crash point and passage; without a passage the one at three quarters of the finished run's commits."""
    changes: Mapping[str, str] = field(default_factory=dict)
    """Patterns of the procedure's text."""
    exports: tuple[str, ...] = ()


SHORT_SETTLE = {r"window_s = 5.0, windows = 2, min_s = 5.0": "window_s = 1.0, windows = 2, min_s = 1.0"}
SMALL_GRID = {
    r'"three-axis[^"]*"': '"small grid"',
    r"replications = \d": "replications = 3",
    r"from = -90.0, to = 90.0, step = 10.0": "from = -60.0, to = 60.0, step = 60.0",
    r"from = -180.0, to = 180.0, step = 30.0": "from = -180.0, to = 90.0, step = 90.0",
    r"samples = 20": "samples = 5",
    r"reference_every = 25": "reference_every = 7",
    r"formats = .*": 'formats = ["csv"]',
}
TUMBLE = {
    r'"three-axis[^"]*"': '"tumble of six points"',
    r'kind = "grid"': 'kind = "tumble"',
    r"replications = \d": "replications = 3",
    r'kind = "D1"\n': 'kind = "T"\n',
    r"(?m)^(pitch_deg|roll_deg|usage_pitch_deg|order) = .*\n": "",
    r"samples = 20": "samples = 5",
    r"formats = .*": 'formats = ["csv"]',
}
CASES = {
    "grid": Case("rig.toml", "procedure.toml", "after-commit", SMALL_GRID, exports=FORMATS),
    "tumble": Case("rig.toml", "procedure.toml", "in-position:12", TUMBLE),
    "tumble_up_down": Case(
        "servo-mechanism/rig.toml",
        "servo-mechanism/accelerometer.toml",
        "before-commit",
        {r"replications = \d": "replications = 2", "samples = 60": "samples = 20", **SHORT_SETTLE},
    ),
    "rates_gyro": Case(
        "rate-table/rig.toml",
        "rate-table/rates.toml",
        "after-commit",
        {r"replications = \d": "replications = 2", r"\[10.0, 40.0\]": "[90.0]", r"dwell_s = 9.0": "dwell_s = 4.0"},
        exports=("csv", "c", "epics", "dcc"),
    ),
    "rates_linear": Case(
        "servo-mechanism/rig.toml",
        "servo-mechanism/gyro.toml",
        "after-commit",
        {
            r"replications = \d": "replications = 2",
            r"dwell_s = 300.0": "dwell_s = 20.0",
            r"\[10.0, 20.0\]": "[20.0]",
            r"\[9.0, 13.5\]": "[13.5]",
            **SHORT_SETTLE,
        },
    ),
    "profile_harmonic": Case(
        "rate-table/rig.toml", "rate-table/harmonic.toml", "after-commit", {r"replications = \d": "replications = 3"}
    ),
    "profile_ramp": Case(
        "rate-table/rig.toml", "rate-table/ramp.toml", "before-commit", {r"replications = \d": "replications = 3"}
    ),
    "static": Case(
        "servo-mechanism/rig.toml",
        "servo-mechanism/drift.toml",
        "after-commit",
        {
            r"replications = \d": "replications = 3",
            r"duration_s = 1200.0": "duration_s = 240.0",
            r"use_s = 120.0": "use_s = 20.0",
            **SHORT_SETTLE,
        },
    ),
    "two_level": Case(
        "servo-mechanism/rig.toml",
        "servo-mechanism/magnetometer.toml",
        "before-commit",
        {r"replications = \d": "replications = 2", r"rest_s = 60.0": "rest_s = 15.0", **SHORT_SETTLE},
    ),
}


def main() -> None:
    """Write every case, the exports of every set, and the archive of all that can be published."""
    target = DATA / f"runs_{version('calrig').replace('.', '_')}"
    if target.exists():
        sys.exit(f"{target}: stands already; what a version stored is never made anew; nothing was written")
    with tempfile.TemporaryDirectory(prefix="stored-runs-") as made:
        folder = Path(made)
        archive = f"sqlite:///{folder / 'archive.sqlite'}"
        for name, case in CASES.items():
            sys.stdout.write(f"{name}\n")
            _make(name, case, folder / name, archive)
        _archive_a_second_calibration(folder, archive)
        _look_up(folder, archive)
        (folder / "demo.json").write_text(_called("demo", "--out", folder / "demo", "--json"), encoding="utf-8")
        shutil.rmtree(folder / "demo")
        _keep(folder, target)


def _make(name: str, case: Case, folder: Path, archive: str) -> None:
    folder.mkdir()
    _write_files(case, folder)
    finished = json.loads(_calrig("run", folder, "--archive", archive))
    shutil.move(finished["run"], folder / "finished")
    solved = _called("solve", folder / "finished", "--archive", archive, "--json")
    (folder / "numbers.json").write_text(solved, encoding="utf-8")
    for entry in (folder / "finished" / "coefficients").glob("*.json"):
        for kind in case.exports:
            _export(entry, folder / "finished" / "exports", kind)
    _calrig("run", folder, crash=_passage(case.crash, folder / "finished" / "journal.sqlite"))
    (killed,) = (folder / "out").glob("*-*")
    shutil.move(killed, folder / "interrupted")
    for run in ("finished", "interrupted"):
        _without_log(folder / run)
    _note_where_resuming_differs(folder)


def _note_where_resuming_differs(folder: Path) -> None:
    """A motion begins elsewhere after a break, so its samples meet it at other moments: its numbers are kept too."""
    copy = Path(shutil.copytree(folder / "interrupted", folder / "resumed"))
    resume(copy, "tester")
    found = json.loads(json.dumps({"sensors": sensors_document(solve_run(copy))}, allow_nan=False))
    shutil.rmtree(copy)
    if found != json.loads((folder / "numbers.json").read_text(encoding="utf-8")):
        (folder / "resumed.json").write_text(json.dumps(found), encoding="utf-8")


def _write_files(case: Case, folder: Path) -> None:
    shutil.copyfile(EXAMPLES / case.rig, folder / "rig.toml")
    text = (EXAMPLES / case.procedure).read_text(encoding="utf-8")
    for pattern, new in case.changes.items():
        text, count = re.subn(pattern, new, text)
        assert count, pattern
    (folder / "procedure.toml").write_text(text, encoding="utf-8")


def _calrig(command: str, folder: Path, *options: str, crash: str | None = None) -> str:
    files = (folder / "procedure.toml", "--rig", folder / "rig.toml", "--out", folder / "out")
    return _called(command, *files, "--operator", "tester", "--json", *options, crash=crash)


def _called(*arguments: object, crash: str | None = None) -> str:
    """Standard output of ``calrig ARGUMENTS``, which must end well, or by the kill that was asked for."""
    more = {} if crash is None else {"CALRIG_CRASH_POINT": crash}
    done = subprocess.run(
        [CALRIG, *map(str, arguments)], env={**os.environ, **more}, capture_output=True, text=True, check=False
    )
    wanted = 0 if crash is None else -signal.SIGKILL
    if done.returncode != wanted:
        sys.exit(f"calrig {' '.join(map(str, arguments))}: status {done.returncode}: {done.stderr}")
    return done.stdout


def _look_up(folder: Path, archive: str) -> None:
    """What the archive answers, beside it: its list, one set, and two calibrations of one sensor compared."""
    where = ("--archive", archive, "--json")
    listed = json.loads(_called("archive", "list", *where))["sets"]
    grids = [entry["sha256"] for entry in listed if entry["run_id"].endswith("small-grid")]
    old, new = grids[0], grids[-1]
    found = {
        "list": listed,
        "show": {old: json.loads(_called("archive", "show", old[:12], *where))},
        "compared": [old, new],
        "compare": json.loads(_called("archive", "compare", old[:12], new[:12], *where)),
    }
    (folder / "archive.json").write_text(json.dumps(found), encoding="utf-8")


def _passage(crash: str, finished: Path) -> str:
    if ":" in crash:
        return crash
    connection = sqlite3.connect(finished)
    (commits,) = connection.execute("SELECT count(*) FROM events").fetchone()  # a dwell is committed with its event
    connection.close()
    return f"{crash}:{commits * 3 // 4}"


def _export(coefficients: Path, exports: Path, kind: str) -> None:
    exports.mkdir(exist_ok=True)
    written = Path(json.loads(_called("export", coefficients, "--to", kind, "--json"))["file"])
    shutil.move(written, exports / written.name)


def _archive_a_second_calibration(folder: Path, archive: str) -> None:
    """The grid's sensor with another seed, so that there is something to compare; and the first one is signed."""
    again = folder / "again"
    again.mkdir()
    for name in ("rig.toml", "procedure.toml"):
        text = (folder / "grid" / name).read_text(encoding="utf-8")
        (again / name).write_text(text.replace("seed = 7", "seed = 8"), encoding="utf-8")
    run_id = json.loads(_header(folder / "grid" / "finished" / "journal.sqlite"))["run_id"]
    (first,) = json.loads(_called("archive", "list", "--run", run_id, "--archive", archive, "--json"))["sets"]
    for role, who in (("prepared", "A. First"), ("reviewed", "B. Second")):
        _called("archive", "sign", first["sha256"][:12], role, "--name", who, "--archive", archive)
    _calrig("run", again, "--archive", archive)
    shutil.rmtree(again)


def _header(journal: Path) -> str:
    connection = sqlite3.connect(journal)
    text = connection.execute("SELECT document FROM header").fetchone()[0]
    connection.close()
    return str(text)


def _without_log(run: Path) -> None:
    """All of the journal in its one file; no row changes."""
    connection = sqlite3.connect(run / "journal.sqlite")
    connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    connection.close()


def _keep(folder: Path, target: Path) -> None:
    for name in CASES:
        shutil.rmtree(folder / name / "out")
        for run in ("finished", "interrupted"):
            for left in (*NOT_KEPT, "journal.sqlite-shm"):
                _remove(folder / name / run / left)
            for entry in (folder / name / run).glob("coefficients/*.json"):
                _remove(folder / name / run / "exports" / entry.name)  # the same bytes
    shutil.copytree(folder, target)


def _remove(path: Path) -> None:
    shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


if __name__ == "__main__":
    main()
