"""Completion of the shell: installed where the shell looks, and known to the shell itself."""

import subprocess
from pathlib import Path

import pytest
from command import call
from programs import require_program

from procedures.cli.main import GROUPS

COMPLETE = """
source "$1"
COMP_WORDS=(calrig res) COMP_CWORD=1
eval "$(complete -p calrig | sed -E 's/.*-F ([^ ]+) .*/\\1 calrig res calrig/')"
echo "${COMPREPLY[@]}"
"""


@pytest.fixture(autouse=True)
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Installing adds a line to the shell's own file."""
    monkeypatch.setenv("HOME", str(tmp_path))
    for name in ("XDG_DATA_HOME", "XDG_CONFIG_HOME", "ZDOTDIR"):
        monkeypatch.delenv(name, raising=False)


def test_bash_completes_every_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(capsys, "--install-completion", "--shell", "bash").status == 0
    (script,) = (path for path in tmp_path.rglob("calrig*") if path.is_file())
    text = script.read_text(encoding="utf-8")
    assert [name for commands in GROUPS.values() for name, _, _ in commands if name not in text] == []
    found = subprocess.run(
        [require_program("bash"), "-c", COMPLETE, "bash", script], capture_output=True, text=True, check=True
    )
    assert set(found.stdout.split()) == {"resume", "resolve"}


def test_fish_completes_every_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = written("fish", tmp_path, capsys)
    completion = "source $argv[1]; complete -C 'calrig res'"
    command = [require_program("fish"), "--no-config", "-c", completion, script]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    assert [line.partition("\t")[0] for line in found.stdout.splitlines()] == ["resolve", "resume"]


def test_zsh_takes_the_script_for_one_of_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = written("zsh", tmp_path, capsys)
    assert script.read_text(encoding="utf-8").startswith("#compdef calrig")
    subprocess.run([require_program("zsh"), "--no-rcs", "-n", script], check=True)


def test_powershell_is_told_every_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No PowerShell is to be had here: what is looked at is the text."""
    text = written("powershell", tmp_path, capsys).read_text(encoding="utf-8")
    assert "Register-ArgumentCompleter -Native -CommandName" in text
    assert [name for commands in GROUPS.values() for name, _, _ in commands if f"'{name}'" not in text] == []


def written(shell: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """Return the script that ``--install-completion`` writes for a shell."""
    script = folder / f"calrig.{shell}"
    assert call(capsys, "--install-completion", "--shell", shell, "--output", script).status == 0
    return script
