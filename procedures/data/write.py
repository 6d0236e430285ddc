"""The tables of a run as files of other systems, each written whole; no digit of a number is lost in any of them."""

import io
import json
from collections.abc import Callable, Mapping
from pathlib import Path

import pandas as pd

from ams.exports.optional_libraries import library
from ams.whole_file import write_whole
from procedures.data.columns import DATA_VERSION, DWELL, MOMENT, TABLES, TEXT
from procedures.data.run_data import RunData

Tables = Mapping[str, pd.DataFrame]
_VERSION_KEY = "calrig_data_version"
_SHORT = 64


def write_tables(data: RunData, kind: str, folder: Path, *, with_samples: bool) -> list[Path]:
    """Write the tables of a run into a folder that is there, and return the files.

    ``kind`` is one of :data:`FORMATS`. Raises: ams.errors.SetError where the library of a format is not installed;
    ams.errors.WriteFailed.
    """
    tables = {"dwells": data.dwells, "readings": data.readings, "events": data.events}
    if with_samples:
        tables["samples"] = data.samples()
    contents = FORMATS[kind](data, tables)
    for name, content in contents.items():
        write_whole(folder / name, content)
    return [folder / name for name in contents]


def _csv(data: RunData, tables: Tables) -> dict[str, bytes]:
    """Make a file a table, with comma and decimal point, and columns.json, which describes them."""
    files = {f"{name}.csv": _flat(name, table).to_csv(index=False).encode() for name, table in tables.items()}
    described = {
        _VERSION_KEY: DATA_VERSION,
        "run": data.run,
        "tables": {
            name: [{"name": column.name, "kind": column.kind, "meaning": column.meaning} for column in TABLES[name]]
            for name in tables
        },
    }
    return {**files, "columns.json": (json.dumps(described, ensure_ascii=False, indent=1) + "\n").encode()}


def _parquet(data: RunData, tables: Tables) -> dict[str, bytes]:
    """Make a file a table; the number of the dwell is the index again where pandas reads it."""
    arrow = library("pyarrow", f"{data.path}: Parquet")
    parquet = library("pyarrow.parquet", f"{data.path}: Parquet")
    files = {}
    for name, table in tables.items():
        content = arrow.Table.from_pandas(table)
        marked = {**(content.schema.metadata or {}), _VERSION_KEY.encode(): str(DATA_VERSION).encode()}
        memory = io.BytesIO()
        parquet.write_table(content.replace_schema_metadata(marked), memory)
        files[f"{name}.parquet"] = memory.getvalue()
    return files


def _hdf5(data: RunData, tables: Tables) -> dict[str, bytes]:
    """Make one file: a group a table, a dataset a column, short texts as UTF-8 of one length."""
    h5py = library("h5py", f"{data.path}: HDF5")
    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=("earliest", "v110")) as file:
        file.attrs[_VERSION_KEY] = DATA_VERSION
        file.attrs["run"] = data.run
        for name, table in tables.items():
            group = file.create_group(name)
            for column, values in _flat(name, table).items():
                if values.dtype == TEXT:
                    texts = [text.encode() for text in values]
                    longest = max(map(len, texts), default=1)
                    kind = h5py.string_dtype(length=max(1, longest) if longest <= _SHORT else None)
                    group.create_dataset(str(column), data=texts, dtype=kind)
                else:
                    group.create_dataset(str(column), data=values.to_numpy())
    return {"run.h5": memory.getvalue()}


def _xarray(data: RunData, tables: Tables) -> dict[str, bytes]:
    """Make one NetCDF file: dwells along one dimension, channels along the other."""
    library("xarray", f"{data.path}: xarray")
    from procedures.data.dataset import to_dataset

    return {"run.nc": bytes(to_dataset(data.run, tables).to_netcdf(format="NETCDF3_64BIT", engine="scipy"))}


def _flat(name: str, table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with the number of the dwell as its last column, and moments as ISO 8601 text."""
    flat = table.assign(**{DWELL: table.index}) if table.index.name == DWELL else table.copy()
    for column in TABLES[name]:
        if column.kind == MOMENT:
            texts = [moment.isoformat(timespec="microseconds") for moment in flat[column.name]]
            flat[column.name] = pd.Series(texts, index=flat.index, dtype="str")
    return flat


FORMATS: Mapping[str, Callable[[RunData, Tables], dict[str, bytes]]] = {
    "csv": _csv,
    "parquet": _parquet,
    "hdf5": _hdf5,
    "xarray": _xarray,
}
"""Name to what makes its files."""
