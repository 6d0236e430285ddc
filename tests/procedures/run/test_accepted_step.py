"""From an epoch on whose step a person accepted, nothing is compared with what was measured before it."""

from pathlib import Path

import pytest
from resumed import resume_on
from small_run import Bench
from turned_table import common_mode_events, several_sensors, slips
from unattended_run import Happening, UnattendedRun, asks, events, run_unattended, states

from ams.archive.sets import list_sets
from procedures.delivery.deliver import sets_of, solve_run
from procedures.delivery.publish import publish_solved
from procedures.journal.requests.corrections import Authorisation, redo, void_from
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.report.assemble import assemble_view
from procedures.report.sections.run import check_rows
from procedures.solution.run_findings import run_findings
from rig.assembly.open_rig import open_rig
from rig.twins.physics.world import World

SLIPPED_DEG = -0.02
BEFORE_VISIT_1, BEFORE_VISIT_3 = 2, 7
"""Dwells of the design done; a visit follows every third."""


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return several_sensors(tmp_path_factory.mktemp("three"), 3)


def resumed(
    three: Bench, run_dir: Path, *, reason: str = "", after: dict[int, Happening] | None = None, off_deg: float
) -> State:
    """Take the run up on a table that stands ``off_deg`` off; whoever comes by a held run stops it."""
    with open_rig(three.rig) as rig:
        world = rig.chance
        assert isinstance(world, World)
        world.slip("roll", off_deg, rig.clock.monotonic_s(), seen=False)
        unattended = UnattendedRun(run_dir, at={5: asks("stop")}, after=after)
        unattended.rig = rig
        return resume_on(run_dir, rig, "bert", reason, observer=unattended, idle_clock=unattended).state


def slipped_while_it_stood(three: Bench, run_dir: Path, done: int) -> None:
    """The run is stopped, roll slips by 72″, and the restart finds it."""
    assert run_unattended(three, UnattendedRun(run_dir, after={done: asks("stop")})).state is State.STOPPED
    assert resumed(three, run_dir, off_deg=SLIPPED_DEG) is State.TRIPPED


def slipped_in_mid_run(three: Bench, run_dir: Path) -> None:
    """Visit 3 holds the run, and somebody stops it."""
    unattended = UnattendedRun(run_dir, at={5: asks("stop")}, after={BEFORE_VISIT_3: slips("roll", SLIPPED_DEG)})
    assert run_unattended(three, unattended).state is State.STOPPED


def accepted(three: Bench, run_dir: Path, after: dict[int, Happening] | None = None) -> State:
    return resumed(three, run_dir, reason="the table stays as it is", after=after, off_deg=SLIPPED_DEG)


def found_in(run_dir: Path) -> list[str]:
    return [finding.text for finding in run_findings(solve_run(run_dir).record)]


def held_for_a_slip(three: Bench, run_dir: Path) -> tuple[str, list[int]]:
    """Run until a visit holds it; return what it says and the steps in doubt."""
    slipped_in_mid_run(three, run_dir)
    (noted,) = events(run_dir, "common_mode")
    doubtful = noted.detail["doubtful"]
    assert isinstance(doubtful, list)
    return str(noted.detail["text"]), doubtful


def test_visits_after_an_accepted_step_are_not_held_for_it_again(three: Bench, tmp_path: Path) -> None:
    """The turn is told once, of the check sets; sets and verdict stay what a turn in mid-run makes them."""
    run_dir = tmp_path / "run"
    slipped_while_it_stood(three, run_dir, BEFORE_VISIT_3)
    assert accepted(three, run_dir) is State.FINISHED
    assert "held" not in states(run_dir)
    assert common_mode_events(run_dir) == []
    solved = solve_run(run_dir)
    (turn,) = run_findings(solved.record)
    assert turn.text.startswith("all three sensors turned by −7")
    assert "about roll since the check set of epoch 1" in turn.text
    assert "stand after it" not in turn.text, "seven dwells of the design stand before it"
    view = assemble_view(solved.record, solved.sensors)
    assert view.verdict.trust == "unusable"
    restart = next(ground for ground in view.verdict.grounds if ground.startswith("A restart made a step"))
    assert "restart 1: the table, its base or the common fixture: " in restart
    assert {row.judged.partition("; ")[2] for row in check_rows(view.checks) if row.restart == 1} == {
        "all together: the table, its base or the common fixture"
    }
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish_solved(url, run_dir, solved.record, solved.sensors, sets_of(solved))
    assert [coefficients.quarantine for coefficients in list_sets(url)] == [turn.text] * 3


def test_what_was_in_doubt_and_is_measured_again_on_the_table_as_it_was_accepted_is_not_held(
    three: Bench, tmp_path: Path
) -> None:
    run_dir = tmp_path / "run"
    _, doubtful = held_for_a_slip(three, run_dir)
    void_from(run_dir, min(doubtful), Authorisation("bert", "all of it again"))
    assert resumed(three, run_dir, off_deg=SLIPPED_DEG) is State.TRIPPED
    assert accepted(three, run_dir) is State.FINISHED
    assert states(run_dir).count("held") == 1
    (text,) = found_in(run_dir)
    assert "since the check set of epoch 1" in text


@pytest.mark.parametrize(
    ("stopped_after", "slips_after", "between"),
    [
        (BEFORE_VISIT_1, 2, "between the check set of epoch 3 and visit 1"),
        (BEFORE_VISIT_3, 8, "between the check set of epoch 3 and visit 3"),
        (BEFORE_VISIT_3, 10, "between visits 3 and 4"),
    ],
)
def test_a_further_step_after_the_accepted_one_is_held_with_its_own_size(
    three: Bench, tmp_path: Path, stopped_after: int, slips_after: int, between: str
) -> None:
    """By 36″ to the other side; with the accepted one it would be -36″. Few visits were made before: none is needed."""
    run_dir = tmp_path / "run"
    slipped_while_it_stood(three, run_dir, stopped_after)
    again = {slips_after + (slips_after == stopped_after): slips("roll", 0.01)}
    assert accepted(three, run_dir, again) is State.STOPPED
    ((kinds, is_held, text),) = common_mode_events(run_dir)
    assert (kinds, is_held) == (["table-rotation"], True)
    assert text.startswith("all three sensors turned by +3")
    assert f"about roll {between}" in text
    told = found_in(run_dir)
    assert len(told) == 2
    assert text in told


class StoppedWithinVisit(UnattendedRun):
    """Somebody asks for a stop when so many dwells of any purpose are done."""

    def __init__(self, run_dir: Path, dwells: int) -> None:
        super().__init__(run_dir)
        self._left = dwells

    def on_event(self, progress: Progress) -> None:
        super().on_event(progress)
        self._left -= progress.event == "dwell"
        if progress.event == "dwell" and self._left == 0:
            asks("stop")(self)


@pytest.mark.parametrize("slips_again", [False, True])
def test_of_a_visit_begun_before_an_accepted_step_only_what_came_after_it_is_compared(
    three: Bench, tmp_path: Path, slips_again: bool
) -> None:
    """Six check dwells, three of the design, visit 1, three of the design, and the first half of visit 2."""
    run_dir = tmp_path / "run"
    assert run_unattended(three, StoppedWithinVisit(run_dir, 6 + 3 + 2 + 3 + 1)).state is State.STOPPED
    assert resumed(three, run_dir, off_deg=SLIPPED_DEG) is State.TRIPPED
    again = {7: slips("roll", 0.01)} if slips_again else {}
    assert accepted(three, run_dir, again) is (State.STOPPED if slips_again else State.FINISHED)
    told = common_mode_events(run_dir)
    assert [is_held for _, is_held, _ in told] == [True] * slips_again
    assert all("turned by +3" in text and "about roll between visits 2 and 3" in text for *_, text in told)
    assert len(found_in(run_dir)) == 1 + slips_again


def test_what_is_redone_on_the_table_set_right_is_compared_with_what_counts_and_not_held(
    three: Bench, tmp_path: Path
) -> None:
    """With the check set of its own start, which stands as the first of the run does."""
    run_dir = tmp_path / "run"
    slipped_in_mid_run(three, run_dir)
    redo(run_dir, 1, Authorisation("bert", "the coupling is tight again"))
    assert resumed(three, run_dir, off_deg=0.0) is State.FINISHED
    assert states(run_dir).count("held") == 1
    solved = solve_run(run_dir)
    judged = [visit.between for visit in solved.record.judged_visits]
    assert judged[:3] == [
        "since the check set of epoch 1",
        "between the check set of epoch 2 and visit 1",
        "between visits 1 and 2",
    ]
    assert run_findings(solved.record) == ()


def test_a_turn_is_told_while_dwells_in_doubt_by_a_visit_that_was_taken_back_still_count(
    three: Bench, tmp_path: Path
) -> None:
    """The last of the three is measured again on the table set right, and the visit with it: that agrees with all."""
    run_dir = tmp_path / "run"
    text, doubtful = held_for_a_slip(three, run_dir)
    void_from(run_dir, max(doubtful), Authorisation("bert", "the coupling is tight again"))
    assert resumed(three, run_dir, off_deg=0.0) is State.FINISHED
    solved = solve_run(run_dir)
    (turn,) = run_findings(solved.record)
    assert turn.text.startswith(text)
    first, last = sorted(doubtful)[:2]
    assert f"the visit that showed it was taken back, and 2 dwells in doubt, of steps {first} to {last}" in turn.text
    assert assemble_view(solved.record, solved.sensors).verdict.trust == "unusable"
    void_from(run_dir, first, Authorisation("bert", "those as well"))
    assert resumed(three, run_dir, off_deg=0.0) is State.FINISHED
    assert found_in(run_dir) == []


@pytest.mark.parametrize("slipped_after", [BEFORE_VISIT_1, BEFORE_VISIT_3], ids=["visit 1", "visit 3"])
@pytest.mark.parametrize(
    ("further_deg", "state"), [(0.0, State.FINISHED), (0.01, State.TRIPPED), (-0.01, State.TRIPPED)]
)
def test_a_turn_that_a_person_continued_with_trips_no_restart_of_that_night_and_a_new_one_does(
    three: Bench, tmp_path: Path, further_deg: float, state: State, slipped_after: int
) -> None:
    """Held at a visit and continued, then stopped and taken up again: as the table stood, or turned by 36″ more.

    The first visit is compared with the check set, the third with the visit before it.
    """
    run_dir = tmp_path / "run"
    unattended = UnattendedRun(
        run_dir, at={5: asks("continue")}, after={slipped_after: slips("roll", SLIPPED_DEG), 10: asks("stop")}
    )
    assert run_unattended(three, unattended).state is State.STOPPED
    assert states(run_dir).count("held") == 1
    assert resumed(three, run_dir, off_deg=SLIPPED_DEG + further_deg) is state
    seam = events(run_dir, "seam")[-1].detail
    assert seam["turned"]
    assert ("accepted" in seam) == (state is State.FINISHED)
    solved = solve_run(run_dir)
    assert assemble_view(solved.record, solved.sensors).verdict.trust == "unusable"


def test_a_turn_at_which_a_person_stopped_is_asked_once_more(three: Bench, tmp_path: Path) -> None:
    """Who stops a held run has accepted nothing."""
    run_dir = tmp_path / "run"
    slipped_in_mid_run(three, run_dir)
    assert resumed(three, run_dir, off_deg=SLIPPED_DEG) is State.TRIPPED
