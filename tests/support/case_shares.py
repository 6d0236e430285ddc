"""Cases of a law shared between `make test` and `make thorough`: the first has a share, and none is dropped."""

from collections.abc import Iterable
from itertools import product

import pytest


def rest_to_thorough(*values: Iterable[object], every: int, first: int = 0) -> list[object]:
    """Return all combinations of the values; each but the ``every``-th, from ``first``, is left to `make thorough`."""
    cases = list(product(*values))
    return [
        pytest.param(*case, marks=() if index % every == first else pytest.mark.thorough)
        for index, case in enumerate(cases)
    ]
