"""What people are told at the end of a run: what it came to, what to do, and where the report is."""

import shlex
from collections.abc import Mapping
from typing import Final

from procedures.delivery.deliver import Delivery
from procedures.report.summary import worst_uncertainty
from procedures.report.view import RunView, Trust

MOST_NAMES = 4
"""In a subject."""
ENDED: Final[Mapping[Trust, tuple[str, str]]] = {
    "sound": ("finished: sound", "Nothing has to be done now."),
    "reserved": (
        "finished: usable with reservations",
        "Nothing has to be done now; read the reservations in the report before the sensors leave.",
    ),
    "unusable": (
        "finished: not to be used",
        "Leave the sensors as they are mounted until the grounds are read: {handover} says what comes next.",
    ),
}
"""How a verdict is told, and what whoever hears it does."""
_UNREPORTED = "Leave the sensors as they are mounted until there is a report: {handover} says what comes next."


def last_word(delivery: Delivery) -> tuple[str, str]:
    """Say what the run came to, for who is told of its end: usable or not, the worst uncertainty, what to do, where."""
    missing = [f"{part}: {failure}" for part, failure in delivery.failures.items()]
    stands = "The run has ended, and every axis was seen to stand."
    if delivery.view is None:
        return "finished, but without a report", "\n".join([*missing, stands])
    word, to_do = ENDED[delivery.view.verdict.trust]
    run = shlex.quote(str(delivery.run.folder))
    is_there = "html" not in delivery.failures
    page = delivery.report.resolve().as_uri() if is_there else f"There is no report yet: calrig solve {run} makes it."
    to_do = to_do if is_there else _UNREPORTED
    handover = f"calrig handover {run}"
    lines = (
        delivery.view.verdict.sentence,
        worst_uncertainty(delivery.view),
        *missing,
        f"{stands} {to_do.format(handover=handover)}",
        page,
    )
    return partly_usable(delivery.view) or word, "\n".join(line for line in lines if line)


def partly_usable(view: RunView) -> str:
    """Say of a run that is not to be used as a whole how many sensors are, and which are not; empty where all or none
    are, by the verdicts of their sets.
    """
    spoiled = [sensor.name for sensor in view.sensors if sensor.failure or sensor.verdict == "not usable"]
    usable = len(view.sensors) - len(spoiled)
    if view.verdict.trust != "unusable" or not usable or not spoiled:
        return ""
    more = f" and {len(spoiled) - MOST_NAMES} more" if len(spoiled) > MOST_NAMES else ""
    return f"finished: {usable} of {len(view.sensors)} sensors usable, not {', '.join(spoiled[:MOST_NAMES])}{more}"
