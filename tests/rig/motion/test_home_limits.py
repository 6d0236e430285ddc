"""Homing keeps the limits: what has no search is moved nowhere, and no axis is homed to outside its limits."""

from pathlib import Path
from typing import Any

import pytest
from motion_bench import DRIVERS, MotionBench, motion_bench
from table_bench import rig_file

from rig.description.read import read_rig
from rig.errors import DescriptionError, DeviceFault, MotionBreach, RequestRefused
from rig.link.memory import MemoryStream
from rig.motion.move import NotSeenAtRest, home_and_arrive, move_and_arrive, stop_all
from rig.motion.supervisor import SupervisedAxis, Supervisor
from rig.wire.table_dialect import load_dialect, published_dialects, rate_dialects, shipped_dialects

DIALECTS = [
    *(("indexing-table", name) for name in (*shipped_dialects(), *published_dialects())),
    *(("rate-table", name) for name in rate_dialects()),
]
WITHOUT_SEARCH = [(driver, name) for driver, name in DIALECTS if load_dialect(name, 1.0).home is None]
LIMITS_DEG = (90.0, 270.0)


def _bench(driver: str, dialect: str, **changes: object) -> MotionBench:
    increment_deg = load_dialect(dialect, 1.0).increment_deg if driver == "indexing-table" else 0.0
    given = {"dialect": dialect, "increment_deg": increment_deg, "limits_deg": LIMITS_DEG}
    return motion_bench(driver, **(given | changes))


def _supervised(bench: MotionBench) -> SupervisedAxis:
    settings = bench.pitch._settings
    home_deg = settings.home_attitude_deg if settings.moves_to_home else None
    return Supervisor(bench.clock).supervise(bench.pitch, home_deg)


def _recorded(stream: MemoryStream) -> list[bytes]:
    sent: list[bytes] = []
    write: Any = stream.write
    stream.write = lambda data: (sent.append(data), write(data))[1]  # type: ignore[method-assign,assignment]
    return sent


def test_the_dialects_without_a_search_are_these() -> None:
    assert {name for _, name in WITHOUT_SEARCH} == {"yaesu-gs-232", "inficon-srt-422", "acutronic-acutrol3000"}


@pytest.mark.parametrize(("driver", "dialect"), WITHOUT_SEARCH)
def test_without_a_search_a_home_moves_nothing_and_every_angle_stays_inside(driver: str, dialect: str) -> None:
    """As seen with limits of 90 to 270 degrees: a head at 200 was driven to 0 by every start of a run."""
    bench = _bench(driver, dialect)
    axis = _supervised(bench)
    for stands_deg in (90.0, 198.0, 270.0):
        assert move_and_arrive(axis, stands_deg, bench.clock, bench.clock.sleep) == pytest.approx(stands_deg, abs=0.01)
        sent = _recorded(bench.stream)
        assert home_and_arrive(axis, bench.clock, bench.clock.sleep) == pytest.approx(stands_deg, abs=0.01)
        bench.clock.sleep(100.0)
        assert bench.true_deg == pytest.approx(stands_deg, abs=0.01)
        assert not [line for line in sent if line.startswith((b"W", b"$H", b":dem:"))]
    lowest_deg, highest_deg = bench.world.axes["pitch"].reached_deg
    assert (lowest_deg, highest_deg) == pytest.approx(LIMITS_DEG, abs=0.01)


@pytest.mark.parametrize(("driver", "dialect"), WITHOUT_SEARCH)
def test_an_absolute_machine_has_its_positions_behind_a_power_cut(driver: str, dialect: str) -> None:
    bench = _bench(driver, dialect)
    axis = _supervised(bench)
    move_and_arrive(axis, 198.0, bench.clock, bench.clock.sleep)
    bench.twin.power_cycle(bench.clock.monotonic_s())
    assert home_and_arrive(axis, bench.clock, bench.clock.sleep) == pytest.approx(198.0, abs=0.01)


def test_without_a_search_what_is_moved_by_others_in_a_home_is_a_breach() -> None:
    bench = _bench("indexing-table", "yaesu-gs-232")
    axis = _supervised(bench)
    move_and_arrive(axis, 200.0, bench.clock, bench.clock.sleep)
    bench.twin.axes[1].move(100.0, bench.clock.monotonic_s())
    bench.clock.sleep(5.0)
    with pytest.raises(MotionBreach, match="moves, though nothing told it to: left at 200°"):
        home_and_arrive(axis, bench.clock, bench.clock.sleep)


def test_without_a_search_an_axis_outside_its_limits_is_told_and_stands() -> None:
    bench = _bench("indexing-table", "yaesu-gs-232")
    bench.twin.axes[1].move(300.0, 0.0)
    bench.clock.sleep(100.0)
    axis = _supervised(bench)
    with pytest.raises(DeviceFault, match=r"stands at 300°, outside its limits, allowed 90 to 270° .*nothing moved"):
        home_and_arrive(axis, bench.clock, bench.clock.sleep)
    assert bench.true_deg == 300.0
    assert move_and_arrive(axis, 200.0, bench.clock, bench.clock.sleep) == 200.0, "the ordinary move brings it inside"


def test_a_machine_without_a_stop_that_stands_is_no_failure_of_a_stop_and_one_that_moves_is() -> None:
    """As seen: every run on such a machine tripped behind its last dwell, "not every axis is known to stand still"."""
    bench = _bench("indexing-table", "inficon-srt-422")
    axis = _supervised(bench)
    stop_all({"pitch": axis}, bench.clock)
    axis.start_move(270.0)
    with pytest.raises(NotSeenAtRest, match="has no stop: a move that began ends at its target"):
        stop_all({"pitch": axis}, bench.clock)


def test_an_axis_whose_home_is_outside_its_limits_is_not_homed() -> None:
    bench = motion_bench("oriental-az", limits_deg=(20.0, 160.0))
    axis = _supervised(bench)
    sent = _recorded(bench.stream)
    with pytest.raises(RequestRefused, match=r"homing brings it to 0°, outside its limits, allowed 20 to 160°"):
        axis.home()
    assert not sent


LIMITS = "limits_deg = [-180.0, 180.0]"
PITCH = 'driver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\n' + LIMITS
NEEDS = {
    "indexing-table": "increment_deg = 1.0",
    "maestro": "points = [[1000.0, 90.0], [2000.0, -90.0]]\nhome_deg = 10.0",
    "oriental-az": "step_deg = 0.01",
    "pi-gcs": 'axis_id = "A"',
    "zaber": "microstep_deg = 0.000234375",
}


def _file(folder: Path, driver: str, limits: str, more: str = "") -> Path:
    needed = NEEDS.get(driver, "")
    return rig_file(folder, (PITCH, f'driver = "{driver}"\nport = "twin"\n{needed}\n{more}\n{limits}'))


@pytest.mark.parametrize("driver", sorted(DRIVERS))
def test_a_file_whose_home_is_outside_the_limits_is_refused(tmp_path: Path, driver: str) -> None:
    home_deg, key = (10, "home_deg") if driver == "maestro" else (0, "zero_deg")
    refused = (
        rf"rig\.toml:\d+: axes\.pitch\.limits_deg: homing brings it to {home_deg}°, outside its limits, allowed 20 to"
        rf" 80° .*nothing moved; take the home into limits_deg, or correct it \({key}\)"
    )
    with pytest.raises(DescriptionError, match=refused):
        read_rig(_file(tmp_path, driver, "limits_deg = [20.0, 80.0]"))
    assert read_rig(_file(tmp_path, driver, f"limits_deg = [{home_deg}.0, 80.0]"))


def test_a_file_of_a_machine_that_is_not_moved_by_a_home_is_taken(tmp_path: Path) -> None:
    absolute = 'dialect = "yaesu-gs-232"'
    assert read_rig(_file(tmp_path, "indexing-table", "limits_deg = [90.0, 270.0]", absolute))
    encoder = 'reference = "none"'
    assert read_rig(_file(tmp_path, "pi-gcs", "limits_deg = [20.0, 160.0]", encoder))
