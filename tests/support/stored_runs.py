"""Runs that earlier versions stored under ``tests/data/runs_*``: where they are, and copies that a test may change."""

import hashlib
import json
import shutil
import sqlite3
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

DATA = Path(__file__).parents[1] / "data"
VERSIONS = sorted(DATA.glob("runs_*"))
BETWEEN_PROCESSORS = (2e-10, 1e-15)
"""Largest change of a solved number, relative, and absolute where a zero is stored, that is none of ours.

The linear algebra under numpy takes other kernels on other processors (AVX2, AVX512), which add in another order, and
another Python brings another build of it; an ill-conditioned fit then moves by more than the 1e-12 that one of them
keeps, the coning of one replication of a profile by 6.5e-11. Numbers that nothing is solved for stay
at 1e-12 everywhere.
"""
Leaf = tuple[str, Any, float]
"""Path, what stands there, and the scale of its neighbours, which is 0 where it is no number."""


REWORDED = (
    ("rest on 1 degrees of freedom", "rest on 1 degree of freedom"),
    (" deg (k = 2)", "° (k = 2)"),
    ("the allowed ±0.1 deg", "the allowed ±0.1°"),
    ("coning_deg and azimuth_deg null", "coning angle and azimuth are not determined"),
)
"""What sentences of stored results have been changed to since: names of parameters to words, units to signs."""


@dataclass(frozen=True)
class StoredCase:
    """One kind of procedure as one version did it."""

    folder: Path

    @property
    def numbers(self) -> dict[str, Any]:
        """What the version that stored it solved from the finished run."""
        return _sensors(self.folder / "numbers.json")

    @property
    def began_elsewhere(self) -> bool:
        """Whether its motion begins anew after a resume: samples then meet it at other moments, with other numbers."""
        return self.folder.name.startswith("profile_")

    def copy(self, run: str, target: Path) -> Path:
        """A copy of the ``finished`` or the ``interrupted`` run."""
        return Path(shutil.copytree(self.folder / run, target))


def _sensors(path: Path) -> dict[str, Any]:
    document: dict[str, dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
    return document["sensors"]


CASES = [StoredCase(folder) for version in VERSIONS for folder in sorted(version.iterdir()) if folder.is_dir()]


def name_of(case: StoredCase) -> str:
    """Version and kind, for the names of tests."""
    return f"{case.folder.parent.name}-{case.folder.name}"


def hashes_of_data() -> dict[str, str]:
    """Path to SHA-256 of every stored file."""
    return {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in DATA.rglob("*") if path.is_file()}


def header_of(journal: Path) -> dict[str, Any]:
    """The header's document by ``sqlite3`` alone; of a copy, because a log beside it is read into it."""
    connection = sqlite3.connect(journal)
    (text,) = connection.execute("SELECT document FROM header").fetchone()
    connection.close()
    document: dict[str, Any] = json.loads(text)
    return document


def is_of_uncertainty(path: str) -> bool:
    """Whether a better budget may move what stands there; the rest are coefficients, which nothing may move."""
    words = ("uncertainty", "covariance", "budget", "interval", "degrees_of_freedom", "warnings", "remarks", "advice")
    return any(word in path for word in words)


def leaves(document: object, path: str = "", scale: float = 0.0) -> Iterator[Leaf]:
    """Every value of a JSON document; a number in a list is on the scale of the largest of the outermost list."""
    if isinstance(document, dict):
        for key, item in document.items():
            yield from leaves(item, f"{path}/{key}", scale)
    elif isinstance(document, list):
        scale = scale or max((abs(number) for number in _numbers(document)), default=0.0)
        for index, item in enumerate(document):
            yield from leaves(item, f"{path}/{index}", scale)
    else:
        yield path, document, max(scale, abs(document)) if _is_number(document) else 0.0


def moved(then: object, now: object, relative: float = 1e-12, of_zero: float = 0.0) -> list[str]:
    """What of ``then`` is not so in ``now``, a sentence each; what ``now`` says beside it is no matter."""
    found = {path: value for path, value, _ in leaves(now)}
    return [
        f"{path}: was {value!r}, is {found.get(path, 'absent')!r}"
        for path, value, scale in leaves(then)
        if not _is_same(_reworded(value), found.get(path, "absent"), relative * scale or of_zero)
    ]


def _reworded(value: object) -> object:
    """What is stored, its sentences as they are written now: the numbers in them stay as they were."""
    if isinstance(value, str):
        for before, since in REWORDED:
            value = value.replace(before, since)
    return value


def _is_same(then: object, now: object, allowed: float) -> bool:
    if _is_number(then) and _is_number(now):
        return abs(then - now) <= allowed  # type: ignore[operator]
    return then == now


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _numbers(document: object) -> Iterator[float]:
    if isinstance(document, list):
        for item in document:
            yield from _numbers(item)
    elif isinstance(document, int | float) and not isinstance(document, bool):
        yield document
