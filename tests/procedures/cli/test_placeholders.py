"""What a printed command leaves to be written is never taken for somebody's name or reason."""

import re
from pathlib import Path

import pytest

from ams.analysis.diagnostics.take_back import redo_command, void_command
from procedures.cli.main import OF_A_PERSON, PLACEHOLDERS, run_command
from procedures.errors import ExitStatus

SOURCES = Path(__file__).parents[3]


@pytest.mark.parametrize("printed", [redo_command(1), void_command(7, "runs/x"), "calrig resume x --operator=NAME"])
def test_a_command_pasted_as_printed_asks_for_a_name_and_does_nothing(
    printed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command(printed.split()[1:]) == ExitStatus.WRONG_REQUEST
    told = " ".join(capsys.readouterr().err.split())
    assert "--operator: got NAME, which only stands for what is to be written there; nothing was done; give" in told


def test_a_reason_that_stands_for_one_is_refused_beside_a_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command(["redo", "--replication", "1", "--operator", "A. Smith", "--reason", "TEXT"]) == 2
    assert "--reason: got TEXT" in capsys.readouterr().err


def test_nothing_keeps_a_run_from_being_stopped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run_command(["stop", str(tmp_path), "--operator", "NAME"])
    assert "only stands for" not in capsys.readouterr().err


def test_all_that_printed_commands_leave_to_be_written_is_known() -> None:
    options = "|".join(OF_A_PERSON)
    printed = {
        found
        for folder in ("ams", "procedures", "rig")
        for path in (SOURCES / folder).rglob("*.py")
        for found in re.findall(rf"(?:{options})[ =]([A-Z]{{2,}})\b", path.read_text(encoding="utf-8"))
    }
    assert printed
    assert printed <= PLACEHOLDERS
