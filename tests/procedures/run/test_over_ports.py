"""The same campaign over TCP and pseudo-terminals, in scaled time, reads the same numbers as in memory."""

from pathlib import Path

import pytest
from asking import put
from cut_line import CutLine, cut_line
from small_run import bench, dwells_of, measured

from procedures.journal.header import make_header
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Spool
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.resume import resume
from rig.assembly.open_rig import open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock, SystemClock

FACTOR = 100.0
SHORT = (("step = 30.0", "step = 60.0"), ("replications = 2", "replications = 1"), ("samples = 5", "samples = 3"))


@pytest.mark.parametrize("pty", [pytest.param(False, marks=pytest.mark.thorough), True])
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


class StopsAfter:
    """Asks for a stop when so many dwells of the design are done."""

    def __init__(self, run_dir: Path, dwells: int) -> None:
        self._spool, self._dwells = Spool(run_dir), dwells

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and progress.dwells_done == self._dwells:
            put(self._spool, "stop", "anna", "the twins are served anew")


@pytest.mark.thorough
def test_fault_70_twins_that_are_served_anew_elsewhere_are_taken_over_with_their_control(tmp_path: Path) -> None:
    """Without its control address a twin is not told the step, and its chance is another."""
    small = bench(tmp_path, procedure=SHORT)
    small.run(tmp_path / "memory")
    run_dir, files = tmp_path / "ports", (tmp_path / "served.toml", tmp_path / "procedure.toml")
    run_dir.mkdir()
    with serve_rig(small.rig, ScaledClock(FACTOR)) as served:
        described = write_rig(tmp_path / "rig.toml", served.addresses, FACTOR, files[0])
        plan = make_plan(described, read_procedure(files[1]))
        header = make_header("ports", plan, described, *files, "tester", SystemClock().now_utc())
        with open_rig(described) as rig:
            assert begin(run_dir, header, plan, rig, StopsAfter(run_dir, 3)).state is State.STOPPED
    with serve_rig(small.rig, ScaledClock(FACTOR)) as again:
        write_rig(tmp_path / "rig.toml", again.addresses, FACTOR, files[0])
        assert resume(run_dir, "carla", "served anew", accepts_changes=True).state is State.FINISHED
    assert measured(dwells_of(run_dir)) == measured(dwells_of(tmp_path / "memory"))


class CutsAfter:
    """Cuts the table's line when so many dwells of the design are done, for so many callers."""

    def __init__(self, line: CutLine, dwells: int, refusals: int) -> None:
        self._line, self._dwells, self._refusals = line, dwells, refusals

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and progress.dwells_done == self._dwells and self._dwells:
            self._dwells = 0
            self._line.cut(self._refusals)


@pytest.mark.thorough
def test_fault_21_a_real_line_that_is_cut_is_opened_again_and_the_numbers_are_the_same(tmp_path: Path) -> None:
    small = bench(tmp_path, procedure=SHORT)
    small.run(tmp_path / "memory")
    run_dir, files = tmp_path / "ports", (tmp_path / "served.toml", tmp_path / "procedure.toml")
    run_dir.mkdir()
    with serve_rig(small.rig, ScaledClock(FACTOR)) as served, cut_line(served.addresses["axes.pitch"]) as line:
        addresses = {**served.addresses, "axes.pitch": line.address, "axes.roll": line.address}
        described = write_rig(tmp_path / "rig.toml", addresses, FACTOR, files[0])
        plan = make_plan(described, read_procedure(files[1]))
        header = make_header("ports", plan, described, *files, "tester", SystemClock().now_utc())
        with open_rig(described) as rig:
            assert begin(run_dir, header, plan, rig, CutsAfter(line, 3, 1)).state is State.FINISHED
    assert line.callers == 3, "opened, refused once, opened again"
    with JournalReader.open(run_dir) as reader:
        states = [str(event.detail["to"]) for event in reader.events("state")]
        held = next(event for event in reader.events("state") if event.detail["to"] == "held")
    assert states == ["planned", "checking", "running", "held", "checking", "running", "finished"]
    assert str(held.detail["reason"]).startswith(f"link lost: axes.pitch at {line.address}")
    assert measured(dwells_of(run_dir)) == measured(dwells_of(tmp_path / "memory"))
