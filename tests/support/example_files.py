"""The example files of the repository, and variants of them with one thing changed."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE_RIG = ROOT / "examples" / "rig.toml"
EXAMPLE_PROCEDURE = ROOT / "examples" / "procedure.toml"


def changed(path: Path, old: str, new: str, target: Path) -> Path:
    """A copy of ``path`` at ``target`` with the first ``old`` replaced; fails where ``old`` does not stand."""
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{path} does not contain {old!r}"
    target.write_text(text.replace(old, new, 1), encoding="utf-8")
    return target
