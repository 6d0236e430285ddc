"""A bench that is left while a line is out: what turns is stopped when it is back, and what is not known is told."""

import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from cut_line import CutLine, cut_line
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served

from procedures.errors import ExitStatus
from procedures.jog_screen.last_stop import stopped
from procedures.jog_screen.log import ActionLog, Snapshots
from procedures.jog_screen.served import jog_for_pages
from procedures.jog_screen.session import jog_on_screen
from procedures.jog_screen.worker import Bench
from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import SimulatedRig
from rig.clock import ScaledClock, SystemClock
from rig.description.read import read_rig
from rig.motion.move import home_and_arrive
from rig.twins.zaber import Stage

CLOCK, RIG_CLOCK = SystemClock(), ScaledClock(10.0)
RATE_DPS = 10.0
FOR_GOOD = 1_000_000
WITHIN_S = 30.0


@contextmanager
def _at_a_line_that_breaks(folder: Path) -> Iterator[tuple[Rig, CutLine, SimulatedRig]]:
    """Roll, homed, over TCP."""
    with served(folder, RIG_CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (simulated, rig_file):
        address = simulated.addresses["axes.roll"]
        with cut_line(address) as line:
            rig_file.write_text(rig_file.read_text(encoding="utf-8").replace(address, line.address), encoding="utf-8")
            with open_rig(read_rig(rig_file), rig_file=rig_file) as rig:
                home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
                yield rig, line, simulated


def _rate_dps(simulated: SimulatedRig) -> float:
    return simulated.world.axes["roll"].rate_dps(RIG_CLOCK.monotonic_s())


def _turned_and_cut(rig: Rig, line: CutLine, refusals: int) -> Callable[[], None]:
    def turn_and_cut() -> None:
        rig.axes["roll"].start_rate(RATE_DPS)  # type: ignore[attr-defined]
        line.cut(refusals)

    return turn_and_cut


class _Screen:
    """A terminal at which roll is turned, its line breaks and the operator leaves."""

    defect = None

    def __init__(self, bench: Bench, happen: Callable[[], None]) -> None:
        self._bench, self._happen = bench, happen

    def heed_signals(self) -> None:
        """No signal comes."""

    def run(self) -> None:
        self._bench.start()
        until_s = CLOCK.monotonic_s() + WITHIN_S
        while not (self._bench.view.channels and self._bench.view.channels[0].count):  # every axis was seen to stand
            assert CLOCK.monotonic_s() < until_s
            CLOCK.sleep(0.02)
        self._happen()


def _on_screen(
    folder: Path, monkeypatch: pytest.MonkeyPatch, rig: Rig, happen: Callable[[], None]
) -> tuple[ExitStatus, list[str]]:
    heard: list[str] = []
    monkeypatch.setattr("procedures.jog_screen.session.JogApp", lambda bench, _heading: _Screen(bench, happen))
    monkeypatch.setattr("procedures.jog_screen.session.is_hung_up", lambda: False)
    files = folder / "ports.toml", folder / "jog.jsonl", folder / "snapshots.csv"
    return jog_on_screen(rig, *files, None, heard.append), heard


def test_who_leaves_while_the_line_of_what_turns_is_out_leaves_it_at_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):
        status, heard = _on_screen(tmp_path, monkeypatch, rig, _turned_and_cut(rig, line, refusals=2))
        assert _rate_dps(simulated) == 0.0
        assert status is ExitStatus.DONE
        assert "the line is open again, and every axis stands still; actions are in " in heard[-1]


def test_who_leaves_is_not_told_that_an_axis_stands_where_another_device_answers_its_stop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Adapters change their numbers when they are plugged in again: the stop reaches a stage that stands anyway."""
    (tmp_path / "other").mkdir()
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):
        defaults = Stage.__init__.__defaults__
        assert defaults is not None
        monkeypatch.setattr(Stage.__init__, "__defaults__", tuple(99999 if it == 12345 else it for it in defaults))
        with served(tmp_path / "other", RIG_CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (elsewhere, _):

            def change_the_cables() -> None:
                _turned_and_cut(rig, line, refusals=2)()
                line.lead_to(elsewhere.addresses["axes.roll"])

            status, heard = _on_screen(tmp_path, monkeypatch, rig, change_the_cables)
            line.cut(FOR_GOOD)
        assert _rate_dps(simulated) == RATE_DPS, "nobody reaches it"
    assert status is ExitStatus.FAILED
    assert "every axis stands still" not in heard[-1]
    for words in (
        "roll: another device answers on its line",
        "99999",
        "use the stop button at the machine",
        "go and look",
    ):
        assert words in heard[-1]


def test_who_leaves_a_bench_that_found_another_device_before_is_told_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The line was opened again while somebody was there; nothing is lost when he leaves."""
    (tmp_path / "other").mkdir()
    with _at_a_line_that_breaks(tmp_path) as (rig, line, _):
        rig.identities()
        defaults = Stage.__init__.__defaults__
        assert defaults is not None
        monkeypatch.setattr(Stage.__init__, "__defaults__", tuple(99999 if it == 12345 else it for it in defaults))
        with served(tmp_path / "other", RIG_CLOCK, STAGE_FOR_ROLL, QUICK_METER) as (elsewhere, _):
            line.cut(0)
            line.lead_to(elsewhere.addresses["axes.roll"])
            rig.reconnect()
            outcome = stopped(rig)
            line.cut(FOR_GOOD)
    assert "roll: another device answers on its line" in outcome.in_words
    assert "every axis stands still" not in outcome.in_words


def test_who_leaves_while_a_line_is_out_for_good_is_told_what_may_turn_and_the_status_is_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rig.motion.out_of_reach.BACK_S", 10.0)
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):
        status, heard = _on_screen(tmp_path, monkeypatch, rig, _turned_and_cut(rig, line, FOR_GOOD))
        assert _rate_dps(simulated) == RATE_DPS, "nobody reaches it"
        assert status is ExitStatus.FAILED
        line.cut(0)
    assert "every axis stands still" not in heard[-1]
    for words in (
        "not every axis is known to stand still: roll: ",
        "use the stop button at the machine",
        "whether roll stands is not known: it was told to turn",
        "pitch was last read at rest at ",
        "go and look",
    ):
        assert words in heard[-1]
    assert heard[-1].partition("; actions")[0] in (tmp_path / "jog.jsonl").read_text(encoding="utf-8")


class _LostConsole(io.BytesIO):
    """Standard output of a page's session that breaks at the twelfth picture, as something happens."""

    def __init__(self, happen: Callable[[], None]) -> None:
        super().__init__()
        self._happen, self._pictures = happen, 0

    def write(self, data: Any, /) -> int:
        self._pictures += b'"axes"' in bytes(data)
        if self._pictures == 12:
            self._happen()
            raise BrokenPipeError
        return 0


@pytest.mark.thorough
@pytest.mark.parametrize(("refusals", "status"), [(2, ExitStatus.ABORTED), (FOR_GOOD, ExitStatus.FAILED)])
def test_a_console_that_is_lost_while_a_line_is_out_says_how_the_axes_were_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refusals: int, status: ExitStatus
) -> None:
    monkeypatch.setattr("rig.motion.out_of_reach.BACK_S", 10.0)
    heard: list[str] = []
    orders_end, ours = os.pipe()
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated), os.fdopen(orders_end, "rb", buffering=0) as orders:
        out = _LostConsole(_turned_and_cut(rig, line, refusals))
        files = tmp_path / "jog.jsonl", tmp_path / "snapshots.csv"
        assert jog_for_pages(rig, *files, None, orders, out, heard.append) is status
        os.close(ours)
        assert (_rate_dps(simulated) == 0.0) is (status is ExitStatus.ABORTED)
        line.cut(0)
    assert heard[-1].startswith("the console is gone; ")
    assert ("every axis stands still" in heard[-1]) is (status is ExitStatus.ABORTED)
    assert ("whether roll stands is not known" in heard[-1]) is (status is ExitStatus.FAILED)


def test_a_bench_whose_operator_is_lost_is_stopped_though_nobody_closes_it(tmp_path: Path) -> None:
    """Its screen hangs: what stops the axes does not wait for it."""
    with _at_a_line_that_breaks(tmp_path) as (rig, line, simulated):
        log = ActionLog(tmp_path / "jog.jsonl", CLOCK)
        bench = Bench(rig, log, Snapshots(tmp_path / "snapshots.csv", CLOCK), CLOCK)
        try:
            _Screen(bench, _turned_and_cut(rig, line, refusals=2)).run()
            bench.guard.lose("SIGHUP: the operator is gone")
            assert bench.has_ended(WITHIN_S)
            assert (bench.last_stop.failure, _rate_dps(simulated)) == ("", 0.0)
        finally:
            bench.close()
            log.close()
