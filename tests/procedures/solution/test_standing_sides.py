"""Which side of a slip stands as the first check set of the run did: told where check sets tell it, and only then."""

from dataclasses import replace
from pathlib import Path

import pytest
from resumed import resume_on
from small_run import Bench
from turned_table import several_sensors, slips
from unattended_run import UnattendedRun, asks, run_unattended

from ams.analysis.diagnostics.beliefs import SLIP, STEP
from ams.findings import Finding
from procedures.delivery.deliver import solve_run
from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from procedures.solution.record import RunRecord
from procedures.solution.standing_sides import StandingSides
from rig.assembly.open_rig import open_rig


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return several_sensors(tmp_path_factory.mktemp("three"), 3)


@pytest.fixture(scope="module")
def put_right(three: Bench, tmp_path_factory: pytest.TempPathFactory) -> RunRecord:
    """The first visit of the second start differs from those of the turned table, and is continued with."""
    return slipped_and_resumed(three, tmp_path_factory.mktemp("put right") / "run", 0.0)


def slipped_and_resumed(three: Bench, run_dir: Path, roll_off_deg: float) -> RunRecord:
    """Roll slips by 72″ at the eighth dwell, somebody goes on all the same; after a stop it is resumed."""
    at, after = {5: asks("continue")}, {7: slips("roll", -0.02), 10: asks("stop")}
    unattended = UnattendedRun(run_dir, at=at, after=after)
    assert run_unattended(three, unattended).state is State.STOPPED
    with open_rig(three.rig) as rig:  # a twin of its own stands where its zero is
        again = UnattendedRun(run_dir, at=at)
        again.rig = rig
        slips("roll", roll_off_deg)(again)
        assert resume_on(run_dir, rig, "bert", observer=again, idle_clock=again).state is State.FINISHED
    return solve_run(run_dir).record


def of_epoch(record: RunRecord, epoch: int) -> list[DwellRecord]:
    return [dwell for dwell in StandingSides(record).design if dwell.epoch == epoch]


def test_a_start_with_a_check_set_as_the_first_stands_as_that_and_what_a_visit_showed_turned_does_not(
    put_right: RunRecord,
) -> None:
    sides = StandingSides(put_right)
    (turn,) = [judged for judged in put_right.judged_visits if judged.holds and judged.until[0] == 1]
    for dwell in of_epoch(put_right, 1):
        before, after = dwell.ended_s <= turn.since[1], dwell.started_s >= turn.until[1]
        assert sides.stands_as_first[dwell.step] is (True if before else False if after else None)
    assert {sides.stands_as_first[dwell.step] for dwell in of_epoch(put_right, 1)} >= {False, None}
    assert {sides.stands_as_first[dwell.step] for dwell in of_epoch(put_right, 2)} == {True}


def test_a_start_on_the_turned_table_does_not_stand_as_the_first(three: Bench, tmp_path: Path) -> None:
    record = slipped_and_resumed(three, tmp_path / "run", -0.02)
    stands = StandingSides(record).stands_as_first
    assert {stands[dwell.step] for dwell in of_epoch(record, 2)} == {False}


def test_the_slip_names_the_side_to_measure_again_and_what_is_no_slip_names_none(put_right: RunRecord) -> None:
    as_first = StandingSides(put_right).stands_as_first
    before_it = {dwell.step for dwell in of_epoch(put_right, 1) if as_first[dwell.step]}
    record = replace(put_right, dwells=tuple(dwell for dwell in put_right.dwells if dwell.step not in before_it))
    sides = StandingSides(record)
    since = tuple(dwell.step for dwell in of_epoch(record, 2))
    others = [dwell.step for dwell in of_epoch(record, 1)]
    either = "measure one side again"
    slip = Finding("table-rotation", "it turned", True, None, since, {"test": SLIP}, what_to_do=either)
    named = sides.with_side(slip)
    assert "those since stand as the first check set of the run did" in named.fact
    assert named.what_to_do.startswith(f"measure the {len(others)} before again, with the table as it stood")
    assert f"calrig redo {record.run} --replication 1 " in named.what_to_do
    assert sides.with_side(replace(slip, details={"test": STEP})).what_to_do == either
    of_both = replace(slip, steps=(*since, others[-1]))
    assert sides.with_side(of_both) == of_both, "a side that stands in part as it did is none"
