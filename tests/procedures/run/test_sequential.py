"""Laws of ``[stop] half_width_deg``: a run ends after the first whole replications that are enough."""

from pathlib import Path

import numpy as np
import pytest
from planning_files import procedure_file
from small_run import Bench, bench, dwells_of

from ams.calibration.columns import solve_columns
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
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
    (told,) = _told(tmp_path / "run")
    assert told["enough"] is True
    assert told["half_width_deg"]["SN1"] < 0.01
    solved = solve_sensors(dwells_of(tmp_path / "run"), made.rig, made.plan, "run")["SN1"]
    assert any("sequential: 2 of at most 5 replications" in remark for remark in solved.calibration.remarks)


@pytest.mark.thorough
def test_what_is_never_enough_is_measured_to_the_last_replication(tmp_path: Path) -> None:
    outcome = sequential(tmp_path, 1e-6, most=3).run(tmp_path / "run", services=SERVICES)
    assert (outcome.state, _replications(tmp_path / "run")) == (State.FINISHED, 3)
    assert [one["enough"] for one in _told(tmp_path / "run")] == [False]


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


def _coverage(campaigns: int, seed: int, least: int = 4, most: int = 12) -> tuple[float, float, float]:
    """Share of 95 % intervals for offset and sensitivities that hold the truth at the stop, at a fixed size, and the
    mean number of replications.

    The rule as it is: precision inside the replications against a limit that is met after about eight of them, and no
    drift that is significant.
    """
    pitch, roll = (np.deg2rad(a).ravel() for a in np.meshgrid([-60.0, 0.0, 60.0], np.arange(-180.0, 180.0, 60.0)))
    points, chance = pitch.size, np.random.default_rng(seed)
    model, truth = PitchRoll("x"), np.array([0.01, 2.5, 0.02, -0.01])
    clean = PitchRoll("x").predict(truth, _rows(pitch, roll, 1))
    noise = chance.standard_normal((most, points, campaigns))
    stopped, held, fixed, counts = np.zeros(campaigns, dtype=bool), [], [], []
    for n in range(least, most + 1):
        outputs = (clean[None, :, None] + 1e-5 * noise[:n]).reshape(n * points, campaigns)
        solved = solve_columns(_rows(pitch, roll, n), outputs, [model] * campaigns)
        half = solved.parameters.halfwidths_95[:, :2]
        covers = np.abs(solved.parameters.values[:, :2] - model.parameters(truth)[:2]) <= half
        foreseen = np.sqrt(solved.mixed.precision_variance / n)
        drift = np.any([test.is_significant for test in solved.replication.drift.values()], axis=0)
        enough = (foreseen <= 1e-5 / np.sqrt(8.0)) & ~drift
        now = ~stopped & (enough | (n == most))
        held.append(covers[now])
        counts += [n] * int(now.sum())
        stopped |= now
        if n == 8:
            fixed.append(covers)
    return float(np.concatenate(held).mean()), float(np.concatenate(fixed).mean()), float(np.mean(counts))


def _rows(pitch: np.ndarray, roll: np.ndarray, n: int) -> Observations:
    points = pitch.size
    return Observations(
        np.repeat(np.arange(n), points), np.tile(np.arange(points), n), np.tile(pitch, n), np.tile(roll, n), {}
    )


def test_intervals_keep_their_coverage_at_the_stop() -> None:
    """Few campaigns: 0.95 ± 0.02 is four standard errors."""
    at_stop, fixed, replications = _coverage(1000, 5)
    assert at_stop == pytest.approx(0.95, abs=0.02)
    assert fixed == pytest.approx(0.95, abs=0.02)
    assert 6.0 < replications < 10.0


@pytest.mark.soak
def test_intervals_cover_95_percent_at_the_stop() -> None:
    at_stop, fixed, _ = _coverage(20_000, 6)
    assert at_stop == pytest.approx(0.95, abs=0.01)
    assert fixed == pytest.approx(0.95, abs=0.01)
