"""What one calibration shows of a sensor over the years: no change, and not that there was none."""

from dataclasses import replace
from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest

from ams.archive.histories import SensorHistory
from ams.surveillance.check_chart import CheckHistory
from ams.surveillance.control_chart import History
from procedures.cli.archive.text import history_lines


@pytest.mark.parametrize("is_check", [False, True])
def test_a_single_calibration_is_told_without_a_word_of_what_changed_or_stayed(is_check: bool) -> None:
    label = SimpleNamespace(created_utc=datetime(2026, 3, 1, tzinfo=UTC))
    alone = History("SN1", (label,), (), np.zeros((1, 3)), (), is_judged=False)  # type: ignore[arg-type]
    check = CheckHistory("SN1", alone.labels, (), (), 0) if is_check else None
    found = SensorHistory(alone, check, None, None)
    text = "\n".join(history_lines(found))
    assert text.startswith("SN1: one calibration, of 2026-03-01\n")
    assert "cannot judge yet (" in text
    assert "there is no other" in text
    assert not any(word in text for word in ("nothing", "changed", "stayed", "drift", "scatter between"))
    two = replace(found, history=replace(alone, labels=(label, label)))  # type: ignore[arg-type]
    assert next(history_lines(two)) == "SN1: 2 calibrations, 2026-03-01 to 2026-03-01"
