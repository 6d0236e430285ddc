"""A streaming twin on a line in memory, and a world that moves in a known way."""

import math
from dataclasses import dataclass, field

from gpib_rig import virtual_clock

from rig.clock import VirtualClock
from rig.devices.csv_imu import CsvImu, CsvImuSettings
from rig.devices.csv_imu import connect as connect_csv
from rig.devices.vn100 import Vn100, Vn100Settings
from rig.devices.vn100 import connect as connect_vn100
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.twins.csv_imu import CsvImuTwin
from rig.twins.physics.imu import Motion
from rig.twins.twin import Twin
from rig.twins.vn100 import Vn100Twin
from rig.wire.csv_rows import RowShape


class Swing:
    """Turns about z at 30 sin(2π t / 10) °/s and feels 1 g downwards."""

    def motion(self, stream: str, now_s: float) -> Motion:
        return Motion(rate_dps=(0.0, 0.0, rate_dps(now_s)))


def rate_dps(now_s: float) -> float:
    return 30.0 * math.sin(2.0 * math.pi * now_s / 10.0)


@dataclass
class StreamRig:
    twin: Twin
    clock: VirtualClock = field(default_factory=virtual_clock)
    faults: FaultScript = field(default_factory=FaultScript)

    def __post_init__(self) -> None:
        self.stream = MemoryStream(self.twin, self.clock, "memory", self.faults)

    def vn100(self, **settings: object) -> Vn100:
        return connect_vn100("imu", vn100_settings(**settings), self.stream, self.clock)

    def csv(self, **settings: object) -> CsvImu:
        return connect_csv("imu", csv_settings(**settings), self.stream, self.clock)


def vn100_rig() -> StreamRig:
    return StreamRig(Vn100Twin("imu", Swing()))


def vn100_settings(**changes: object) -> Vn100Settings:
    return Vn100Settings.model_validate({"driver": "vn100", "port": "twin", "baud_rate": 460800} | changes)


COLUMNS = ["n", "t", "ax", "ay", "az", "gz", "mx", "-"]


def csv_settings(**changes: object) -> CsvImuSettings:
    fields: dict[str, object] = {
        "driver": "csv-imu",
        "port": "twin",
        "rate_hz": 100.0,
        "columns": COLUMNS,
        "count": {"column": "n", "wraps_at": 256.0},
        "time": {"column": "t", "wraps_at": 65536.0, "unit_s": 1e-3},
        "channels": {
            **{name: {"preset": "SCA3000"} for name in ("ax", "ay", "az")},
            "gz": {"preset": "ITG-3200"},
            "mx": {"preset": "MicroMag3"},
        },
    }
    return CsvImuSettings.model_validate(fields | changes)


def csv_rig(banner: bytes = b"") -> StreamRig:
    """Counts by the data sheets, written here once more: 1333 per g, 14.375 per °/s, 31.24 per µT."""
    per_unit = {"ax": 1333.0, "ay": 1333.0, "az": 1333.0, "gz": 14.375, "mx": 31.24}
    twin = CsvImuTwin(
        "imu",
        Swing(),
        RowShape(len(COLUMNS)),
        COLUMNS,
        100.0,
        lambda column, value: per_unit.get(column, 0.0) * value,
        count={"n": 256.0},
        time={"t": (65536.0, 1000.0)},
        banner=banner,
    )
    return StreamRig(twin)
