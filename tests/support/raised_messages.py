"""Every message that a part of the code can raise, read from its source: the fixed words, values left out as …"""

import ast
from collections.abc import Iterator
from pathlib import Path

ERRORS = (
    "RequestError",
    "JournalError",
    "StorageFailed",
    "JournalReplaced",
    "JournalTakenAway",
    "ChamberFault",
    "DeviceFault",
    "GuardLost",
    "DescriptionError",
    "NotDelivered",
    "TrustLost",
    "Ending",
    "Alarm",
)


def messages_in(folder: Path) -> Iterator[tuple[str, str]]:
    """(file, message) of every error, alarm and ending that is made in the files under ``folder``."""
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ERRORS:
                texts = [_text(part) for part in node.args]
                message = max(texts, key=len, default="")
                if len(message.replace("…", "").split()) >= 2:
                    yield path.name, message


def texts_in(folder: Path) -> Iterator[str]:
    """Every literal or formatted text in the files under ``folder``."""
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.expr) and (text := _text(node)):
                yield text


def _text(node: ast.expr) -> str:
    """Of a literal or formatted text; empty for anything else."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(part) if isinstance(part, ast.Constant) else "…" for part in node.values)
    return ""
