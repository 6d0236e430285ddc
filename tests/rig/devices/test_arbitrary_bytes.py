"""Whatever the other side says: a value that could be one, or an error of the rig, within its deadlines.

Axes have the same law in their conformance suite.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

import pytest
from daq_rig import daq_settings
from gpib_rig import meter_settings
from hypothesis import given, settings
from hypothesis import strategies as st
from meter_rig import meter_settings as meter_of
from stream_rig import csv_settings, vn100_settings
from table_bench import virtual_clock

from rig.clock import VirtualClock
from rig.description.drivers import settings_classes
from rig.devices import csv_imu, vn100, watlow_f4, watlow_f4t
from rig.devices.angle_meter import AngleMeter, AngleMeterSettings
from rig.devices.ascii_chamber import AsciiChamber, AsciiChamberSettings
from rig.devices.hp3458a import Hp3458aReadout
from rig.devices.scpi_daq import ScpiDaqReadout
from rig.devices.scpi_meter import ScpiMeter
from rig.devices.watlow_f4 import WatlowF4Settings
from rig.devices.watlow_f4t import WatlowF4TSettings
from rig.errors import RigError
from rig.link.byte_stream import ByteStream
from rig.link.memory import MemoryStream
from rig.link.messages import StreamMessages
from rig.link.prologix import PrologixBus
from rig.wire.angle_dialect import load_angle_dialect

LONGEST_S = 900.0
"""Of virtual time: no driver asks longer, however often it repeats."""


@dataclass
class Babbler:
    """Says the next of ``replies`` to whatever it hears, the first again behind the last."""

    replies: list[bytes]
    _due: bytes = b""
    _said: int = field(default=0)

    def receive(self, data: bytes, now_s: float) -> None:
        self._due += self.replies[self._said % len(self.replies)]
        self._said += 1

    def transmit(self, now_s: float) -> bytes:
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None


Work = Callable[[ByteStream, VirtualClock], object]


def _meter(line: ByteStream, clock: VirtualClock) -> None:
    readout = Hp3458aReadout("dmm", meter_settings(), PrologixBus(line), clock)
    readout.prepare()
    readout.read("dmm.x", 2, clock.sleep)


def _daq(line: ByteStream, clock: VirtualClock) -> None:
    readout = ScpiDaqReadout("daq", daq_settings(), StreamMessages(line), clock)
    readout.prepare()
    readout.read("daq.x", 2, clock.sleep)


def _meter_of_its_own(model: str) -> Work:
    def work(line: ByteStream, clock: VirtualClock) -> None:
        meter = ScpiMeter("dmm", meter_of(model), StreamMessages(line), clock)
        meter.prepare()
        meter.read("dmm.x", 2, clock.sleep)

    return work


def _f4(line: ByteStream, _clock: VirtualClock) -> None:
    air = watlow_f4.connect("air", WatlowF4Settings(driver="watlow-f4", port="line"), line)
    assert -100.0 <= air.temperature_degc() <= 200.0
    air.hold(20.0)


def _f4t(transport: str) -> Work:
    def work(line: ByteStream, _clock: VirtualClock) -> None:
        table = {"driver": "watlow-f4t", "port": "line", "transport": transport}
        air = watlow_f4t.connect("air", WatlowF4TSettings.model_validate(table), line)
        assert -100.0 <= air.temperature_degc() <= 250.0
        air.hold(20.0)

    return work


def _vn100(line: ByteStream, clock: VirtualClock) -> None:
    stream = vn100.connect("imu", vn100_settings(), line, clock)
    stream.start()
    stream.poll()


def _csv(line: ByteStream, clock: VirtualClock) -> None:
    stream = csv_imu.connect("board", csv_settings(), line, clock)
    stream.start()
    line.write(b"?")
    stream.poll()


def _ascii(model: str) -> Work:
    def work(line: ByteStream, _clock: VirtualClock) -> None:
        table = {"driver": "ascii-chamber", "port": "line", "model": model, "values": "degc"}
        air = AsciiChamber("air", AsciiChamberSettings.model_validate(table), line)
        assert -100.0 <= air.temperature_degc() <= 250.0
        air.hold(20.0)

    return work


def _angles(dialect: str) -> Work:
    def work(line: ByteStream, clock: VirtualClock) -> None:
        table = {"driver": "angle-meter", "resource": "line", "dialect": dialect, "channels": {"x": {"about": "pitch"}}}
        settings = AngleMeterSettings.model_validate(table)
        level = AngleMeter("level", settings, load_angle_dialect(dialect), line, clock)
        level.prepare()
        level.read("level.x", 2, clock.sleep)

    return work


WORK: dict[str, Work] = {
    "angle-meter": _angles("meas-dpg"),
    "angle-meter, unit asked": _angles("newport-lds1000"),
    "hp3458a": _meter,
    "scpi-daq": _daq,
    "scpi-meter": _meter_of_its_own("34401A"),
    "scpi-meter, keithley": _meter_of_its_own("keithley-2000"),
    "ascii-chamber": _ascii("thermotron-8800"),
    "ascii-chamber, espec": _ascii("espec-p300"),
    "watlow-f4": _f4,
    "watlow-f4t": _f4t("tcp"),
    "watlow-f4t, rtu": _f4t("rtu"),
    "vn100": _vn100,
    "csv-imu": _csv,
}


def test_every_driver_but_those_of_axes_and_people_is_held_to_it() -> None:
    devices = {*settings_classes("readouts"), *settings_classes("environments"), *settings_classes("streams")}
    assert {name.partition(",")[0] for name in WORK} == devices


LIKELY = st.sampled_from(
    [b"0\r\n", b"1\r\n", b'+0,"No error"\n', b'0,"NO ERROR"\r\n', b"HP3458A\r\n", b"\x01\x03\x02\x00\xfd\x79\xc5"]
)
"""What comes further than noise does."""


@pytest.mark.parametrize("driver", sorted(WORK))
@settings(max_examples=60, deadline=None)
@given(replies=st.lists(st.one_of(st.binary(max_size=40), LIKELY), min_size=1, max_size=12))
def test_arbitrary_replies_end_in_an_error_of_the_rig_or_a_value_that_could_be_one(
    driver: str, replies: list[bytes]
) -> None:
    clock = virtual_clock()
    with suppress(RigError):
        WORK[driver](MemoryStream(Babbler(replies), clock, "line"), clock)
    assert clock.monotonic_s() < LONGEST_S
