"""All benchmarks in one table, every figure beside its target. Names of benchmarks select some.

A missed target is printed, not an error: a busy machine misses some. A script that fails is an error, and so is a ratio
to a peer that misses its bound, since a busy machine slows both. ``--tiny`` only looks whether everything runs.
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from importlib import import_module

from bench.figure import Effort, Figure

BENCHMARKS = (
    "fit",
    "engine",
    "rehearsal",
    "startup",
    "streams",
    "ports",
    "archive",
    "resolve",
    "attitude",
    "angles",
    "plan",
    "report",
)


def main(arguments: Sequence[str]) -> int:
    """Measure the named benchmarks, print every figure as it comes; returns 1 where a gated ratio misses its bound."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"any of {', '.join(BENCHMARKS)}; without one, all")
    parser.add_argument("--tiny", action="store_true", help="run everything at its smallest: the figures say nothing")
    options = parser.parse_args(arguments)
    if unknown := set(options.names) - set(BENCHMARKS):
        parser.error(f"no benchmark {', '.join(sorted(unknown))} (allowed: {', '.join(BENCHMARKS)})")
    effort = Effort(options.tiny)
    print(f"{'figure':<50}{'measured':>12}  {'target':>12}")
    failed = []
    for figure in figures_of(options.names or BENCHMARKS, effort):
        sign = "≤" if figure.at_most else "≥"
        verdict = "" if figure.is_met or effort.is_tiny else "   FAILED" if figure.is_gated else "   MISSED"
        if verdict and figure.is_gated:
            failed.append(figure.what.strip())
        note = f"   {figure.note}" if figure.note else ""
        print(
            f"{figure.what:<50}{figure.value:>9.3g} {figure.unit:<4}{sign:>2}{figure.target:>7g} {figure.unit:<4}"
            f"{verdict}{note}",
            flush=True,
        )
    if failed:
        print(f"bench: out of bounds beside its peers: {', '.join(failed)}", file=sys.stderr)
    return int(bool(failed))


def figures_of(names: Iterable[str], effort: Effort) -> Iterator[Figure]:
    """Measure benchmark after benchmark; import each when it is its turn."""
    for name in names:
        figures: Callable[[Effort], Iterator[Figure]] = import_module(f"bench.{name}").figures
        yield from figures(effort)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
