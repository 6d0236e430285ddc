"""Whose defect an error is that nobody expected: calrig's, or that of a part that another distribution registered."""

import traceback
from functools import cache
from importlib.metadata import entry_points

OURS = frozenset({"ams", "calrig", "procedures", "rig"})
_GROUPS = "calrig."


def defect_text(error: BaseException) -> str:
    """Return what to say of an error: the deepest frame of calrig or of a part of others tells whose it is."""
    return f"a defect of {_owner(error)}: {type(error).__name__}: {error}"


def is_ours(error: BaseException) -> bool:
    return _owner(error) == "calrig"


def _owner(error: BaseException) -> str:
    foreign = _foreign()
    for frame, _ in reversed(list(traceback.walk_tb(error.__traceback__))):
        package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        if package in foreign:
            return f"{foreign[package]} (installed beside calrig)"
        if package in OURS:
            break
    return "calrig"


@cache
def _foreign() -> dict[str, str]:
    """Return the distribution of each package that registered a part."""
    installed = entry_points()
    return {
        entry.value.partition(":")[0].partition(".")[0]: entry.dist.name
        for group in installed.groups
        if group.startswith(_GROUPS)
        for entry in installed.select(group=group)
        if entry.dist is not None and entry.dist.name != "calrig"
    }
