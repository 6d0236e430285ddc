"""The study of hours: its laboratory runs, its intervals hold, and the page in the documentation is its own."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

STUDIES = Path(__file__).parents[3] / "docs" / "studies"


@pytest.mark.thorough
def test_a_small_run_of_the_laboratory_is_solved_and_its_intervals_hold(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(STUDIES)
    hours, laboratory = import_module("hours"), import_module("hours_laboratory")
    small = hours.BASELINE.replace("replications = 6", "replications = 4")
    small = small.replace("step = 5.0", "step = 30.0").replace("step = 30.0 }\nusage", "step = 45.0 }\nusage")
    run = laboratory.measured("small", 1, small, tmp_path / "small")
    assert run.verdict == "usable"
    assert run.calibration_arcsec < run.u95_arcsec < run.single_arcsec
    held = laboratory.coverage(run, 200, np.random.default_rng(1))
    assert min(held.shares) > 0.93
    written = "".join(hours.page([run], 20)).splitlines()
    stored = (STUDIES / "hours.md").read_text(encoding="utf-8").splitlines()
    headings = [line for line in written if line.startswith("#")]
    assert headings == [line for line in stored if line.startswith("#")]
