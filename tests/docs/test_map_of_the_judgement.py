"""The map of the judgement is true: every function stands where it is said to, and the one named calls it."""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs"))
from house import tree_of  # noqa: E402

ROW = re.compile(r"^\| (?P<what>[^|]+) \| `(?P<file>[\w/]+\.py)` (?P<names>[^|]+) \| (?P<by>[^|]+) \|$", re.MULTILINE)
QUOTED = re.compile(r"`([\w/.]+)`")
HEADING = "## The judgement, from dwells to words"


class _Line(NamedTuple):
    file: Path
    names: tuple[str, ...]
    caller_file: Path
    caller: str


def _lines() -> Iterator[_Line]:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8").partition(HEADING)[2].partition("\n## ")[0]
    rows = [line for line in page.splitlines() if line.startswith("|")][2:]
    for row in rows:
        found = ROW.match(row)
        assert found is not None, row
        *elsewhere, caller = QUOTED.findall(found["by"])
        yield _Line(
            ROOT / found["file"], tuple(QUOTED.findall(found["names"])), ROOT / (*elsewhere, found["file"])[0], caller
        )


def _functions(path: Path) -> dict[str, ast.FunctionDef]:
    return {node.name: node for node in ast.walk(tree_of(path)) if isinstance(node, ast.FunctionDef)}


def _used(function: ast.FunctionDef) -> set[str]:
    """Return every name and attribute that a function reads."""
    names = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)}
    return names | {node.attr for node in ast.walk(function) if isinstance(node, ast.Attribute)}


def test_every_function_of_the_map_is_there_and_is_called_by_the_one_named() -> None:
    lines = list(_lines())
    assert len(lines) >= 20
    for line in lines:
        there, calling = _functions(line.file), _functions(line.caller_file)
        assert set(line.names) <= there.keys(), line
        assert line.caller in calling, line
        assert set(line.names) <= _used(calling[line.caller]), line


def test_the_map_leads_from_the_rows_of_a_run_to_the_head_of_its_page() -> None:
    named = [name for line in _lines() for name in line.names]
    path = ["solve_sensors", "calibrate", "diagnose_together", "axis_tests", "decided_together", "findings_of", "judge"]
    assert [name for name in named if name in path] == path
