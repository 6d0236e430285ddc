"""The design, the run's own figures, and the check set after restarts.

Of the check set a channel has a row, or in one row many that stand.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from ams.rounding import two_digits
from ams.units import with_unit
from procedures.numbers import as_drawn
from procedures.report.section import Section, fragment_beside
from procedures.report.view import CheckComparison

MOST_THAT_STAND = 6
"""Channels of a restart that have a row each; of more only those that stepped have."""


@dataclass(frozen=True)
class CheckRow:
    """One row, every cell as text."""

    restart: int
    about: str
    attitudes: str
    mean: str
    largest: str
    largest_at: str
    scatter: str
    judged: str


def check_rows(checks: Sequence[CheckComparison]) -> list[CheckRow]:
    """Return the rows, restart by restart: first what stepped, channel by channel, then what stands."""
    return [row for _, members in groupby(checks, key=lambda check: check.epoch) for row in _rows(list(members))]


def _rows(checks: list[CheckComparison]) -> Iterator[CheckRow]:
    standing = [check for check in checks if not check.is_step]
    if len(standing) <= MOST_THAT_STAND:
        yield from map(_row, checks)
        return
    yield from (_row(check) for check in checks if check.is_step)
    for _, alike in groupby(sorted(standing, key=_unit), key=_unit):
        yield _summary(list(alike))


def _row(check: CheckComparison) -> CheckRow:
    return CheckRow(
        check.epoch - 1,
        check.label,
        f"{check.attitudes}",
        _drawn(check, check.mean_change),
        _drawn(check, check.largest_change),
        check.largest_at,
        _drawn(check, check.scatter),
        _with_cause("step" if check.is_step else "stands", check),
    )


def _summary(checks: list[CheckComparison]) -> CheckRow:
    """Return one row for channels of one unit, with the range of each figure and where the largest change was."""
    if len(checks) == 1:
        return _row(checks[0])
    worst = max(checks, key=lambda check: abs(_scaled(check, check.largest_change)))
    return CheckRow(
        worst.epoch - 1,
        f"{len(checks)} channels",
        _span(checks, lambda check: check.attitudes, lambda check: f"{check.attitudes}"),
        _span(checks, lambda check: _scaled(check, check.mean_change), lambda check: _drawn(check, check.mean_change)),
        _drawn(worst, worst.largest_change),
        f"{worst.label}, {worst.largest_at}",
        _span(checks, lambda check: _scaled(check, check.scatter), lambda check: _drawn(check, check.scatter)),
        _with_cause("stand", worst),
    )


def _with_cause(judged: str, check: CheckComparison) -> str:
    """Return what a channel is judged, with whose doing it is: one that stands alone may have turned with all."""
    return f"{judged}; all together: {check.cause}" if check.cause else judged


def _span(
    checks: list[CheckComparison], size: Callable[[CheckComparison], float], text: Callable[[CheckComparison], str]
) -> str:
    low, high = (text(pick(checks, key=size)) for pick in (min, max))
    return low if low == high else f"{low} to {high}"


def _unit(check: CheckComparison) -> str:
    return as_drawn(check.sensitivity_v_per_g, check.unit)[1]


def _scaled(check: CheckComparison, value: float) -> float:
    return value * as_drawn(check.sensitivity_v_per_g, check.unit)[0]


def _drawn(check: CheckComparison, value: float) -> str:
    """Return a change as an angle, or in the channel's unit where no sensitivity makes an angle of it."""
    unit, text = _unit(check), two_digits(_scaled(check, value))
    text = text.replace("-", "−", 1) if text.startswith("-") else text
    return with_unit(text, unit)


SECTION = Section(
    "run",
    200,
    fragment_beside(__file__),
    lambda _view: {"run": "Run and design"},
    data=lambda source: check_rows(source.view.checks),
)
