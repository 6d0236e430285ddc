"""Another device at a resume: it measures nothing until somebody takes it over by name, and then everybody is told."""

from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from resumed import resume_on
from small_run import Bench, StopAt, bench
from unattended_run import events

from ams.sets.equipment import equipment_of
from procedures.delivery.deliver import sets_of, solve_run
from procedures.errors import RequestError
from procedures.records.states import State
from procedures.report.assemble import assemble_view
from procedures.run.handover import handover
from procedures.run.resume import resume
from rig.assembly.open_rig import open_rig

OTHER = "HP3458A, another one"
SENTENCE = "not the devices of this run: readouts.dmm: was 'HP3458A, revision"


@pytest.fixture
def small(tmp_path: Path) -> Bench:
    return bench(tmp_path)


def _stopped(small: Bench) -> Path:
    run_dir = small.folder / "stopped"
    assert small.run(run_dir, observer=StopAt(run_dir, 5)).state is State.STOPPED
    return run_dir


def _with_other(
    small: Bench, run_dir: Path, identity: str = OTHER, *, accepts_changes: bool = False
) -> tuple[State, str]:
    with open_rig(small.rig) as opened:
        rig = FaultyRig(opened, identity=identity)
        outcome = resume_on(run_dir, rig, "carla", "the meter went for repair", accepts_changes=accepts_changes)
    return outcome.state, outcome.reason


def test_another_device_trips_every_resume_until_the_first_is_put_back(small: Bench) -> None:
    run_dir = _stopped(small)
    for _ in range(2):
        state, reason = _with_other(small, run_dir)
        assert (state, reason.startswith(SENTENCE)) == (State.TRIPPED, True), reason
    assert resume(run_dir, "carla", "the meter is back").state is State.FINISHED
    assert not events(run_dir, "override")


def test_another_device_is_taken_over_by_name_and_everybody_is_told(small: Bench) -> None:
    run_dir = _stopped(small)
    state, reason = _with_other(small, run_dir, accepts_changes=True)
    assert (state, "takes over only what the run stopped at before" in reason) == (State.TRIPPED, True)
    assert _with_other(small, run_dir, "HP3458A, a third", accepts_changes=True)[0] is State.TRIPPED, "not seen before"
    assert _with_other(small, run_dir)[0] is State.TRIPPED
    assert _with_other(small, run_dir, accepts_changes=True)[0] is State.FINISHED
    (override,) = events(run_dir, "override")
    assert override.detail["devices"] == {"readouts.dmm": OTHER}
    assert (override.detail["by"], override.detail["reason"]) == ("carla", "the meter went for repair")

    solved = solve_run(run_dir)
    sentence = f"'{OTHER}', taken over by carla: the meter went for repair, measured 19 dwells of steps 11 to 32"
    assert sentence in handover(run_dir)
    (ground,) = [text for text in assemble_view(solved.record, solved.sensors).verdict.grounds if sentence in text]
    assert "measured 5 dwells of steps 6 to 10" in ground
    (made,) = sets_of(solved).values()
    (row,) = [row for row in equipment_of(made) if row.identity == OTHER]
    assert (row.certificate, row.used_for) == (None, "outputs (19 dwells)")


def test_a_device_that_was_taken_over_is_the_run_s_and_the_first_one_is_another(small: Bench) -> None:
    run_dir = _stopped(small)
    _with_other(small, run_dir)
    with open_rig(small.rig) as opened:
        observer, rig = StopAt(run_dir, 9), FaultyRig(opened, identity=OTHER)
        assert resume_on(run_dir, rig, "carla", "new", observer, accepts_changes=True).state is State.STOPPED
    assert resume(run_dir, "carla", "the first again").state is State.TRIPPED
    assert _with_other(small, run_dir)[0] is State.FINISHED


def test_who_takes_over_a_device_gives_a_name_and_a_reason(small: Bench) -> None:
    run_dir = _stopped(small)
    with pytest.raises(RequestError, match="--accept-changes needs a name and a reason"):
        resume(run_dir, "", "", accepts_changes=True)
