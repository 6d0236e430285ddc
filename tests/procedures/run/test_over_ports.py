"""The same campaign over TCP and pseudo-terminals, in scaled time, reads the same numbers as in memory."""

from pathlib import Path

import pytest
from small_run import bench, dwells_of, measured

from procedures.description import read_procedure
from procedures.plan.planner import make_plan
from procedures.run.begin import begin
from procedures.run.header import make_header
from procedures.run.states import State
from rig.assembly import open_rig
from rig.clock import ScaledClock, SystemClock
from rig.simulate import serve_rig, write_rig

FACTOR = 100.0
SHORT = (("step = 30.0", "step = 60.0"), ("replications = 2", "replications = 1"), ("samples = 5", "samples = 3"))


@pytest.mark.parametrize("pty", [False, True])
def test_a_run_over_real_ports_reads_what_it_reads_in_memory(tmp_path: Path, pty: bool) -> None:
    small = bench(tmp_path, procedure=SHORT)
    small.run(tmp_path / "memory")
    run_dir, files = tmp_path / "ports", (tmp_path / "served.toml", tmp_path / "procedure.toml")
    run_dir.mkdir()
    with serve_rig(small.rig, ScaledClock(FACTOR), pty=pty) as served:
        described = write_rig(tmp_path / "rig.toml", served.addresses, FACTOR, files[0])
        plan = make_plan(described, read_procedure(files[1]))
        header = make_header("ports", plan, described, *files, "tester", SystemClock().now_utc())
        with open_rig(described) as rig:
            assert begin(run_dir, header, plan, rig).state is State.FINISHED
    assert header.is_simulated
    assert measured(dwells_of(run_dir)) == measured(dwells_of(tmp_path / "memory"))
