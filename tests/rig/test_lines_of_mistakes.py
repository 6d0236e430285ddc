"""Mistakes of a TOML file that were told at the wrong place, in the wrong words, or without what to do."""

from pathlib import Path

import pytest
from pydantic import Field

from rig.errors import DescriptionError
from rig.toml_file import StrictTable, read_toml


class Plateau(StrictTable):
    """A table in a table, with a key in a unit."""

    soak_s: float = 0.0
    speed_dps: float = 1.0


class Whole(StrictTable):
    """A whole file."""

    title: str = ""
    gravity_mps2: float = 9.8
    environment: dict[str, Plateau] = Field(default_factory=dict)


def _refusal(folder: Path, text: str) -> str:
    (folder / "file.toml").write_text(text, encoding="utf-8")
    with pytest.raises(DescriptionError) as refused:
        read_toml(folder / "file.toml").validate(Whole)
    return str(refused.value).removeprefix(f"{folder}/")


def test_an_unknown_table_that_has_only_a_dotted_head_is_told_where_that_head_stands(tmp_path: Path) -> None:
    text = 'title = "a"\n' + "\n" * 70 + "[enviroment.box]\nsoak_s = 1.0\n"
    assert _refusal(tmp_path, text).startswith("file.toml:72: enviroment: unknown key; did you mean environment?")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("gravity_mps2 = 9,8078 # here", "gravity_mps2: got 9,8078, allowed is a number with a decimal point"),
        ('title = "a"\n\n[environment.box]\nsoak_s = -1,5', "environment.box.soak_s: got -1,5, allowed is a number"),
        ("environment = { box = { soak_s = 1,5 } }", "soak_s: got 1,5, allowed is a number with a decimal point"),
        ("environment = { box = { soak_s = 1,5e3, speed_dps = 2.0 } }", "soak_s: got 1,5e3, allowed"),
    ],
)
def test_a_decimal_comma_is_told_with_its_key_and_what_to_write(tmp_path: Path, text: str, said: str) -> None:
    refusal = _refusal(tmp_path, f"{text}\n")
    line = 1 + text.count("\n")
    assert refusal.startswith(f"file.toml:{line}: {said}")
    number = said.split("got ")[1].split(", allowed")[0]
    assert refusal.endswith(f"nothing was read; write {number.replace(',', '.')}")


def test_a_file_that_is_wrong_in_another_way_is_told_no_decimal_comma(tmp_path: Path) -> None:
    assert "not valid TOML" in _refusal(tmp_path, 'title = "1,5\n')
    assert "decimal" not in _refusal(tmp_path, 'title = "x = 1,5" 2\n')


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("soak_h", "did you mean soak_s? It is in s and not in h: convert the value (allowed"),
        ("soak_min", "did you mean soak_s? It is in s and not in min: convert the value (allowed"),
        ("sooak_s", "did you mean soak_s? (allowed"),
    ],
)
def test_a_key_in_another_unit_is_told_with_the_unit_that_is_wanted(tmp_path: Path, key: str, said: str) -> None:
    assert f"environment.box.{key}: unknown key; {said}" in _refusal(tmp_path, f"[environment.box]\n{key} = 0.25\n")
