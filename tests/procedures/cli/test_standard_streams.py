"""Standard streams that are closed, full or gone change neither what a command does nor how it ends."""

import json
import os
import sqlite3
import subprocess
import sys
from contextlib import closing, suppress
from pathlib import Path
from typing import TextIO

import pytest
from small_run import PROCEDURE, RIG

from procedures.cli.main import run_command

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="a shell that closes streams, and /dev/full")
CALRIG = (sys.executable, "-m", "procedures.cli.start")
RINGS = "import sys; open(sys.argv[1], 'a').write(sys.stdin.read())"
"""Appends a message to a file."""
STANDARD = {0, 1, 2}


def _status(redirections: str, *words: object) -> int:
    """Run ``calrig WORDS REDIRECTIONS`` in a shell."""
    return subprocess.run(
        ["sh", "-c", f'exec "$@" {redirections}', "sh", *CALRIG, *map(str, words)], timeout=120
    ).returncode


def _files(folder: Path, rig: str = RIG, procedure: str = PROCEDURE) -> list[str]:
    (folder / "rig.toml").write_text(rig, encoding="utf-8")
    (folder / "procedure.toml").write_text(procedure, encoding="utf-8")
    return ["run", str(folder / "procedure.toml"), "--rig", str(folder / "rig.toml"), "--out", str(folder / "runs")]


def _states(folder: Path) -> list[str]:
    (journal,) = folder.glob("runs/*/journal.sqlite")
    with closing(sqlite3.connect(journal)) as connection:
        return [detail for (detail,) in connection.execute("select detail from events where kind = 'state'")]


@pytest.mark.parametrize(
    "closed",
    ["<&- >&- 2>&-", *(pytest.param(each, marks=pytest.mark.thorough) for each in ("2>&-", ">&- 2>&-", "<&-", ">&-"))],
)
def test_a_run_runs_without_standard_streams(tmp_path: Path, closed: str) -> None:
    """As cron and some supervisors begin it: the run was never begun, and its empty folder stayed."""
    assert _status(closed, *_files(tmp_path)) == 0
    assert "finished" in _states(tmp_path)[-1]


def test_a_terminal_that_is_held_keeps_no_run_waiting(tmp_path: Path) -> None:
    """Ctrl-S, a pager, a link that hangs: the next line of progress was waited for, an axis turning perhaps."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    with suppress(BlockingIOError):
        while True:
            os.write(writer, bytes(512))
    os.set_blocking(writer, True)
    run = [*CALRIG, *_files(tmp_path)]
    assert subprocess.run(run, stdout=subprocess.DEVNULL, stderr=writer, timeout=100).returncode == 0
    assert "finished" in _states(tmp_path)[-1]
    os.close(reader)
    os.close(writer)


def test_a_refusal_that_no_stream_takes_rings(tmp_path: Path) -> None:
    words = _files(tmp_path, RIG.replace("seed = 7", 'seed = 7\ntime = "real"'), "[procedure]\n")
    ring = json.dumps([sys.executable, "-c", RINGS, str(tmp_path / "rung.txt")])
    (tmp_path / "alerts.toml").write_text(f"command = {ring}\n", encoding="utf-8")
    assert _status("2>&-", *words, "--alerts", tmp_path / "alerts.toml") == 2
    assert "not begun" in (tmp_path / "rung.txt").read_text(encoding="utf-8")


def test_no_file_gets_the_number_of_a_stream_that_was_closed() -> None:
    """What a library writes on standard error would go into it."""
    look = "import os; print(os.open('/dev/zero', os.O_RDONLY), *map(os.get_inheritable, range(3)), file=out)"
    program = (
        "import os, sys\nos.dup2(1, 9)\nout = os.fdopen(9, 'w')\n[os.close(n) for n in (0, 1, 2)]\n"
        "sys.stdin = sys.stdout = sys.stderr = None\n"
        "from procedures.cli.standard_streams import open_closed_streams\nopen_closed_streams()\n" + look
    )
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    number, *inherited = said.split()
    assert int(number) not in STANDARD
    assert inherited == ["True"] * 3


@pytest.mark.parametrize("output", ["full", "gone"])
@pytest.mark.parametrize("form", [[], ["--json"]])
@pytest.mark.usefixtures("no_report")
def test_the_status_of_a_run_is_not_that_of_its_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], output: str, form: list[str]
) -> None:
    """A unit with Restart=on-failure began a finished run again."""
    with _that_takes_nothing(output) as stream:
        monkeypatch.setattr(sys, "stdout", stream)
        assert run_command([*_files(tmp_path), *form]) == 0
    assert "finished" in _states(tmp_path)[-1]
    said = capsys.readouterr().err
    full = "standard output: No space left on device; everything is written; calrig solve "
    assert (full in said) is (output == "full")


def _that_takes_nothing(output: str) -> TextIO:
    if output == "full":
        return open("/dev/full", "w", encoding="utf-8")
    read, write = os.pipe()
    os.close(read)
    return os.fdopen(write, "w", encoding="utf-8")


def test_what_is_asked_for_alone_and_cannot_be_told_failed() -> None:
    assert _status(">/dev/full 2>/dev/null", "run", "--help") == 1
