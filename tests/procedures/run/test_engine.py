"""The engine on real twins: the order of things, every way to end, and what a grumbling device leads to."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from asking import put
from faulty_rig import FaultyRig, noisier
from journals import a_clock
from small_run import Bench, bench, dwells_of, measured

from procedures.errors import ExitStatus
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Request, Spool
from procedures.journal.status.status import status
from procedures.records.dwells import Event
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from rig.abilities.abilities import AxisState, Burst
from rig.assembly.open_rig import open_rig
from rig.errors import DeviceNonsense, DeviceSilent, LinkLost


class Asking:
    """An observer that puts requests into the spool: before dwell number n, ask this."""

    def __init__(self, run_dir: Path, requests: dict[int, str]) -> None:
        self._spool, self._requests = Spool(run_dir), requests
        self.seen: list[Progress] = []

    def on_event(self, progress: Progress) -> None:
        self.seen.append(progress)
        if progress.event == "dwell" and progress.dwells_done in self._requests:
            kind = self._requests.pop(progress.dwells_done)
            put(self._spool, kind, "anna", f"please {kind}")


class Continuing:
    """Real seconds for a person's answer: who says continue after a while, without any waiting."""

    slice_s = 0.1
    factor = 1.0

    def __init__(self, run_dir: Path, kind: str = "continue", looks: int = 3) -> None:
        self._spool, self._kind, self._left = Spool(run_dir), kind, looks
        self._clock = a_clock()

    def sleep(self, duration_s: float) -> None:
        self._left -= 1
        if self._left == 0:
            put(self._spool, self._kind, "bert")

    def monotonic_s(self) -> float:
        return self._clock.monotonic_s()

    def boottime_s(self) -> float:
        return self._clock.boottime_s()

    def now_utc(self) -> datetime:
        return self._clock.now_utc()


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def clean(small: Bench) -> Path:
    run_dir = small.folder / "clean"
    assert small.run(run_dir).state is State.FINISHED
    return run_dir


def _events(run_dir: Path, kind: str | None = None) -> list[Event]:
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        return list(reader.events(kind))


def _states(run_dir: Path) -> list[str]:
    return [str(event.detail["to"]) for event in _events(run_dir, "state")]


@contextmanager
def _grumbling(small: Bench, **wrong: Callable[..., object] | str) -> Iterator[FaultyRig]:
    with open_rig(small.rig) as rig:
        yield FaultyRig(rig, **wrong)  # type: ignore[arg-type]


def _run_grumbling(small: Bench, run_dir: Path, **wrong: Callable[..., object] | str) -> Outcome:
    run_dir.mkdir()
    with _grumbling(small, **wrong) as rig:
        outcome = begin(run_dir, small.header(run_dir), small.plan, rig)
        assert not any(axis.state().is_moving for axis in rig.axes.values())
        assert rig.pitch.stops >= 1
        return outcome


def test_a_run_measures_every_dwell_of_its_plan_once_and_in_order(small: Bench, clean: Path) -> None:
    dwells = dwells_of(clean)
    assert [dwell.step for dwell in dwells] == [dwell.step for dwell in small.plan.dwells]
    assert all(dwell.accepted and dwell.epoch == 1 and dwell.attempt == 1 for dwell in dwells)
    for dwell, planned in zip(dwells, small.plan.dwells, strict=True):
        assert list(dwell.targets_deg.items()) == list(planned.targets_deg.items())
        assert dwell.measured_deg == pytest.approx(dict(planned.targets_deg), abs=1e-3)
        assert list(dwell.readings) == list(small.plan.channels)
        assert {reading.samples.size for reading in dwell.readings.values()} == {5}
        assert dwell.ended_s > dwell.started_s + dwell.settle_s


def test_a_dwell_reads_what_gravity_gives(clean: Path) -> None:
    """v = b + S (u·f) with f of the conventions, written out for pitch 30°, roll 90°."""
    alpha, roll, cone, azimuth = np.radians([30.0, 90.0, 0.5, 35.0])
    force = np.array([np.sin(alpha), -np.cos(alpha) * np.sin(roll), -np.cos(alpha) * np.cos(roll)])
    along = np.array([np.cos(cone), np.sin(cone) * np.cos(azimuth), np.sin(cone) * np.sin(azimuth)])
    found = [
        dwell.readings["dmm.x"].mean
        for dwell in dwells_of(clean)
        if dict(dwell.targets_deg) == {"pitch": 30.0, "roll": 90.0} and dwell.purpose == "design"
    ]
    assert len(found) == 2
    assert found == pytest.approx([0.005 + 2.5 * float(along @ force)] * 2, abs=6 * 2e-5 / np.sqrt(5))


def test_the_trail_tells_the_states_and_every_intent_before_its_dwell(small: Bench, clean: Path) -> None:
    assert _states(clean) == ["planned", "checking", "running", "finished"]
    events = _events(clean)
    assert [event.kind for event in events[:5]] == ["state", "readiness", "opened", "state", "identities"]
    assert events[-1].kind == "state"
    pairs = [(event.kind, event.detail["step"]) for event in events if event.kind in ("intent", "dwell")]
    assert pairs == [(kind, dwell.step) for dwell in small.plan.dwells for kind in ("intent", "dwell")]
    assert events[2].detail["operator"] == "tester"
    assert set(events[4].detail) == {"axes.pitch", "axes.roll", "readouts.dmm", "environment.air"}


def test_every_phase_of_a_step_is_announced_by_counters_of_its_own(small: Bench, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    with _grumbling(small) as rig:
        begin(run_dir, small.header(run_dir), small.plan, rig)
    wanted = [
        (dwell.step, phase)
        for dwell in small.plan.dwells
        for phase in ("settle", "check" if dwell.purpose == "check" else "read")
    ]
    assert [(step, phase) for step, phase, _, _ in rig.heard_chance.heard] == wanted
    assert {attempt for _, _, attempt, _ in rig.heard_chance.heard} == {1}
    completed = [replications for *_, replications in rig.heard_chance.heard]
    assert completed == sorted(completed)
    assert 0.0 == completed[0] < completed[-1] < small.plan.replications


def test_two_runs_of_one_seed_are_the_same_numbers(small: Bench, clean: Path) -> None:
    small.run(small.folder / "again")
    assert measured(dwells_of(small.folder / "again")) == measured(dwells_of(clean))


def test_a_rehearsal_is_the_same_run_on_twins_and_says_so(small: Bench, clean: Path) -> None:
    run_dir = small.folder / "rehearsal"
    run_dir.mkdir()
    twins = small.rig.all_on_twins()
    header = replace(small.header(run_dir), is_simulated=True, is_rehearsal=True, rig_json=twins.model_dump_json())
    with open_rig(twins, purpose="rehearsal") as rig:
        assert begin(run_dir, header, small.plan, rig).state is State.FINISHED
    with JournalReader.open(run_dir) as reader:
        assert reader.header.is_rehearsal
        assert reader.header.is_simulated
    assert measured(dwells_of(run_dir)) == measured(dwells_of(clean))


@pytest.mark.parametrize("error", [DeviceNonsense, DeviceSilent])
def test_a_garbled_or_missing_answer_voids_the_attempt_and_changes_no_number(
    small: Bench, clean: Path, error: type[Exception], tmp_path: Path
) -> None:
    def spoil(number: int, burst: Burst) -> Burst:
        if number in (20, 50, 51):
            raise error("dmm: 12.x4: not a number")
        return burst

    assert _run_grumbling(small, tmp_path / "run", spoil=spoil).state is State.FINISHED
    assert [event.detail["void"] for event in _events(tmp_path / "run", "void")] == [1, 1, 2]
    assert measured(dwells_of(tmp_path / "run")) == measured(dwells_of(clean))


def test_a_device_that_stays_silent_fails_the_run_after_the_retries(small: Bench, tmp_path: Path) -> None:
    def spoil(number: int, burst: Burst) -> Burst:
        if number >= 40:
            raise DeviceSilent("dmm: no reply within 2 s; nothing moved; check its power")
        return burst

    outcome = _run_grumbling(small, tmp_path / "run", spoil=spoil)
    assert (outcome.state, outcome.exit_status) == (State.FAILED, ExitStatus.FAILED)
    assert "dmm: no reply within 2 s" in outcome.reason
    assert len(_events(tmp_path / "run", "void")) == small.plan.dwell.retries + 1
    assert _events(tmp_path / "run")[-1].detail["to"] == "failed"


def test_a_lost_link_without_anybody_there_fails_the_run_at_once(small: Bench, tmp_path: Path) -> None:
    def spoil(number: int, burst: Burst) -> Burst:
        if number == 40:
            raise LinkLost("dmm: the port is gone")
        return burst

    outcome = _run_grumbling(small, tmp_path / "run", spoil=spoil)
    assert (outcome.state, outcome.reason) == (State.FAILED, "link lost: dmm: the port is gone")
    assert _states(tmp_path / "run")[-2:] == ["held", "failed"]
    assert not _events(tmp_path / "run", "void")


def test_a_noisy_dwell_is_rejected_kept_and_measured_again(small: Bench, tmp_path: Path) -> None:
    step = small.plan.design_dwells[8].step

    def spoil(number: int, burst: Burst) -> Burst:
        return noisier(burst, 30.0) if number == 3 * step + 2 else burst

    assert _run_grumbling(small, tmp_path / "run", spoil=spoil).state is State.FINISHED
    first, second = (dwell for dwell in dwells_of(tmp_path / "run") if dwell.step == step)
    assert (first.accepted, first.attempt, second.accepted, second.attempt) == (False, 1, True, 2)
    assert first.reasons[0].startswith("dmm.y: noise")
    assert len(first.readings["dmm.y"].samples) == 5


def test_in_virtual_time_a_dwell_that_stays_suspect_fails_the_run_with_the_sentence(
    small: Bench, tmp_path: Path
) -> None:
    def spoil(number: int, burst: Burst) -> Burst:
        return noisier(burst, 30.0) if number > 40 else burst

    outcome = _run_grumbling(small, tmp_path / "run", spoil=spoil)
    assert outcome.state is State.FAILED
    assert "rejected 3 times: dmm." in outcome.reason
    assert _states(tmp_path / "run")[-2:] == ["held", "failed"]


def test_a_suspect_dwell_holds_a_real_run_until_a_person_says_continue(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=(("seed = 7", "seed = 7\ntime = 2000.0"),))
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    step = small.plan.design_dwells[9].step

    def spoil(number: int, burst: Burst) -> Burst:
        return noisier(burst, 30.0) if 3 * step < number <= 3 * step + 9 else burst

    with _grumbling(small, spoil=spoil) as rig:
        outcome = begin(run_dir, small.header(run_dir), small.plan, rig, None, Continuing(run_dir))  # type: ignore[arg-type]
    assert outcome.state is State.FINISHED
    assert _states(run_dir) == ["planned", "checking", "running", "held", "running", "finished"]
    assert [dwell.accepted for dwell in dwells_of(run_dir) if dwell.step == step] == [False] * 3 + [True]
    assert [event.detail["by"] for event in _events(run_dir, "request")] == ["bert"]


def test_a_continue_grants_all_the_retries_anew(small: Bench, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    step = small.plan.design_dwells[9].step

    def spoil(number: int, burst: Burst) -> Burst:
        return noisier(burst, 30.0) if 3 * step < number <= 3 * step + 15 else burst

    with _grumbling(small, spoil=spoil) as rig:
        outcome = begin(run_dir, small.header(run_dir), small.plan, rig, None, Continuing(run_dir))  # type: ignore[arg-type]
    assert outcome.state is State.FINISHED
    assert _states(run_dir).count("held") == 1, "the fourth and fifth rejection lie within what was granted"
    assert [dwell.accepted for dwell in dwells_of(run_dir) if dwell.step == step] == [False] * 5 + [True]


def test_fault_44_an_axis_that_slips_during_a_dwell_voids_it(small: Bench, tmp_path: Path) -> None:
    step = small.plan.design_dwells[8].step
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    with open_rig(small.rig) as opened:
        slipped: list[int] = []

        def look(state: AxisState) -> AxisState:
            if rig.meter.read_so_far != 3 * step + 3 or slipped:
                return state
            slipped.append(step)
            return replace(state, position_deg=state.position_deg + 0.05)

        rig = FaultyRig(opened, look=look)
        assert begin(run_dir, small.header(run_dir), small.plan, rig).state is State.FINISHED
    first, second = (dwell for dwell in dwells_of(run_dir) if dwell.step == step)
    target_deg = first.targets_deg["pitch"]
    assert first.reasons == (
        f"pitch: at {target_deg + 0.05:g}° after the readings, allowed within 0.001° of {target_deg:g}°",
    )
    assert second.accepted


def test_stop_ends_after_the_dwell_and_abort_at_once(small: Bench, tmp_path: Path) -> None:
    for kind, state in (("stop", State.STOPPED), ("abort", State.ABORTED)):
        run_dir = tmp_path / kind
        outcome = small.run(run_dir, observer=Asking(run_dir, {5: kind}))
        assert (outcome.state, outcome.exit_status, outcome.dwells_done) == (state, ExitStatus.ABORTED, 5)
        last = _events(run_dir)[-1].detail
        assert (last["to"], last["by"]) == (state, "anna")
        assert not list((run_dir / "requests").iterdir())


def test_stop_and_abort_end_a_soak(tmp_path: Path) -> None:
    small = bench(tmp_path, procedure=(("[check]", "[environment]\nplateaus_degc = [30.0]\n[check]"),))
    for kind, state in (("stop", State.STOPPED), ("abort", State.ABORTED)):
        run_dir = tmp_path / kind

        class AtTheSoak(Asking):
            def on_event(self, progress: Progress) -> None:
                if progress.event == "soak":
                    self._spool.submit(Request(kind, "anna", "2026-03-01T12:00:00+00:00"))  # type: ignore[arg-type]  # noqa: B023

        assert small.run(run_dir, observer=AtTheSoak(run_dir, {})).state is state
        assert dwells_of(run_dir) == []


def test_pause_waits_after_the_dwell_until_continue(small: Bench, clean: Path, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    outcome = small.run(run_dir, observer=Asking(run_dir, {4: "pause"}), idle_clock=Continuing(run_dir))
    assert outcome.state is State.FINISHED
    assert _states(run_dir) == ["planned", "checking", "running", "paused", "running", "finished"]
    assert [event.detail["kind"] for event in _events(run_dir, "request")] == ["pause", "continue"]
    assert measured(dwells_of(run_dir)) == measured(dwells_of(clean))


def test_a_paused_run_can_be_stopped(small: Bench, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    outcome = small.run(run_dir, observer=Asking(run_dir, {4: "pause"}), idle_clock=Continuing(run_dir, "stop"))
    assert (outcome.state, outcome.dwells_done) == (State.STOPPED, 4)


def test_a_note_is_journalled_with_its_author(small: Bench, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    small.run(run_dir, observer=Asking(run_dir, {4: "note"}))
    (note,) = _events(run_dir, "note")
    assert (note.detail["by"], note.detail["text"]) == ("anna", "please note")


def test_a_soak_brings_the_chamber_into_its_band_first(tmp_path: Path) -> None:
    text = "[environment]\nplateaus_degc = [30.0, 10.0]\nsoak_s = 600.0\n[check]"
    small = bench(tmp_path, procedure=(("[check]", text), ("replications = 2", "replications = 1")))
    assert small.run(tmp_path / "run").state is State.FINISHED
    wanted = {1: 30.0, 2: 10.0}
    for dwell in dwells_of(tmp_path / "run"):
        if dwell.purpose == "design":
            assert dwell.temperature_degc["air"] == pytest.approx(wanted[dwell.replication], abs=1.0)
    assert [event.detail["soak"] for event in _events(tmp_path / "run", "intent") if "soak" in event.detail] == [
        "air"
    ] * 2


def test_the_longest_duration_stops_the_run_after_the_dwell(tmp_path: Path) -> None:
    small = bench(tmp_path, procedure=(("[check]", "[stop]\nmax_duration_s = 80.0\n[check]"),))
    outcome = small.run(tmp_path / "run")
    assert outcome.state is State.STOPPED
    assert "max_duration_s = 80 s has passed" in outcome.reason
    assert dwells_of(tmp_path / "run")[-1].ended_s >= 80.0
    assert dwells_of(tmp_path / "run")[-2].ended_s <= 80.0 + 30.0


def test_fault_18_a_defect_stops_the_axes_is_journalled_and_passed_on(small: Bench, tmp_path: Path) -> None:
    class Broken:
        def on_event(self, progress: Progress) -> None:
            if progress.dwells_done == 3 and progress.event == "dwell":
                raise ZeroDivisionError("of ours")

    run_dir = tmp_path / "run"
    with pytest.raises(ZeroDivisionError):
        small.run(run_dir, observer=Broken())
    assert _states(run_dir)[-1] == "failed"
    (defect,) = _events(run_dir, "defect")
    assert "ZeroDivisionError: of ours" in str(defect.detail["traceback"])
    assert status(run_dir).state is State.FAILED


def test_fault_20_gone_an_axis_that_cannot_be_stopped_is_told_whatever_else_happened(
    small: Bench, tmp_path: Path
) -> None:
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    with _grumbling(small) as rig:

        def no_stop() -> None:
            raise LinkLost("pitch: the port is gone")

        rig.pitch.stop = no_stop  # type: ignore[method-assign]
        outcome = begin(run_dir, small.header(run_dir), small.plan, rig, Asking(run_dir, {5: "abort"}))
    assert outcome.state is State.TRIPPED
    last = _events(run_dir)[-1].detail
    assert "stop: not every axis is known to stand still: pitch: pitch: the port is gone" in str(last["reason"])
    assert outcome.reason == f"{last['reason']} (asked for by anna)"
