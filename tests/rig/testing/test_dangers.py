"""The laws of danger: every driver of calrig keeps them, and each way of breaking one is named."""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from motion_bench import DRIVERS, settings_of
from table_bench import example_rig
from turner_rig import turner_rig

from rig.abilities.abilities import AxisState, StopStep
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.devices.pi_gcs import PiGcsAxis
from rig.testing.axis_bench import AxisBench
from rig.testing.dangers import keep_axis_safe

WITHOUT_SPEED = {"manual", "indexing-table"}
"""An operator, and a dialect that has no command for it."""
ENDS_DEG = (-30.0, 30.0)
GOES_ON = "stop_steps .*(do not bring it to rest|let it arrive)"


def _rig(driver: str) -> RigDescription:
    return example_rig().model_copy(update={"axes": settings_of(driver)})


@pytest.mark.parametrize("driver", sorted(DRIVERS))
def test_every_driver_of_calrig_keeps_them(driver: str) -> None:
    keep_axis_safe(_rig(driver), "pitch", ENDS_DEG, 0.1, sets_speed=driver not in WITHOUT_SPEED)


def test_the_line_they_break_is_the_axis_own() -> None:
    """A bench whose line loses nothing proves nothing: a homed stage says its state, then takes the move."""
    with AxisBench(_rig("zaber"), "pitch") as bench:
        bench.axis.home()
        bench.clock.sleep(60.0)
        bench.line.heard, before = 0, bench.starts
        bench.axis.start_move(30.0)
        assert bench.line.heard >= 2
        assert bench.starts == before + 1


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RigDescription:
    return read_rig(turner_rig(tmp_path, monkeypatch))


def _steps(command: int, value: int = 0, beside: int = 0) -> Callable[[Any], tuple[StopStep, ...]]:
    """Return stop_steps of other bytes than a stop of this drive."""

    def told(axis: Any) -> tuple[StopStep, ...]:
        codec = import_module("turner.codec")
        return (StopStep(codec.encode(codec.Frame(axis._settings.axis + beside, command, value))),)

    return told


def _always_homed(state: Callable[[Any], AxisState]) -> Callable[[Any], AxisState]:
    return lambda axis: replace(state(axis), is_homed=True)


def _asks_again(ask: Callable[..., Any]) -> Callable[..., Any]:
    return lambda axis, command, value=0, *, idempotent=True: ask(axis, command, value, idempotent=True)


def _constant(member: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    return lambda _sound: member


MUTANTS: dict[str, tuple[str, Callable[[Callable[..., Any]], Callable[..., Any]], str]] = {
    "another motor's stop": (
        "stop_steps",
        _constant(_steps(3, beside=1)),
        GOES_ON,
    ),
    "a move for a stop": ("stop_steps", _constant(_steps(1, 9)), "sent at rest moved it"),
    "a home for a stop": ("stop_steps", _constant(_steps(4)), "sent at rest moved it"),
    "a word that it does not know": (
        "stop_steps",
        _constant(_steps(99)),
        GOES_ON,
    ),
    "a stop waits for silence": (
        "stop",
        _constant(lambda axis: axis._ask(3)),
        "its stop was not sent over a line that",
    ),
    "always homed": ("state", _always_homed, "its power failed at 60°, and it says that it is homed: got 25"),
    "a start is repeated": ("_ask", _asks_again, "was started 2 times where one answer was lost, need 1"),
    "the speed is not sent": ("_prepare", _constant(lambda _axis: None), "it does not go at speed_dps = 8"),
}


@pytest.mark.parametrize("mutant", MUTANTS)
def test_each_way_of_breaking_them_is_named(own: RigDescription, mutant: str, monkeypatch: pytest.MonkeyPatch) -> None:
    axis = import_module("turner.device").Turner
    member, broken, sentence = MUTANTS[mutant]
    monkeypatch.setattr(axis, member, broken(getattr(axis, member)))
    with pytest.raises(AssertionError, match=sentence):
        keep_axis_safe(own, "pitch", (60.0, 20.0), 0.1)


def test_an_axis_without_stop_steps_breaks_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(PiGcsAxis, "stop_steps")
    with pytest.raises(AssertionError, match="no stop_steps: nothing stops it when calrig dies"):
        keep_axis_safe(_rig("pi-gcs"), "pitch", ENDS_DEG, 0.1)
