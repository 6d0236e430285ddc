"""The unit of docs/service.md: shut in as it is, it still shares the locks with every terminal and can report."""

import re
from pathlib import Path

from procedures.errors import ExitStatus
from rig.machine_folder import FOLDERS

PAGE = Path(__file__).parents[4] / "docs" / "service.md"


def _unit() -> dict[str, str]:
    unit = re.search(r"```ini\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert unit is not None
    return dict(line.split("=", 1) for line in unit[1].splitlines() if re.match(r"[A-Z]\w+=", line))


def test_the_unit_may_write_where_the_locks_are() -> None:
    """systemd.exec(5): with ProtectSystem=strict only what is named may be written; with PrivateTmp /tmp is its own, so
    the locks may not lie there."""
    unit = _unit()
    assert (unit["ProtectSystem"], unit["PrivateTmp"]) == ("strict", "yes")
    assert FOLDERS[0] in unit["ReadWritePaths"].split()


def test_the_unit_restarts_nothing_that_waits_for_a_person() -> None:
    waiting = {ExitStatus.WRONG_REQUEST, ExitStatus.HELD, ExitStatus.ABORTED}
    assert {int(entry) for entry in _unit()["RestartPreventExitStatus"].split()} == {int(status) for status in waiting}
    assert _unit()["KillSignal"] == "SIGTERM", "stops at once, and can be resumed"
