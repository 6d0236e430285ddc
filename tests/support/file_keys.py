"""Every key of a file's form, found by walking the form itself, and one key of one document changed.

A key is written as in the file with ``*`` for a name that the file's author chooses, and ``*:driver`` where the driver
decides which keys there are: ``axes.*:zaber.microstep_deg``.
"""

from collections.abc import Iterator, Mapping
from copy import deepcopy
from datetime import date
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, TypeAdapter
from pydantic.fields import FieldInfo
from pydantic.json_schema import SkipJsonSchema

Document = dict[str, Any]


def keys_of(form: type[BaseModel]) -> dict[str, FieldInfo]:
    """Every key of a file to its field; ``driver`` is left out, since it chooses among the tables."""
    return {".".join(path): field for path, field in _keys(form, ())}


def _keys(form: type[BaseModel], table: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], FieldInfo]]:
    for name, field in form.model_fields.items():
        if name == "driver":
            continue
        path = (*table, field.alias or name)
        is_value = False
        for kind in _alternatives(field.annotation):
            if tables := list(_tables_below(kind, path)):
                for inner, where in tables:
                    yield from _keys(inner, where)
            elif kind is not type(None):
                is_value = True
        if is_value:
            yield path, field


def _tables_below(kind: Any, path: tuple[str, ...]) -> Iterator[tuple[type[BaseModel], tuple[str, ...]]]:
    """The tables that a key may hold itself, or under names that are chosen by the file's author."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        driver = kind.model_fields.get("driver")
        yield kind, path if driver is None else (*path[:-1], f"{path[-1]}:{get_args(driver.annotation)[0]}")
    elif get_origin(kind) is dict:
        for inner in _alternatives(get_args(kind)[1]):
            yield from _tables_below(inner, (*path, "*"))


def _alternatives(annotation: Any) -> list[Any]:
    """The members of a union, or the annotation itself; constraints are taken off.

    What stands in no schema of the file is written by nobody: what a file says that the key names.
    """
    if get_origin(annotation) is Annotated:
        is_written = not any(isinstance(mark, SkipJsonSchema) for mark in get_args(annotation)[1:])
        return _alternatives(get_args(annotation)[0]) if is_written else []
    if get_origin(annotation) in (dict, list, tuple, Literal) or not get_args(annotation):
        return [annotation]
    return [inner for member in get_args(annotation) for inner in _alternatives(member)]


def paths_of(document: Document, key: str) -> list[tuple[str, ...]]:
    """Where in a document the key may stand, its table being there."""
    *table, last = key.split(".")
    found: list[tuple[tuple[str, ...], Any]] = [((), document)]
    for part in table:
        name, _, driver = part.partition(":")
        found = [
            ((*path, inner), here[inner])
            for path, here in found
            if isinstance(here, Mapping)
            for inner in (here if name == "*" else [name] if name in here else [])
            if not driver or here[inner].get("driver") == driver
        ]
    return [(*path, last) for path, here in found if isinstance(here, Mapping)]


def value_at(document: Document, path: tuple[str, ...], default: Any = None) -> Any:
    here: Any = document
    for part in path:
        if not isinstance(here, Mapping) or part not in here:
            return default
        here = here[part]
    return here


def changed(document: Document, path: tuple[str, ...], value: Any) -> Document:
    """A copy with the value there; None takes the key away."""
    copy = deepcopy(document)
    here = copy
    for part in path[:-1]:
        here = here.setdefault(part, {})
    if value is None:
        here.pop(path[-1], None)
    else:
        here[path[-1]] = value
    return copy


def is_a_value(field: FieldInfo, value: Any) -> bool:
    """Whether the field would take it by itself: a refusal of the whole file is then about more than its form."""
    try:
        kind = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
        TypeAdapter(kind).validate_python(value)
    except ValueError:
        return False
    return True


def other_value(field: FieldInfo, value: Any) -> Any:
    """A value of the same form that is not ``value``; None where nobody can tell."""
    value = field.get_default() if value is None else value
    for kind in _alternatives(field.annotation):
        if get_origin(kind) is Literal and value in get_args(kind):
            return next((other for other in get_args(kind) if other != value), None)
    match value:
        case bool():
            return not value
        case int():
            return value + 1
        case float():
            return 1.5 * value if value else 0.5
        case date():
            return date(2020, 1, 1)
        case list() | tuple() if value and all(isinstance(entry, int | float) for entry in value):
            return [1.5 * entry if entry else 0.5 for entry in value]
    return None


def toml_of(document: Document) -> str:
    """A document as a file: one line a table, since no person reads it."""
    return "".join(f"{_quoted(name)} = {_toml(value)}\n" for name, value in document.items())


def _toml(value: Any) -> str:
    match value:
        case dict():
            return "{ " + ", ".join(f"{_quoted(name)} = {_toml(inner)}" for name, inner in value.items()) + " }"
        case list() | tuple():
            return "[" + ", ".join(map(_toml, value)) + "]"
        case bool():
            return "true" if value else "false"
        case str():
            return _quoted(value)
        case date():
            return value.isoformat()
    return repr(value)


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\t", "\\t") + '"'
