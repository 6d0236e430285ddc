"""What a finding says is printed on pages, papers and terminals alike: no mark-up stands in it."""

import ast
from pathlib import Path

import ams

ROOT = Path(ams.__file__).parent


def test_no_sentence_of_a_diagnosis_has_a_backtick() -> None:
    for path in sorted((*(ROOT / "analysis").rglob("*.py"), *(ROOT / "calibration").rglob("*.py"))):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
                assert "`" not in node.value, f"{path}:{node.lineno}"
