"""The laws find what is broken: a sound device passes, each way of lying is named by a sentence."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from example_files import EXAMPLE_RIG
from instrument_rigs import daq_and_f4t_rig_file, text_chambers_rig_file
from motion_bench import motion_bench

from rig.abilities.abilities import AxisState, TurnLook
from rig.assembly.open_rig import Rig, open_rig
from rig.description.read import read_rig
from rig.testing import keep_promises, rig_on, survive_damage
from rig.testing.axes import keep_axis_promises, keep_rate_promises


class Lying:
    """A device that answers some questions otherwise."""

    def __init__(self, device: Any, **lies: Callable[..., Any]) -> None:
        self._device = device
        self._lies = lies

    def __getattr__(self, name: str) -> Any:
        return self._lies.get(name) or getattr(self._device, name)


def _told(state: AxisState, off_deg: float) -> AxisState:
    return replace(state, position_deg=state.position_deg + off_deg)


def _axis_laws(axis: Any, bench: Any) -> None:
    keep_axis_promises(axis, bench.clock, target_deg=-30.0, beyond_deg=181.0, close_deg=0.1, others={})


def test_a_sound_axis_keeps_them() -> None:
    bench = motion_bench("zaber")
    _axis_laws(bench.pitch, bench)
    keep_rate_promises(bench.pitch, bench.clock)


@pytest.mark.parametrize(
    ("lie", "sentence"),
    [
        (lambda a: {"check_target": lambda deg: None}, r"181\.0°: it is not refused"),
        (lambda a: {"stop": lambda: None}, "after a stop|let it arrive"),
        (lambda a: {"identify": iter(range(99)).__next__}, "one thing, then another"),
        (
            lambda a: {"state": lambda: _told(a.state(), 1.0)},
            "came to rest at -29°, allowed within",
        ),
    ],
)
def test_an_axis_that_lies_is_named(lie: Callable[[Any], dict[str, Callable[..., Any]]], sentence: str) -> None:
    bench = motion_bench("zaber")
    with pytest.raises(Exception, match=sentence):
        _axis_laws(Lying(bench.pitch, **lie(bench.pitch)), bench)


@pytest.mark.parametrize(
    ("lie", "sentence"),
    [
        (
            lambda a: {"start_rate": lambda dps: a.start_rate(0.9 * dps) if a.check_rate(dps) is None else None},
            "rate: got",
        ),
        (lambda a: {"turn_look": lambda c: _wrapped(a.turn_look(c))}, "rate: got|does not go on"),
        (lambda a: {"check_rate": lambda dps: None}, "it is not refused"),
    ],
)
def test_a_rate_axis_that_lies_is_named(lie: Callable[[Any], dict[str, Callable[..., Any]]], sentence: str) -> None:
    bench = motion_bench("zaber")
    bench.home_all()
    with pytest.raises(AssertionError, match=sentence):
        keep_rate_promises(Lying(bench.pitch, **lie(bench.pitch)), bench.clock)  # type: ignore[arg-type]


def _wrapped(look: TurnLook) -> TurnLook:
    return TurnLook(look.angle_deg % 360.0, look.taken_s, look.uncertainty_s)


@pytest.fixture
def rig(tmp_path: Path) -> Any:
    with rig_on("memory", daq_and_f4t_rig_file(tmp_path)) as opened:
        yield opened


@pytest.mark.parametrize("key", ["axes.pitch", "readouts.dmm", "environment.air", "streams.imu", "streams.board"])
def test_every_device_of_a_rig_file_is_held_to_its_own(rig: Rig, key: str) -> None:
    keep_promises(rig, key, sets_speed=False)  # its table has no command for it


@pytest.mark.parametrize(
    ("table", "name", "lie", "sentence"),
    [
        ("environments", "air", lambda d: {"hold": lambda degc: None}, "it is not refused"),
        ("environments", "air", lambda d: {"setpoint_degc": lambda: 3.0}, "set point: got 3"),
        ("readouts", "dmm", lambda d: {"reading_s": lambda nplc=None: 9.0}, "seconds between readings"),
        ("readouts", "dmm", lambda d: {"identify": iter("abc").__next__}, "identity changes"),
        ("streams", "imu", lambda d: {"units": dict.fromkeys(d.channels, "furlong")}, "a unit is none of"),
    ],
)
def test_an_instrument_that_lies_is_named(rig: Rig, table: str, name: str, lie: Any, sentence: str) -> None:
    devices = getattr(rig, table)
    devices[name] = Lying(devices[name], **lie(devices[name]))
    key = {"environments": "environment"}.get(table, table)
    with pytest.raises(AssertionError, match=sentence):
        keep_promises(rig, f"{key}.{name}")


def test_a_table_that_is_none_is_named(rig: Rig) -> None:
    with pytest.raises(AssertionError, match="no table 'ovens'"):
        keep_promises(rig, "ovens.air")


def test_a_driver_that_believes_damage_is_named(tmp_path: Path) -> None:
    believed = iter([20.0] + [25.0, 99.0] * 99)
    with pytest.raises(AssertionError, match=r"environment\.air: drop: it tells 25, right is 20"):
        survive_damage(EXAMPLE_RIG, "environment.air", lambda rig: next(believed), 1e-9)
    survive_damage(EXAMPLE_RIG, "environment.air", lambda rig: rig.environments["air"].setpoint_degc(), 1e-9)


@pytest.mark.parametrize("model", ["thermotron_8800", "thermotron_3800", "espec_p300"])
def test_chambers_of_text_survive_damage(tmp_path: Path, model: str) -> None:
    path = text_chambers_rig_file(tmp_path)
    survive_damage(path, f"environment.{model}", lambda rig: rig.environments[model].setpoint_degc(), 1e-9)


def test_the_rig_is_whole_afterwards(tmp_path: Path) -> None:
    with open_rig(read_rig(EXAMPLE_RIG)) as rig:
        keep_promises(rig, "environment.air")
        keep_promises(rig, "environment.air")
