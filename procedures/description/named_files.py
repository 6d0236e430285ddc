"""The files that a rig file and a procedure file name: dialects, lists of index errors, points of a design.

A run keeps what they hold with the two files, a resume compares it, and an item of a queue is not started over another.
Which keys name files their tables say (:attr:`rig.toml_file.StrictTable.names_files`), those of drivers, kinds and
designs of other distributions too. A dialect that calrig brings is no file: it belongs to the version of the software.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from procedures.description.procedure_file import ProcedureDescription
from rig.description.rig_file import RigDescription
from rig.errors import DescriptionError
from rig.toml_file import KeyPath, StrictTable, read_toml
from rig.wire.dialect_files import shipped_names

RIG_FILE, PROCEDURE_FILE = "rig file", "procedure file"
DIALECT = "dialect"
"""A key that may also be the name of one that calrig brings."""
MOST_KEPT_BYTES = 1_000_000
"""What is longer is kept as its hash alone."""


@dataclass(frozen=True, slots=True)
class NamedFile:
    """One such file as it was found."""

    named_by: str
    """``rig file`` or ``procedure file``."""
    key: str
    """Such as ``axes.pitch.dialect``."""
    path: str
    sha256: str
    """Of its bytes."""
    text: str | None
    """None where it is too long to be kept, or no UTF-8."""

    @property
    def label(self) -> str:
        """Which it is, as people read it."""
        return f"{self.named_by}: {self.key}: {Path(self.path).name}"


def files_named_by(rig: RigDescription, rig_file: Path, procedure: ProcedureDescription) -> tuple[NamedFile, ...]:
    """Return every file that the two name, as it is now.

    ``rig`` is what was read of ``rig_file``. Raises: DescriptionError for one that cannot be read.
    """
    return (*_named_by(RIG_FILE, rig_file, rig), *_named_by(PROCEDURE_FILE, procedure.path, procedure))


def content_of(path: Path) -> tuple[str, str | None]:
    """Return the SHA-256 of a file and, where it is short enough and UTF-8, its text. Raises: OSError."""
    content = path.read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    if len(content) > MOST_KEPT_BYTES:
        return digest, None
    try:
        return digest, content.decode("utf-8")
    except UnicodeDecodeError:
        return digest, None


def _named_by(name: str, path: Path, description: StrictTable) -> Iterator[NamedFile]:
    file = read_toml(path)
    for key, text in _keys_of_files(description, file.values, ()):
        named = (path.parent / text).resolve()
        try:
            yield NamedFile(name, ".".join(key), str(named), *content_of(named))
        except OSError as error:
            raise DescriptionError(file.complaint(key, f"{named}: cannot be read: {error.strerror}")) from None


def _keys_of_files(table: StrictTable, written: Mapping[str, Any], above: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    """Yield the keys of ``written`` that name a file, each with its path; ``table`` is what was read of it."""
    for name in table.names_files:
        if isinstance(text := written.get(name), str) and not (name == DIALECT and text in shipped_names()):
            yield (*above, name), text
    for name, form in type(table).model_fields.items():
        key = form.alias or name
        yield from _below(getattr(table, name), written.get(key), (*above, key))


def _below(value: object, written: object, above: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    if not isinstance(written, Mapping):
        return
    if isinstance(value, StrictTable):
        yield from _keys_of_files(value, written, above)
    elif isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _below(inner, written.get(name), (*above, str(name)))
