"""Where dialect files are: those that are shipped, by name, and a laboratory's own, by path.

Every file is named as the dialect in it.
"""

from functools import cache
from importlib.resources import as_file, files
from pathlib import Path
from typing import TypeVar

from rig.toml_file import StrictTable, read_toml

Form = TypeVar("Form", bound=StrictTable)


@cache
def shipped_in(parent: str, form: type[Form]) -> dict[str, Form]:
    """Return the dialects of a folder inside the package, by name."""
    with as_file(files("rig").joinpath(parent)) as folder:
        return {path.stem: read_toml(path).validate(form) for path in sorted(folder.glob("*.toml"))}


@cache
def shipped_names() -> frozenset[str]:
    """Return the names of every shipped dialect, whatever it is for."""
    with as_file(files("rig").joinpath("dialects")) as folder:
        return frozenset(path.stem for path in folder.rglob("*.toml"))


def dialect_file(text: str, folder: Path) -> Path | None:
    """Return the file that a file in ``folder`` means by ``text``; None where that is the name of a shipped dialect."""
    return None if text in shipped_names() else folder / text


def name_or_file(value: object) -> str:
    """Tell what stands for a dialect: its ``name`` or path, or, once it is read, what its ``file`` says."""
    return "file" if isinstance(value, dict | StrictTable) else "name"


WRITTEN_OUT = "got a table, allowed the name of a dialect or the path of its file; write it in quotes"
"""Of a rig file that holds a dialect itself."""
