"""Observers of other distributions: each is told what a run tells, in the engine's thread, and none can end it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from procedures.errors import RequestError
from procedures.records.progress import Progress, RunObserver
from rig.registry import Registry


@dataclass(frozen=True)
class ObserverKind:
    """What an entry point ``calrig.observers`` names."""

    name: str
    make: Callable[[Path], RunObserver | None]
    """Called with the folder of a run that begins; None where it has nothing to do there."""


OBSERVERS: Registry[ObserverKind] = Registry("calrig.observers", ObserverKind, RequestError)


class Audience:
    """Tells everybody in turn; who raises is told no more, and that he failed is said once."""

    def __init__(
        self, first: RunObserver, others: Sequence[tuple[str, RunObserver]], failed: Callable[[str], None]
    ) -> None:
        """``first``: the one that never fails, such as the screen."""
        self._first = first
        self._others = list(others)
        self._failed = failed

    def on_event(self, progress: Progress) -> None:
        self._first.on_event(progress)
        for named in list(self._others):
            name, observer = named
            try:
                observer.on_event(progress)
            except Exception as error:  # noqa: BLE001  a rim: nobody who only looks ends a run
                self._others.remove(named)
                self._failed(f"{_failure(name, error)}; it is told no more; the run goes on")


def with_observers(first: RunObserver, run_dir: Path, failed: Callable[[str], None]) -> RunObserver:
    """Return ``first`` and everybody who is registered; what cannot be made is told and left out."""
    others: list[tuple[str, RunObserver]] = []
    for name in OBSERVERS:
        try:
            made = OBSERVERS[name].make(run_dir)
        except Exception as error:  # noqa: BLE001  a rim: what other people install keeps no run from its beginning
            failed(f"{_failure(name, error)}; the run goes on without it")
            continue
        if made is not None:
            others.append((name, made))
    return Audience(first, others, failed) if others else first


def _failure(name: str, error: Exception) -> str:
    return f"observer {name}: {type(error).__name__}: {error}"
