"""A driver that is no part of the package keeps what the package's own promise (examples/own_driver).

The laws of its ability: test_own_devices.py.
"""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from command import call
from installed_examples import install_example
from table_bench import rig_file, virtual_clock

from rig.assembly.open_rig import Rig, open_rig
from rig.clock import VirtualClock
from rig.description.fault_plan import FaultPlan, FaultRule
from rig.description.read import read_rig
from rig.errors import DescriptionError, DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent, RequestRefused
from rig.link.exchange import Exchange
from rig.link.memory import MemoryStream
from rig.testing import LINES, rig_on

IN_THE_FILE = ('driver = "watlow-f4"', 'driver = "oven"\nlimits_degc = [-40.0, 85.0]')


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install_example("own_driver", tmp_path / "site", monkeypatch)


def test_before_it_is_installed_nobody_knows_it(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="got 'oven'"):
        read_rig(rig_file(tmp_path, IN_THE_FILE))


@pytest.fixture(params=LINES)
def rig(request: pytest.FixtureRequest, tmp_path: Path, installed: None) -> Iterator[Rig]:
    with rig_on(str(request.param), rig_file(tmp_path, IN_THE_FILE)) as opened:
        yield opened


def test_it_keeps_the_promises_of_an_environment(rig: Rig) -> None:
    air = rig.environments["air"]
    assert air.identify() == "OVEN-3 SN 17"
    assert air.temperature_degc() == pytest.approx(20.0, abs=0.5)
    before_degc = air.setpoint_degc()
    for wrong_degc in (-41.0, 86.0, float("nan"), 21.005):
        with pytest.raises(RequestRefused, match=r"air: setpoint"):
            air.hold(wrong_degc)
    assert air.setpoint_degc() == before_degc
    air.hold(21.5)
    assert air.setpoint_degc() == 21.5
    rig.clock.sleep(60.0)  # 0.05 °C/s
    assert air.temperature_degc() == pytest.approx(21.5, abs=0.2)
    air.hold(-12.5)
    assert air.setpoint_degc() == -12.5


@pytest.mark.parametrize("kind", ["truncate", "flip-bit", "echo", "stale", "drop", "previous"])
def test_a_damaged_answer_is_asked_again_and_never_a_wrong_number(tmp_path: Path, installed: None, kind: str) -> None:
    keys = {"truncate": {"keep": 9}, "stale": {"text": "TEMP +099.99"}, "flip-bit": {"byte": 7, "bit": 6}}
    rule = FaultRule(line="environment.air", kind=kind, every=3, **keys.get(kind, {}))  # type: ignore[arg-type]
    with open_rig(read_rig(rig_file(tmp_path, IN_THE_FILE)), faults=FaultPlan(fault={"it": rule})) as rig:
        told_degc = [rig.environments["air"].temperature_degc() for _ in range(9)]
    assert told_degc == pytest.approx([20.0] * 9, abs=0.5)


class _Says:
    """A line whose other side says the same to every question."""

    def __init__(self, reply: bytes) -> None:
        self._reply = reply
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self._due = self._reply

    def transmit(self, now_s: float) -> bytes:
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None


@pytest.mark.parametrize(
    ("reply", "error"),
    [
        (b"TEMP +923.45\r\n", DeviceFault),
        (b"ERR 1\r\n", DeviceRefused),
        (b"TEMP 23.45\r\n", DeviceNonsense),
        (b"TEMP +023.4\r\n", DeviceNonsense),
        (b"SET +023.45\r\n", DeviceNonsense),
        (b"TEMP +023.45\r\nTEMP +023.45\r\n", DeviceNonsense),
        (b"TEMP +023.45", DeviceSilent),
    ],
)
@pytest.mark.usefixtures("installed")
def test_what_is_no_answer_is_none(reply: bytes, error: type[Exception]) -> None:
    driver = import_module("oven_driver.device")
    settings = driver.OvenSettings(driver="oven", port="twin")
    clock: VirtualClock = virtual_clock()
    oven = driver.Oven("air", settings, Exchange(MemoryStream(_Says(reply), clock, "oven")))
    with pytest.raises(error):
        oven.temperature_degc()
    assert clock.monotonic_s() < 60.0, "no wait beyond the deadlines"


def test_the_command_knows_it(tmp_path: Path, installed: None, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "devices", "--rig", rig_file(tmp_path, IN_THE_FILE))
    assert outcome.status == 0
    assert "environment.air: OVEN-3 SN 17" in outcome.out
