"""Strict TOML: every mistake named by ``file:line: key: what was found, what is allowed``.

:mod:`tomllib` tells no lines and pydantic no file, so this module joins the two: a small index of where each key
stands, and a translation of pydantic's complaints into sentences. All mistakes of a file are told at once.
"""

import difflib
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from datetime import date, time
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from rig.allowed_values import allowed_in_words, near_to
from rig.errors import DescriptionError
from rig.plain_text import BYTE_ORDER_MARK, LONGEST_OF_FILE, PARAGRAPHS, one_line, text_complaint

KeyPath = tuple[str, ...]

MOST_BYTES = 16_000_000
"""Of a file that a person writes."""
OF_LINES = (("address",), ("remarks",))
"""Keys whose texts may have several lines."""
_NAMED_KEY = re.compile(r"([a-z][a-z0-9_]*): ")
_HEADER = re.compile(r"^\s*\[\[?(?P<path>[^\[\]]+)\]\]?\s*(#.*)?$")
_DOTTED = r"""(?P<key>(?:[A-Za-z0-9_-]++|"[^"]*+"|'[^']*+')(?:\s*+\.\s*+(?:[A-Za-z0-9_-]++|"[^"]*+"|'[^']*+'))*+)\s*+"""
"""What was read once is not tried again (``++``): a line takes time by its length, not by the square of it."""
_ASSIGNMENT = re.compile(f"{_DOTTED}=")
_KEY_OR_TEXT = re.compile(f"{_DOTTED}(?P<is_assigned>=)?")
_DECIMAL_COMMA = re.compile(rf"{_DOTTED}=\s*+(?P<number>[+-]?\d++,\d++(?:[eE][+-]?\d++)?+)\s*+(?=[,}}]|$)")
_KEY_PART = re.compile(r"""[A-Za-z0-9_-]+|"[^"]*"|'[^']*'""")
_COUNTED_IN = (
    ("_deg", "_arcsec"),
    ("_rad", "_arcsec"),
    ("_rad", "_deg"),
    ("_mv", "_v"),
    ("_ms", "_s"),
    ("_min", "_s"),
    ("_h", "_s"),
)
"""Endings of keys in a unit that the key is not counted in, and in that which it is."""
_UNITS = ("deg", "rad", "s", "hz", "v", "g", "degc", "dps", "arcsec", "mps2", "v_per_g", "ohm", "pa")


class StrictTable(BaseModel):
    """Base of every table of a calrig file: frozen, no unknown key, no silent conversion."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)
    instead: ClassVar[Mapping[str, str]] = {}
    """Keys that it had before, each with what its refusal says to do."""
    names_files: ClassVar[tuple[str, ...]] = ()
    """Keys whose values are paths of files, relative to the file that the table stands in. What these files hold is
    kept with a run and held against them at a resume (:mod:`procedures.description.named_files`)."""


Table = TypeVar("Table", bound=BaseModel)


def as_tuple(value: object) -> object:
    """Return a list of TOML as the tuple that a frozen table holds; for ``field_validator(..., mode="before")``."""
    return tuple(value) if isinstance(value, list) else value


class TomlFile:
    """A parsed file that knows where its keys stand."""

    def __init__(self, path: Path, text: str) -> None:
        text = text.removeprefix(BYTE_ORDER_MARK)
        self.path = path
        self.values = _parse(path, text)
        self._lines = _lines_of_keys(text)

    def require_seen(self) -> None:
        """Refuse a file whose texts hold what nobody sees. Raises: DescriptionError.

        It is for files whose texts people read.
        """
        found = [self.complaint(key, complaint) for key, complaint in _hidden(self.values, ())]
        if found:
            raise DescriptionError("\n".join(found))

    def require_kind(self, head: str, mine: str, other_head: str, other: str) -> None:
        """Refuse a file of another kind by the table at its head, before every key of it is called unknown.

        Raises: DescriptionError.
        """
        if head not in self.values and other_head in self.values:
            raise DescriptionError(
                f"{self.where((other_head,))}: {other_head}: this is a {other} file, and a {mine} file is wanted here "
                "(calrig COMMAND PROCEDURE --rig RIG)"
            )

    def where(self, key: Sequence[object]) -> str:
        """Return ``file:line`` of a key, of the first table inside it, or of the nearest table around it."""
        parts = tuple(str(part) for part in key)
        while parts:
            inside = (line for path, line in self._lines.items() if path[: len(parts)] == parts)
            if line := self._lines.get(parts) or next(inside, None):
                return f"{self.path}:{line}"
            parts = parts[:-1]
        return f"{self.path}:1"

    def complaint(self, key: Sequence[object], text: str) -> str:
        """Return one mistake as ``file:line: key: text``."""
        return f"{self.where(key)}: {'.'.join(str(part) for part in key) or 'file'}: {text}"

    def error(self, key: Sequence[object], text: str) -> DescriptionError:
        """Return a mistake as an error to raise."""
        return DescriptionError(self.complaint(key, text))

    def validate(self, model: type[Table]) -> Table:
        """Return the file as a frozen value. Raises: DescriptionError with every mistake, one a line."""
        try:
            return model.model_validate(self.values)
        except ValidationError as error:
            complaints = [self._sentence(dict(item), model) for item in error.errors(include_url=False)]
            raise DescriptionError("\n".join(dict.fromkeys(complaints))) from None

    def _sentence(self, item: dict[str, Any], model: type[BaseModel]) -> str:
        kind = item["type"]
        key, tags = _without_tags(self.values, item["loc"], last_is_key=kind == "missing")
        if kind == "extra_forbidden":
            return self.complaint(key, _unknown_key(str(key[-1]), _tables_at(model, key[:-1], tags)))
        if kind == "missing" and isinstance(key[-1], int):
            return self.complaint(key[:-1], f"value {key[-1] + 1} is missing; write all of them between the brackets")
        if kind == "missing":
            return self.complaint(key, "is missing" + _unit_hint(self.values, key))
        if kind == "union_tag_not_found":
            drivers = ", ".join(map(repr, sorted(_drivers_of(_tables_at(model, key, ())))))
            return self.complaint((*key, "driver"), f"is missing, allowed {drivers}")
        if kind == "union_tag_invalid":
            tag, allowed = item["ctx"]["tag"], item["ctx"]["expected_tags"]
            return self.complaint((*key, "driver"), f"got {tag!r}, allowed {allowed}{near_to(tag, allowed)}")
        tables = _tables_at(model, key[:-1], tags) if key and isinstance(key[-1], str) else []
        bounds = [bound for table in tables for bound in _bounds_of(table, str(key[-1]))]
        allowed = allowed_in_words(kind, item.get("ctx", {}), bounds)
        if allowed is not None:
            meant = near_to(item["input"], allowed) if kind == "literal_error" else ""
            return self.complaint(key, f"got {_short(item['input'])}, allowed {allowed}{meant}")
        text = _plain(item)
        named = _NAMED_KEY.match(text)
        if isinstance(item["input"], dict) and named is not None:  # a mistake of a whole table names its key
            return self.complaint((*key, named[1]), text[named.end() :])
        return self.complaint(key, f"got {_short(item['input'])}: {text}")


def read_toml(path: Path) -> TomlFile:
    """Read a TOML file. Raises: DescriptionError when it is missing, unreadable, not UTF-8 or not TOML."""
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise DescriptionError(
                f"{path}: longer than {MOST_BYTES} bytes, which no file of this kind is; check the path"
            )
        return TomlFile(path, content.decode("utf-8"))
    except FileNotFoundError:
        raise DescriptionError(f"{path}: no such file; check the path") from None
    except UnicodeDecodeError as error:
        raise DescriptionError(f"{path}: not UTF-8 text (byte {error.start}); save the file as UTF-8") from None
    except OSError as error:
        raise DescriptionError(f"{path}: cannot be read: {error.strerror}") from None


def values_in(text: str) -> dict[str, Any]:
    """Return what a text of TOML says. Raises: tomllib.TOMLDecodeError."""
    return tomllib.loads(text.removeprefix(BYTE_ORDER_MARK))


def _parse(path: Path, text: str) -> dict[str, Any]:
    try:
        return values_in(text)
    except tomllib.TOMLDecodeError as error:
        at = re.search(r"line (\d+)", str(error))
        line = int(at[1]) if at else max(len(text.splitlines()), 1)
        of_a_key = re.search("Cannot (overwrite|declare)", str(error))
        line, said = (
            (of_a_key and _written_twice(text, line))
            or _decimal_comma(text, line)
            or (line, f"not valid TOML: {error}")
        )
        raise DescriptionError(f"{path}:{line}: {said}") from None
    except RecursionError:
        raise DescriptionError(f"{path}: not valid TOML: brackets in brackets without an end") from None
    except ValueError as error:
        raise DescriptionError(f"{path}: not valid TOML: {error}") from None


def _written_twice(text: str, line: int) -> tuple[int, str] | None:
    """Return line and sentence of a key that stands in the file before; None where the line is wrong in another way.

    ``line`` is where the value ends, which may be lines below its key.
    """
    lines = text.splitlines()
    while line > 1 and not (_HEADER.match(lines[line - 1]) or _ASSIGNMENT.match(lines[line - 1].strip())):
        line -= 1
    header = _HEADER.match(lines[line - 1])
    if header and "=" not in header["path"]:
        found = _parts(header["path"])
    elif match := _ASSIGNMENT.match(lines[line - 1].strip()):
        found = (*_table_of(lines[: line - 1]), *_parts(match["key"]))
    else:
        return None
    first = _lines_of_keys("\n".join(lines[: line - 1])).get(found)
    if first is None:
        return None
    return line, f"{'.'.join(found)}: is written twice, first on line {first}; nothing was read; remove one of them"


def _decimal_comma(text: str, line: int) -> tuple[int, str] | None:
    """Return line and sentence of a number with a decimal comma; None where the line is wrong in another way."""
    lines = text.splitlines()
    written = lines[line - 1].split("#", 1)[0] if line <= len(lines) else ""
    if (match := _DECIMAL_COMMA.search(written)) is None:
        return None
    key = ".".join((*_table_of(lines[: line - 1]), *_parts(match["key"])))
    point = match["number"].replace(",", ".")
    return (
        line,
        f"{key}: got {match['number']}, allowed is a number with a decimal point; nothing was read; write {point}",
    )


def _table_of(lines: Sequence[str]) -> KeyPath:
    """Return the table that a line after these stands in."""
    headers = (header for line in reversed(lines) if (header := _HEADER.match(line)) and "=" not in header["path"])
    return next((_parts(header["path"]) for header in headers), ())


def _hidden(value: object, key: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    """Keys and what is wrong with their letters that nobody sees; the key that is told is as it can be shown."""
    if isinstance(value, dict):
        for name, item in value.items():
            if complaint := text_complaint(name, longest=LONGEST_OF_FILE):
                yield (*key, one_line(name)), complaint
            yield from _hidden(item, (*key, name))
    elif isinstance(value, list):
        for item in value:
            yield from _hidden(item, key)
    elif isinstance(value, str):
        kept = PARAGRAPHS if key[-1:] in OF_LINES else ""
        if complaint := text_complaint(value, kept, LONGEST_OF_FILE):
            yield key, complaint


def _lines_of_keys(text: str) -> dict[KeyPath, int]:
    lines: dict[KeyPath, int] = {}
    table: KeyPath = ()
    for number, line in enumerate(text.splitlines(), start=1):
        header = _HEADER.match(line)
        if header and "=" not in header["path"]:
            table = _parts(header["path"])
            lines.setdefault(table, number)
            continue
        _index_assignments(lines, table, line, number)
    return lines


def _index_assignments(lines: dict[KeyPath, int], table: KeyPath, line: str, number: int) -> None:
    """Index ``a = 1`` and, inside inline tables, every further ``key =`` under the first key of the line."""
    owner: KeyPath | None = None
    for match in _KEY_OR_TEXT.finditer(line.split("#", 1)[0]):
        if match["is_assigned"] is None:
            continue
        parts = _parts(match["key"])
        path = (*table, *parts) if owner is None else (*owner, *parts)
        lines.setdefault(path, number)
        owner = owner or path


def _parts(dotted: str) -> KeyPath:
    return tuple(part.strip("\"'") for part in _KEY_PART.findall(dotted))


def _without_tags(
    values: Mapping[str, Any], loc: Sequence[str | int], *, last_is_key: bool
) -> tuple[list[str | int], list[str]]:
    """Drop the names of union members, which pydantic mixes into the location, and tell them apart."""
    key: list[str | int] = []
    tags: list[str] = []
    here: Any = values
    for index, part in enumerate(loc):
        known = (isinstance(here, Mapping) and part in here) or (
            isinstance(here, list) and isinstance(part, int) and part < len(here)
        )
        if not known and not (last_is_key and index == len(loc) - 1):
            tags.append(str(part))
            continue
        key.append(part)
        here = here[part] if known else None
    return key, tags


def _tables_at(model: type[BaseModel], table: Sequence[str | int], tags: Sequence[str]) -> list[type[BaseModel]]:
    """Return the forms of the table at ``table`` below ``model``, following dictionaries, options and unions."""
    candidates: list[Any] = [model]
    for part in table:
        candidates = [inner for outer in candidates for inner in _descend(outer, str(part))]
    tables = [item for item in candidates if _is_table(item)]
    tagged = [item for item in tables if tags and tags[-1] in str(item.model_fields.get("driver", ""))]
    return tagged or tables


def _drivers_of(tables: Sequence[type[BaseModel]]) -> Iterator[str]:
    """Yield the names of the drivers whose tables these are."""
    for table in tables:
        yield from getattr(table.model_fields["driver"].annotation, "__args__", ())


def _bounds_of(table: type[BaseModel], key: str) -> Sequence[object]:
    return table.model_fields[key].metadata if key in table.model_fields else ()


def _is_table(item: Any) -> bool:
    return isinstance(item, type) and issubclass(item, BaseModel)


def _descend(item: Any, part: str) -> list[Any]:
    if _is_table(item):
        return _alternatives(item.model_fields[part].annotation) if part in item.model_fields else []
    arguments = getattr(item, "__args__", ())
    return _alternatives(arguments[-1]) if arguments else []


def _alternatives(annotation: Any) -> list[Any]:
    """Return the members of a union, or the annotation itself."""
    arguments = getattr(annotation, "__args__", ())
    if getattr(annotation, "__origin__", None) in (dict, list, tuple, Mapping) or not arguments:
        return [annotation]
    return [inner for argument in arguments for inner in _alternatives(argument)]


def _unknown_key(key: str, tables: Sequence[type[BaseModel]]) -> str:
    for table in tables:
        if issubclass(table, StrictTable) and key in table.instead:
            return table.instead[key]
    allowed = sorted({field.alias or name for table in tables for name, field in table.model_fields.items()})
    with_unit = [name for name in allowed if name.startswith(f"{key}_") and name.removeprefix(f"{key}_") in _UNITS]
    if with_unit:
        return f"unknown key: the unit is missing; write {with_unit[0]}"
    near = [*_in_another_unit(key, allowed), *difflib.get_close_matches(key, allowed, n=1)]
    hint = f"; did you mean {near[0]}?{_other_unit(key, near[0])}" if near else ""
    return f"unknown key{hint} (allowed: {', '.join(allowed) or 'none'})"


def _other_unit(key: str, meant: str) -> str:
    """Return that the value is to be converted, where a key is meant that only its unit tells from the one written."""
    endings = {ending for pair in _COUNTED_IN for ending in pair} | {f"_{unit}" for unit in _UNITS}
    given, counted = (max((end for end in endings if name.endswith(end)), key=len, default="") for name in (key, meant))
    if not given or not counted or given == counted or key.removesuffix(given) != meant.removesuffix(counted):
        return ""
    return f" It is in {counted[1:]} and not in {given[1:]}: convert the value"


def _in_another_unit(key: str, allowed: Sequence[str]) -> list[str]:
    """Return the same key in the unit that it is counted in, where it was written in a larger or smaller one."""
    return [
        f"{key.removesuffix(given)}{counted}"
        for given, counted in _COUNTED_IN
        if key.endswith(given) and f"{key.removesuffix(given)}{counted}" in allowed
    ]


def _unit_hint(values: Mapping[str, Any], key: Sequence[str | int]) -> str:
    """Return a hint where the key stands there without its unit, else nothing."""
    here: Any = values
    for part in key[:-1]:
        here = here.get(part, {}) if isinstance(here, Mapping) else {}
    stem = next((str(key[-1]).removesuffix(f"_{unit}") for unit in _UNITS if str(key[-1]).endswith(f"_{unit}")), "")
    return f" ({stem} stands there without its unit)" if stem and isinstance(here, Mapping) and stem in here else ""


def _plain(item: Mapping[str, Any]) -> str:
    message = str(item["msg"]).removeprefix("Value error, ")
    return message[:1].lower() + message[1:]


def as_in_file(value: object) -> str:
    """Return a value as a TOML file has it, text in single quotes: a list, a table or ``true`` as its author wrote."""
    match value:
        case bool():
            return "true" if value else "false"
        case list() | tuple():
            return f"[{', '.join(map(as_in_file, value))}]"
        case Mapping():
            inside = ", ".join(f"{key} = {as_in_file(item)}" for key, item in value.items())
            return f"{{ {inside} }}" if inside else "{}"
        case date() | time():
            return value.isoformat()
    return repr(value)


def _short(value: object) -> str:
    text = as_in_file(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
