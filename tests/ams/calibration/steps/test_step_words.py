"""Of a change in mid-run both sides are named, each with the command that measures it again and no more."""

import numpy as np
import pytest
from dwells_of_points import layout_of_points

from ams.analysis.diagnostics.steps.step_scan import Change, Course
from ams.calibration.steps.step_words import doubt
from ams.observations import Observations

REPLICATIONS, POINTS = 4, 20
REPLICATION = np.repeat(np.arange(1, REPLICATIONS + 1), POINTS)
STEP = np.arange(7, 7 + REPLICATIONS * POINTS)
ZEROS = np.zeros(STEP.size)
REDONE_S = STEP + np.where(REPLICATION == 1, 1000.0, 0.0)
"""The first replication was measured again, and stands last."""


def doubt_of(
    index: int, end: int | None = None, time_s: np.ndarray = REDONE_S, what: str = "roll", *, is_of_run: bool = True
) -> str:
    point = np.tile(np.arange(1, POINTS + 1), REPLICATIONS)
    step = STEP if is_of_run else None
    rows = Observations(REPLICATION, point, ZEROS, ZEROS, {}, time_s=time_s, step=step, run="night-1")
    course = Course(layout_of_points(point), np.argsort(time_s), ZEROS, ZEROS, 60)
    return doubt(Change(what, None, index, 1e-9, 1.0, end), course, rows).text  # type: ignore[arg-type]


def test_where_a_replication_was_measured_again_on_a_table_put_right_the_way_that_ends_it_is_named() -> None:
    """A void from the first of its steps takes back those alone that are right, for ever."""
    said = doubt_of(60)
    assert said.startswith("20 of 80 dwells were measured since; measure one side again, with the table as it stood")
    since, before = said.split(", or the ")
    assert "the 20 since (calrig redo night-1 --replication 1 " in since
    assert "takes back 20 dwells of the design" in since
    assert before.startswith("60 before (")
    assert all(f"calrig redo night-1 --replication {label} " in before for label in (2, 3, 4))
    assert "--replication 1 " not in before
    assert "take back 60 dwells of the design" in before
    assert "solve those" not in said


def test_in_the_order_of_the_plan_what_was_measured_since_is_taken_back_from_its_first_dwell() -> None:
    said = doubt_of(50, time_s=STEP.astype(float))
    assert "the 30 since (calrig void night-1 --from 57 --operator NAME --reason TEXT takes back 30 dwells" in said
    assert "the 50 before (calrig redo night-1 --replication 1 " in said
    assert "take back 60 dwells of the design" in said, "the replication in which it changed is taken back whole"


def test_a_side_that_costs_the_whole_run_is_not_named() -> None:
    said = doubt_of(65, 75, time_s=STEP.astype(float))
    assert said.startswith("10 of 80 dwells were measured in between; ")
    assert "the 10 in between (calrig void night-1 --from 72 " in said
    assert "takes back 15 dwells" in said
    assert "outside" not in said


@pytest.mark.parametrize("end", [None, 70])
def test_the_rows_of_a_file_are_solved_again_without_one_side(end: int | None) -> None:
    said = doubt_of(60, end, is_of_run=False)
    assert said.endswith("; measure them again, or solve those of one side" if end is None else "solve those outside")
    assert "calrig" not in said


def test_of_a_sensor_nothing_is_said_of_the_table() -> None:
    assert "with the table" not in doubt_of(60, what="offset")
