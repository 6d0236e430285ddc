"""The command as a user would call it, in this process: what it says and the status it leaves with."""

import json
from dataclasses import dataclass
from typing import Any

import pytest

from procedures.cli.main import run_command


@dataclass(frozen=True)
class Outcome:
    """What the shell would see."""

    status: int
    out: str
    err: str

    @property
    def document(self) -> Any:
        """The one JSON document on standard output."""
        return json.loads(self.out)


def call(capsys: pytest.CaptureFixture[str], *arguments: object) -> Outcome:
    """Run ``calrig ARGUMENTS``."""
    capsys.readouterr()
    status = run_command([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    return Outcome(int(status), captured.out, captured.err)
