"""What is registered by entry points: calrig's own parts and those of other distributions, in one way.

A distribution names an object in its ``pyproject.toml`` (``[project.entry-points."calrig.exports"]``), and calrig's own
file does the same. Names are read without importing anything; the object behind a name is imported when it is used.
``ams/registry.py`` and ``rig/registry.py`` are the same text, because the two packages do not know each other.
"""

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from typing import Protocol, TypeVar

OWNER = "calrig"
"""The distribution whose names no other may take."""


class Named(Protocol):
    """What can be registered: an object that says its own name."""

    @property
    def name(self) -> str: ...


Part = TypeVar("Part", bound=Named)


class Registry(Mapping[str, Part]):
    """Name to object: calrig's own names first, then those of other distributions, each part in the order of letters.

    Every method raises ``error`` with a sentence where the registrations contradict each other, where calrig's own are
    missing, or where what is registered cannot be imported or is of another kind.
    """

    def __init__(self, group: str, kind: type[Part], error: type[Exception]) -> None:
        self._group = group
        self._kind = kind
        self._error = error
        self._read_by: Callable[..., EntryPoints] | None = None
        self._found: dict[str, EntryPoint] = {}
        self._parts: dict[str, Part] = {}

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries())

    def __len__(self) -> int:
        return len(self._entries())

    def __contains__(self, name: object) -> bool:
        return name in self._entries()

    def __getitem__(self, name: str) -> Part:
        """Return the object. Raises: KeyError where nothing has the name, and as the class says."""
        entry = self._entries()[name]
        if name not in self._parts:
            self._parts[name] = self._loaded(entry)
        return self._parts[name]

    def foreign(self) -> dict[str, str]:
        """Return the names of other distributions, each with the distribution it comes from."""
        return {name: _owner(entry) for name, entry in self._entries().items() if _owner(entry) != OWNER}

    def _entries(self) -> dict[str, EntryPoint]:
        select = _select(tuple(sys.path))
        if select is not self._read_by:
            self._found, self._parts = self._read(select), {}
            self._read_by = select
        return self._found

    def _read(self, select: Callable[..., EntryPoints]) -> dict[str, EntryPoint]:
        found: dict[str, EntryPoint] = {}
        for entry in select(group=self._group):
            other = found.setdefault(entry.name, entry)
            if other.value != entry.value or _owner(other) != _owner(entry):
                raise self._error(
                    f"{self._group}: two distributions register {entry.name!r}: {_owner(other)} ({other.value}) and "
                    f"{_owner(entry)} ({entry.value}); a name stands for one thing; rename or uninstall one of them"
                )
        if not any(_owner(entry) == OWNER for entry in found.values()):
            raise self._error(
                f"{self._group}: the installation of calrig is incomplete: its own entry points are missing; install "
                "calrig again (in a copy of its repository: python -m pip install --no-deps --editable .)"
            )
        return dict(sorted(found.items(), key=lambda pair: (_owner(pair[1]) != OWNER, pair[0])))

    def _loaded(self, entry: EntryPoint) -> Part:
        where = f"{self._group}: {entry.name!r} of {_owner(entry)} ({entry.value})"
        try:
            part = entry.load()
        except Exception as error:
            raise self._error(
                f"{where}: cannot be loaded: {type(error).__name__}: {error}; install {_owner(entry)} again"
            ) from error
        if not isinstance(part, self._kind) or part.name != entry.name:
            raise self._error(
                f"{where}: is registered wrongly: got {part!r:.80}, needed is a {self._kind.__module__}."
                f"{self._kind.__qualname__} with the name {entry.name!r}"
            )
        return part


@cache
def _select(path: tuple[str, ...]) -> Callable[..., EntryPoints]:  # noqa: ARG001  what is found depends on it
    """Return what selects from all entry points installed: they are read once, and again where the path has changed."""
    return entry_points().select


def _owner(entry: EntryPoint) -> str:
    name = entry.dist.name if entry.dist is not None else "an unknown distribution"
    return re.sub(r"[-_.]+", "-", name).lower()
