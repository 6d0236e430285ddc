"""All benchmarks in one table, every figure beside its target. Names of benchmarks select some.

A missed target is printed, not an error: a busy machine misses some. A script that fails is.
"""

import sys
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module

from bench.figure import Figure

BENCHMARKS = ("fit", "engine", "rehearsal", "startup", "streams", "ports", "archive", "resolve", "attitude")


def main(names: Iterable[str]) -> None:
    """Measure the named benchmarks, print every figure as it comes."""
    print(f"{'figure':<50}{'measured':>12}  {'target':>12}")
    for figure in _figures(tuple(names) or BENCHMARKS):
        sign = "≤" if figure.at_most else "≥"
        verdict = "" if figure.is_met else "   MISSED"
        note = f"   {figure.note}" if figure.note else ""
        print(
            f"{figure.what:<50}{figure.value:>9.3g} {figure.unit:<4}{sign:>2}{figure.target:>7g} {figure.unit:<4}"
            f"{verdict}{note}",
            flush=True,
        )


def _figures(names: Iterable[str]) -> Iterator[Figure]:
    for name in names:
        figures: Callable[[], Iterator[Figure]] = import_module(f"bench.{name}").figures
        yield from figures()


if __name__ == "__main__":
    main(sys.argv[1:])
