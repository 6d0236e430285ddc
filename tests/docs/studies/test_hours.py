"""The study of hours: its laboratory runs, its intervals hold, also at the stop, and the stored page is its own."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

STUDIES = Path(__file__).parents[3] / "docs" / "studies"


@pytest.mark.thorough
def test_a_small_run_of_the_laboratory_is_solved_and_its_intervals_hold(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(STUDIES)
    hours, laboratory, campaigns = map(import_module, ("hours", "hours_laboratory", "hours_coverage"))
    small = hours.BASELINE.replace("replications = 6", "replications = 4")
    small = small.replace("step = 5.0", "step = 30.0").replace("step = 30.0 }\nusage", "step = 45.0 }\nusage")
    runs = [
        laboratory.measured("small", 1, small, tmp_path / str(listed), is_listed=listed) for listed in (False, True)
    ]
    for run in runs:
        assert run.verdict == "usable"
        assert run.u95_arcsec < run.once_arcsec
        for entry in run.dwell.values():
            assert entry.calibration_rad < entry.u95_rad
            squares = sum(share * abs(share) for share in entry.shares_rad.values())
            assert squares == pytest.approx(entry.u95_rad**2)
        held = campaigns.coverage(run, 200, np.random.default_rng(1))
        assert min(held.shares) > 0.93
    assert runs[1].dwell["pitch"].calibration_rad < 0.5 * runs[0].dwell["pitch"].calibration_rad
    written = "".join(hours.page(runs, 20)).splitlines()
    stored = (STUDIES / "hours.md").read_text(encoding="utf-8").splitlines()
    headings = [line for line in written if line.startswith("#")]
    assert headings == [line for line in stored if line.startswith("#")]


def test_intervals_keep_their_coverage_where_a_run_stops_by_itself(monkeypatch) -> None:
    monkeypatch.syspath_prepend(STUDIES)
    found = import_module("hours_sequential").coverage_at_stop(4000, np.random.default_rng(5))
    assert found.stopped == pytest.approx(0.95, abs=0.01)
    assert found.fixed == pytest.approx(0.95, abs=0.01)
    assert 6.0 < found.replications < 10.0


@pytest.mark.soak
@pytest.mark.parametrize("lack_of_fit", [0.0, 1.0, 3.0])
@pytest.mark.parametrize(("least", "most"), [(2, 12), (4, 12), (6, 10)])
def test_intervals_cover_95_percent_at_the_stop(monkeypatch, least: int, most: int, lack_of_fit: float) -> None:
    monkeypatch.syspath_prepend(STUDIES)
    chance = np.random.default_rng(6)
    found = import_module("hours_sequential").coverage_at_stop(20_000, chance, least, most, lack_of_fit)
    assert found.stopped == pytest.approx(0.95, abs=0.01)
    assert found.fixed == pytest.approx(0.95, abs=0.01)
