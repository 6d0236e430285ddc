"""Every library that an installation brings may be used in a closed laboratory: permissive, or named in the page."""

import re
from importlib.metadata import PackageNotFoundError, metadata, requires
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "licences.md"
PERMISSIVE = re.compile(
    r"\b(MIT|BSD|0BSD|Apache|PSF|Python Software Foundation|Zlib|CC0|any-OSI|ISC)\b|MIT-CMU|Historical", re.IGNORECASE
)


def test_what_is_not_permissive_is_named_in_the_page() -> None:
    found = _brought()
    assert len(found) > 60
    others = sorted(name for name, licence in found.items() if not PERMISSIVE.search(licence))
    text = PAGE.read_text(encoding="utf-8")
    named = sorted(re.findall(r"^\| `([\w-]+)` \|", text, flags=re.MULTILINE))
    assert others == named


def _brought() -> dict[str, str]:
    """Name to licence of everything that ``calrig[all]`` brings here, as the distributions state it."""
    found: dict[str, str] = {}
    waiting = [Requirement("calrig[all]")]
    while waiting:
        wanted = waiting.pop()
        name = re.sub("[-_.]+", "-", wanted.name).lower()
        try:
            said = metadata(wanted.name)
        except PackageNotFoundError:
            continue  # of another system or Python
        is_new = name not in found
        classifiers = [line.rpartition("::")[2] for line in said.get_all("Classifier") or [] if "License ::" in line]
        found[name] = said.get("License-Expression") or "; ".join(classifiers) or (said.get("License") or "?")[:40]
        if is_new or wanted.extras:
            for line in requires(wanted.name) or ():
                needed = Requirement(line)
                extras = [{"extra": extra} for extra in wanted.extras] or [{"extra": ""}]
                if needed.marker is None or any(needed.marker.evaluate(extra) for extra in extras):
                    waiting.append(needed)
    return found
