"""Completion of the shell: installed where the shell looks, and known to the shell itself."""

import shutil
import subprocess
from pathlib import Path

import pytest
from command import call

from procedures.cli.main import GROUPS

COMPLETE = """
source "$1"
COMP_WORDS=(calrig res) COMP_CWORD=1
eval "$(complete -p calrig | sed -E 's/.*-F ([^ ]+) .*/\\1 calrig res calrig/')"
echo "${COMPREPLY[@]}"
"""


def test_bash_completes_every_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    assert call(capsys, "--install-completion", "--shell", "bash").status == 0
    (script,) = (path for path in tmp_path.rglob("calrig*") if path.is_file())
    text = script.read_text(encoding="utf-8")
    assert [name for commands in GROUPS.values() for name, _, _ in commands if name not in text] == []
    shell = shutil.which("bash")
    assert shell is not None
    found = subprocess.run([shell, "-c", COMPLETE, "bash", script], capture_output=True, text=True, check=True)
    assert set(found.stdout.split()) == {"resume", "resolve"}
