"""What depends on the design of a calibration alone, computed once for all axes and packages that share it.

The key is the content of the arguments, not their identity: packages of a batch bring equal arrays of their own. What
is remembered is handed out read-only, and is known by a number where it is an argument in turn, so that a chain of such
functions looks at the content of the first arguments only.
"""

from collections.abc import Callable, Hashable
from dataclasses import fields, is_dataclass
from functools import partial, wraps
from itertools import count
from threading import Lock
from typing import Any, Final, Generic, ParamSpec, TypeVar
from weakref import ref

import numpy as np

P = ParamSpec("P")
R = TypeVar("R")
_MOST_BYTES: Final = 1_000_000
"""Of arguments: what is larger takes longer to compare, and more room, than it is worth."""
_SAMPLE: Final = 512
"""Bytes that content is looked up by: the hash of all of them takes ten times as long as the comparison that decides.
"""
_NUMBERS: Final = count()
_HANDED_OUT: Final[dict[int, "tuple[ref[np.ndarray], int]"]] = {}
"""Identity of an array to itself, while it is alive, and the number that it is known by."""


def remembered(most: int) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Remember the last ``most`` results of a function of arrays, hashable values and tuples of them.

    Pure functions only, whose arrays are new: a view of an argument would change with it.
    """

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        known: dict[Hashable, _Result[R]] = {}
        lock = Lock()

        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            key = _key((*args, *kwargs.values(), *kwargs) if kwargs else args)
            if key is None:
                return function(*args, **kwargs)
            entry = known.get(key)
            if entry is not None:
                entry.last_use = next(_NUMBERS)
                return entry.found
            found = function(*args, **kwargs)
            _hand_out(found)
            with lock:
                known[key] = _Result(found)
                while len(known) > most:
                    del known[min(known, key=lambda other: known[other].last_use)]
            return found

        return called

    return wrap


class _Result(Generic[R]):
    """What was found, and when it was used last, as a number that grows: the lowest is forgotten first."""

    __slots__ = ("found", "last_use")

    def __init__(self, found: R) -> None:
        self.found, self.last_use = found, next(_NUMBERS)


@remembered(32)
def known(values: np.ndarray) -> np.ndarray:
    """Return an array as the one of its content that is handed out: its content is looked at this once."""
    return values.copy()


def _hand_out(found: object) -> None:
    for part in found if isinstance(found, tuple) else (found,):
        if is_dataclass(part):
            _hand_out(tuple(getattr(part, entry.name) for entry in fields(part)))
        elif isinstance(part, tuple):
            _hand_out(part)
        elif isinstance(part, np.ndarray) and not _is_handed_out(part):
            part.flags.writeable = False
            _HANDED_OUT[id(part)] = (ref(part, partial(_forget, id(part))), next(_NUMBERS))


def _is_handed_out(array: np.ndarray) -> bool:
    entry = _HANDED_OUT.get(id(array))
    return entry is not None and entry[0]() is array and not array.flags.writeable


def _forget(key: int, _: object) -> None:
    _HANDED_OUT.pop(key, None)


def _key(values: tuple[Any, ...]) -> tuple[Hashable, ...] | None:
    """Return what arguments are known by; None where it is too much to compare."""
    parts: list[Hashable] = []
    unknown = 0
    for value in values:
        if isinstance(value, tuple):
            within = _key(value)
            if within is None:
                return None
            parts.append(within)
        elif not isinstance(value, np.ndarray):
            parts.append(value)
        elif (known := _HANDED_OUT.get(id(value))) and known[0]() is value and not value.flags.writeable:
            parts.append(known[1])
        else:
            unknown += value.nbytes
            if unknown > _MOST_BYTES:
                return None
            parts.append(_Content(value))
    return tuple(parts)


class _Content:
    """An array by its content: it is found by a sample of its bytes, and compared byte for byte."""

    __slots__ = ("form", "found_by", "whole")

    def __init__(self, array: np.ndarray) -> None:
        self.form, self.whole = (array.dtype.str, array.shape), array.tobytes()
        self.found_by = hash((self.form, self.whole[:: len(self.whole) // _SAMPLE | 1], self.whole[-_SAMPLE:]))

    def __hash__(self) -> int:
        return self.found_by

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Content) and self.form == other.form and self.whole == other.whole
