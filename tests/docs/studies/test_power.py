"""The study of power: it simulates what it says, and the page in the documentation is its own."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

STUDIES = Path(__file__).parents[3] / "docs" / "studies"


@pytest.fixture
def power(monkeypatch):
    monkeypatch.syspath_prepend(STUDIES)
    return import_module("power")


@pytest.mark.parametrize("lack_of_fit", [0.0, 3.0])
def test_simulated_power_is_that_of_theory_and_tps_is_lost_under_lack_of_fit(power, lack_of_fit) -> None:
    observations, rng = power.design(), np.random.default_rng(0)
    points = observations.rows // power.REPLICATIONS
    offset, offset_tp, sensitivity, sensitivity_tp = power.alarms(observations, 2.0, lack_of_fit, rng, campaigns=1000)
    assert (offset, sensitivity) == pytest.approx((power.theory(2.0, points),) * 2, abs=0.05)
    if lack_of_fit:
        assert max(offset_tp, sensitivity_tp) < 0.02
    else:
        assert (offset_tp, sensitivity_tp) == pytest.approx((offset, sensitivity), abs=0.02)


def test_the_page_is_what_the_script_writes(power, monkeypatch) -> None:
    """Shape and words; the shares themselves are drawn anew with another number of campaigns."""
    monkeypatch.setattr(power, "CAMPAIGNS", 2)
    monkeypatch.setattr(power.alarms, "__defaults__", (2,))
    written = "".join(power.page(np.random.default_rng(0))).splitlines()
    stored = (STUDIES / "power.md").read_text(encoding="utf-8").splitlines()
    assert len(written) == len(stored)
    assert [line for line in written if not line.startswith("| ") and "campaigns a line" not in line] == [
        line for line in stored if not line.startswith("| ") and "campaigns a line" not in line
    ]
