"""Catalogue 4.2: links and protocols, as whole runs on twins whose lines misbehave."""

from pathlib import Path

import pytest
from case_shares import rest_to_thorough
from runs_with_faults import faults, run_with_faults
from small_run import Bench, bench, dwells_of, measured
from unattended_run import UnattendedRun, asks, events, states

from procedures.journal.journal_reader import JournalReader
from procedures.records.states import State
from rig.assembly.open_rig import open_rig
from rig.errors import DeviceNonsense, DeviceSilent, RigBusy

TABLE, METER, CHAMBER = "axes.pitch", "readouts.dmm", "environment.air"
EVERY = {TABLE: 71, METER: 97, CHAMBER: 23}
"""A line that talks little gets its share of the faults as well."""


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """An air without noise: a question that is repeated would take another reading of it than the undisturbed run."""
    still = "[twin.environment.air]\nnoise_degc = 0.0\n\n[twin.truth.SN1]"
    return bench(tmp_path_factory.mktemp("bench"), rig=(("[twin.truth.SN1]", still),))


@pytest.fixture(scope="module")
def clean(small: Bench) -> Path:
    assert small.run(small.folder / "clean").state is State.FINISHED
    return small.folder / "clean"


def _unharmed(small: Bench, clean: Path, run_dir: Path, **rules: dict[str, object]) -> list[str]:
    """Run with the faults, and see that they happened and changed no number; what they were."""
    unattended = UnattendedRun(run_dir, at={number: asks("continue") for number in range(40, 4000, 40)})
    outcome, found = run_with_faults(small, unattended, faults(**rules))
    assert outcome.state is State.FINISHED, outcome.reason
    assert found, "no fault happened"
    assert measured(dwells_of(run_dir)) == measured(dwells_of(clean))
    return found


@pytest.mark.parametrize("line", [TABLE, METER, CHAMBER])
def test_fault_24_garbled_bytes_are_asked_for_again_and_change_no_number(
    small: Bench, clean: Path, tmp_path: Path, line: str
) -> None:
    """Detected: framing, checksum, a strict pattern over the whole line, range.
    Response: drained and asked again at most twice where that is harmless; then the dwell is void and repeated.
    """
    _unharmed(small, clean, tmp_path / "run", noise={"line": line, "kind": "garble", "every": 71})


def test_fault_24_stuck_a_line_that_only_talks_nonsense_measures_nothing(small: Bench, tmp_path: Path) -> None:
    """A wrong baud rate from the start: no dwell, no motion."""
    rule = {"line": METER, "kind": "garble", "every": 1}
    with pytest.raises((DeviceNonsense, DeviceSilent), match="dmm"):
        _ask_everything(small, rule)


def _ask_everything(small: Bench, rule: dict[str, object]) -> None:
    with open_rig(small.rig, faults=faults(rule=rule)) as rig:
        rig.identities()
        rig.axes["pitch"].state()
        rig.environments["air"].temperature_degc()


@pytest.mark.parametrize(
    ("line", "keep"),
    [
        (TABLE, 4),
        (METER, 9),
        *[
            pytest.param(*entry, marks=pytest.mark.thorough)
            for entry in ((TABLE, 1), (TABLE, 9), (METER, 1), (METER, 4))
        ],
    ],
)
def test_fault_25_a_partial_reply_is_never_used(
    small: Bench, clean: Path, tmp_path: Path, line: str, keep: int
) -> None:
    """Detected: no terminator or length by the deadline.
    Response: waited for, drained, asked again only where that is harmless; a prefix is no number.
    """
    _unharmed(small, clean, tmp_path / "run", cut={"line": line, "kind": "truncate", "keep": keep, "every": 83})


def test_fault_25_a_reply_that_trickles_is_put_together(small: Bench, clean: Path, tmp_path: Path) -> None:
    rules = {
        f"at{keep}": {"line": TABLE, "kind": "split", "keep": keep, "delay_s": 0.05, "every": 40 + keep}
        for keep in range(1, 10)
    }
    file = _unharmed(small, clean, tmp_path / "run", **rules)
    assert len(file) > 20


@pytest.mark.parametrize("line", rest_to_thorough([TABLE, METER, CHAMBER], every=3, first=1))
def test_fault_26_a_late_reply_is_not_the_answer_to_the_next_question(
    small: Bench, clean: Path, tmp_path: Path, line: str
) -> None:
    """Detected: the reply echoes its question, or the line was seen quiet and a sentinel answered before it.
    Response: after a time-out the line falls quiet first; no answer is shifted by one.
    """
    _unharmed(
        small, clean, tmp_path / "run", late={"line": line, "kind": "delay", "delay_s": 2.7, "every": EVERY[line]}
    )


@pytest.mark.parametrize("line", rest_to_thorough([TABLE, METER, CHAMBER], every=3, first=0))
def test_fault_27_a_doubled_reply_is_dropped_before_the_next_question(
    small: Bench, clean: Path, tmp_path: Path, line: str
) -> None:
    """Detected: bytes that nobody asked for, before the next question.
    Response: drained and counted; more than 2 % of the questions hold the run.
    """
    _unharmed(
        small, clean, tmp_path / "run", twice={"line": line, "kind": "duplicate", "delay_s": 0.01, "every": EVERY[line]}
    )


def test_fault_28_an_echo_is_never_a_value(small: Bench, tmp_path: Path) -> None:
    """Detected: the first bytes equal what was sent.
    Response: no device of ours echoes, so it is nonsense: refused, repeated, never parsed as a value.
    """
    for line in (TABLE, METER, CHAMBER):
        with pytest.raises((DeviceNonsense, DeviceSilent)):
            _ask_everything(small, {"line": line, "kind": "echo", "every": 1})


def test_fault_28_an_echo_now_and_then_changes_no_number(small: Bench, clean: Path, tmp_path: Path) -> None:
    _unharmed(small, clean, tmp_path / "run", echo={"line": TABLE, "kind": "echo", "every": 89})


@pytest.mark.parametrize("line", rest_to_thorough([TABLE, METER, CHAMBER], every=3, first=2))
def test_fault_29_stale_bytes_at_open_are_no_answer(small: Bench, clean: Path, tmp_path: Path, line: str) -> None:
    """Detected: bytes before the first question, or before its answer.
    Response: waited until quiet, discarded, asked again.
    """
    banner = "BOOT 1.7 OK 12.5\r\n+1.23456789E+00\r\n" * 100
    _unharmed(small, clean, tmp_path / "run", banner={"line": line, "kind": "stale", "text": banner, "nth": [1]})


def test_fault_30_a_lost_acknowledgement_never_moves_an_axis_twice(small: Bench, clean: Path, tmp_path: Path) -> None:
    """Detected: no acknowledgement by the deadline.
    Response: absolute moves only; in doubt the state is asked, and nothing is sent again blindly.
    """
    _unharmed(small, clean, tmp_path / "run", ack={"line": TABLE, "kind": "drop", "every": 53})


def test_fault_30_a_lost_question_is_asked_again(small: Bench, clean: Path, tmp_path: Path) -> None:
    _unharmed(small, clean, tmp_path / "run", lost={"line": TABLE, "kind": "drop", "on": "question", "every": 53})


@pytest.mark.parametrize("code", [2, 6, 11, *[pytest.param(n, marks=pytest.mark.thorough) for n in (1, 3, 5, 10)]])
def test_fault_31_one_exception_is_void_or_waited_for_and_changes_no_number(
    small: Bench, clean: Path, tmp_path: Path, code: int
) -> None:
    """Detected: the function code with its high bit, decoded by number.
    Response: 5 and 6 are waited for; 4 and 8, the device's own fault, trip; any other voids the attempt, and trips
    when it comes again and again: nothing is retried for ever.
    """
    _unharmed(small, clean, tmp_path / "run", once={"line": CHAMBER, "kind": "exception", "code": code, "nth": [30]})


@pytest.mark.parametrize(("code", "times"), [(1, 400), (2, 400), (3, 400), (4, 1), (8, 1)])
def test_fault_31_stuck_a_refusal_for_ever_and_a_fault_of_the_device_trip(
    small: Bench, tmp_path: Path, code: int, times: int
) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={400: asks("stop")})
    refused = {"line": CHAMBER, "kind": "exception", "code": code, "nth": list(range(30, 30 + times))}
    outcome, _ = run_with_faults(small, unattended, faults(refused=refused))
    assert outcome.state is State.TRIPPED
    assert f"answered exception {code}" in outcome.reason


def test_fault_35_a_mute_device_is_told_by_name_and_silences_no_other(small: Bench, tmp_path: Path) -> None:
    """Detected: every device has a deadline and counts of its own.
    Response: held by name; the others answer meanwhile, and the axes are stopped.
    """
    unattended = UnattendedRun(tmp_path / "run", at={200: asks("stop")})
    outcome, _ = run_with_faults(
        small, unattended, faults(mute={"line": CHAMBER, "kind": "freeze", "delay_s": 1e9, "nth": [40]})
    )
    assert outcome.state is State.STOPPED
    held = next(event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held")
    assert "environment.air" in str(held.detail["reason"]) or "air: " in str(held.detail["reason"])
    assert set(outcome.positions_deg) == {"pitch", "roll"}, "the table answered all the while"


def test_fault_37_one_percent_of_damaged_replies_changes_no_number(small: Bench, clean: Path, tmp_path: Path) -> None:
    """Detected: counts of questions and errors on every line.
    Response: recorded from 0.1 % on, held above 2 % until a person says continue.
    """
    rules: dict[str, dict[str, object]] = {
        kind: {"line": "*", "kind": kind, "probability": 0.0033, **more}
        for kind, more in {"drop": {}, "garble": {}, "truncate": {"keep": 2}}.items()  # type: ignore[dict-item]
    }
    assert len(_unharmed(small, clean, tmp_path / "run", **rules)) > 10


def test_fault_38_a_second_controller_is_refused_and_told_who_has_the_rig(small: Bench, tmp_path: Path) -> None:
    """Detected: kernel locks on every port and on the rig file.
    Response: the second is refused with the owner's name; foreign motion trips (52), foreign bytes are drained (27).
    """
    rig_file = tmp_path / "rig.toml"
    rig_file.write_text("", encoding="utf-8")
    with open_rig(small.rig, rig_file=rig_file, purpose="run"), pytest.raises(RigBusy, match=r"run"):
        open_rig(small.rig, rig_file=rig_file, purpose="jog")


def test_fault_36_a_port_that_is_gone_is_noticed_at_the_next_question(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    """Detected: age of the last good answer, never the port's own word.
    Response: void, repeated, then held as a lost link; five restarts without a dwell trip.
    """
    unattended = UnattendedRun(tmp_path / "run")
    rule = {"line": METER, "kind": "hang-up", "at_s": 80.0, "away_s": 300.0}
    outcome, _ = run_with_faults(small, unattended, faults(gone=rule))
    assert outcome.state is State.FINISHED
    assert "held" in states(unattended.run_dir)
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(clean))


def test_fault_21_a_line_that_hangs_up_in_mid_move_is_held_and_goes_on(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    """Detected: every way in which a port breaks, also while it calls itself open.
    Response: axes told to stop, held; tried again after 1, 2, 4 … 60 s; then identities, home, check set, seam test.
    """
    unattended = UnattendedRun(tmp_path / "run")
    rule = {"line": TABLE, "kind": "hang-up", "nth": [150], "away_s": 20.0}
    outcome, _ = run_with_faults(small, unattended, faults(gone=rule))
    assert outcome.state is State.FINISHED
    with JournalReader.open(unattended.run_dir) as reader:
        reader.verify()
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(clean))


def test_fault_23_lines_that_are_swapped_in_mid_run_measure_nothing_more(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={600: asks("stop")})
    swapped = {"line": METER, "kind": "swap", "other": CHAMBER, "at_s": 80.0}
    outcome, found = run_with_faults(small, unattended, faults(swapped=swapped))
    assert found
    assert outcome.state in (State.STOPPED, State.TRIPPED)
    assert measured(dwells_of(unattended.run_dir)).items() <= measured(dwells_of(clean)).items()
