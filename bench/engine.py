"""What the engine costs a dwell beyond the devices' own time, the synced commit to the journal included.

The devices answer at once and time is virtual, so everything that is measured is the engine's: steering, settle
statistics, judgement, encoding, hashes, and SQLite's fsync on the disk of this checkout.
"""

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from timeit import Timer

from bench.bench_rig import BenchRig
from bench.figure import Effort, Figure
from procedures.journal.header import make_header
from procedures.journal.journal import Journal
from procedures.journal.requests.spool import Spool
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.records.states import State
from procedures.run.engine import Start, run
from rig.description.read import read_rig

EXAMPLES = Path(__file__).parents[1] / "examples"
SCRATCH = Path(__file__).parents[1] / "build"
PROCEDURE = """
[procedure]
title = "engine overhead"
kind = "grid"
replications = 3
[design]
kind = "D1"
pitch_deg = { from = -90.0, to = 90.0, step = 10.0 }
roll_deg = { from = -180.0, to = 180.0, step = 30.0 }
"""
TINY = PROCEDURE.replace("step = 10.0", "step = 60.0").replace("step = 30.0", "step = 90.0")


def figures(effort: Effort) -> Iterator[Figure]:
    """Milliseconds a dwell."""
    if not effort.is_tiny:
        SCRATCH.mkdir(exist_ok=True)
    with TemporaryDirectory(dir=effort.amount(SCRATCH, None)) as folder:
        dwells: list[int] = []
        seconds = Timer(lambda: dwells.append(finished_run(Path(folder), effort.amount(PROCEDURE, TINY)))).timeit(1)
    note = f"{dwells[0]} dwells of 3 × 20 samples"
    yield Figure(
        "engine overhead a dwell, fsync included", seconds / dwells[0] * 1e3, "ms", 5.0, at_most=True, note=note
    )


def finished_run(folder: Path, procedure: str) -> int:
    """A whole run on devices that cost nothing; returns how many dwells it took."""
    rig_path, procedure_path = EXAMPLES / "rig.toml", folder / "procedure.toml"
    procedure_path.write_text(procedure, encoding="utf-8")
    description = read_rig(rig_path)
    plan, bench_rig = make_plan(description, read_procedure(procedure_path)), BenchRig()
    header = make_header("bench", plan, description, rig_path, procedure_path, "bench", datetime.now(UTC))
    journal = Journal.create(folder / "journal.sqlite", header, bench_rig.clock)
    outcome = run(plan, bench_rig, journal, Spool(folder), Start("bench"))
    if outcome.state is not State.FINISHED:
        raise SystemExit(f"the run did not finish: {outcome}")
    return len(plan.dwells)
