"""Whether a document is a coefficient set that this version can read, asked in the order that tells people most.

Not a set at all, of a newer version, changed after it was written, of a shape that no set has: each its own sentence.
"""

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from ams.errors import SetError
from ams.sets.canonical import Document, Json, checksum

if TYPE_CHECKING:
    from jsonschema.protocols import Validator

FORMAT = "calrig coefficient set"
VERSION = 4
"""The version that is written: 1 held TP's models, 2 also CR's, with yaw and rates among the inputs, 3 the findings,
4 straight lines in units of their own."""


def check_identity(value: Json, where: str) -> Document:
    """Return the value as a document of version 1 to 4.

    Raises: SetError where it is something else, newer or damaged.
    """
    document = _checked_identity(value, where)
    _check_checksum(document, where)
    return document


def _checked_identity(value: Json, where: str) -> Document:
    if not isinstance(value, dict) or value.get("format") != FORMAT:
        raise SetError(
            f'{where}: is not a coefficient set: got {_described(value)}, needed is "format": "{FORMAT}"; '
            "nothing was read; give a set that calrig wrote"
        )
    version = value.get("version")
    if isinstance(version, bool) or not isinstance(version, int) or version < 1:
        raise SetError(
            f"{where}: version: is no version of a coefficient set: got {version!r}, known are 1 to {VERSION}; "
            "nothing was read; the file is damaged: take an intact copy, or export the set again from the archive"
        )
    if version > VERSION:
        raise SetError(
            f"{where}: version: was written by a newer calrig: got version {version}, this one reads up to {VERSION}; "
            "nothing was read; install the calrig that wrote it"
        )
    return value


def _described(value: Json) -> str:
    if isinstance(value, dict):
        return f'"format": {value["format"]!r}' if "format" in value else 'a document without "format"'
    return f"a {type(value).__name__}"


def _check_checksum(document: Mapping[str, Json], where: str) -> None:
    entry = document.get("checksum")
    stated = entry.get("sha256") if isinstance(entry, dict) else None
    if stated is None:
        raise SetError(
            f"{where}: checksum: is missing; the set is not used; "
            "the file is damaged: take an intact copy, or export the set again from the archive"
        )
    actual = checksum(document)
    if stated != actual:
        raise SetError(
            f"{where}: checksum: does not fit the content: stated {stated}, computed {actual}; the set is not used; "
            "the file was changed or damaged after it was written: take an intact copy, or export it from the archive"
        )


def check_schema(document: Document, where: str) -> None:
    """Refuse a document of another shape, where jsonschema is installed. Raises: SetError.

    Where it is not, as in a tunnel program that has NumPy alone, the checksum has told already that nobody changed what
    calrig wrote; a shape that cannot be read is refused when it is read.
    """
    validator = _validator()
    if validator is None:
        return
    for error in sorted(validator.iter_errors(document), key=lambda found: (len(found.path), str(found.path))):
        path = "/".join(str(part) for part in error.absolute_path) or "document"
        raise SetError(
            f"{where}: {path}: does not fit the schema of version {document['version']}: {error.message[:200]}; "
            "the set is not used; it was not written by calrig, or by a defective one: export it again from the archive"
        )


@cache
def _validator() -> "Validator | None":
    try:
        from jsonschema import Draft202012Validator
    except ImportError:
        return None
    text = files("ams.sets").joinpath("coefficient_set.schema.json").read_text(encoding="utf-8")
    schema: Document = json.loads(text)
    definitions = schema.pop("$defs")
    assert isinstance(definitions, dict)
    return Draft202012Validator({key: _inlined(part, definitions) for key, part in schema.items()})


def _inlined(schema: Json, definitions: Document) -> Json:
    """Put definitions in the place of what refers to them: looking them up takes half the time of a check.

    None of them refers to itself.
    """
    if isinstance(schema, list):
        return [_inlined(part, definitions) for part in schema]
    if not isinstance(schema, dict):
        return schema
    inlined: Document = {key: _inlined(part, definitions) for key, part in schema.items() if key != "$ref"}
    if "$ref" not in schema:
        return inlined
    definition = _inlined(definitions[str(schema["$ref"]).removeprefix("#/$defs/")], definitions)
    assert isinstance(definition, dict)
    assert not inlined.keys() & definition.keys(), "a reference adds to what it refers to and repeats nothing of it"
    return definition | inlined
