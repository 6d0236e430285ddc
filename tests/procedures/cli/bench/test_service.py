"""``calrig service`` writes the unit of the page, with the paths of this machine and the folders that it needs."""

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from command import call
from open_folder import open_folder
from small_run import PROCEDURE, RIG

from procedures.cli.bench.service import unit_text
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.status.status import status
from procedures.records.states import State
from rig.clock import SystemClock

PAGE = Path(__file__).parents[4] / "docs" / "service.md"


def test_the_page_shows_the_unit_that_is_shipped() -> None:
    shown = re.search(r"```ini\n#[^\n]*\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert shown is not None
    made = unit_text("%h/calrig/.venv/bin/calrig", Path("%h/runs"), Path("%h/.local/state/calrig"))
    assert made == shown[1]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="systemd is of Linux")
def test_the_unit_is_written_with_the_folders_it_may_write_to(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a folder with a plain path: any other is refused, and the temporary folder may be one."""
    with open_folder(plain=True) as home:
        for name in ("config", "state"):
            monkeypatch.setenv(f"XDG_{name.upper()}_HOME", str(home / name))
        monkeypatch.setattr("procedures.cli.bench.service._program", lambda: "/opt/calrig/bin/calrig")
        outcome = call(capsys, "service", "--out", home / "runs")
        assert outcome.status == 0
        unit = (home / "config" / "systemd" / "user" / "calrig@.service").read_text("utf-8")
        assert f"ExecStart=/opt/calrig/bin/calrig resume {home}/runs/%i --operator %u" in unit
        folders = (home / "runs", home / "state" / "calrig")
        assert [folder.is_dir() for folder in folders] == [True, True]
    assert not re.search(r"@[A-Z]+@", unit), "a place that was not filled in"
    for folder in folders:
        assert str(folder) in re.findall(r"^ReadWritePaths=(.*)$", unit, re.MULTILINE)[0].split()


def test_showing_it_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr("procedures.cli.bench.service._program", lambda: "/opt/calrig/bin/calrig")
    outcome = call(capsys, "service", "--show")
    assert outcome.out.startswith("[Unit]")
    assert list(tmp_path.iterdir()) == []


def test_a_path_that_a_unit_would_misread_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "a place"
    folder.mkdir()
    outcome = call(capsys, "service", "--out", folder, "--show")
    assert outcome.status == 2
    assert "has a space" in outcome.err


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="systemd is of Linux")
@pytest.mark.parametrize(
    ("end", "left", "restarts"),
    [
        pytest.param("KillSignal", State.STOPPED, 0, id="shutdown", marks=pytest.mark.thorough),
        pytest.param("KILL", State.INTERRUPTED, 0, id="crash", marks=pytest.mark.soak),
        pytest.param("abort", State.ABORTED, 2, id="a person's abort", marks=pytest.mark.soak),
    ],
)
def test_the_story_of_a_reboot_by_the_unit_that_is_written(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], end: str, left: State, restarts: int
) -> None:
    """As systemd goes by it: its signal to the process of a run, then its command for that run at the next start."""
    (tmp_path / "rig.toml").write_text(RIG.replace("seed = 7", "seed = 7\ntime = 100.0"), encoding="utf-8")
    (tmp_path / "procedure.toml").write_text(PROCEDURE, encoding="utf-8")
    words = [tmp_path / "procedure.toml", "--rig", tmp_path / "rig.toml", "--out", tmp_path / "runs"]
    unit = dict(re.findall(r"^(\w+)=(.*)$", call(capfd, "service", "--out", tmp_path / "runs", "--show").out, re.M))
    begun, clock = call(capfd, "run", *words, "--detach", "--json").document, SystemClock()
    run = Path(begun["run"])
    while status(run).dwells_done < 3:
        clock.sleep(0.05)
    if end == "abort":
        assert call(capfd, "abort", run).status == 0
    else:
        os.kill(begun["pid"], signal.Signals[unit.get(end, f"SIG{end}")])
    while is_owned(run):
        clock.sleep(0.05)
    assert status(run).state is left
    command = unit["ExecStart"].replace("%i", run.name).replace("%u", "anna")
    again = subprocess.run(shlex.split(command), capture_output=True, text=True, check=False)
    assert again.returncode == restarts, again.stderr
    waits = {int(number) for number in unit["RestartPreventExitStatus"].split()}
    assert again.returncode == 0 or again.returncode in waits
    assert status(run).state is (left if restarts else State.FINISHED)


def test_a_queue_of_a_rig_that_is_not_there_gets_no_unit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    outcome = call(capsys, "service", "--out", tmp_path / "runs", "--queue", tmp_path / "rig.toml")
    assert (outcome.status, list(tmp_path.iterdir())) == (2, [])
    assert "no rig file is there; nothing was written" in outcome.err
