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
