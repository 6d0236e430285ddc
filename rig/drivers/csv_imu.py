"""Boards that send lines of numbers."""

from rig.abilities.abilities import Stream
from rig.clock import Clock
from rig.devices import csv_imu
from rig.devices.csv_imu import CsvImuSettings
from rig.drivers.driver import Driver, StreamDriver
from rig.lines.open_lines import Lines
from rig.twins.csv_imu import CsvImuTwin
from rig.twins.physics.strapped_down import StrappedDown
from rig.twins.twin import Twin


def _open(name: str, settings: CsvImuSettings, lines: Lines, clock: Clock) -> Stream:
    line = lines.stream(
        f"streams.{name}", settings.port, settings.baud_rate, dtr_low=settings.dtr_low, rts_low=settings.rts_low
    )
    return csv_imu.connect(name, settings, line, clock)


def _twin(name: str, settings: CsvImuSettings, source: StrappedDown) -> Twin:
    return CsvImuTwin(
        name,
        source,
        settings.shape(),
        settings.columns,
        settings.rate_hz,
        settings.counts,
        count={settings.count.column: settings.count.wraps_at} if settings.count else {},
        time={settings.time.column: (settings.time.wraps_at, 1.0 / settings.time.unit_s)} if settings.time else {},
        reading=lambda column, at_s: source.reading(f"{name}.{column}", at_s),
    )


DRIVER = Driver("csv-imu", stream=StreamDriver(CsvImuSettings, _open, _twin))
