"""The CSV export as a spreadsheet user and as a foreign program meet it."""

import csv
import hashlib
import io
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from solved import PARAMETERS, provenance, solved_package

from ams.errors import SetError
from ams.exports.csv_text import from_csv, to_csv
from ams.sets.coefficients import CoefficientSet, build_set

TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**6), 10**6) | st.floats(allow_nan=False, allow_infinity=False) | TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXT, inner, max_size=3),
    max_leaves=8,
)


def rows_of(coefficients: CoefficientSet) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(to_csv(coefficients).decode("utf-8"), newline="")))


@pytest.fixture(scope="module")
def rows() -> list[dict[str, str]]:
    return rows_of(build_set(solved_package(), provenance()))


def test_a_coefficient_stands_in_a_row_with_its_unit(rows: list[dict[str, str]]) -> None:
    by_path = {row["path"]: row for row in rows}
    sensitivity = by_path["/axes/x/parameters/sensitivity_v_per_g/value"]
    assert (float(sensitivity["value"]), sensitivity["unit"]) == (PARAMETERS["x"][1], "V/g")
    assert by_path["/axes/y/parameters/coning_deg/standard_uncertainty"]["unit"] == "deg"
    assert by_path["/axes/x/parameters/offset_v/effective_degrees_of_freedom"]["unit"] == "1"
    assert by_path["/axes/x/primary/values/k_y_v_per_g"]["unit"] == "V/g"
    assert by_path["/axes/x/primary/effective_degrees_of_freedom/offset_v"]["unit"] == "1"
    assert by_path["/validity/pitch_deg/[1]"]["unit"] == "deg"
    assert by_path["/acceleration_unit/value_mps2"]["unit"] == "m/s^2"
    assert by_path["/test_vectors/forward/[0]/outputs_v/x"]["unit"] == "V"


def test_no_text_cell_can_be_taken_for_a_formula(rows: list[dict[str, str]]) -> None:
    for row in rows:
        for name, cell in row.items():
            if name != "value" or row["kind"] != "number":
                assert not cell.startswith(("=", "+", "-", "@", "\t", "\r", "\n")), row


def test_numbers_stay_numbers(rows: list[dict[str, str]]) -> None:
    numbers = [row["value"] for row in rows if row["kind"] == "number"]
    assert any(text.startswith("-") for text in numbers)
    assert all(isinstance(float(text), float) for text in numbers)


def test_the_last_line_is_the_checksum_of_everything_above() -> None:
    content = to_csv(build_set(solved_package("x"), provenance()))
    body, last = content[: content.rindex(b"\r\n", 0, -2) + 2], content.splitlines()[-1].decode()
    assert last == f"sha256 of all bytes above this line,text,{hashlib.sha256(body).hexdigest()},"


@given(job=st.dictionaries(TEXT, VALUES, max_size=4))
def test_whatever_is_declared_comes_back(job: dict[str, Any]) -> None:
    coefficients = build_set(solved_package("x"), provenance(job=job))
    assert from_csv(to_csv(coefficients), "file") == coefficients


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "file: is empty"),
        (b"a;b\r\n1;2\r\n", "file: is not a coefficient set as CSV: its first line is b'a;b"),
        (b"path,kind,value,unit\r\n/a,number,1,V\r\n", "file: is truncated or was saved again by another program"),
    ],
)
def test_another_file_is_refused_in_a_sentence(content: bytes, sentence: str) -> None:
    with pytest.raises(SetError, match=sentence):
        from_csv(content, "file")


def sealed_rows(*lines: str) -> bytes:
    body = "".join(f"{line}\r\n" for line in ("path,kind,value,unit", *lines)).encode()
    return body + f"sha256 of all bytes above this line,text,{hashlib.sha256(body).hexdigest()},\r\n".encode()


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        ((), "is not a coefficient set"),
        (("/format,text,plan,",), "is not a coefficient set"),
        (("/format,word,plan,",), "file: row 2: /format: kind: got 'word', allowed are number, text"),
        (("/version,number,one,",), "file: row 2: /version: is no number: got 'one'"),
        (("/version,number",), "file: row 2: has 2 cells, needed are 4"),
        (("/a,number,1,", "/a/b,number,1,"), "file: rows contradict each other"),
        (("/a/[0],number,1,", "/a/b,number,1,"), "file: rows contradict each other"),
        (("/a/[1],number,1,",), "file: rows contradict each other"),
        (("/a/b,number,1,", "/a,number,1,"), "file: rows contradict each other"),
        (("/a,number,1,", "/b,number,1,", "/a,number,1,"), "file: rows contradict each other"),
        (("/a/[x],number,1,",), "is not a coefficient set"),
    ],
)
def test_a_sealed_file_of_other_rows_is_refused_in_a_sentence(lines: tuple[str, ...], sentence: str) -> None:
    with pytest.raises(SetError, match=sentence):
        from_csv(sealed_rows(*lines), "file")
