"""How a TOML file is refused: what stands there twice by file, line, key and the first line, values as written."""

import tomllib
from pathlib import Path

import pytest

from rig import toml_file
from rig.clock import SystemClock
from rig.errors import DescriptionError
from rig.toml_file import TomlFile, as_in_file


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("[a]\nb = 1\nc = 2\nb = 3\n", 4, "a.b: is written twice, first on line 2"),
        ("[a]\nb = 1\nb = 3", 3, "a.b: is written twice, first on line 2"),
        ("[a]\nb = 1\n\n[c]\nd = 1\n[a]\n", 6, "a: is written twice, first on line 1"),
        ("[a]\nb = [1,\n2]\nb = [3,\n4,\n]\n", 4, "a.b: is written twice, first on line 2"),
        ('[a]\n"b c" = 1\n"b c" = 2\n', 3, "a.b c: is written twice, first on line 2"),
        ("[a]\nb.c = 1\nb.c = 2\n", 3, "a.b.c: is written twice, first on line 2"),
        ("[a]\nb = { c = 1, c = 2 }\n", 2, "not valid TOML: Duplicate inline table key 'c'"),
        ("[a]\nb = 1\nc =", 3, "not valid TOML"),
    ],
)
def test_it_is_a_sentence(text: str, line: int, words: str) -> None:
    with pytest.raises(DescriptionError) as refused:
        TomlFile(Path("rig.toml"), text)
    assert str(refused.value).startswith(f"rig.toml:{line}: {words}")


@pytest.mark.parametrize(
    "written", ["true", "'a b'", "[1, 2.5]", "['pitch', false]", "{ a = 1, b = [true] }", "[]", "{}", "2026-03-01"]
)
def test_a_refusal_shows_a_value_as_a_file_has_it(written: str) -> None:
    assert as_in_file(tomllib.loads(f"key = {written}")["key"]) == written


@pytest.mark.parametrize("piece", ["a", "a.", "a .", "x y ", "'\"", "[ "])
def test_a_long_line_takes_time_by_its_length(piece: str) -> None:
    """A line of a megabyte took hours where its time grew by the square."""
    text = f"k = 1\n{piece * 300_000}\n"
    start_s = SystemClock().monotonic_s()
    lines_of_keys = toml_file._lines_of_keys(text)
    assert lines_of_keys[("k",)] == 1
    assert SystemClock().monotonic_s() - start_s < 5.0


def test_a_text_that_looks_like_a_key_is_none() -> None:
    found = toml_file._lines_of_keys('[a.b]\nx = { y = 1, z.w = "p = q" }\n"q r".s = 2\n[[ k ]]\nm=1')
    assert found == {
        ("a", "b"): 1,
        ("a", "b", "x"): 2,
        ("a", "b", "x", "y"): 2,
        ("a", "b", "x", "z", "w"): 2,
        ("a", "b", "q r", "s"): 3,
        ("k",): 4,
        ("k", "m"): 5,
    }
