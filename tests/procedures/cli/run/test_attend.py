"""What surrounds a run that is started from the command line."""

from pathlib import Path

import pytest

from procedures.cli.run.attend import attended
from procedures.cli.run.opening import Opening


@pytest.mark.parametrize("is_asked_for", [True, False])
def test_alerts_that_virtual_time_keeps_silent_are_said_to_be_silent(
    is_asked_for: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alerts = tmp_path / "alerts.toml" if is_asked_for else None
    with attended(Opening("small grid", is_virtual=True), alerts, tmp_path / "run") as attendance:
        assert attendance.dispatcher is None
    assert ("in virtual time nobody is told" in capsys.readouterr().err) is is_asked_for
