"""Tables as the text of a TOML file."""

import json
from collections.abc import Iterator, Mapping, Sequence


def toml_text(tables: Mapping[str, Mapping[str, object]], comments: Mapping[str, Sequence[str]] | None = None) -> str:
    """Return the file: every table under its heading, tables within one as inline tables.

    ``comments``: table, or empty for the whole file, to the lines that stand above it.
    """
    said = comments or {}
    return "\n".join([*_commented(said.get("", ())), *_lines(tables, said)]).lstrip("\n") + "\n"


def _lines(tables: Mapping[str, Mapping[str, object]], said: Mapping[str, Sequence[str]]) -> Iterator[str]:
    for name, keys in tables.items():
        yield from ("", *_commented(said.get(name, ())), f"[{name}]")
        yield from (f"{_key(key)} = {toml_value(value)}" for key, value in keys.items() if value is not None)


def _commented(lines: Sequence[str]) -> list[str]:
    return [f"# {line}" for line in lines]


def toml_value(value: object) -> str:
    """Return one value in TOML; arrays of NumPy and columns of pandas are lists.

    Raises: TypeError for what TOML has no word for.
    """
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            return json.dumps(value, ensure_ascii=False)
        case int() | float():
            return repr(value)
        case Mapping():
            return "{ " + ", ".join(f"{_key(str(key))} = {toml_value(item)}" for key, item in value.items()) + " }"
        case list() | tuple() | range():
            return f"[{', '.join(toml_value(item) for item in value)}]"
    if hasattr(value, "tolist"):
        return toml_value(value.tolist())
    raise TypeError(f"got {value!r}, allowed are texts, numbers, true and false, lists and tables")


def _key(name: str) -> str:
    return name if name.isascii() and name.replace("-", "_").isidentifier() else json.dumps(name, ensure_ascii=False)
