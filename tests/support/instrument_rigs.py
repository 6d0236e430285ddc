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


def daq_and_f4t_rig_file(folder: Path, *, streams: bool = True) -> Path:
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    tables = text.split("\n\n")
    replaced = [
        DAQ if "[readouts.dmm]" in table else CHAMBER if "[environment.air]" in table else table for table in tables
    ]
    path = folder / "wider.toml"
    path.write_text("\n\n".join(replaced) + (STREAMS if streams else ""), encoding="utf-8")
    return path


def meters_rig_file(folder: Path) -> Path:
    """The example rig with a meter of its own for each sensor: readouts ``dmm``, ``second``, ``third``."""
    meter = '[readouts.{name}]\ndriver = "scpi-meter"\nmodel = "{model}"\nresource = "twin"\nnplc = 10.0\n'
    channels = "channels = {{ {axis} = {{ range_v = {range_v} }} }}\n\n"
    kinds = (
        ("dmm", "34401A", "x", 10.0),
        ("second", "keithley-2002", "y", 20.0),
        ("third", "34461A", "z", 10.0),
    )
    meters = "".join(
        (meter + channels).format(name=name, model=model, axis=axis, range_v=range_v)
        for name, model, axis, range_v in kinds
    )
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    tables = [meters.strip() if "[readouts.dmm]" in table else table for table in text.split("\n\n")]
    path = folder / "meters.toml"
    whole = "\n\n".join(tables).replace('"dmm.y"', '"second.y"').replace('"dmm.z"', '"third.z"')
    path.write_text(whole, encoding="utf-8")
    return path


def angle_meter_rig_file(folder: Path, dialect: str = "meas-dpg", more: str = "") -> Path:
    """The example rig with an inclinometer ``level`` that tells the pitch by x and the roll by y."""
    level = f"""
[readouts.level]
driver = "angle-meter"
resource = "twin"
dialect = "{dialect}"
channels = {{ pitch = {{ about = "pitch" }}, roll = {{ about = "roll", value = "y" }} }}
{more}
[twin.readouts.level]
noise_deg = 0.002
"""
    path = folder / "level.toml"
    path.write_text(EXAMPLE_RIG.read_text(encoding="utf-8") + level, encoding="utf-8")
    return path


def text_chambers_rig_file(folder: Path) -> Path:
    """The example rig in four chambers that speak lines of text, one of each model."""
    models = ("thermotron-8800", "thermotron-3800", "espec-p300", "espec-scp220")
    chamber = '[environment.{name}]\ndriver = "ascii-chamber"\nport = "twin"\nmodel = "{model}"\nvalues = "degc"\n'
    chambers = "".join(chamber.format(name=model.replace("-", "_"), model=model) for model in models)
    path = folder / "chambers.toml"
    path.write_text(EXAMPLE_RIG.read_text(encoding="utf-8") + "\n" + chambers, encoding="utf-8")
    return path


def rate_tables_rig_file(folder: Path) -> Path:
    """The example rig with rate tables that speak lines beside its own axes, one of each dialect, and a GCS stage."""
    table = '[axes.{name}]\ndriver = "rate-table"\nport = "twin"\ndialect = "{dialect}"\n' + (
        "limits_deg = [-180.0, 180.0]\nspeed_dps = 20.0\ntop_rate_dps = 100.0\n"
    )
    dialects = ("generic-rate-table", "ideal-aerosmith-1270vs", "acutronic-acutrol3000")
    tables = "".join(table.format(name=f"table_{n}", dialect=dialect) for n, dialect in enumerate(dialects))
    tables += (
        '[axes.stage]\ndriver = "pi-gcs"\nport = "twin"\nlimits_deg = [-90.0, 90.0]\nspeed_dps = 5.0\naxis_id = "A"\n'
    )
    path = folder / "rate-tables.toml"
    path.write_text(EXAMPLE_RIG.read_text(encoding="utf-8") + "\n" + tables, encoding="utf-8")
    return path
