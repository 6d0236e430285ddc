"""Runs of what moves, on the twins of the example rigs, with pieces of the files replaced; nothing is reported."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from example_files import ROOT

from procedures.delivery.deliver import SolvedRun, solve_run
from procedures.journal.header import RunHeader, make_header
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.plan.plan import Plan
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from rig.assembly.open_rig import open_rig
from rig.description.fault_plan import FaultPlan
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

EXAMPLES = ROOT / "examples"
Changes = Mapping[str, str]


@dataclass(frozen=True)
class MotionRun:
    """Files in a folder of their own, and what is made of them."""

    folder: Path
    rig: RigDescription
    plan: Plan

    def header(self, run_dir: Path) -> RunHeader:
        files = self.folder / "rig.toml", self.folder / "procedure.toml"
        return make_header(run_dir.name, self.plan, self.rig, *files, "tester", datetime.now(UTC))

    def run(self, run_dir: Path, faults: FaultPlan | None = None) -> Outcome:
        run_dir.mkdir()
        with open_rig(self.rig, faults=faults) as rig:
            return begin(run_dir, self.header(run_dir), self.plan, rig)

    def solved(self) -> SolvedRun:
        """Run it and solve it; it must finish."""
        outcome = self.run(self.folder / "run")
        assert outcome.exit_status == 0, outcome.reason
        return solve_run(self.folder / "run")


def motion_run(
    folder: Path, example: str, procedure: str, changes: Changes | None = None, rig_changes: Changes | None = None
) -> MotionRun:
    """``example``: a folder of ``examples``; ``changes``: of the procedure, as patterns of whole lines or pieces."""
    texts = {
        "rig.toml": ((EXAMPLES / example / "rig.toml"), rig_changes),
        "procedure.toml": ((EXAMPLES / example / f"{procedure}.toml"), changes),
    }
    for name, (source, wanted) in texts.items():
        text = source.read_text(encoding="utf-8")
        for pattern, new in (wanted or {}).items():
            text, count = re.subn(pattern, new, text)
            assert count, pattern
        (folder / name).write_text(text, encoding="utf-8")
    description = read_rig(folder / "rig.toml")
    return MotionRun(folder, description, make_plan(description, read_procedure(folder / "procedure.toml")))
