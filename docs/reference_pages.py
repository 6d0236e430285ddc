"""Write the pages of the reference that are the code's own words: every key of both files, every command and option.

They are made when the site is built and are not committed, so they cannot fall behind.
"""

import contextlib
import inspect
import io
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]  # the walk through the forms serves the tests too

from file_keys import keys_of  # noqa: E402

from procedures.cli.main import GROUPS, run_command  # noqa: E402
from procedures.kinds.read import procedure_form  # noqa: E402
from rig.description.read import rig_form  # noqa: E402

FILES = {"rig.toml": rig_form, "procedure.toml": procedure_form}


def write_reference(folder: Path) -> None:
    """Write the pages that are not as they are to be."""
    folder.mkdir(exist_ok=True)
    for name, text in pages().items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def pages() -> dict[str, str]:
    """Return the pages by their names."""
    keys = {f"{name.partition('.')[0]}-keys.md": "\n".join(_keys_page(name, form())) for name, form in FILES.items()}
    return {**keys, "commands.md": "\n".join(_commands_page())}


def _keys_page(name: str, form: type[BaseModel]) -> Iterator[str]:
    yield f"# Every key of {name}\n"
    yield (
        "Made from the code. `*` is a name that you choose; behind a colon stands the driver or kind that a table "
        "belongs to. [What the keys mean](../files.md) is told beside.\n"
    )
    yield "| key | value | without it |\n|---|---|---|"
    for key, field in keys_of(form).items():
        yield f"| `{key}` | {_cell(_kind(field.annotation))} | {_default(field)} |"
    yield ""


def _kind(annotation: Any) -> str:
    """Return the type in words of the file."""
    words = {"float": "number", "int": "whole number", "str": "text", "bool": "true or false", "date": "day"}
    if annotation is type(None):
        return ""
    name = getattr(annotation, "__name__", str(annotation))
    inner = get_args(annotation)
    if not inner:
        return words.get(name, f"table ({name})" if isinstance(annotation, type) else repr(annotation))
    if get_origin(annotation) is Literal:
        return ", ".join(f"`{value}`" for value in inner)
    parts = [
        part
        for argument in inner
        if argument is not Ellipsis and not _is_constraint(argument) and (part := _kind(argument))
    ]
    if name in ("list", "tuple"):
        return f"list of {', '.join(dict.fromkeys(parts))}"
    if name == "dict":
        return f"table of {parts[-1]}"
    return " or ".join(dict.fromkeys(parts))


def _is_constraint(part: Any) -> bool:
    return not isinstance(part, type) and not get_args(part)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True) if field.default_factory is not None else field.default
    return "" if value in (None, "") or isinstance(value, BaseModel) else f"`{_cell(str(value))}`"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def _commands_page() -> Iterator[str]:
    yield "# Every command\n\nWhat `calrig COMMAND --help` prints.\n"
    for heading, commands in GROUPS.items():
        yield f"## {heading}\n"
        for name, target, _ in commands:
            yield f"### calrig {name}\n"
            yield f"```text\n{_help(name)}\n```\n"
            for inner in _inner_commands(target):
                yield f"#### calrig {name} {inner}\n\n```text\n{_help(name, inner)}\n```\n"


def _help(*words: str) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as output:
        run_command([*words, "--help"])
    return "\n".join(line.rstrip() for line in output.getvalue().strip().splitlines())


def _inner_commands(target: str) -> list[str]:
    module, name = target.split(":")
    app = getattr(import_module(f"procedures.cli.{module}"), name)
    if inspect.isfunction(app):
        return []
    return sorted(name for name in app if not name.startswith("-"))


if __name__ == "__main__":
    write_reference(Path(sys.argv[1]))
