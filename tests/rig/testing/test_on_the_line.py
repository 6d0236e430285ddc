"""What an axis has sent is lawful by every driver of calrig, and each way of sending wrongly is named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from file_keys import toml_of
from key_jobs import jobs

from rig.devices.abilities import StopStep
from rig.devices.zaber import ZaberAxis, ZaberChain
from rig.testing import keep_promises_on_the_line
from rig.wire import zaber as wire

DRIVERS = ("indexing-table", "esp301", "zaber", "pi-gcs", "rate-table", "oriental-az", "maestro")


def _rig_file(folder: Path, driver: str) -> Path:
    path = folder / "rig.toml"
    path.write_text(toml_of(jobs()[driver].rig), encoding="utf-8")
    return path


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_sound_axis_keeps_them(driver: str, tmp_path: Path) -> None:
    keep_promises_on_the_line(_rig_file(tmp_path, driver), "pitch")


def _steps(text: str) -> Callable[[Any], tuple[StopStep, ...]]:
    return lambda axis: (StopStep(wire.encode_command(wire.Command(axis._settings.axis, 1, text))),)


def _of_the_other_axis(_axis: Any) -> tuple[StopStep, ...]:
    return (StopStep(wire.encode_command(wire.Command(2, 1, "stop"))),)


ASK = ZaberChain.ask


@pytest.mark.parametrize(
    ("of", "member", "wrong", "sentence"),
    [
        (ZaberAxis, "stop_steps", lambda axis: (), "no stop_steps: nobody stops it"),
        (ZaberAxis, "stop_steps", _of_the_other_axis, "they let it arrive|do not end a move"),
        (ZaberAxis, "stop_steps", _steps("move abs 999"), "they send it back"),
        (ZaberAxis, "_prepare", lambda axis: setattr(axis, "speed_dps", 1.0), "speed_dps is 1: is the machine told"),
        (
            ZaberChain,
            "ask",
            lambda chain, device, axis, text, *, idempotent=True: ASK(chain, device, axis, text, idempotent=True),
            "was sent 3 times, need 1",
        ),
    ],
    ids=["none", "of another", "a move", "speed", "repeated"],
)
def test_what_is_sent_wrongly_is_named(
    of: type, member: str, wrong: Any, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(of, member, wrong)
    with pytest.raises(AssertionError, match=sentence):
        keep_promises_on_the_line(_rig_file(tmp_path, "zaber"), "pitch")
