"""The Parquet export as a query meets it, by pandas and pyarrow alone."""

import io
import json

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from foreign_sets import HOSTILE, hostile
from solved import provenance, solved_package

from ams.errors import SetError, VectorsDisagree
from ams.exports.checksum_inside import CHECKSUM_SLOT, with_checksum_inside
from ams.exports.parquet import from_parquet, to_parquet
from ams.sets.coefficients import CoefficientSet, build_set


@pytest.fixture(scope="module")
def package() -> CoefficientSet:
    return build_set(solved_package(), provenance())


def test_the_rows_alone_reproduce_the_vectors(package: CoefficientSet) -> None:
    rows = pd.read_parquet(io.BytesIO(to_parquet(package))).set_index("path")["number"]
    for index in range(9):
        vector = f"/test_vectors/forward/[{index}]"
        alpha, roll = np.radians(rows[f"{vector}/pitch_deg"]), np.radians(rows[f"{vector}/roll_deg"])
        f = [np.sin(alpha), -np.cos(alpha) * np.sin(roll), -np.cos(alpha) * np.cos(roll)]
        for axis in "xyz":
            values = f"/axes/{axis}/primary/values"
            k = [rows[f"{values}/k_{c}_v_per_g"] for c in "xyz"]
            assert rows[f"{values}/offset_v"] + np.dot(k, f) == pytest.approx(
                rows[f"{vector}/outputs_v/{axis}"], rel=0, abs=2.5e-12
            )


def test_a_number_is_a_double_with_its_unit_and_a_text_is_none(package: CoefficientSet) -> None:
    rows = pd.read_parquet(io.BytesIO(to_parquet(package))).set_index("path")
    assert tuple(rows.loc["/axes/x/parameters/coning_deg/value", ["number", "unit"]]) == (0.5, "deg")
    assert np.isnan(rows.loc["/convention/name", "number"])
    assert rows.loc["/convention/name", "value"] == "TP"
    assert rows["number"].dtype == np.float64


def test_the_metadata_hold_the_whole_document() -> None:
    metadata = pq.read_metadata(io.BytesIO(to_parquet(hostile()))).metadata
    assert json.loads(metadata[b"document_json"])["provenance"]["operator"] == HOSTILE


def resealed(content: bytes, change: pa.Table, version: int = 1) -> bytes:
    old = pq.read_metadata(io.BytesIO(content)).metadata
    file = io.BytesIO()
    with pq.ParquetWriter(file, change.schema, store_schema=False) as writer:
        writer.write_table(change)
        writer.add_key_value_metadata(
            {
                "document_json": old[b"document_json"].decode(),
                "file_format": f"calrig coefficient set as Parquet, version {version}",
                "file_sha256": CHECKSUM_SLOT.decode(),
            }
        )
    return with_checksum_inside(file.getvalue())


def test_a_sealed_file_with_another_number_than_its_document_disagrees(package: CoefficientSet) -> None:
    content = to_parquet(package)
    table = pq.ParquetFile(io.BytesIO(content)).read()
    numbers = table.column("number").to_pylist()
    index = table.column("path").to_pylist().index("/axes/y/primary/values/k_x_v_per_g")
    numbers[index] = np.nextafter(numbers[index], 1.0)
    other = table.set_column(2, "number", pa.array(numbers))
    with pytest.raises(VectorsDisagree, match="file: rows: the file's own are others than those of the document"):
        from_parquet(resealed(content, other), "file")
    assert from_parquet(resealed(content, table), "file") == package


def test_a_file_of_another_layout_is_refused(package: CoefficientSet) -> None:
    content = to_parquet(package)
    table = pq.ParquetFile(io.BytesIO(content)).read()
    with pytest.raises(SetError, match=r"file: file_format: is of another version: got 'calrig .* version 2', this"):
        from_parquet(resealed(content, table, 2), "file")


def test_a_sealed_file_of_other_columns_is_refused(package: CoefficientSet) -> None:
    content = to_parquet(package)
    with pytest.raises(SetError, match="file: has no document_json and rows to read"):
        from_parquet(resealed(content, pa.table({"a": [1.0]})), "file")


def test_another_parquet_file_is_refused() -> None:
    file = io.BytesIO()
    pq.write_table(pa.table({"a": [1.0]}), file)
    with pytest.raises(SetError, match=r"file: checksum: does not fit .* or written by another program"):
        from_parquet(file.getvalue(), "file")
