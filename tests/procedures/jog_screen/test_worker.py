"""What turns by hand stops where nobody can look at it or write down what it does, though its screen answers."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event

import pytest
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served

from procedures.jog_screen.log import ActionLog, Snapshots
from procedures.jog_screen.values import Asker, GoTo, Home, Turn
from procedures.jog_screen.worker import Bench
from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import SimulatedRig
from rig.clock import SystemClock
from rig.description.read import read_rig
from rig.errors import DeviceSilent
from rig.guard.ask import of_rig, stop

CLOCK = SystemClock()
WITHIN_S = 30.0
TOLD_S = 1.0
NARROW = (STAGE_FOR_ROLL[0], STAGE_FOR_ROLL[1].replace("[-180.0, 180.0]", "[-30.0, 30.0]"))


@dataclass
class Turning:
    """A bench whose roll turns at 10°/s by a terminal that goes on answering."""

    bench: Bench
    rig: Rig
    simulated: SimulatedRig | None
    """None where the rig's twins are its own."""
    log: ActionLog
    file: Path

    def answer(self) -> None:
        self.bench.guard.answer()
        CLOCK.sleep(0.02)

    def until(self, words: str) -> None:
        until_s = CLOCK.monotonic_s() + WITHIN_S
        while words not in (text := f"{[line.text for line in self.bench.view.messages]} {self.bench.guard.lost}"):
            assert CLOCK.monotonic_s() < until_s, text
            self.answer()

    def at_rest_deg(self) -> float:
        until_s = CLOCK.monotonic_s() + WITHIN_S
        while self.simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s()) != 0.0:
            assert CLOCK.monotonic_s() < until_s, "it turns on"
            self.answer()
        return self.simulated.world.attitude_deg("roll", CLOCK.monotonic_s())


@contextmanager
def _turning(folder: Path) -> Iterator[Turning]:
    with (
        served(folder, CLOCK, QUICK_METER, NARROW) as (simulated, file),
        open_rig(read_rig(file), rig_file=file) as rig,
    ):
        log = ActionLog(folder / "actions.jsonl", CLOCK)
        bench = Bench(rig, log, Snapshots(folder / "snapshots.csv", CLOCK), CLOCK)
        turning = Turning(bench, rig, simulated, log, file)
        try:
            bench.start()
            bench.ask(Home("roll"))
            turning.until("roll: homed")
            bench.ask(Turn("roll", 10.0, is_held=False))
            turning.until("turns at +10 °/s")
            yield turning
        finally:
            bench.close()
            log.close()


def _block(turning: Turning, answered: Event, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have every meter wait for an answer that does not come, as a line does whose other end is gone."""

    def read(*_: object) -> None:
        answered.wait(WITHIN_S)
        raise DeviceSilent("dmm: no complete reply")

    for readout in turning.rig.readouts.values():
        monkeypatch.setattr(readout, "read", read)


def test_a_meter_that_blocks_lets_no_axis_turn_beyond_its_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answered = Event()
    with _turning(tmp_path) as turning:
        _block(turning, answered, monkeypatch)
        try:
            assert 0.0 < turning.at_rest_deg() < 30.0
            turning.until("roll: it may be near its limit, and was not looked at for")
        finally:
            answered.set()


@pytest.mark.parametrize("whose", ["its own", pytest.param("the shell's", marks=pytest.mark.thorough)])
def test_a_stop_is_told_within_a_second_also_while_a_meter_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whose: str
) -> None:
    answered = Event()
    with _turning(tmp_path) as turning:
        _block(turning, answered, monkeypatch)
        try:
            while not (waits := turning.bench.view.waits_for):
                turning.answer()
            assert re.fullmatch(r"waiting for dmm, channel \S+, 0\.[78] s: values are older, stop works", waits)
            asked_s = CLOCK.monotonic_s()
            if whose == "its own":
                turning.bench.stop("Anna pressed stop")
            else:
                (guard,) = of_rig(str(turning.file))
                assert stop(guard, None, "Anna") is not None
            turning.until("stop: Anna pressed stop" if whose == "its own" else "asked for by Anna")
            assert CLOCK.monotonic_s() - asked_s < TOLD_S
            assert turning.bench.view.is_stopping
            assert "dmm, channel" in turning.bench.view.waits_for
        finally:
            answered.set()
        turning.until("every axis stands still")
        turning.bench.ask(Turn("roll", 10.0, is_held=False))  # what was obeyed keeps nothing from moving
        turning.until("turns at +10 °/s while this terminal answers")
        while turning.simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s()) == 0.0:
            assert CLOCK.monotonic_s() - asked_s < WITHIN_S
            turning.answer()


def test_a_motion_that_a_meter_kept_waiting_for_long_is_not_begun(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answered, page = Event(), Asker("tab", "Anna", "192.0.2.7")
    with _turning(tmp_path) as turning:
        turning.bench.stop("enough")
        turning.until("every axis stands still")
        before_deg = turning.at_rest_deg()
        _block(turning, answered, monkeypatch)
        CLOCK.sleep(0.5)
        turning.bench.ask(GoTo("roll", 1.0, is_step=True), page, CLOCK.boottime_s())
        since_s = CLOCK.monotonic_s()
        while CLOCK.monotonic_s() < since_s + 3.1:
            turning.bench.guard.answer(page.client)
            CLOCK.sleep(0.02)
        answered.set()
        turning.until("roll by +1°: a device kept it waiting for ")
        assert turning.at_rest_deg() == before_deg
        assert not turning.bench.guard.has_lease("roll")


def test_a_log_that_cannot_be_written_stops_what_turns(tmp_path: Path) -> None:
    with _turning(tmp_path) as turning:
        with open("/dev/full", "ab", buffering=0) as full:
            whole, turning.log._file = turning.log._file, full
            turning.log.write("note")
            assert turning.at_rest_deg() < 30.0
            assert "actions.jsonl: cannot be written: No space left" in turning.bench.guard.lost
        turning.log._file = whole


def test_a_defect_in_the_thread_that_owns_the_devices_stops_what_turns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def defect(_wait: object) -> None:
        raise ZeroDivisionError("of a driver")

    with _turning(tmp_path) as turning:
        monkeypatch.setattr(turning.bench._polling, "round", defect)
        assert turning.at_rest_deg() < 30.0
        turning.until("a defect of calrig: ZeroDivisionError: of a driver")


def test_a_name_of_no_axis_is_refused_and_written_down_whatever_its_letters(tmp_path: Path) -> None:
    with _turning(tmp_path) as turning:
        turning.bench.ask(GoTo("\ud800", 1.0), Asker("tab", "Anna", "192.0.2.7"))
        turning.until(r"no axis '\\ud800' (allowed: pitch, roll); nothing moved")
        assert not turning.bench.guard.has_lease("\ud800")
    lines = (tmp_path / "actions.jsonl").read_text(encoding="utf-8").splitlines()
    assert any(line["kind"] == "refused" and "\\ud800" in line["why"] for line in map(json.loads, lines))


def test_a_stop_by_hand_names_an_order_that_no_machine_answered(tmp_path: Path) -> None:
    with _turning(tmp_path) as turning:
        turning.rig.motion.sent("pitch", "move to 90°")
        turning.rig.motion.awaits_answer("pitch", CLOCK.now_utc(), target_deg=90.0, wanders_deg=0.05)
        turning.bench.stop("enough")
        turning.until("every axis stands still, but pitch: the order to move to 90° of ")
    assert "may still come; no stop ends that for certain" in turning.log.path.read_text(encoding="utf-8")


EXAMPLES = sorted(Path("examples").glob("**/rig.toml"))
WITHOUT_READOUT = {"rate-table", "servo-mechanism"}


@pytest.mark.parametrize(
    "file",
    [
        pytest.param(file, id=name, marks=() if name in WITHOUT_READOUT else pytest.mark.thorough)
        for file in EXAMPLES
        for name in (file.parent.name,)
    ],
)
def test_every_rig_of_the_examples_homes_at_the_bench_and_goes_on_being_looked_at(tmp_path: Path, file: Path) -> None:
    """The rate table and the servo mechanism have no channel of a readout: there is nothing to look at but axes."""
    with open_rig(read_rig(file), rig_file=file, clock=CLOCK) as rig:
        log = ActionLog(tmp_path / "actions.jsonl", CLOCK)
        bench = Bench(rig, log, Snapshots(tmp_path / "snapshots.csv", CLOCK), CLOCK)
        turning = Turning(bench, rig, None, log, file)
        axis = next(iter(rig.axes))
        try:
            bench.start()
            bench.ask(Home(axis))
            turning.until(f"{axis}: homed")
            seen_s = CLOCK.monotonic_s()
            while CLOCK.monotonic_s() < seen_s + 1.5:  # several rounds over all that is polled
                assert not turning.bench.guard.lost
                turning.answer()
        finally:
            bench.close()
            log.close()
    assert "defect" not in (tmp_path / "actions.jsonl").read_text(encoding="utf-8")
