"""Columns of numbers from an HDF5 file of any size, piece by piece: one data set of one dimension for each column.

The data sets stand together, at the root or in any one group; that group is found by the columns that are wanted.
"""

from collections.abc import Iterator, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ams.errors import ObservationsError
from ams.inputs.csv_table import SOLVING, Remedies
from ams.inputs.number_blocks import PIECE_ROWS, Block, csv_blocks, parquet_blocks, refuse_missing_names


def blocks_of(
    path: Path, wanted: Sequence[str], optional: Sequence[str] = (), remedies: Remedies = SOLVING
) -> Iterator[Block]:
    """Yield columns of a file piece by piece: Parquet and HDF5 by their names' ends, every other as CSV.

    Raises: ObservationsError, at the piece that is wrong.
    """
    readers = {".parquet": parquet_blocks, ".h5": hdf5_blocks, ".hdf5": hdf5_blocks}
    yield from readers.get(path.suffix, csv_blocks)(path, wanted, optional, remedies)


def hdf5_blocks(
    path: Path, wanted: Sequence[str], optional: Sequence[str] = (), remedies: Remedies = SOLVING
) -> Iterator[Block]:
    """Yield columns of an HDF5 file piece by piece; what is missing in it is NaN.

    Raises: ObservationsError for a file that is none, a column that is missing, or columns of other lengths.
    """
    if find_spec("h5py") is None:
        raise ObservationsError("HDF5: the library h5py is not installed; install calrig[export], or use CSV")
    library = import_module("h5py")
    try:
        file = library.File(path, "r")
    except OSError as error:
        raise ObservationsError(f"{path}: cannot be read as HDF5: {str(error).splitlines()[0]}") from error
    with file:
        columns = _columns_of(file, library, path, wanted, remedies)
        names = list(dict.fromkeys((*wanted, *(name for name in optional if name in columns))))
        lengths = {name: len(columns[name]) for name in names}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{name} {count}" for name, count in lengths.items())
            raise ObservationsError(f"{path}: the columns are of different lengths: {listed}; {remedies.not_done}")
        for start in range(0, lengths[names[0]], PIECE_ROWS):
            rows = slice(start, start + PIECE_ROWS)
            yield {name: np.asarray(columns[name][rows], dtype=float) for name in names}


def _columns_of(file: Any, library: Any, path: Path, wanted: Sequence[str], remedies: Remedies) -> dict[str, Any]:
    """Return the columns of the group that has all that are wanted, the root first. Raises: ObservationsError."""
    groups = [file]
    file.visititems(lambda _, item: groups.append(item) if isinstance(item, library.Group) else None)
    found = [{name: item for name, item in group.items() if _is_column(item, library)} for group in groups]
    for columns in found:
        if all(name in columns for name in wanted):
            return columns
    best = max(found, key=lambda columns: sum(name in columns for name in wanted))
    refuse_missing_names(path, wanted, tuple(best), remedies)
    return best


def _is_column(item: Any, library: Any) -> bool:
    return isinstance(item, library.Dataset) and item.ndim == 1 and item.dtype.kind in "fiu"
