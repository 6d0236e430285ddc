"""What depends on the design of a calibration alone, computed once for all axes and packages that share it.

The key is the content of the arguments, not their identity: packages of a batch bring equal arrays of their own. What
is remembered is handed out read-only.
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from threading import Lock
from typing import ParamSpec, TypeVar

import numpy as np

P = ParamSpec("P")
R = TypeVar("R")


def remembered(most: int) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Remember the last ``most`` results of a function of arrays and hashable values; pure functions only."""

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        known: OrderedDict[Hashable, R] = OrderedDict()
        lock = Lock()

        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            key = (*map(_key, args), *((name, _key(value)) for name, value in kwargs.items()))
            with lock:
                if key in known:
                    known.move_to_end(key)
                    return known[key]
            found = function(*args, **kwargs)
            if isinstance(found, np.ndarray):
                found.flags.writeable = False
            with lock:
                known[key] = found
                while len(known) > most:
                    known.popitem(last=False)
            return found

        return called

    return wrap


def _key(value: object) -> Hashable:
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    assert isinstance(value, Hashable), "what is remembered is a function of arrays and hashable values"
    return value
