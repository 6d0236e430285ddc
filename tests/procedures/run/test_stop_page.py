"""The page for every stop that nobody asked for: cause, moment, rest, what to do, the last minutes."""

import os
from datetime import UTC, datetime
from pathlib import Path
from shutil import copytree
from xml.etree import ElementTree

import pytest
from faulty_rig import FaultyRig, noisier
from small_run import Bench, StopAt, bench
from unattended_run import UnattendedRun, asks, run_unattended

from procedures.journal.journal import Journal
from procedures.journal.status.stop_advice import ADVICE
from procedures.records.states import State
from procedures.run.sparkline import sparkline
from procedures.run.stop_page import explain, read_why
from procedures.run.watch.keep_awake import awake
from rig.abilities.abilities import Burst
from rig.clock import VirtualClock
from rig.errors import FileContradicted, LinkLost

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


def _noisy(number: int, burst: Burst) -> Burst:
    return noisier(burst, 30.0) if 60 < number <= 69 else burst


def test_a_hold_leaves_a_page_that_says_why_where_the_axes_are_and_what_to_do(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={30: asks("continue")})
    assert run_unattended(small, unattended, rig_of=lambda rig: FaultyRig(rig, spoil=_noisy)).state is State.FINISHED
    text, page = ((unattended.run_dir / name).read_text() for name in ("why.txt", "why.html"))
    assert text.startswith("small grid: held\n")
    for said in (
        "rejected 3 times: dmm.",
        f"calrig continue {unattended.run_dir}: it is measured again",
        "dwells of the design",
    ):
        assert said in text
        assert said in page
    assert "axes     at rest, read back: pitch at" in text
    assert page.count("<polyline") == 3 + 1 + 2 + 1, "scatter of three channels, air, two axes, settling"
    assert "<script" not in page
    ElementTree.fromstring(page.replace("<!doctype html>", "").replace('<meta charset="utf-8">', "").replace(
        '<meta name="viewport" content="width=device-width, initial-scale=1">', ""))  # fmt: skip


def test_a_trip_says_where_every_axis_rests(small: Bench, tmp_path: Path) -> None:
    class Button(FaultyRig):
        def __init__(self, rig: object) -> None:
            from dataclasses import replace

            super().__init__(rig, look=lambda state: replace(state, fault="stop button") if self.is_late else state)  # type: ignore[arg-type]

        @property
        def is_late(self) -> bool:
            return hasattr(self, "meter") and self.meter.read_so_far >= 60

    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=Button)
    assert outcome.state is State.TRIPPED
    text = ", ".join(f"{name} at {degrees:.4f}°" for name, degrees in outcome.positions_deg.items())
    assert f"at rest, read back: {text}; nothing has been moved since" in (unattended.run_dir / "why.txt").read_text()


def test_where_the_rig_file_is_contradicted_the_page_names_file_and_key_to_change_before_a_resume(
    small: Bench, tmp_path: Path
) -> None:
    def other_card(number: int, burst: Burst) -> Burst:
        if number > 40:
            raise FileContradicted("dmm: slot 1 has a 34902A, the rig file says 34901A (readouts.dmm: cards)")
        return burst

    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=lambda rig: FaultyRig(rig, spoil=other_card))
    assert outcome.state is State.TRIPPED
    text = (unattended.run_dir / "why.txt").read_text()
    assert "(readouts.dmm: cards)" in text
    assert "correct that key" in text
    assert text.index("A resume before that is put right stops here again") < text.index(
        f"calrig resume {unattended.run_dir}"
    )


def test_axes_that_do_not_answer_are_not_said_to_rest(small: Bench, tmp_path: Path) -> None:
    def gone(number: int, burst: Burst) -> Burst:
        if number > 40:
            raise LinkLost("dmm: the port is gone")
        return burst

    class Dark(FaultyRig):
        @property
        def axes(self):  # type: ignore[no-untyped-def]
            if self.meter.read_so_far > 40:
                self.pitch._axis = _Gone()  # type: ignore[assignment]
                return {"pitch": self.pitch}
            return super().axes

    unattended = UnattendedRun(tmp_path / "run", at={20: asks("abort")})
    outcome = run_unattended(small, unattended, rig_of=lambda rig: Dark(rig, spoil=gone))
    assert outcome.state is State.TRIPPED
    assert outcome.positions_deg == {}
    page = (unattended.run_dir / "why.txt").read_text()
    assert "axes     no axis could be read back now: pitch was last read at rest at " in page
    assert "; go and look before anything is moved" in page


class _Gone:
    def __getattr__(self, name: str) -> object:
        def lost(*arguments: object) -> object:
            raise LinkLost("axes.pitch: the port is gone")

        return lost


def test_a_stop_that_was_asked_for_leaves_no_page(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run", after={5: asks("stop")})
    assert run_unattended(small, unattended).state is State.STOPPED
    assert not (unattended.run_dir / "why.html").exists()


def test_dwells_that_record_different_axes_have_a_page(tmp_path: Path) -> None:
    """The motions of a profile turn one axis after the other, and each records its own."""
    run_dir = tmp_path / "run"
    copytree(ROOT / "tests" / "data" / "runs_0_1_0" / "profile_harmonic" / "interrupted", run_dir)
    assert explain(run_dir, "the table stood still", {}) == run_dir / "why.html"
    text = (run_dir / "why.txt").read_text(encoding="utf-8")
    assert "the table stood still" in text


def test_names_and_reasons_are_escaped(tmp_path: Path) -> None:
    evil = bench(tmp_path, procedure=(('title = "small grid"', 'title = "<img src=x onerror=alert(1)>"'),))
    unattended = UnattendedRun(tmp_path / "run", at={30: asks("continue")})
    run_unattended(evil, unattended, rig_of=lambda rig: FaultyRig(rig, spoil=_noisy))
    assert "<img" not in (unattended.run_dir / "why.html").read_text()


def test_every_cause_that_the_code_knows_has_advice() -> None:
    import re

    source = "".join(
        path.read_text() for path in (ROOT / "procedures/run").rglob("*.py") if path.name != "stop_advice.py"
    )
    causes = set(re.findall(r'cause="([a-z ]+)"', source)) | set(re.findall(r'Alarm\(\s*"([a-z ]+)"', source))
    causes |= set(re.findall(r'TrustLost\("([a-z ]+)"', source))
    assert causes >= {"device", "identity", "seam", "mount", "disk", "motion", "home", "suspend", "noise"}
    assert causes <= ADVICE.keys()


def test_a_sparkline_spans_its_box_and_skips_what_is_no_number() -> None:
    drawn = sparkline("air", "°C", [-2.0, -1.0, -0.5, 0.0], [20.0, 21.0, float("nan"), 22.0])
    assert drawn.points == "0.0,44.0 130.0,22.0 260.0,0.0"
    assert (drawn.low, drawn.high, drawn.last) == ("20", "22", "22")
    assert sparkline("rest", "s", [-1.0, 0.0], [3.0, 3.0 + 1e-12]).points == "0.0,22.0 260.0,22.0"


def _helper(folder: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    program = folder / "systemd-inhibit"
    program.write_text(f"#!/bin/sh\n{text}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")


def test_fault_15_the_machine_is_kept_awake_while_the_run_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = tmp_path / "asked"
    _helper(tmp_path, f'echo "$@" > "{text}"; shift 4; "$@"; echo over >> "{text}"', monkeypatch)
    with awake("night run") as refusal:
        assert refusal == ""
    assert text.read_text().startswith("--what=sleep:idle:handle-lid-switch --who=calrig")
    assert text.read_text().endswith("over\n")


def test_fault_15_an_inhibitor_that_refuses_is_told_and_keeps_no_run_from_running(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _helper(tmp_path, "exit 1", monkeypatch)
    with awake("night run") as refusal:
        assert "ended with status 1: forbid suspending yourself" in refusal


NO_PULSE = "no pulse is sent, position not known"


@pytest.mark.parametrize("later", ["", "intent", "opened"])
def test_a_position_that_nobody_knew_at_the_last_stop_is_told_until_it_is_read_back_or_may_have_changed(
    small: Bench, tmp_path: Path, later: str
) -> None:
    """As it was seen: a page that said where the servo rests and, of hours before, that nobody knows it."""
    run_dir = tmp_path / "run"
    assert small.run(run_dir, observer=StopAt(run_dir, 2)).state is State.STOPPED
    journal, clock = Journal.open_for_append(run_dir / "journal.sqlite"), VirtualClock(datetime.now(UTC))
    journal.append_event("safe", {"positions_deg": {}, "failures": [], "unknown": {"pitch": NO_PULSE}}, clock)
    if later:
        journal.append_event(later, {"step": 3} if later == "intent" else {}, clock)
    journal.close()

    def axes(positions_deg: dict[str, float]) -> str:
        return read_why(run_dir, "", positions_deg).positions

    assert (f"pitch: {NO_PULSE}" in axes({"roll": 0.0})) is not bool(later)
    assert axes({"pitch": 10.0}) == "at rest, read back: pitch at 10.0000°; nothing has been moved since"
