"""Laws of what a journal says of durations: nothing is lost, nothing disturbed teaches, every kind is foreseen."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from shutil import rmtree

import pytest
from faulty_rig import FaultyRig, noisier
from motion_runs import MotionRun, motion_run
from small_run import Bench, bench

from procedures.journal.journal_reader import JournalReader
from procedures.plan.estimate import expected_duration
from procedures.plan.learned_times import PartSums, learned_from
from procedures.plan.step_times import AGAIN
from procedures.run.begin import begin
from procedures.solution.part_durations import part_durations
from procedures.solution.record import RunRecord, read_record
from rig.assembly.open_rig import open_rig

SOAKS = ("[check]", "[environment]\nplateaus_degc = [15.0, 25.0]\nsoak_s = 600.0\n[check]")
ONCE = {r"replications = \d": "replications = 1"}
SHORT_REST = {"rest_s = 60.0": "rest_s = 10.0"}
SHORT_STATIC = {"duration_s = 1200.0": "duration_s = 200.0", "use_s = 120.0": "use_s = 20.0"}
KINDS: dict[str, tuple[str, str, dict[str, str]]] = {
    "tumble": ("servo-mechanism", "accelerometer", {**ONCE, "samples = 60": "samples = 10"}),
    "static": ("servo-mechanism", "drift", SHORT_STATIC),
    "sweeps": ("servo-mechanism", "gyro", {**ONCE, "dwell_s = 300.0": "dwell_s = 30.0"}),
    "two-level": ("servo-mechanism", "magnetometer", {**ONCE, **SHORT_REST}),
    "harmonic": ("rate-table", "harmonic", {}),
    "ramp": ("rate-table", "ramp", {}),
    "turns": ("rate-table", "rates", {"replications = 4": "replications = 2"}),
}
QUICK = ("tumble", "static")
KINDS_OF_CHANCE = ("tumble", "static", "two-level")
SAME_S = 1e-3
EVERY = [pytest.param(kind, marks=() if kind in QUICK else pytest.mark.thorough) for kind in KINDS]


def _record(run_dir: Path) -> RunRecord:
    with JournalReader.open(run_dir) as reader:
        return read_record(reader)


def _took_s(record: RunRecord) -> float:
    return record.events[-1].monotonic_s - record.events[0].monotonic_s


@pytest.fixture(scope="module")
def soaked(tmp_path_factory: pytest.TempPathFactory) -> tuple[Bench, RunRecord]:
    small = bench(tmp_path_factory.mktemp("soaked"), procedure=(SOAKS,))
    small.run(small.folder / "run")
    return small, _record(small.folder / "run")


def test_the_parts_of_an_undisturbed_run_are_all_of_it(soaked: tuple[Bench, RunRecord]) -> None:
    parts = part_durations(soaked[1])
    assert sum(sums.measured_s for sums in parts.values()) == pytest.approx(_took_s(soaked[1]), rel=1e-9)
    assert parts[AGAIN].measured_s == 0.0
    assert parts["soak"].measured_s == 1200.0
    assert parts["settle"].count == len(soaked[0].plan.dwells)
    assert {name for name in parts if name.startswith("move")} == {
        "move pitch up to 30 deg", "move pitch up to 100 deg", "move roll up to 100 deg", "move roll over 100 deg",
    }  # fmt: skip


def test_what_was_learned_of_a_run_foresees_the_same_run(soaked: tuple[Bench, RunRecord]) -> None:
    small, record = soaked
    learned, plan = learned_from([part_durations(record)] * 3), small.plan
    foreseen = expected_duration(small.rig, plan.steps, plan.dwell, plan.channels, learned)
    assert foreseen.p50_s == pytest.approx(_took_s(record), rel=1e-3)
    assert foreseen.learned_from == 3


def test_a_dwell_that_was_rejected_teaches_nothing_but_how_long_that_takes(tmp_path: Path) -> None:
    small = bench(tmp_path)
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    with open_rig(small.rig) as rig:
        faulty = FaultyRig(rig, spoil=lambda number, burst: noisier(burst, 100.0) if number == 40 else burst)
        begin(run_dir, small.header(run_dir), small.plan, faulty)  # type: ignore[arg-type]
    record = _record(run_dir)
    rejected = [dwell for dwell in record.dwells if not dwell.accepted]
    parts = part_durations(record)
    assert len(rejected) == 1
    assert parts["read"].count == len(small.plan.dwells) - 1
    assert 0.0 < parts[AGAIN].measured_s < 2.0 * (rejected[0].ended_s - rejected[0].started_s)


def test_a_run_that_was_interrupted_teaches_by_what_was_whole(soaked: tuple[Bench, RunRecord]) -> None:
    """A second epoch measures the check set again and comes from nowhere: it has no begin and no first move."""
    record = soaked[1]
    later = replace(record, state="stopped", events=record.events[: len(record.events) // 2])
    parts = part_durations(later)
    assert "begin" not in parts
    assert 0 < parts["settle"].count < len(soaked[0].plan.dwells)


@pytest.mark.parametrize("kind", EVERY)
def test_before_any_run_every_kind_takes_what_the_files_say_within_a_tenth(kind: str, tmp_path: Path) -> None:
    example, procedure, changes = KINDS[kind]
    made = motion_run(tmp_path, example, procedure, changes)
    made.run(tmp_path / "run")
    record = _record(tmp_path / "run")
    assert _took_s(record) == pytest.approx(made.plan.expected.p50_s, rel=0.1)
    assert _took_s(record) < made.plan.expected.p90_s
    parts = part_durations(record)
    assert parts[AGAIN].measured_s == 0.0
    assert sum(sums.measured_s for sums in parts.values()) == pytest.approx(_took_s(record), rel=1e-9)


@pytest.mark.soak
@pytest.mark.timeout(600)
def test_motions_that_leave_nothing_to_chance_take_what_was_learned(tmp_path: Path) -> None:
    over = _exceeded(tmp_path, "harmonic", past_runs=3, runs=1)
    assert over.most_off < 1e-3


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("kind", ["grid", *KINDS_OF_CHANCE])
def test_two_hundred_runs_of_a_kind_exceed_p50_by_half_and_p90_by_a_tenth(kind: str, tmp_path: Path) -> None:
    """Each after ten past runs of its rig or more: those before it.

    Twins are as quick today as yesterday, so that most runs of few dwells take the same to the millisecond. A run that
    takes just what was foreseen stands on both sides: no more than half are above the p50, and no more than half below.
    """
    found = _exceeded(tmp_path, kind, past_runs=10, runs=200)
    assert found.runs >= 195
    assert found.over[0] / found.runs <= 0.6, found
    assert found.reached[0] / found.runs >= 0.4, found
    assert found.over[1] / found.runs <= 0.16, found
    assert found.reached[1] / found.runs >= 0.04, found


@dataclass
class Exceeded:
    """How many runs took longer than was foreseen as p50 and as p90, and how many as long or longer."""

    runs: int = 0
    over: list[int] = field(default_factory=lambda: [0, 0])
    reached: list[int] = field(default_factory=lambda: [0, 0])
    most_off: float = 0.0
    """Largest relative difference from the p50."""


def _exceeded(folder: Path, kind: str, past_runs: int, runs: int) -> Exceeded:
    over, past = Exceeded(), list[dict[str, PartSums]]()
    for seed in range(1, past_runs + runs + 1):
        place = folder / f"{kind}-{seed}"
        place.mkdir()
        made = _made(place, kind, seed)
        made.run(place / "run")
        record = _record(place / "run")
        rmtree(place)
        if record.state != "finished":
            continue
        if len(past) >= past_runs:
            learned, plan = learned_from(past[::-1]), made.plan
            foreseen = expected_duration(made.rig, plan.steps, plan.dwell, plan.channels, learned)
            took_s = _took_s(record)
            over.runs += 1
            for which, foreseen_s in enumerate((foreseen.p50_s, foreseen.p90_s)):
                over.over[which] += took_s > foreseen_s + SAME_S
                over.reached[which] += took_s >= foreseen_s - SAME_S
            over.most_off = max(over.most_off, abs(took_s / foreseen.p50_s - 1.0))
        past.append(part_durations(record))
    return over


def _made(folder: Path, kind: str, seed: int) -> Bench | MotionRun:
    if kind == "grid":
        return bench(folder, (("seed = 7", f"seed = {seed}"),), (("replications = 2", "replications = 1"),))
    example, procedure, changes = KINDS[kind]
    return motion_run(folder, example, procedure, changes, {r"seed = \d+": f"seed = {seed}"})
