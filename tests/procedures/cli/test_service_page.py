"""The unit of docs/service.md: shut in as it is, it still shares the locks with every terminal and can report."""

import re
from pathlib import Path

import pytest

from procedures.errors import ExitStatus
from rig.lines.lock import lock_folder

PAGE = Path(__file__).parents[3] / "docs" / "service.md"


def _unit() -> dict[str, str]:
    unit = re.search(r"```ini\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert unit is not None
    return dict(line.split("=", 1) for line in unit[1].splitlines() if re.match(r"[A-Z]\w+=", line))


def test_the_unit_may_write_where_the_locks_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """systemd.exec(5): with ProtectSystem=strict only what is named may be written; RuntimeDirectory is a folder under
    XDG_RUNTIME_DIR in a user's manager, and is removed at the end of the unit unless it is preserved."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    unit = _unit()
    assert unit["ProtectSystem"] == "strict"
    assert lock_folder() == tmp_path / unit["RuntimeDirectory"]
    assert (unit["RuntimeDirectoryPreserve"], unit["PrivateTmp"]) == ("yes", "yes")


def test_the_unit_restarts_nothing_that_waits_for_a_person() -> None:
    waiting = {ExitStatus.WRONG_REQUEST, ExitStatus.HELD, ExitStatus.ABORTED}
    assert {int(one) for one in _unit()["RestartPreventExitStatus"].split()} == {int(status) for status in waiting}
    assert _unit()["KillSignal"] == "SIGTERM", "stops at once, and can be resumed"
