"""Laws of references out of a rig file: dialects and instrument addresses are checked before any port is opened."""

import re
from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG, changed
from table_bench import rig_file

from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.errors import DescriptionError
from rig.wire.table_dialect import shipped_dialects

ROOT = Path(__file__).resolve().parents[3]
SHIPPED = ROOT / "rig" / "dialects" / "dual-axis-1deg.toml"


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("axis = 1", 'axis = 1\ndialect = "nowhere.toml"', r"axes.pitch.dialect: .*nowhere.toml: no such file"),
        ("increment_deg = 1.0", "increment_deg = 0.00003", r"axes.pitch.increment_deg: .*no shipped dialect"),
        ('resource = "twin"', 'resource = "gpib:22"', r"readouts.dmm.resource: .*not a GPIB instrument"),
        ('resource = "twin"', 'resource = "prologix+/dev/x#77"', r"readouts.dmm.resource: .*not a number from 0 to 30"),
    ],
)
def test_what_a_file_points_to_is_checked_with_it(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    path = rig_file(tmp_path, (old, new))
    with pytest.raises(DescriptionError, match=rf"{re.escape(str(path))}:\d+: {sentence}"):
        read_rig(path)


def test_a_dialect_file_lies_beside_the_rig_file(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(SHIPPED.read_text().replace('"ID?"', '"WHO?"'))
    text = rig_file(tmp_path).read_text().replace("increment_deg = 1.0", 'increment_deg = 1.0\ndialect = "own.toml"')
    path = tmp_path / "rig.toml"
    path.write_text(text)
    with open_rig(read_rig(path)) as rig:
        assert rig.axes["pitch"].identify()


def test_a_shipped_dialect_may_be_named(tmp_path: Path) -> None:
    name = "single-axis-0.0001deg"
    assert name in shipped_dialects()
    path = rig_file(tmp_path, ("axis = 1", f'axis = 1\ndialect = "{name}"'))
    assert getattr(read_rig(path).axes["pitch"], "dialect", None) == name


def test_a_range_that_one_g_overloads_is_refused(tmp_path: Path) -> None:
    path = changed(
        EXAMPLE_RIG, "x = { scanner = 1, range_v = 10.0 }", "x = { scanner = 1, range_v = 1.0 }", tmp_path / "r.toml"
    )
    with pytest.raises(
        DescriptionError, match=r"channels\.x\.range_v: got 1 V, but SN1047\.x is declared to make 2\.5 V"
    ):
        read_rig(path)


METER = (
    '[readouts.{name}]\ndriver = "scpi-meter"\nmodel = "34401A"\nresource = "prologix+/dev/x#{address}"\n'
    "channels = {{ v = {{ range_v = 10.0 }} }}\n"
)
CHAMBER = (
    '[environment.{name}]\ndriver = "ascii-chamber"\nmodel = "espec-p300"\nvalues = "degc"\nport = "/dev/x"\n'
    "address = {address}\n"
)
STREAM = '[streams.{name}]\ndriver = "vn100"\nport = "/dev/x{address}"\nbaud_rate = 460800\n'
STAGE = (
    '[axes.{name}]\ndriver = "pi-gcs"\nport = "/dev/x"\naxis = {number}\naxis_id = "A{address}"\n'
    "limits_deg = [-1.0, 1.0]\nspeed_dps = 1.0\n"
)


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        (METER, r"readouts\.second\.resource: prologix\+/dev/x#3 is already readouts\.first; two devices need two"),
        (CHAMBER, r"environment\.second\.port: /dev/x is already environment\.first"),
        (STREAM, r"streams\.second\.port: /dev/x3 is already streams\.first"),
        (STAGE, r"axes\.second\.axis_id: axis 'A3' at /dev/x is already first"),
    ],
)
def test_two_devices_of_one_address_are_refused_with_their_line(tmp_path: Path, table: str, sentence: str) -> None:
    path = tmp_path / "two.toml"

    def written(addresses: tuple[int, int]) -> None:
        tables = (
            table.format(name=name, address=address, number=number)
            for number, (name, address) in enumerate(zip(("first", "second"), addresses, strict=True), start=1)
        )
        path.write_text(EXAMPLE_RIG.read_text(encoding="utf-8") + "\n" + "".join(tables), encoding="utf-8")

    written((3, 3))
    with pytest.raises(DescriptionError, match=rf"two\.toml:\d+: {sentence}"):
        read_rig(path)
    written((3, 4))
    assert read_rig(path)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (
            'terminator = "\\r\\n"',
            'terminator = "\\r\\n"\nline = { baud_rate = 9601 }',
            r"own\.toml:\d+: line\.baud_rate: got 9601",
        ),
        (
            "{target_deg:+09.4f}",
            "{target_deg:+.0f}",
            r"own\.toml:13: move: 0.5° is written .* cannot be parsed back",
        ),
    ],
)
def test_a_dialect_that_no_line_and_no_number_survives_is_refused_with_both_files(
    tmp_path: Path, old: str, new: str, sentence: str
) -> None:
    text = SHIPPED.read_text(encoding="utf-8").replace("increment_deg = 1.0", "increment_deg = 0.5")
    assert old in text
    (tmp_path / "own.toml").write_text(text.replace(old, new), encoding="utf-8")
    path = rig_file(tmp_path, ("axis = 1", 'axis = 1\ndialect = "own.toml"'))
    with pytest.raises(DescriptionError, match=rf"{re.escape(str(path))}:\d+: axes\.pitch\.dialect: .*{sentence}"):
        read_rig(path)
