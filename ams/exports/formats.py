"""The formats that are registered, and the two things done with them: export a set, load a set from any of them.

A format is one file with a :class:`ams.exports.format.Format` and one entry point ``calrig.exports``.
"""

from codecs import BOM_UTF8
from dataclasses import replace
from pathlib import Path

from ams.errors import SetError
from ams.exports.format import Format
from ams.exports.json_text import INTACT
from ams.exports.withdrawn_folder import withdrawn_beside
from ams.registry import Registry
from ams.sets.coefficients import CoefficientSet
from ams.whole_file import read_whole, write_whole

FORMATS: Registry[Format] = Registry("calrig.exports", Format, SetError)


def export_set(coefficients: CoefficientSet, format_name: str, path: str | Path) -> None:
    """Write the set whole.

    Raises: SetWithdrawn; SetError for an unknown format, a file name of another format, a set that the format has no
    form of, or a file system that refuses.
    """
    coefficients.require_standing(f"{path}: export", "nothing was written")
    wanted, path = format_named(format_name, coefficients.sensor), Path(path)
    if _by_ending(path) != wanted:
        raise SetError(
            f"{path}: export: the name does not end as the format's files do: got {path.name!r}, needed "
            f"{wanted.ending} (verify tells formats by it); nothing was written"
        )
    write_whole(path, wanted.to_bytes(coefficients))


def format_named(name: str, where: str) -> Format:
    """Return the format. Raises: SetError for an unknown one."""
    if name not in FORMATS:
        raise SetError(
            f"{where}: export: unknown format: got {name!r}, allowed are {', '.join(FORMATS)}; nothing was written"
        )
    return FORMATS[name]


def format_of(path: Path) -> Format:
    """Return the format that a file's name ends in. Raises: SetError where it ends in none."""
    found = _by_ending(path)
    if found is None:
        raise SetError(
            f"{path}: is no coefficient set by its name: it ends in {path.suffix!r}, allowed are "
            f"{', '.join(form.ending for form in FORMATS.values())}; nothing was read"
        )
    return found


def _by_ending(path: Path) -> Format | None:
    """Return the format whose ending a file has; None where there is none.

    Raises: SetError where two formats would read the same file.
    """
    name = path.name.lower()
    fitting = sorted(
        (form for form in FORMATS.values() if name.endswith(form.ending)), key=lambda form: -len(form.ending)
    )
    if len(fitting) > 1 and fitting[0].ending == fitting[1].ending:
        raise SetError(
            f"{path}: two formats, {fitting[0].name} and {fitting[1].name}, have files that end in "
            f"{fitting[0].ending}: which one is meant cannot be told; nothing was done; uninstall one of them"
        )
    return next(iter(fitting), None)


def load_set(path: str | Path) -> CoefficientSet:
    """Return the set in a file of any format, every check made but the recomputation of the test vectors (``verify``).

    One of a folder that says so is withdrawn.

    Raises: SetError naming the file, what is wrong with it and what to do.
    """
    file = Path(path)
    form, content = format_of(file), read_whole(file)
    if content.startswith(BOM_UTF8):
        raise SetError(
            f"{path}: begins with a byte order mark (bytes ef bb bf), with which no set is written: saved again by "
            f"another program, such as an editor or a spreadsheet; {INTACT}"
        )
    found, word = form.from_bytes(content, str(path)), withdrawn_beside(file)
    return found if word is None else replace(found, withdrawal=word)
