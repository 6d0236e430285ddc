"""Whether somebody reads what a process says, as processes see it."""

import os
import subprocess
import sys
from collections.abc import Mapping

import pytest
from terminal_window import TerminalWindow

from procedures.alerts.reader import READ_BY, read_by_us

ASKS = [sys.executable, "-c", "from procedures.alerts.reader import is_read; print('read:', is_read())"]


@pytest.mark.parametrize(
    ("variables", "is_read"),
    [({}, False), (read_by_us(), True), ({READ_BY: "1"}, False), ({READ_BY: ""}, False)],
    ids=["nobody", "who started it", "one who is gone", "nonsense"],
)
def test_a_process_without_a_terminal_is_read_by_who_started_it_alone(
    variables: Mapping[str, str], is_read: bool
) -> None:
    done = subprocess.run(
        ASKS, env={**os.environ, **variables}, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True
    )
    assert done.stdout == f"read: {is_read}\n"


def test_a_terminal_is_read() -> None:
    with TerminalWindow(ASKS) as window:
        window.wait_for("read: True")
