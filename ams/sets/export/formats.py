"""The table of formats, and the two things done with it: export a set, load a set from any of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from ams.errors import SetError
from ams.sets.coefficients import CoefficientSet
from ams.sets.export.csv_text import from_csv, to_csv
from ams.sets.export.json_text import from_json, to_json
from ams.sets.export.matlab import from_matlab, to_matlab
from ams.sets.whole_file import read_whole, write_whole


@dataclass(frozen=True)
class Format:
    """One format: its name on the command line is also the end of its file names."""

    name: str
    to_bytes: Callable[[CoefficientSet], bytes]
    from_bytes: Callable[[bytes, str], CoefficientSet]
    """Content and what to call it in messages. Raises: SetError, VectorsDisagree."""


FORMATS: Mapping[str, Format] = {
    one.name: one
    for one in (
        Format("json", to_json, from_json),
        Format("csv", to_csv, from_csv),
        Format("mat", to_matlab, from_matlab),
    )
}


def export_set(coefficients: CoefficientSet, format_name: str, path: Path) -> None:
    """Write the set whole.

    Raises: SetError for an unknown format, a file name of another format, or a file system that refuses.
    """
    if format_name not in FORMATS:
        raise SetError(
            f"{coefficients.sensor}: export: unknown format: got {format_name!r}, allowed are {', '.join(FORMATS)}; "
            "nothing was written"
        )
    if path.suffix.lower() != f".{format_name}":
        raise SetError(
            f"{path}: export: the name does not end as the format's files do: got {path.suffix!r}, needed "
            f".{format_name} (verify tells formats by it); nothing was written"
        )
    write_whole(path, FORMATS[format_name].to_bytes(coefficients))


def format_of(path: Path) -> Format:
    """The format that a file's name ends in. Raises: SetError where it ends in none."""
    found = FORMATS.get(path.suffix.lower().removeprefix("."))
    if found is None:
        raise SetError(
            f"{path}: is no coefficient set by its name: it ends in {path.suffix!r}, allowed are "
            f"{', '.join('.' + name for name in FORMATS)}; nothing was read"
        )
    return found


def load_set(path: Path) -> CoefficientSet:
    """The set in a file of any format, every check made but the recomputation of the test vectors (``verify``).

    Raises: SetError naming the file, what is wrong with it and what to do.
    """
    return format_of(path).from_bytes(read_whole(path), str(path))
