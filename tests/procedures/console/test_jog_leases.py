"""Leases on real lines: what turns by a page stands within half a second of whatever happens to the page."""

import os
import signal
import socket
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from jog_bench import CLOCK, RIG, JogBench, WordPage, jog_bench, word_page
from slow_wires import Wire

from rig.lines.lock import acquire, owner_of

STOPPED_S = 0.5
pytestmark = pytest.mark.skipif(os.name == "nt", reason="the console hands its benches over pipes of a loop")


def _released(bench: JogBench, page: WordPage) -> None:
    page.release()


def _hung(bench: JogBench, page: WordPage) -> None:
    page.answers = False


def _closed(bench: JogBench, page: WordPage) -> None:
    page.line.socket.shutdown(socket.SHUT_RDWR)


def _left(bench: JogBench, page: WordPage) -> None:
    page.say(say="beat", tick=page.seen["tick"], press=page.press, held=page.held, away=True)


def _given_back(bench: JogBench, page: WordPage) -> None:
    page.say(say="give")


def _console_hung(bench: JogBench, page: WordPage) -> None:
    bench.console.process.send_signal(signal.SIGSTOP)


def _console_killed(bench: JogBench, page: WordPage) -> None:
    bench.console.process.kill()


def _stopped(bench: JogBench, page: WordPage) -> None:
    page.say(say="stop")


LOSSES = (_released, _hung, _closed, _left, _given_back, _console_hung, _console_killed, _stopped)


@pytest.mark.parametrize(
    "lose", [pytest.param(one, id=one.__name__, marks=() if one is _hung else pytest.mark.thorough) for one in LOSSES]
)
def test_what_turns_by_a_page_stands_when_the_page_is_lost(
    tmp_path: Path, lose: Callable[[JogBench, WordPage], None]
) -> None:
    with jog_bench(tmp_path) as bench, word_page(bench) as page, word_page(bench) as other:
        page.take()
        page.home()
        other.until(" has the bench")
        page.hold(5.0)
        bench.until_turning()
        page.until("turns at +5 °/s")
        lost_s = CLOCK.monotonic_s()
        lose(bench, page)
        late_s = bench.late_s(lost_s)
        bench.console.process.send_signal(signal.SIGCONT)
        assert late_s < STOPPED_S
        asked = [line for line in bench.log() if line["kind"] == "asked"]
        assert {(line["via"], line["place"]) for line in asked} == {("console", "127.0.0.1")}
        assert all(line["by"] for line in asked)


@pytest.mark.thorough
def test_a_rig_that_somebody_has_is_not_taken_and_a_bench_that_is_open_keeps_others_out(tmp_path: Path) -> None:
    with jog_bench(tmp_path) as bench, word_page(bench) as page:
        with acquire([str(bench.files / RIG)], "run"):
            page.say(say="take")
            page.until(f"in use by process {os.getpid()} (run)")
        page.take()
        owner = owner_of(str(bench.files / RIG))
        assert owner is not None
        assert owner.purpose == "jog"


@contextmanager
def _over_a_wire(bench: JogBench) -> Iterator[tuple[Wire, WordPage]]:
    with word_page(bench) as probe:
        address = probe.wire.getpeername()
    wire = Wire(address)
    with closing(wire.listener), word_page(bench, wire.address) as page:
        yield wire, page


@pytest.mark.thorough
def test_a_network_that_is_cut_stops_what_turns_and_another_page_keeps_nothing_alive(tmp_path: Path) -> None:
    with jog_bench(tmp_path) as bench, _over_a_wire(bench) as (wire, page), word_page(bench) as other:
        page.take()
        page.home()
        page.hold(5.0)
        bench.until_turning()
        lost_s = CLOCK.monotonic_s()
        wire.is_cut.set()
        other.press = page.press
        other.held = page.held
        other.beat()
        assert bench.late_s(lost_s) < STOPPED_S
        other.until("has the bench no more: its page was not heard")
        other.take()
        other.until("has the bench no more")
        ticks = int(str(other.seen["tick"]))
        while int(str(other.seen["tick"])) < ticks + 10:  # it said that it held before it had the bench
            assert bench.rate_dps() == 0.0
            CLOCK.sleep(0.01)
        other.release()
        other.hold(5.0)
        bench.until_turning()


@pytest.mark.thorough
def test_a_network_of_two_seconds_begins_nothing(tmp_path: Path) -> None:
    with jog_bench(tmp_path) as bench, _over_a_wire(bench) as (wire, page), word_page(bench) as other:
        page.take()
        page.home()
        wire.delay_s = 2.0
        page.hold(5.0)
        other.until("allowed are 0.25 s; nothing moved")
        assert bench.rate_dps() == 0.0


@pytest.mark.thorough
def test_what_is_no_number_is_refused_and_a_bench_that_died_is_not_said_to_stand(tmp_path: Path) -> None:
    with jog_bench(tmp_path) as bench, word_page(bench) as page:
        page.take()
        page.home()
        page.say(say="do", act="goto", axis="roll", degrees=10**400, tick=page.seen["tick"])
        page.until("roll: move to nan: not a number of degrees; nothing moved")
        owner = owner_of(str(bench.files / RIG))
        assert owner is not None
        os.kill(owner.pid, signal.SIGKILL)
        page.until("the bench ended by itself (signal 9)")
        page.until("nobody has seen them stand")
