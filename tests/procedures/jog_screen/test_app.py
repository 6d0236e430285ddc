"""Laws of the jog screen in process: a frozen screen ends a rate, a stop overtakes, a lost line is told and mended."""

import asyncio
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event

import pytest
from many_packages import many_packages, serial
from starved import starved
from table_bench import rig_file
from textual.events import CursorPosition, Key
from textual.pilot import Pilot
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served

from procedures.jog_screen.app import ASK_TERMINAL, JogApp
from procedures.jog_screen.heading import Heading
from procedures.jog_screen.log import ActionLog, Snapshots
from procedures.jog_screen.worker import Bench
from rig.assembly.open_rig import Rig, open_rig
from rig.clock import Clock, ScaledClock, SystemClock
from rig.description.fault_plan import FaultPlan, FaultRule
from rig.description.read import read_rig

CLOCK = SystemClock()
SIZE = (118, 36)
ROLL = "increment_deg = {}\nlimits_deg = [-180.0, 180.0]\nspeed_dps = 5.0\nuncertainty_arcsec = 1.0\n{}"
TWO_TABLES = (
    (ROLL.format("1.0", 'standard = "table"\naxis = 2'), ROLL.format("0.0001", 'standard = "table"\naxis = 1')),
)
"""Two controllers with lines of their own, which tell themselves apart by their dialects."""


@contextmanager
def _bench(folder: Path, rig: Rig) -> Iterator[Bench]:
    actions = ActionLog(folder / "actions.jsonl", CLOCK)
    bench = Bench(rig, actions, Snapshots(folder / "snapshots.csv", CLOCK), CLOCK)
    try:
        yield bench
    finally:
        bench.close()
        actions.close()


@contextmanager
def _on_twins(folder: Path, clock: Clock, *changes: tuple[str, str], **faults: dict[str, object]) -> Iterator[Bench]:
    plan = FaultPlan(fault={name: FaultRule(**rule) for name, rule in faults.items()}) if faults else None  # type: ignore[arg-type]
    path = rig_file(folder, QUICK_METER, *changes)
    with open_rig(read_rig(path), clock=clock, rig_file=path, faults=plan) as rig, _bench(folder, rig) as bench:
        yield bench


def _app(bench: Bench) -> JogApp:
    return JogApp(bench, Heading("a rig", "twins", "held by us", "actions.jsonl"))


async def _until(pilot: Pilot[None], condition: Callable[[], bool], within_s: float = 20.0) -> None:
    deadline_s = CLOCK.monotonic_s() + within_s
    while not condition():
        assert CLOCK.monotonic_s() < deadline_s, [line.text for line in _bench_of(pilot).view.messages]
        await pilot.pause(0.02)


async def _told(pilot: Pilot[None], words: str) -> None:
    await _until(pilot, lambda: any(words in line.text for line in _bench_of(pilot).view.messages))


def _press(pilot: Pilot[None], *keys: str) -> None:
    """Keys as the terminal's thread hands them over; the pilot's own way waits for an idle processor."""
    for key in keys:
        pilot.app.post_message(Key(key, key if len(key) == 1 else None))


def _bench_of(pilot: Pilot[None]) -> Bench:
    assert isinstance(pilot.app, JogApp)
    return pilot.app.bench


WORTH_S = 0.25
"""So long an answer of the terminal is worth: whoever tests may have had no processor for that."""
LONGEST_S = 30.0


def _answering(app: JogApp) -> list[None]:
    """A terminal that answers through the screen's own queue, as a real one does; its answers, as they come."""
    driver, answers = app._driver, list[None]()
    assert driver is not None
    write = driver.write

    def answered(text: str) -> None:
        write(text)
        if text == ASK_TERMINAL:
            app.post_message(CursorPosition(0, 0))
            answers.append(None)

    driver.write = answered  # type: ignore[method-assign]
    return answers


def test_a_frozen_screen_ends_a_rate_within_half_a_second(tmp_path: Path) -> None:
    async def act() -> None:
        with (
            served(tmp_path, CLOCK, QUICK_METER, STAGE_FOR_ROLL) as (simulated, file),
            open_rig(read_rig(file)) as rig,
            _bench(tmp_path, rig) as bench,
            starved() as meter,
        ):
            app, body = _app(bench), simulated.world.axes["roll"]
            async with app.run_test(size=SIZE) as pilot:
                answers = _answering(app)
                _press(pilot, "down", "h")
                await _told(pilot, "roll: homed")
                _press(pilot, "r", "5", "enter")
                await _told(pilot, "roll: turns at +5 °/s")
                heard = len(answers)
                while len(answers) < heard + 4:  # longer than one answer is worth
                    await pilot.pause(0.02)
                assert body.rate_dps(CLOCK.monotonic_s()) == 5.0 or meter.allowance_s > WORTH_S, "it is answered for"
                frozen_s = CLOCK.monotonic_s()
                while body.rate_dps(CLOCK.monotonic_s()) != 0.0:
                    assert CLOCK.monotonic_s() < frozen_s + LONGEST_S, "it turns on"
                    Event().wait(0.01)  # the loop of the screen stands still
                assert body.still_from_s - frozen_s < 0.5 + meter.allowance_s
                await _told(pilot, "roll: stop: the terminal did not answer")

    asyncio.run(act())


def _pitch_deg(bench: Bench) -> float:
    state = bench.view.axes[0].state
    return 0.0 if state is None else state.position_deg


def _is_at_rest(bench: Bench) -> bool:
    state = bench.view.axes[0].state
    return state is not None and not state.is_moving


def test_steps_are_not_saved_up_and_a_stop_leaves_nothing_behind(tmp_path: Path) -> None:
    async def act() -> None:
        with _on_twins(tmp_path, ScaledClock(5.0)) as bench:
            async with _app(bench).run_test(size=SIZE) as pilot:
                _press(pilot, "h")
                await _told(pilot, "pitch: homed")
                _press(pilot, "g", "9", "0", "enter", "right", "right")
                await _told(pilot, "pitch by +1°: pitch to +90° is under way; wait, or stop it (space)")
                await _until(pilot, lambda: _pitch_deg(bench) > 0.0)
                _press(pilot, "space", "right")
                await _told(pilot, "a stop is under way")
                await _told(pilot, "every axis stands still")
                await _until(pilot, lambda: not bench.view.is_stopping and _is_at_rest(bench))
                rested_deg = _pitch_deg(bench)
                assert 0.0 < rested_deg < 90.0
                _press(pilot, "right")
                await _told(pilot, f"pitch: at rest at {rested_deg + 1:+.4f}°")

    asyncio.run(act())


def test_a_stop_voids_keys_that_were_struck_before_it_but_not_yet_heard(tmp_path: Path) -> None:
    async def act() -> None:
        with _on_twins(tmp_path, ScaledClock(50.0)) as bench:
            app = _app(bench)
            async with app.run_test(size=SIZE) as pilot:
                _press(pilot, "h")
                await _told(pilot, "pitch: homed")
                _press(pilot, "g", "4", "0", "space")
                await _told(pilot, "every axis stands still")
                await _until(pilot, lambda: not bench.view.is_stopping)
                _press(pilot, "enter", "s")
                await _told(pilot, "snapshot 1")
                assert not any("+40" in line.text for line in bench.view.messages)

    asyncio.run(act())


def test_a_wrong_number_is_told_and_moves_nothing(tmp_path: Path) -> None:
    async def act() -> None:
        with _on_twins(tmp_path, ScaledClock(50.0)) as bench:
            async with _app(bench).run_test(size=SIZE) as pilot:
                _press(pilot, "h")
                await _told(pilot, "pitch: homed")
                _press(pilot, "g", "1", "-", "backspace", "x", "enter")
                await _told(pilot, "got '1x', allowed is a number; nothing moved")
                for wrong, why in (("nan", "finite"), ("0.5", "multiples of 1°"), ("181", "outside the limits")):
                    _press(pilot, "g", *wrong, "enter")
                    await _told(pilot, why)

    asyncio.run(act())


def test_a_lost_line_is_told_by_its_device_and_opened_again(tmp_path: Path) -> None:
    async def act() -> None:
        gone = {"line": "axes.pitch", "kind": "hang-up", "on": "question", "nth": 12, "away_s": 40.0}
        with _on_twins(tmp_path, ScaledClock(50.0), gone=gone) as bench:
            async with _app(bench).run_test(size=SIZE) as pilot:
                await _told(pilot, "axes.pitch and axes.roll: the line is gone")
                await _told(pilot, "every line is open again")
                _press(pilot, "h")
                await _told(pilot, "pitch: homed")

    asyncio.run(act())


def test_an_axis_that_falls_silent_is_told_once_and_keeps_no_other_from_moving(tmp_path: Path) -> None:
    async def act() -> None:
        dead = {"line": "axes.roll", "kind": "power-cycle", "at_s": 40.0, "away_s": 1e6}
        with _on_twins(tmp_path, ScaledClock(50.0), STAGE_FOR_ROLL, dead=dead) as bench:
            async with _app(bench).run_test(size=SIZE) as pilot:
                await _told(pilot, "twin of axes.roll: no complete reply")
                assert bench.view.axes[1].state is None
                _press(pilot, "h")
                await _told(pilot, "pitch: homed")
                _press(pilot, "g", "1", "2", "0", "enter")
                await _told(pilot, "pitch: at rest at +120.0000°")
                assert sum("no complete reply" in line.text for line in bench.view.messages) == 1

    asyncio.run(act())


def test_a_move_that_is_made_again_is_told_and_on_record(tmp_path: Path) -> None:
    async def act() -> None:
        stall = {"line": "axes.pitch", "kind": "stall", "for_s": 1000.0, "at_s": 100.0}
        clock = ScaledClock(50.0)
        with _on_twins(tmp_path, clock, stall=stall) as bench:
            opened_s = clock.monotonic_s()
            async with _app(bench).run_test(size=SIZE) as pilot:
                _press(pilot, "h")
                await _told(pilot, "pitch: homed")
                await _until(pilot, lambda: clock.monotonic_s() - opened_s > 100.0)
                _press(pilot, "g", "1", "2", "0", "enter")
                await _told(pilot, "it went back to 0° and is tried once more")
                await _told(pilot, "pitch: at rest at +120.0000°")

    asyncio.run(act())
    lines = [json.loads(line) for line in (tmp_path / "actions.jsonl").read_text(encoding="utf-8").splitlines()]
    (again,) = [line["why"] for line in lines if line["kind"] == "again"]
    # Two rig seconds are 40 ms here: a busy machine looks again when the whole time allowed is over.
    assert "no progress in 2 s" in again or "still moving at" in again


def test_devices_that_changed_places_are_named_and_nothing_moves_any_more(tmp_path: Path) -> None:
    async def act() -> None:
        swapped = {"line": "axes.pitch", "kind": "swap", "other": "axes.roll", "on": "question", "nth": 12}
        gone = {"line": "axes.pitch", "kind": "hang-up", "on": "question", "nth": 13, "away_s": 1.0}
        with _on_twins(tmp_path, ScaledClock(50.0), *TWO_TABLES, swapped=swapped, gone=gone) as bench:
            async with _app(bench).run_test(size=SIZE) as pilot:
                await _told(pilot, "pitch: another device answers on its line: was")
                _press(pilot, "h")
                await _told(pilot, "pitch home: pitch: another device answers")

    asyncio.run(act())


def test_a_snapshot_file_of_another_rig_is_not_added_to(tmp_path: Path) -> None:
    (tmp_path / "snapshots.csv").write_text("utc,yaw_deg\n", encoding="utf-8")

    async def act() -> None:
        with _on_twins(tmp_path, ScaledClock(50.0)) as bench:
            async with _app(bench).run_test(size=SIZE) as pilot:
                _press(pilot, "s")
                await _told(pilot, "has other columns; nothing was written; name another with --snapshot")

    asyncio.run(act())
    assert (tmp_path / "snapshots.csv").read_text(encoding="utf-8") == "utc,yaw_deg\n"


@pytest.mark.parametrize("key", ["r", "p"])
def test_what_an_axis_cannot_do_is_told(tmp_path: Path, key: str) -> None:
    async def act() -> None:
        with _on_twins(tmp_path, ScaledClock(50.0)) as bench:
            async with _app(bench).run_test(size=SIZE) as pilot:
                _press(pilot, key)
                await _told(pilot, {"r": "pitch: this axis only goes to positions", "p": "pitch: is no servo"}[key])

    asyncio.run(act())


def test_a_defect_of_the_screen_stops_the_axes_and_is_told_like_any_other(tmp_path: Path) -> None:
    class Broken(JogApp):
        def _select(self, way: int) -> None:
            raise ZeroDivisionError(f"way {way}")

    async def act() -> None:
        with _on_twins(tmp_path, ScaledClock(50.0)) as bench:
            app = Broken(bench, Heading("a rig", "twins", "held by us", "actions.jsonl"))
            async with app.run_test(size=SIZE) as pilot:
                _press(pilot, "down")
                await _until(pilot, lambda: app.defect is not None)

    with pytest.raises(ZeroDivisionError, match="way 1"):
        asyncio.run(act())
    assert '"kind": "end"' in (tmp_path / "actions.jsonl").read_text(encoding="utf-8").splitlines()[-1]


@pytest.mark.parametrize(
    "size", [(60, 20), *(pytest.param(size, marks=pytest.mark.thorough) for size in ((80, 24), (200, 50)))]
)
def test_prompt_last_message_and_stop_are_in_view_at_any_size(tmp_path: Path, size: tuple[int, int]) -> None:
    """24 channels on two axes: what does not fit are readings, and they are paged."""
    path, _ = many_packages(tmp_path, 8)
    sensors = {serial(number): frozenset(f"daq.{serial(number).lower()}{axis}" for axis in "xyz") for number in (1, 8)}

    async def look(bench: Bench) -> None:
        app = JogApp(bench, Heading("a rig", "twins", "held by us", "actions.jsonl", sensors))
        async with app.run_test(size=size) as pilot:
            bench.refuse("roll: this axis only goes to positions")
            await _until(pilot, lambda: bool(bench.view.messages))
            _press(pilot, "g", "1", "0")
            await _until(pilot, lambda: "10" in shown(app, "#prompt"))
            height = size[1]
            for location in ("#prompt", "#keys", "#messages", "#channels", "#axes"):
                region = app.query_one(location).region
                assert 0 <= region.y < region.bottom <= height, location
            assert app.query_one("#messages").region.bottom <= app.query_one("#prompt").region.y
            assert "stops everything" in shown(app, "#keys")
            assert "only goes to positions" in shown(app, "#messages")
            _press(pilot, "escape", "tab", "tab")
            await _until(pilot, lambda: "readings of SN1048" in shown(app, "#channels"))
            readings = shown(app, "#channels")
            assert ("sn1048z" in readings, "sn1041x" in readings) == (True, False)

    def shown(app: JogApp, location: str) -> str:
        region = app.query_one(location).region
        lines = ("".join(part.text for part in line) for line in app.screen._compositor.render_strips(app.screen.size))
        return "\n".join(list(lines)[region.y : region.bottom])

    with open_rig(read_rig(path), clock=ScaledClock(50.0), rig_file=path) as rig, _bench(tmp_path, rig) as bench:
        asyncio.run(look(bench))
