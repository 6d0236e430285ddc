"""What pages and docstrings name is there: files that moved and parameters that got another name are found."""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs"))
from house import tree_of  # noqa: E402

FOLDERS = ("ams", "rig", "procedures", "tests", "docs", "examples", "bench", ".ci", ".github")
MADE_UP = {"ams/models/mine.py", "ams/exports/mine.py"}
"""Files of a reader's own, which CONTRIBUTING tells how to write."""
OF_A_READER = ("docs/tutorials/first-night.md", "bench/")
"""A page on which a folder of that name is the reader's."""
_PATH = re.compile(rf"(?<![\w/.-])((?:{'|'.join(map(re.escape, FOLDERS))})/[\w./<>*{{}}-]*[\w*/>}}])")
_OPENING = re.compile(
    r"(?:^|(?<=[.;,:] )|(?<=\bfrom ))``([a-z_][a-z_0-9]*)``(?=:| (?:is|are|has|says|its) )", re.MULTILINE
)


def _pages() -> list[Path]:
    return sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


@pytest.fixture(scope="module")
def there() -> set[str]:
    """Every file of the repository and every folder of one."""
    return {
        path.relative_to(ROOT).as_posix()
        for top in FOLDERS
        for path in ((ROOT / top), *(ROOT / top).rglob("*"))
        if path.exists()
    }


def test_every_path_that_a_page_names_is_there(there: set[str]) -> None:
    lost = [
        f"{page.relative_to(ROOT)}:{number}: {path}"
        for page in _pages()
        for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1)
        for path in (found.rstrip("/.") for found in _PATH.findall(line))
        if not set(path) & set("<>*{}") and path not in there | MADE_UP
        if not (page.relative_to(ROOT).as_posix() == OF_A_READER[0] and path.startswith(OF_A_READER[1]))
    ]
    assert lost == []


def _documented(tree: ast.Module) -> Iterator[tuple[str, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and (doc := ast.get_docstring(node)):
            yield node.name, doc


def _words_of(tree: ast.Module) -> set[str]:
    """Return every identifier of a file, and every word of its texts but its docstrings."""
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef | ast.Module)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    words: set[str] = set()
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.arg(arg=name) | ast.Attribute(attr=name) | ast.keyword(arg=str(name)):
                words.add(name)
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                words.add(name)
            case ast.Constant(value=str(text)) if id(node) not in docstrings:
                words |= set(re.findall(r"\w+", text))
    return words


def test_what_a_sentence_of_a_docstring_explains_is_in_the_code() -> None:
    """``word`` before what it is, such as a parameter: where the code has no such word, it was renamed."""
    lost = []
    for package in ("ams", "rig", "procedures"):
        for path in (ROOT / package).rglob("*.py"):
            tree = tree_of(path)
            words = _words_of(tree)
            lost += [
                f"{path.relative_to(ROOT)}: {name}: ``{word}``"
                for name, doc in _documented(tree)
                for word in _OPENING.findall(doc)
                if word not in words
            ]
    assert sorted(lost) == []
