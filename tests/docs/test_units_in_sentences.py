"""Sentences say °, °C, °/s and µT: ``deg``, ``degC`` and ``uT`` are for what programs read."""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs"))
from house import tree_of  # noqa: E402

PARTS = ("ams", "rig", "procedures", "examples")
SPELLED = re.compile(r"(?<=[…\d)\]]) ?(?:deg/s|dps|deg[CFc]?|uT|us|arcsec|m/s\^2)(?![\w^(])")
SPACED = re.compile(r"[…\d](?:°C|°F|°/s|µT|m/s²)|[…\d] (?:°(?![CF/])|″)")
READ_BY_PROGRAMS = {
    ("rig/wire/manual.py", ""): "the pattern of the line below",
    ("rig/wire/manual.py", "encode"): "a line of the wire: replayed from journals, read by the twin of the operator",
    ("rig/devices/esp301.py", "identify"): "rig files quote from it (`identity`), journals keep it",
    ("rig/devices/watlow_f4t.py", "identify"): "as above",
    ("procedures/plan/step_times.py", "_move_name"): "under this name the archive keeps what past runs took",
    ("ams/exports/statement.py", "_valid"): "inside exported files, in ASCII",
    ("ams/exports/statement.py", "statement"): "inside exported files, in ASCII",
    ("ams/exports/dcc_administration.py", "_statements"): "inside the certificate's XML",
}
"""File and function, and who reads the text."""


def texts_of(tree: ast.Module) -> Iterator[tuple[str, int, str]]:
    """Function, line and text of everything that is formatted or spelled out; … for a value, docstrings left out."""
    yield from _in(tree, "")


def _in(node: ast.AST, function: str) -> Iterator[tuple[str, int, str]]:
    match node:
        case ast.FunctionDef(name=name):
            function = name
        case ast.Expr(value=ast.Constant()):
            return
        case ast.JoinedStr(values=values):
            parts = [str(part.value) if isinstance(part, ast.Constant) else "…" for part in values]
            yield function, node.lineno, "".join(parts)
            for part in values:
                if isinstance(part, ast.FormattedValue):
                    yield from _in(part.value, function)
            return
        case ast.Constant(value=str(text)):
            yield function, node.lineno, text
            return
    for child in ast.iter_child_nodes(node):
        yield from _in(child, function)


@pytest.fixture(scope="module")
def texts() -> list[tuple[str, str, int, str]]:
    found = []
    for part in PARTS:
        for path in sorted((ROOT / part).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            found += [(name, *text) for text in texts_of(tree_of(path))]
    return found


def test_sentences_have_the_signs_of_units(texts) -> None:
    spelled = {
        (path, function): f"{path}:{line}: {text}" for path, function, line, text in texts if SPELLED.search(text)
    }
    assert [found for where, found in spelled.items() if where not in READ_BY_PROGRAMS] == []
    assert set(READ_BY_PROGRAMS) - set(spelled) == set(), "nothing is spelled out there any more"


def test_a_sign_stands_off_its_number_as_the_si_has_it(texts) -> None:
    """5 °C, 5 °/s and 5 µT, but 5° and 5″ (SI brochure, 5.4.3)."""
    assert [f"{path}:{line}: {text}" for path, _, line, text in texts if SPACED.search(text)] == []


def test_the_law_sees_what_is_spelled_out() -> None:
    source = 'def f(x):\n    """At 5 deg."""\n    return g(f"at {x:g} deg, " f"allowed {x} degC") + " 5 uT"\n'
    found = [(line, bool(SPELLED.search(text))) for _, line, text in texts_of(ast.parse(source))]
    assert found == [(3, True), (3, True)]
