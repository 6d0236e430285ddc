"""A file that an editor or a spreadsheet of Windows saved, with a byte order mark in front, says what it says."""

from pathlib import Path

import pytest

from rig.description.index_table import read_index_table
from rig.errors import DescriptionError
from rig.toml_file import read_toml, values_in

MARK = b"\xef\xbb\xbf"


def test_a_toml_file_says_the_same_behind_the_mark_and_between_other_line_ends(tmp_path: Path) -> None:
    text = b'# laboratory\n[rig]\nname = "bench"\n\n[axes.pitch]\nspeed_dps = 5.0\n'
    plain, marked = tmp_path / "plain.toml", tmp_path / "marked.toml"
    plain.write_bytes(text)
    for changed in (MARK + text, MARK + text.replace(b"\n", b"\r\n")):
        marked.write_bytes(changed)
        assert read_toml(marked).values == read_toml(plain).values == values_in(changed.decode())
        assert read_toml(marked).where(("axes", "pitch", "speed_dps")) == f"{marked}:6"


def test_a_table_on_the_first_line_has_its_line(tmp_path: Path) -> None:
    path = tmp_path / "marked.toml"
    path.write_bytes(MARK + b"[rig]\nname = 3\n[rig]\n")
    with pytest.raises(DescriptionError, match=r"marked\.toml:3: rig: is written twice, first on line 1"):
        read_toml(path)


def test_a_mark_in_the_middle_is_no_mark(tmp_path: Path) -> None:
    path = tmp_path / "glued.toml"
    path.write_bytes(b"[rig]\n" + MARK + b"name = 3\n")
    with pytest.raises(DescriptionError, match=r"glued\.toml:2: not valid TOML"):
        read_toml(path)


def test_a_list_of_index_errors_is_read_behind_the_mark(tmp_path: Path) -> None:
    rows = b"angle_deg,error_arcsec,uncertainty_arcsec\r\n-180,0.5,0.1\r\n0,0.2,0.1\r\n180,0.5,0.1\r\n"
    for name, content in (("table.csv", rows), ("marked.csv", MARK + rows)):
        (tmp_path / name).write_bytes(content)
    plain, marked = (read_index_table(tmp_path / name, (-180.0, 180.0)) for name in ("table.csv", "marked.csv"))
    assert marked.error_arcsec == plain.error_arcsec
