"""Whose defect an error is that nobody expected: calrig's, or that of a part that another distribution registered.

Parts of others run inside calrig. Where an error passed through the module of one, its author must read it first: also
where a line of calrig's raised it, for what that line was handed.
"""

from collections.abc import Collection, Iterator
from importlib.metadata import distributions
from traceback import walk_tb

OURS = "calrig"


def defect_text(error: BaseException) -> str:
    """Return what to say of an error: whose defect it is, and what. Raises nothing."""
    return f"a defect of {_owner(error)}: {type(error).__name__}: {error}"


def is_ours(error: BaseException) -> bool:
    return _owner(error) == OURS


def _owner(error: BaseException) -> str:
    passed = {str(frame.f_globals.get("__name__", "")).partition(".")[0] for frame, _ in walk_tb(error.__traceback__)}
    try:
        return next(_parts_of_others(passed), OURS)
    except Exception:  # noqa: BLE001  it is asked while an axis is being stopped: an installation that is broken is ours
        return OURS


def _parts_of_others(packages: Collection[str]) -> Iterator[str]:
    for distribution in distributions():
        for entry in distribution.entry_points if distribution.name.lower() != OURS else ():
            if entry.group.startswith("calrig.") and entry.module.partition(".")[0] in packages:
                what = entry.group.removeprefix("calrig.").removesuffix("s")
                yield f"the {what} {entry.name!r} of {distribution.name} {distribution.version}"
