"""Laws of homes from one connection to the next: taken over where the machine proves it, else homed anew."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest
from table_bench import rig_file
from turning_rig import _TABLE as TABLE
from turning_rig import SERVO_FOR_PITCH, served

from ams.whole_file import replace_file
from rig.abilities.abilities import AxisState
from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock
from rig.description.fault_plan import FaultPlan, FaultRule
from rig.description.read import read_rig
from rig.motion.home_memory import HomeMemory
from rig.motion.jog import home, jog_to

FACTOR = 10.0
ESP_FOR_PITCH = (
    TABLE.format(axis=1),
    'driver = "esp301"\nport = "twin"\naxis = 1\nlimits_deg = [-90.0, 90.0]\nspeed_dps = 20.0\n',
)
MACHINES = {"maestro": SERVO_FOR_PITCH, "esp301": ESP_FOR_PITCH}


@contextmanager
def _connected(file: Path, folder: Path) -> Iterator[tuple[Rig, dict[str, str]]]:
    """One connection, as one command has it."""
    with open_rig(read_rig(file)) as rig:
        memory = HomeMemory(rig.description, rig.clock, replace_file, folder)
        yield rig, memory.take_over(rig.axes)
        memory.keep(rig.axes)


@pytest.fixture(params=MACHINES)
def machine(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_a_home_is_taken_over_where_the_machine_kept_it(tmp_path: Path, machine: str) -> None:
    with served(tmp_path, ScaledClock(FACTOR), MACHINES[machine]) as (_, file):
        with _connected(file, tmp_path / "homes") as (rig, refusals):
            assert not refusals
            assert not rig.axes["pitch"].state().is_homed
            home(rig, "pitch", rig.clock.sleep)
            jog_to(rig, "pitch", 20.0, rig.clock.sleep)
        for target_deg in (10.0, -5.0):
            with _connected(file, tmp_path / "homes") as (rig, refusals):
                assert not refusals
                assert rig.axes["pitch"].state().is_homed
                assert jog_to(rig, "pitch", target_deg, rig.clock.sleep) == pytest.approx(target_deg, abs=0.03)


def test_a_machine_that_lost_power_meanwhile_says_so_and_is_homed_anew(tmp_path: Path, machine: str) -> None:
    cut = FaultRule(line="axes.pitch", kind="power-cycle", at_s=45.0, away_s=1.0)
    clock = ScaledClock(FACTOR)
    path = rig_file(tmp_path, MACHINES[machine])
    begun_s = clock.monotonic_s()
    with serve_rig(read_rig(path), clock, faults=FaultPlan(fault={"cut": cut})) as simulated:
        write_rig(path, simulated.addresses, FACTOR, tmp_path / "ports.toml")
        with _connected(tmp_path / "ports.toml", tmp_path / "homes") as (rig, _):
            home(rig, "pitch", rig.clock.sleep)
            jog_to(rig, "pitch", 20.0, rig.clock.sleep)
        clock.sleep(begun_s + 48.0 - clock.monotonic_s())
        with _connected(tmp_path / "ports.toml", tmp_path / "homes") as (rig, refusals):
            assert "does not hold any more" in refusals["pitch"]
            assert {"maestro": "was left at 1717.5 µs", "esp301": "the motor is off"}[machine] in refusals["pitch"]
            assert not rig.axes["pitch"].state().is_homed
        assert not list((tmp_path / "homes").iterdir()), "an axis that is left without a home is forgotten"


def test_a_controller_whose_motor_came_on_again_by_itself_is_found_out_by_its_clock(tmp_path: Path) -> None:
    with (
        served(tmp_path, ScaledClock(FACTOR), ESP_FOR_PITCH) as (_, file),
        _connected(file, tmp_path / "homes") as (rig, _),
    ):
        home(rig, "pitch", rig.clock.sleep)
        axis = rig.axes["pitch"]
        mark = axis.home_mark()  # type: ignore[attr-defined]
        assert "lost power" in axis.resume_home({"stamp": mark["stamp"] + 1e6}, 10.0)  # type: ignore[attr-defined]
        assert "lost power" in axis.resume_home(mark, 3600.0)  # type: ignore[attr-defined]
        assert "lost power" in axis.resume_home(mark, 30.0)  # type: ignore[attr-defined]


def test_a_controller_that_ran_longer_than_we_were_away_did_not_lose_power(tmp_path: Path) -> None:
    with (
        served(tmp_path, ScaledClock(FACTOR), ESP_FOR_PITCH) as (_, file),
        _connected(file, tmp_path / "homes") as (rig, _),
    ):
        home(rig, "pitch", rig.clock.sleep)
        axis = rig.axes["pitch"]
        mark = axis.home_mark()  # type: ignore[attr-defined]
        why = axis.resume_home({"stamp": mark["stamp"] - 1e6}, 10.0)  # type: ignore[attr-defined]
    assert "another controller" in why
    assert "lost power" not in why


class _SlowToBegin:
    """A machine whose line takes 8 s to its first answer, as one with an old stream on it, and whose clock is ours."""

    name = "pitch"

    def __init__(self, clock: ScaledClock) -> None:
        self._clock = clock
        self._is_awake = False
        self.off_by_s = float("nan")

    def _stamp_s(self) -> float:
        if not self._is_awake:
            self._clock.sleep(8.0)
        self._is_awake = True
        return self._clock.monotonic_s()

    def state(self) -> AxisState:
        return AxisState(position_deg=0.0, is_moving=False, is_homed=True, is_seated=True, fault="")

    def home_mark(self) -> dict[str, float]:
        return {"stamp": self._stamp_s()}

    def resume_home(self, mark: Mapping[str, float], away_s: float) -> str:
        self.off_by_s = self._stamp_s() - mark["stamp"] - away_s
        return ""


def test_the_time_that_a_line_takes_to_begin_is_no_time_away(tmp_path: Path) -> None:
    path = rig_file(tmp_path, ('port = "twin"', 'port = "socket://127.0.0.1:1"'))
    clock = ScaledClock(40.0)
    HomeMemory(read_rig(path), clock, replace_file, tmp_path / "homes").keep({"pitch": _SlowToBegin(clock)})  # type: ignore[dict-item]
    clock.sleep(10.0)
    next_connection = _SlowToBegin(clock)
    HomeMemory(read_rig(path), clock, replace_file, tmp_path / "homes").take_over({"pitch": next_connection})  # type: ignore[dict-item]
    assert next_connection.off_by_s == pytest.approx(0.0, abs=4.0)


def test_a_torn_memory_is_no_memory(tmp_path: Path) -> None:
    with served(tmp_path, ScaledClock(FACTOR), SERVO_FOR_PITCH) as (_, file):
        with _connected(file, tmp_path / "homes") as (rig, _):
            home(rig, "pitch", rig.clock.sleep)
        (kept,) = (tmp_path / "homes").iterdir()
        kept.write_text(kept.read_text(encoding="utf-8")[:-5], encoding="utf-8")
        with _connected(file, tmp_path / "homes") as (rig, refusals):
            assert not refusals
            assert not rig.axes["pitch"].state().is_homed
