"""A run that is refused before it moves: people are told where nobody is at a terminal, and only there."""

import json
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from command import call
from small_run import PROCEDURE, RIG
from terminal_window import TerminalWindow

from rig.lines.lock import acquire

RINGS = "import sys; open(sys.argv[1], 'a').write(sys.stdin.read())"
"""Appends a message to a file."""


@contextmanager
def a_silent_port() -> Iterator[str]:
    """Somebody listens there, and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"socket://127.0.0.1:{server.getsockname()[1]}"


def _files(folder: Path, port: str = "twin") -> list[object]:
    chamber = f'driver = "ascii-chamber"\nmodel = "espec-p300"\nvalues = "degc"\nport = "{port}"'
    real = RIG.replace('driver = "watlow-f4"\nport = "twin"', chamber)
    (folder / "rig.toml").write_text(real.replace("seed = 7", 'seed = 7\ntime = "real"'), encoding="utf-8")
    (folder / "procedure.toml").write_text(PROCEDURE, encoding="utf-8")
    ring = [sys.executable, "-c", RINGS, str(folder / "rung.txt")]
    (folder / "alerts.toml").write_text(f"command = {json.dumps(ring)}\n", encoding="utf-8")
    words = ["run", folder / "procedure.toml", "--rig", folder / "rig.toml", "--out", folder / "runs"]
    return [*words, "--alerts", folder / "alerts.toml"]


def _rung(folder: Path) -> str:
    file = folder / "rung.txt"
    return file.read_text(encoding="utf-8") if file.exists() else ""


@pytest.mark.parametrize(
    "cause", [pytest.param("silent", marks=pytest.mark.thorough), "gone", "in use", "wrong file", "no folder"]
)
def test_fault_90_a_run_that_is_refused_where_nobody_looks_rings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], cause: str
) -> None:
    """Detected: whatever refuses a run or a resume, and no terminal that shows it; what a queue does not begin.
    Response: people are told once, in the words of the refusal.
    """
    with a_silent_port() as port:
        words = _files(tmp_path, {"silent": port, "gone": "socket://127.0.0.1:9"}.get(cause, "twin"))
        match cause:
            case "wrong file":
                (tmp_path / "procedure.toml").write_text("[procedure]\n", encoding="utf-8")
            case "no folder":
                (tmp_path / "runs").write_text("a file", encoding="utf-8")
        if cause == "in use":
            with acquire([str(tmp_path / "rig.toml")], "a jog"):
                outcome = call(capsys, *words)
        else:
            outcome = call(capsys, *words)
    assert outcome.status != 0
    title = "procedure" if cause == "wrong file" else "small grid"
    rung = _rung(tmp_path)
    assert rung.startswith(f"calrig: {title}: not begun\n\n")
    assert rung.count("calrig: ") == 1, "once"
    assert outcome.err.strip().removeprefix("calrig: ").splitlines()[0] in rung
    assert "There is no run yet, and nothing moved. Mend what is named above, then begin it again. Nobody" in rung
    assert rung.rstrip().endswith(f"\nRig: bench of twins, on the computer {socket.gethostname()}.")
    assert not [path for path in (tmp_path / "runs").glob("*/*") if path.is_dir()]


def test_a_rehearsal_that_is_refused_tells_nobody(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = _files(tmp_path)
    (tmp_path / "procedure.toml").write_text("[procedure]\n", encoding="utf-8")
    assert call(capsys, *words, "--rehearse").status == 2
    assert _rung(tmp_path) == ""


@pytest.mark.thorough
@pytest.mark.parametrize("detached", [[], ["--detach"]])
def test_a_run_that_is_refused_at_a_terminal_is_told_there_alone(tmp_path: Path, detached: list[str]) -> None:
    with a_silent_port() as port:
        words = [*_files(tmp_path, port), *detached]
        with TerminalWindow([sys.executable, "-m", "procedures.cli.main", *map(str, words)]) as window:
            window.wait_for(lambda text: "chamber" in text or "environment.air" in text, 60.0)
            window.process.wait(30)
    assert _rung(tmp_path) == ""
