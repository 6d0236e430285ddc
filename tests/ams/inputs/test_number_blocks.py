"""The quick reader says what the careful one says, bit for bit and line for line, or leaves it to that one."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ams.errors import ObservationsError
from ams.inputs import number_blocks
from ams.inputs.csv_table import numbers, parse_csv
from ams.inputs.number_blocks import csv_blocks, numbers_of, parquet_blocks, read_numbers

CELLS = st.one_of(
    st.floats().map(repr),
    st.sampled_from(["", "1e", "1e5", ".5", "5.", ".", "+1", "--1", " 1 ", "inf", "nan", "NA", "0x1", "1_0", "1d3",
                     "\t7", "True", '"3"', '"3', "1e400", "1e-400", "9" * 40, "e5", "1 2", "null", "1.2.3", "+.e1"]),
    st.text("0123456789.eE+- \t", max_size=8),
)  # fmt: skip
BODIES = st.lists(st.lists(CELLS, min_size=1, max_size=4).map(",".join), min_size=1, max_size=4).map("\n".join)


@settings(max_examples=100, deadline=None)
@given(body=BODIES, columns=st.integers(1, 3), ending=st.sampled_from(["", "\n", "\r\n", "\n\n"]))
def test_what_the_quick_reader_takes_the_careful_one_takes_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, body: str, columns: int, ending: str
) -> None:
    names = ("a", "b", "c")[:columns]
    piece = (body + ending).encode()
    quick = numbers_of(piece, names, names)
    if quick is None:
        return
    path = tmp_path_factory.getbasetemp() / "quick.csv"
    path.write_bytes(",".join(names).encode() + b"\n" + piece)
    table = parse_csv(path)
    for name in names:
        np.testing.assert_array_equal(quick[name], numbers(table, name))


def rows(count: int) -> list[str]:
    chance = np.random.default_rng(4)
    return [",".join(map(repr, row)) for row in chance.normal(size=(count, 3)).tolist()]


@pytest.fixture
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let everything be read in pieces of a few lines."""
    monkeypatch.setattr(number_blocks, "PIECE_BYTES", 700)
    monkeypatch.setattr(number_blocks, "SMALL_BYTES", 0)


def written(path: Path, lines: list[str], end: str = "\n") -> Path:
    path.write_bytes((end.join(["a,b,c", *lines]) + end).encode())
    return path


@pytest.mark.parametrize(
    ("location", "odd"), [(0, '"1.0",2,3'), (57, "1.0,2,3\n\n"), (99, ' 1.0,"2" ,3'), (None, ""), (20, "\n\n1,2,3")]
)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.usefixtures("small_pieces")
def test_a_file_in_pieces_is_the_file(tmp_path: Path, location: int | None, odd: str, end: str) -> None:
    lines = rows(100)
    if location is not None:
        lines[location] = odd.replace('"2" ', '"2"').replace("\n", end)
    path = written(tmp_path / "f.csv", lines, end)
    table, found = parse_csv(path), read_numbers(path, ("c", "a"))
    for name in "ac":
        np.testing.assert_array_equal(found.values[name], numbers(table, name))
        together = np.concatenate([piece[name] for piece in csv_blocks(path, ("c", "a"))])
        np.testing.assert_array_equal(together, found.values[name])
    assert found.lines.tolist() == list(table.lines)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ("1,nan,3", "line 82: column b: got 'nan', allowed a finite number"),
        ("1,2", "line 82: 2 cells, allowed 3"),
        ("1,2,3,4\n1,2", "line 82: 4 cells, allowed 3"),
        ("1,2\n1,2,3,4", "line 82: 2 cells, allowed 3"),
        ("1,,3", "line 82: column b: the cell is empty"),
        ("1,\u0661,3", "line 82: column b: got '\u0661'"),
        ("1,1_0,3", "line 82: column b: got '1_0'"),
    ],
)
@pytest.mark.usefixtures("small_pieces")
def test_a_wrong_line_far_down_is_told_with_its_own_number(tmp_path: Path, wrong: str, sentence: str) -> None:
    lines = rows(100)
    lines[80] = wrong
    path = written(tmp_path / "f.csv", lines)
    with pytest.raises(ObservationsError, match=sentence):
        read_numbers(path, ("b",))
    if wrong not in {"1,nan,3", "1,,3"}:
        with pytest.raises(ObservationsError, match=sentence.partition(", allowed a finite")[0]):
            list(csv_blocks(path, ("b",)))


@pytest.mark.parametrize("cell", ["", "nan", "NaN", "NAN", "inf", "-Inf", "Infinity", " ", " nan "])
@pytest.mark.parametrize("size", ["small", "large"])
def test_what_is_missing_in_csv_is_no_number_in_rows_that_become_angles(
    tmp_path: Path, cell: str, size: str, request: pytest.FixtureRequest
) -> None:
    """As in Parquet and HDF5; a table of observations is refused. A line without anything is no row in both ways."""
    if size == "large":
        request.getfixturevalue("small_pieces")
    lines = rows(100)
    first, _, third = lines[80].split(",")
    lines[80] = f"{first},{cell},{third}"
    lines.insert(40, ",,")
    path = written(tmp_path / "f.csv", lines)
    found = {name: np.concatenate([piece[name] for piece in csv_blocks(path, ("b", "c"))]) for name in "bc"}
    assert np.flatnonzero(np.isnan(found["b"])).tolist() == [80]
    assert np.isfinite(found["c"]).all()
    assert found["c"].size == 100
    with pytest.raises(ObservationsError, match="line 83: column b"):
        read_numbers(path, ("b",))


@pytest.mark.usefixtures("small_pieces")
def test_good_lines_before_a_wrong_one_were_read_quickly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the test above would say nothing about the seam between the two readers."""
    taken = []
    quick = number_blocks.numbers_of
    monkeypatch.setattr(number_blocks, "numbers_of", lambda *a, **k: taken.append(quick(*a, **k)) or taken[-1])
    lines = rows(100)
    lines[80] = "1,,3"
    with pytest.raises(ObservationsError):
        read_numbers(written(tmp_path / "f.csv", lines), ("b",))
    assert sum(entry is not None for entry in taken) >= 5
    assert taken[-1] is None


def test_what_is_missing_in_parquet_is_no_number(tmp_path: Path) -> None:
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    parquet.write_table(
        arrow.table({"a": [1.5, None, 3.0], "n": [1, 2, 3], "w": ["x", "y", "z"]}), tmp_path / "f.parquet"
    )
    (block,) = parquet_blocks(tmp_path / "f.parquet", ("a",), ("n", "t"))
    np.testing.assert_array_equal(block["a"], [1.5, np.nan, 3.0])
    np.testing.assert_array_equal(block["n"], [1.0, 2.0, 3.0])
    with pytest.raises(ObservationsError, match="column w: holds no numbers"):
        list(parquet_blocks(tmp_path / "f.parquet", ("w",)))
    with pytest.raises(ObservationsError, match="column q missing; found: a, n, w"):
        list(parquet_blocks(tmp_path / "f.parquet", ("q",)))
