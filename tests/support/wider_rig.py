"""The example rig with a data-acquisition unit and an F4T chamber in place of its own, and two streams beside."""

from pathlib import Path

from example_files import EXAMPLE_RIG

DAQ = """[readouts.dmm]
driver = "scpi-daq"
model = "34970A"
resource = "twin"
nplc = 10.0
channels = { x = { channel = 101, range_v = 10.0 }, y = { channel = 102, range_v = 10.0 }, z = { channel = 103, range_v = 10.0 } }
"""  # noqa: E501 one line of TOML
CHAMBER = """[environment.air]
driver = "watlow-f4t"
port = "twin"
"""
STREAMS = """
[streams.imu]
driver = "vn100"
port = "twin"
baud_rate = 460800
rate_hz = 200

[streams.board]
driver = "csv-imu"
port = "twin"
rate_hz = 50.0
columns = ["n", "ax", "ay", "az", "gz"]
count = { column = "n", wraps_at = 65536 }

[streams.board.channels]
ax = { preset = "SCA3000" }
ay = { preset = "SCA3000" }
az = { preset = "SCA3000" }
gz = { preset = "ITG-3200" }

[twin.streams.imu]
noise_g = 0.0
"""


def wider_rig_file(folder: Path, *, streams: bool = True) -> Path:
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    tables = text.split("\n\n")
    replaced = [
        DAQ if "[readouts.dmm]" in table else CHAMBER if "[environment.air]" in table else table for table in tables
    ]
    path = folder / "wider.toml"
    path.write_text("\n\n".join(replaced) + (STREAMS if streams else ""), encoding="utf-8")
    return path
