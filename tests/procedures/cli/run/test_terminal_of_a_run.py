"""The terminal of a run as real processes see it: closed, given back, attached again."""

import json
import os
import pty
import signal
import subprocess
import sys
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

import pytest
from command import call
from small_run import PROCEDURE, RIG
from unattended_run import events

from procedures.errors import RequestError
from procedures.journal.requests.spool import ask
from procedures.journal.sidecar.delivering import delivered_by
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.sidecar.verdict_file import VERDICT_FILE
from procedures.journal.status.status import status
from procedures.records.states import ACTIVE, State
from rig.clock import SystemClock


def _files(folder: Path, factor: float) -> list[str]:
    (folder / "rig.toml").write_text(RIG.replace("seed = 7", f"seed = 7\ntime = {factor}"), encoding="utf-8")
    (folder / "procedure.toml").write_text(PROCEDURE, encoding="utf-8")
    return ["run", str(folder / "procedure.toml"), "--rig", str(folder / "rig.toml"), "--out", str(folder / "runs")]


def test_fault_77_a_terminal_that_is_closed_ends_nothing(tmp_path: Path) -> None:
    """Detected: the hang-up signal, and a screen that nothing can be written to any more.
    Response: the run goes on, journals and tells that the terminal was closed, and delivers everything.
    """
    words = [sys.executable, "-m", "procedures.cli.main", *_files(tmp_path, 100.0), "--operator", "李雷 👍"]
    child, terminal = pty.fork()
    if child == 0:
        os.execv(sys.executable, words)
    shown = b""
    while b"PAUSED" not in shown:  # it waits there until it was closed, however long that takes
        shown += os.read(terminal, 4096)
        for run in (tmp_path / "runs").glob("*/journal.sqlite") if b"CHECKING" in shown else ():
            with suppress(RequestError):  # of the state before
                ask(run.parent, "pause", "anna", datetime.now(UTC))
    os.close(terminal)
    (run_dir,) = (path for path in (tmp_path / "runs").iterdir() if path.is_dir())
    while not events(run_dir, "terminal"):
        SystemClock().sleep(0.02)
    ask(run_dir, "continue", "anna", datetime.now(UTC))
    _, left = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(left) == 0
    assert status(run_dir).state is State.FINISHED
    (text,) = events(run_dir, "terminal")
    assert text.detail["text"] == "the terminal was closed; the run goes on"
    assert (run_dir / "report.pdf").read_bytes().startswith(b"%PDF")


def test_a_run_gives_the_shell_back_is_attached_stopped_at_once_and_closed(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    alerts = tmp_path / "alerts.toml"
    alerts.write_text('command = ["false", "--token=hush"]\n', encoding="utf-8")
    begun = call(capfd, *_files(tmp_path, 20.0), "--alerts", alerts, "--detach", "--json").document
    run_dir = Path(begun["run"])
    assert is_owned(run_dir)
    attach = [sys.executable, "-m", "procedures.cli.main", "attach", str(run_dir)]
    with subprocess.Popen(attach, stderr=subprocess.PIPE, text=True) as attached:
        assert attached.stderr is not None
        shown = attached.stderr.readline()  # it follows
        os.kill(begun["pid"], signal.SIGTERM)
        shown += attached.stderr.read()
    assert attached.returncode == 4
    assert "told to end, as by a shutdown, systemd or kill (asked for by signal SIGTERM)" in shown
    clock = SystemClock()
    while is_owned(run_dir) or status(run_dir).state in ACTIVE:
        clock.sleep(0.05)
    outcome = call(capfd, "status", run_dir).out
    assert "because: told to end" in outcome
    assert "alert: calrig: small grid: stopped: not delivered: command false: exit status 1" in outcome
    assert "hush" not in outcome
    assert "signal SIGTERM" in call(capfd, "handover", run_dir).out
    _require_a_refused_resume_rings(capfd, run_dir)
    assert call(capfd, "close", run_dir, "--reason", "sensor sold").status == 0
    refused = call(capfd, "resume", run_dir, "--operator", "a", "--reason", "b")
    assert (refused.status, "the run is closed" in refused.err) == (2, True)


def _require_a_refused_resume_rings(capfd: pytest.CaptureFixture[str], run_dir: Path) -> None:
    """As a unit's after a reboot is, where files changed: no terminal shows it. One that is over does not ring."""
    folder, rung = run_dir.parents[1], run_dir.parents[1] / "rung.txt"
    ring = [sys.executable, "-c", "import sys, pathlib; open(sys.argv[1], 'a').write(sys.stdin.read())", str(rung)]
    (folder / "alerts.toml").write_text(f"command = {json.dumps(ring)}\n", encoding="utf-8")
    rig_file = folder / "rig.toml"
    own = rig_file.read_text(encoding="utf-8")
    rig_file.write_text(own.replace("nplc = 1", "nplc = 2"), encoding="utf-8")
    assert call(capfd, "resume", run_dir, "--alerts", folder / "alerts.toml").status == 2
    assert "calrig: small grid: not begun" in rung.read_text(encoding="utf-8")
    assert "nplc" in rung.read_text(encoding="utf-8")
    rig_file.write_text(own, encoding="utf-8")


def test_what_hides_something_is_refused_where_it_is_typed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for hidden, name in (("\x1b[31m", "<U+001B>"), ("\u202e", "<U+202E>"), ("\x00", "<U+0000>")):
        refused = call(capsys, *_files(tmp_path, 1.0), "--operator", f"an{hidden}na")
        assert (refused.status, refused.out) == (2, "")
        assert f"holds {name}, which nobody sees, or which acts on a screen" in refused.err
        assert hidden not in refused.err
    (tmp_path / "procedure.toml").write_text(PROCEDURE.replace("small grid", "small \\u202egrid"), encoding="utf-8")
    outcome = call(capsys, "check", tmp_path / "procedure.toml", "--rig", tmp_path / "rig.toml")
    assert "procedure.title: holds <U+202E>" in outcome.err


def test_a_resume_gives_the_shell_back_and_keeps_the_words_of_the_process_before(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    begun = call(capfd, *_files(tmp_path, 20.0), "--detach", "--json").document
    run_dir = Path(begun["run"])
    os.kill(begun["pid"], signal.SIGTERM)
    clock = SystemClock()
    while is_owned(run_dir):
        clock.sleep(0.02)
    before = (run_dir / "terminal.log").read_text(encoding="utf-8")
    (tmp_path / "procedure.toml").write_text(PROCEDURE.replace("[dwell]", "[dwell]\nretries = 4"), encoding="utf-8")
    refused = call(capfd, "resume", run_dir, "--detach")
    assert refused.status == 2, refused.err
    assert "retries" in refused.err, "told here, where somebody reads it"
    (tmp_path / "procedure.toml").write_text(PROCEDURE, encoding="utf-8")
    assert not list(run_dir.glob(".begins-*"))
    resumed = call(capfd, "resume", run_dir, "--operator", "anna", "--detach", "--json").document
    assert resumed["run"] == str(run_dir)
    assert status(run_dir).state in ACTIVE
    assert is_owned(run_dir)
    os.kill(resumed["pid"], signal.SIGTERM)
    while is_owned(run_dir):
        clock.sleep(0.02)
    assert (run_dir / "terminal.log").read_text(encoding="utf-8").startswith(before)
    assert str(run_dir) in (run_dir / "terminal-2.log").read_text(encoding="utf-8")


@pytest.mark.parametrize("has_verdict", [False, True])
def test_sigterm_while_results_are_made_says_what_makes_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], has_verdict: bool
) -> None:
    """A reboot behind the last dwell: the night's dwells are all there, and nobody is sent to measure them again.

    ``has_verdict``: the verdict is written by then, the paper not yet.
    """
    files = map(str, _files(tmp_path, 1000.0))
    with subprocess.Popen(
        [sys.executable, "-m", "procedures.cli.main", *files], stderr=subprocess.PIPE, text=True
    ) as run:
        clock = SystemClock()
        is_there = (lambda folder: (folder / VERDICT_FILE).exists()) if has_verdict else delivered_by
        while not any(map(is_there, (tmp_path / "runs").glob("2*"))):
            clock.sleep(0.005)
        run.send_signal(signal.SIGTERM)
        assert run.stderr is not None
        told = run.stderr.read()
    (run_dir,) = (path for path in (tmp_path / "runs").iterdir() if path.is_dir())
    assert run.returncode == 4, told
    assert "stopped by SIGTERM" in told
    makes = f"calrig solve {run_dir} makes what is missing"
    assert makes in " ".join(told.split())
    refused = call(capsys, "resume", run_dir, "--operator", "anna", "--reason", "reboot")
    assert (refused.status, makes in refused.err, f"calrig solve {run_dir} makes" in refused.err) == (
        2,
        not has_verdict,
        True,
    )
    assert (run_dir / "report.pdf").exists() is False
    assert call(capsys, "solve", run_dir).status == 0
    assert (run_dir / "report.pdf").read_bytes().startswith(b"%PDF")
