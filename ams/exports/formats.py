"""The table of formats, and the two things done with it: export a set, load a set from any of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from ams.errors import SetError
from ams.exports import c_fixed, epics, linear_form
from ams.exports.c_fixed import from_c_fixed, to_c_fixed
from ams.exports.c_header import from_c_header, to_c_header
from ams.exports.csv_text import from_csv, to_csv
from ams.exports.dcc import from_dcc, to_dcc
from ams.exports.epics import from_epics, to_epics
from ams.exports.hdf5 import from_hdf5, to_hdf5
from ams.exports.json_text import from_json, to_json
from ams.exports.linear_form import from_linear_form, to_linear_form
from ams.exports.matlab import from_matlab, to_matlab
from ams.exports.parquet import from_parquet, to_parquet
from ams.sets.coefficients import CoefficientSet
from ams.whole_file import read_whole, write_whole


@dataclass(frozen=True)
class Format:
    """One format, by its name on the command line and in procedure files."""

    name: str
    ending: str
    """Of its files' names: a file is read as the format with the longest ending that fits."""
    to_bytes: Callable[[CoefficientSet], bytes]
    """Raises: SetError where the format has no form of this set."""
    from_bytes: Callable[[bytes, str], CoefficientSet]
    """Content and what to call it in messages. Raises: SetError, VectorsDisagree."""
    loses: str | None = None
    """What the format's own numbers do not hold; the whole set is inside every file all the same."""

    def file_name(self, stem: str) -> str:
        """Such as ``SN1047.fixed.h``."""
        return f"{stem}{self.ending}"


FORMATS: Mapping[str, Format] = {
    one.name: one
    for one in (
        Format("json", ".json", to_json, from_json),
        Format("csv", ".csv", to_csv, from_csv),
        Format("mat", ".mat", to_matlab, from_matlab),
        Format("hdf5", ".h5", to_hdf5, from_hdf5),
        Format("parquet", ".parquet", to_parquet, from_parquet),
        Format("c", ".h", to_c_header, from_c_header),
        Format("c-fixed", ".fixed.h", to_c_fixed, from_c_fixed, c_fixed.LOSES),
        Format("epics", ".db", to_epics, from_epics, epics.LOSES),
        Format("dcc", ".xml", to_dcc, from_dcc),
        Format("linear", ".linear.toml", to_linear_form, from_linear_form, linear_form.LOSES),
    )
}


def export_set(coefficients: CoefficientSet, format_name: str, path: Path) -> None:
    """Write the set whole.

    Raises: SetError for an unknown format, a file name of another format, a set that the format has no form of, or a
    file system that refuses.
    """
    wanted = format_named(format_name, coefficients.sensor)
    if _by_ending(path) is not wanted:
        raise SetError(
            f"{path}: export: the name does not end as the format's files do: got {path.name!r}, needed "
            f"{wanted.ending} (verify tells formats by it); nothing was written"
        )
    write_whole(path, wanted.to_bytes(coefficients))


def format_named(name: str, where: str) -> Format:
    """Raises: SetError for an unknown format."""
    if name not in FORMATS:
        raise SetError(
            f"{where}: export: unknown format: got {name!r}, allowed are {', '.join(FORMATS)}; nothing was written"
        )
    return FORMATS[name]


def format_of(path: Path) -> Format:
    """The format that a file's name ends in. Raises: SetError where it ends in none."""
    found = _by_ending(path)
    if found is None:
        raise SetError(
            f"{path}: is no coefficient set by its name: it ends in {path.suffix!r}, allowed are "
            f"{', '.join(one.ending for one in FORMATS.values())}; nothing was read"
        )
    return found


def _by_ending(path: Path) -> Format | None:
    name = path.name.lower()
    fitting = [one for one in FORMATS.values() if name.endswith(one.ending)]
    return max(fitting, key=lambda one: len(one.ending), default=None)


def load_set(path: Path) -> CoefficientSet:
    """The set in a file of any format, every check made but the recomputation of the test vectors (``verify``).

    Raises: SetError naming the file, what is wrong with it and what to do.
    """
    return format_of(path).from_bytes(read_whole(path), str(path))
