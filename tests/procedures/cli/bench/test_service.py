"""``calrig service`` writes the unit of the page, with the paths of this machine and the folders that it needs."""

import re
import sys
from pathlib import Path

import pytest
from command import call

from procedures.cli.bench.service import unit_text

PAGE = Path(__file__).parents[4] / "docs" / "service.md"


def test_the_page_shows_the_unit_that_is_shipped() -> None:
    shown = re.search(r"```ini\n#[^\n]*\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert shown is not None
    made = unit_text("%h/calrig/.venv/bin/calrig", Path("%h/runs"), Path("%h/.local/state/calrig"))
    assert made == shown[1]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="systemd is of Linux")
def test_the_unit_is_written_with_the_folders_it_may_write_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("config", "state"):
        monkeypatch.setenv(f"XDG_{name.upper()}_HOME", str(tmp_path / name))
    monkeypatch.setattr("procedures.cli.bench.service._program", lambda: "/opt/calrig/bin/calrig")
    told = call(capsys, "service", "--out", tmp_path / "runs")
    assert told.status == 0
    unit = (tmp_path / "config" / "systemd" / "user" / "calrig@.service").read_text("utf-8")
    assert f"ExecStart=/opt/calrig/bin/calrig resume {tmp_path}/runs/%i --operator %u" in unit
    assert not re.search(r"@[A-Z]+@", unit), "a place that was not filled in"
    for folder in (tmp_path / "runs", tmp_path / "state" / "calrig"):
        assert folder.is_dir()
        assert str(folder) in re.findall(r"^ReadWritePaths=(.*)$", unit, re.MULTILINE)[0].split()


def test_showing_it_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr("procedures.cli.bench.service._program", lambda: "/opt/calrig/bin/calrig")
    told = call(capsys, "service", "--show")
    assert told.out.startswith("[Unit]")
    assert list(tmp_path.iterdir()) == []


def test_a_path_that_a_unit_would_misread_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "a place"
    folder.mkdir()
    told = call(capsys, "service", "--out", folder, "--show")
    assert told.status == 2
    assert "has a space" in told.err
