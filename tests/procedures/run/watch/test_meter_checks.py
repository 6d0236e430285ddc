"""Laws of the meters' proofs in a run: at the start, on time, when its temperature moves, at the end; all recorded.

What was measured since the last good proof is taken back when one is bad.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import pytest
from small_run import Bench, bench, dwells_of, measured
from table_bench import virtual_clock

from procedures.journal.journal_reader import JournalReader
from procedures.records.states import State
from procedures.run.ending import Outcome
from procedures.run.watch.meter_checks import MeterWatch
from rig.abilities.abilities import Wait
from rig.abilities.self_checking import MeterLook, MeterProof
from rig.clock import VirtualClock

METER = 'resource = "twin"\nnplc = 1\n'
CHECKS = "checks = { short_scanner = 5, short_limit_v = 1e-6, reference_scanner = 6, reference_v = 1.0, "
SEED = "[twin]\nseed = 7\n"
HOUR_S = 3600.0


def _bench(folder: Path, checks: str, truth: str = "") -> Bench:
    changes = ((METER, f"{METER}{CHECKS}{checks} }}\n"), (SEED, f"{SEED}[twin.readouts.dmm]\n{truth}\n"))
    return bench(folder, rig=changes)


def _checks(run_dir: Path) -> list[dict[str, Any]]:
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        return [dict(event.detail) for event in reader.events("meter_check")]


def _run(folder: Path, checks: str, truth: str = "") -> tuple[Outcome, Path]:
    run_dir = folder / "run"
    return _bench(folder, checks, truth).run(run_dir), run_dir


def test_every_meter_is_proven_at_the_start_on_time_and_at_the_end(tmp_path: Path) -> None:
    outcome, run_dir = _run(tmp_path, "reference_limit_v = 1e-5, every_s = 100.0")
    assert outcome.state is State.FINISHED
    occasions = [check["occasion"] for check in _checks(run_dir)]
    assert (occasions[0], occasions[-1]) == ("start", "end")
    assert set(occasions[1:-1]) == {"time"}
    duration_s = max(dwell.ended_s for dwell in dwells_of(run_dir))
    assert len(occasions) - 2 == pytest.approx(duration_s / 100.0, rel=0.3)
    first = _checks(run_dir)[0]
    assert [proof["what"] for proof in first["proofs"]] == ["short on 10 V", "reference on 10 V"]
    assert [proof["value_v"] for proof in first["proofs"]] == [0.0, 1.0]
    assert first["temperature_degc"] == 36.4


def test_the_checks_change_nothing_that_is_measured(tmp_path: Path) -> None:
    for name in ("with", "without"):
        (tmp_path / name).mkdir()
    _, with_them = _run(tmp_path / "with", "every_s = 50.0")
    bench(tmp_path / "without").run(tmp_path / "without" / "run")
    assert measured(dwells_of(with_them)) == measured(dwells_of(tmp_path / "without" / "run"))


def test_a_meter_that_is_wrong_from_the_start_trips_the_run_before_a_dwell(tmp_path: Path) -> None:
    outcome, run_dir = _run(tmp_path, "reference_limit_v = 1e-5", "reference_error_v = 2e-5")
    assert outcome.state is State.TRIPPED
    assert (
        "dmm: a proof of the meter failed: the reference on 10 V reads 1.00002 V, +2e-05 V off, allowed 1e-05 V"
        in outcome.reason
    )
    assert not dwells_of(run_dir)


def test_what_was_measured_since_the_last_good_proof_is_taken_back(tmp_path: Path) -> None:
    drift = f"reference_drift_v_per_h = {1e-5 * HOUR_S / 120.0}"  # beyond its limit after two minutes
    outcome, run_dir = _run(tmp_path, "reference_limit_v = 1e-5, every_s = 50.0", drift)
    assert outcome.state is State.TRIPPED
    are_good = [check["proofs"][1]["is_good"] for check in _checks(run_dir)]
    assert are_good == [True] * (len(are_good) - 1) + [False]
    with JournalReader.open(run_dir) as reader:
        (taken_back,) = reader.events("voided")
        good_s = next(event.monotonic_s for event in reversed(list(reader.events("meter_check"))[:-1]))
    kept = [dwell for dwell in dwells_of(run_dir) if dwell.accepted]
    assert taken_back.detail["cause"] == "meter"
    assert all(dwell.ended_s <= good_s for dwell in kept)


def test_a_meter_that_may_hold_fails_a_run_that_nobody_watches(tmp_path: Path) -> None:
    outcome, _ = _run(tmp_path, 'reference_limit_v = 1e-5, action = "hold"', "reference_error_v = 2e-5")
    assert outcome.state is State.FAILED
    assert "the reference on 10 V" in outcome.reason


def test_the_meter_calibrates_itself_before_the_run_and_whenever_its_temperature_moved(tmp_path: Path) -> None:
    outcome, run_dir = _run(tmp_path, "autocalibrate = true", f"own_temperature_drift_degc_per_h = {HOUR_S / 60.0}")
    assert outcome.state is State.FINISHED
    checks = _checks(run_dir)
    assert (checks[0]["occasion"], checks[0]["is_calibrated_anew"]) == ("start", True)
    warm = [check for check in checks if check["occasion"] == "temperature"]
    assert warm
    assert all(check["is_calibrated_anew"] for check in warm)
    degc = [check["temperature_degc"] for check in (checks[0], *warm)]
    assert all(after - before >= 1.0 for before, after in pairwise(degc))


class Meter:
    """A readout that reads its reference as ``offs_v`` says, one after the other."""

    name = "dmm"
    check_every_s: float | None = 100.0
    check_action: Literal["hold", "trip"] = "hold"

    def __init__(self, offs_v: list[float]) -> None:
        self.offs_v = offs_v
        self.is_warm = False

    def needs_check(self) -> bool:
        return self.is_warm

    def check_itself(self, wait: Wait) -> MeterLook:
        wait(1.0)
        proof = MeterProof("reference on 10 V", 10.0 + self.offs_v.pop(0), 10.0, 1e-4)
        return MeterLook((proof,), 36.4, is_calibrated_anew=False)


@dataclass
class Desk:
    """As much of an open rig as the checks need."""

    clock: VirtualClock
    readouts: dict[str, Meter]


def _watch(offs_v: list[float]) -> tuple[MeterWatch, Desk, list[str]]:
    desk = Desk(virtual_clock(), {"dmm": Meter(offs_v)})
    messages: list[str] = []

    def record(_kind: str, detail: Mapping[str, object]) -> None:
        messages.append(str(detail["occasion"]))

    return MeterWatch(desk, record, desk.clock.sleep), desk, messages  # type: ignore[arg-type]


def test_a_meter_is_due_at_the_start_on_time_when_warm_and_at_the_end_and_at_no_other_time() -> None:
    watch, desk, found = _watch([0.0] * 9)

    def look(last_dwell_s: float | None = None) -> None:
        assert watch.look(lambda: None, last_dwell_s) is None

    look()
    look()
    desk.clock.sleep(99.0)
    look()
    assert found == ["start"]
    desk.clock.sleep(2.0)
    look()
    desk.readouts["dmm"].is_warm = True
    look()
    desk.readouts["dmm"].is_warm = False
    last_dwell_s = desk.clock.monotonic_s() + 5.0
    desk.clock.sleep(10.0)
    assert watch.owes(last_dwell_s)
    look(last_dwell_s)
    assert not watch.owes(last_dwell_s)
    look(last_dwell_s)
    assert found == ["start", "time", "temperature", "end"]


def test_a_bad_proof_that_holds_is_read_again_as_soon_as_somebody_says_continue() -> None:
    watch, desk, found = _watch([0.0, 2e-4, 2e-4, 0.0])
    assert watch.look(lambda: None) is None
    good_s = desk.clock.monotonic_s()
    desk.clock.sleep(200.0)
    first, second = watch.look(lambda: None), watch.look(lambda: None)
    assert first is not None
    assert (first.response, first.cause, first.void_from_s) == ("ask", "meter", good_s)
    assert second is not None
    assert second.void_from_s is None  # what is in doubt was taken back with the first
    assert watch.look(lambda: None) is None
    assert found == ["start", "time", "again", "again"]
