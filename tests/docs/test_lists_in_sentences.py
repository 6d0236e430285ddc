"""No sentence holds a list, tuple, set or table as Python prints it: ``['a', 'b']`` is no English."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
GATHERED = ("list", "tuple", "set", "frozenset", "dict", "sorted", "Sequence", "Mapping", "Iterable", "Collection")
Function = ast.FunctionDef | ast.AsyncFunctionDef


def _is_gathered(node: ast.expr, of_several: frozenset[str]) -> bool:
    """Return whether a value prints with brackets, as far as its function shows."""
    if isinstance(node, ast.List | ast.Tuple | ast.Set | ast.Dict | ast.ListComp | ast.SetComp | ast.DictComp):
        return True
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id in GATHERED
    return isinstance(node, ast.Name) and node.id in of_several


def _names_of_several(function: Function) -> frozenset[str]:
    """Return parameters and variables that are annotated as, or made of, several values."""
    arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    found = {argument.arg for argument in arguments if _says_several(argument.annotation)}
    for node in ast.walk(function):
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and _says_several(node.annotation):
            found.add(node.target.id)
        elif isinstance(node, ast.Assign) and _is_gathered(node.value, frozenset()):
            found |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    # A name that is also bound to something else is left to whoever reads it.
    other = {
        target.id
        for node in ast.walk(function)
        if isinstance(node, ast.Assign) and not _is_gathered(node.value, frozenset())
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    loops = {
        part.id
        for node in ast.walk(function)
        if isinstance(node, ast.For | ast.comprehension)
        for part in ast.walk(node.target)
        if isinstance(part, ast.Name)
    }
    return frozenset(found - other - loops)


def _says_several(annotation: ast.expr | None) -> bool:
    return isinstance(annotation, ast.Subscript) and ast.unparse(annotation.value) in GATHERED


def _printed(source: str) -> Iterator[tuple[int, str]]:
    for function in ast.walk(ast.parse(source)):
        if isinstance(function, Function):
            of_several = _names_of_several(function)
            for node in ast.walk(function):
                if isinstance(node, ast.FormattedValue) and _is_gathered(node.value, of_several):
                    yield node.lineno, ast.unparse(node.value)


def test_no_list_is_printed_into_a_sentence() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {value}"
        for package in ("rig", "procedures", "ams")
        for path in sorted((ROOT / package).rglob("*.py"))
        for line, value in _printed(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_the_law_sees_what_it_is_about() -> None:
    seen = dict(_printed("def f(a: list[str]):\n b = [1]\n c = 'x'\n return f'{a} {b} {c} {sorted(a)} {len(a)}'\n"))
    assert list(_printed("def f(a: list[str]):\n return f'{sorted(a)} {len(a)}'\n")) == [(2, "sorted(a)")]
    assert seen
