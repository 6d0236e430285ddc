"""Three days in virtual time with faults on every line: memory, files and threads at the end are those of the start."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from device_sets import device_set
from fault_scripts import tell_of

from procedures.records.progress import Progress
from procedures.run.watch.process_health import process_figures
from rig.assembly.open_rig import Rig
from rig.description.fault_plan import FaultPlan

PROCEDURE = """
[procedure]
title = "three days"
kind = "grid"
replications = {replications}
[design]
kind = "D"
pitch_deg = {{ from = -90.0, to = 90.0, step = 5.0 }}
roll_deg = {{ from = -180.0, to = 150.0, step = 30.0 }}
[dwell]
samples = 10
settle = {{ window_s = 20.0, windows = 2, min_s = 40.0, max_s = 300.0 }}
[check]
reference_every = 25
"""
EVERY_DWELLS = 20
MOST_MB_PER_H = 1.0
WARM_UP = 0.1
"""Of the run: until then caches fill."""


@dataclass
class Figures:
    """What the process holds, by the hours of the rig."""

    rig: Rig
    hours: list[float] = field(default_factory=list)
    resident_mb: list[float] = field(default_factory=list)
    files: list[int] = field(default_factory=list)
    threads: list[int] = field(default_factory=list)
    seen: int = 0

    def on_event(self, progress: Progress) -> None:
        self.seen += 1
        if self.seen % EVERY_DWELLS:
            return
        found = process_figures()
        self.hours.append(self.rig.clock.monotonic_s() / 3600.0)
        self.resident_mb.append(float(str(found["resident_mb"])))
        self.files.append(int(str(found["open_files"])))
        self.threads.append(int(str(found["threads"])))


def _faults(hours: float) -> FaultPlan:
    """One reply in five hundred damaged; every three hours a line is pulled out, and a table loses its power."""
    rules: dict[str, dict[str, object]] = {
        "noise": {"line": "*", "kind": "garble", "probability": 0.002},
        "late": {"line": "*", "kind": "delay", "delay_s": 6.0, "probability": 0.0005},
    }
    for number, hour in enumerate(np.arange(1.0, hours, 3.0)):
        line = ("readouts.dmm", "axes.pitch", "environment.air")[number % 3]
        rules[f"pulled{number}"] = {"line": line, "kind": "hang-up", "away_s": 30.0, "at_s": 3600.0 * float(hour)}
        rules[f"dark{number}"] = {
            "line": "axes.pitch", "kind": "power-cycle", "away_s": 5.0, "at_s": 3600.0 * (float(hour) + 1.5)
        }  # fmt: skip
    return FaultPlan.model_validate({"seed": 72, "fault": rules})


def _run(folder: Path, replications: int, hours: float) -> Figures:
    bench = device_set("table-3458a", folder, PROCEDURE.format(replications=replications))
    watched: list[Figures] = []

    def observer(rig: Rig) -> Figures:
        watched.append(Figures(rig))
        return watched[-1]

    story = tell_of(bench, folder / "run", _faults(hours), observer)
    assert story.is_finished, story.outcome
    return watched[0]


def _slope_mb_per_h(figures: Figures) -> float:
    first = int(WARM_UP * len(figures.hours))
    return float(np.polyfit(figures.hours[first:], figures.resident_mb[first:], 1)[0])


def _require_no_growth(figures: Figures) -> None:
    assert _slope_mb_per_h(figures) < MOST_MB_PER_H
    first = int(WARM_UP * len(figures.hours))
    for counted in (figures.files, figures.threads):
        assert max(counted[-10:]) <= max(counted[first : first + 20]), counted


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_fault_17_seventy_two_virtual_hours_with_faults_grow_nothing(tmp_path: Path) -> None:
    figures = _run(tmp_path, replications=11, hours=85.0)
    assert figures.hours[-1] > 72.0
    _require_no_growth(figures)
