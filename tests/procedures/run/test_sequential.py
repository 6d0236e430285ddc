"""Laws of ``[stop] half_width_deg``: a run ends after the first whole replications that are enough."""

from pathlib import Path

import pytest
from planning_files import procedure_file
from small_run import Bench, bench, dwells_of

from procedures.errors import PlanError
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_sensors
from procedures.records.states import State
from procedures.run.services import RunServices
from procedures.solution.sufficient import sufficient
from rig.errors import DescriptionError

SERVICES = RunServices(enough=sufficient)


def sequential(folder: Path, half_width_deg: float, most: int = 5, least: int = 2) -> Bench:
    rule = (
        f"[stop]\nhalf_width_deg = {half_width_deg}\nleast_replications = {least}\nmost_replications = {most}\n[check]"
    )
    return bench(folder, procedure=(("replications = 2\n", ""), ("[check]", rule)))


def _replications(run_dir: Path) -> int:
    return max(dwell.replication for dwell in dwells_of(run_dir))


def _told(run_dir: Path) -> list[dict]:
    with JournalReader.open(run_dir) as reader:
        return [dict(event.detail) for event in reader.events() if event.kind == "enough"]


def test_a_run_ends_when_it_has_measured_enough_and_its_solution_says_so(tmp_path: Path) -> None:
    made = sequential(tmp_path, 0.01)
    outcome = made.run(tmp_path / "run", services=SERVICES)
    assert (outcome.state, _replications(tmp_path / "run")) == (State.FINISHED, 2)
    assert outcome.dwells_done == 2 * 12 < outcome.dwells_planned
    (text,) = _told(tmp_path / "run")
    assert text["enough"] is True
    assert text["half_width_deg"]["SN1"] < 0.01
    solved = solve_sensors(dwells_of(tmp_path / "run"), made.rig, made.plan, "run")["SN1"]
    assert any("sequential: 2 of at most 5 replications" in remark for remark in solved.calibration.remarks)


@pytest.mark.thorough
def test_what_is_never_enough_is_measured_to_the_last_replication(tmp_path: Path) -> None:
    outcome = sequential(tmp_path, 1e-6, most=3).run(tmp_path / "run", services=SERVICES)
    assert (outcome.state, _replications(tmp_path / "run")) == (State.FINISHED, 3)
    assert [entry["enough"] for entry in _told(tmp_path / "run")] == [False]


def test_a_significant_drift_is_measured_to_the_last_replication(tmp_path: Path) -> None:
    rule = "[stop]\nhalf_width_deg = 0.01\nleast_replications = 2\nmost_replications = 3\n[check]"
    drift = ("azimuth_deg = 35.0,", "azimuth_deg = 35.0, offset_drift_v_per_replication = 2e-4,")
    made = bench(tmp_path, (drift,), (("replications = 2\n", ""), ("[check]", rule)))
    made.run(tmp_path / "run", services=SERVICES)
    assert _replications(tmp_path / "run") == 3
    assert "a drift is significant (SN1 x offset" in _told(tmp_path / "run")[0]["text"]


@pytest.mark.thorough
def test_without_anybody_who_can_judge_the_rule_is_not_forgotten(tmp_path: Path) -> None:
    outcome = sequential(tmp_path, 0.01).run(tmp_path / "run")
    assert outcome.state is State.FAILED
    assert "nothing here can judge it" in outcome.reason


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ("[stop]\nhalf_width_deg = 0.01\n", "go together: give all or none"),
        ("[stop]\nleast_replications = 3\nmost_replications = 4\nmax_duration_s = 9.0\n", "go together"),
        ("[stop]\nhalf_width_deg = 0.01\nleast_replications = 5\nmost_replications = 4\n", "must not exceed"),
        ("[stop]\n", "give max_duration_s, or half_width_deg"),
    ],
)
def test_a_rule_without_its_bounds_is_a_sentence(tmp_path: Path, more: str, sentence: str) -> None:
    with pytest.raises(DescriptionError, match=sentence):
        procedure_file(tmp_path, more=more)


def test_replications_beside_the_rule_are_refused(tmp_path: Path) -> None:
    rule = "[stop]\nhalf_width_deg = 0.01\nleast_replications = 2\nmost_replications = 4\n[check]"
    with pytest.raises(PlanError, match="most_replications says how many there are at most"):
        bench(tmp_path, procedure=(("[check]", rule),))
