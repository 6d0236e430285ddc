"""The manual page says what the commands say, and troff takes it."""

import subprocess
import sys
from pathlib import Path

import pytest

from procedures.cli.main import GROUPS

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "calrig.1"


def test_it_has_every_command() -> None:
    text = PAGE.read_text(encoding="utf-8").replace("\\-", "-")
    assert [name for commands in GROUPS.values() for name, _, _ in commands if f".SS calrig {name}\n" not in text] == []


@pytest.mark.thorough
def test_it_is_what_the_commands_say_now() -> None:
    code = "import sys; from man_page import man_page; sys.stdout.buffer.write(man_page())"
    made = subprocess.run([sys.executable, "-c", code], cwd=ROOT / "docs", capture_output=True)
    assert made.returncode == 0, made.stderr.decode()
    assert made.stdout == PAGE.read_bytes(), "run `make house`"
