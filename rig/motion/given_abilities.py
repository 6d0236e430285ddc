"""What an axis behind the supervisor can do is what its driver can, and nothing else."""

from collections.abc import Callable, Mapping
from typing import Any, Final

_AS_THEY_ARE: Final = (
    "check_rate",
    "top_rate_dps",
    "stop_steps",
    "home_mark",
    "resume_home",
    "watchdog_s",
    "feed_watchdog",
    "disarm_watchdog",
)


def give_abilities(supervised: object, axis: object, watched: Mapping[str, Callable[..., Any]]) -> None:
    """Give the supervised axis the members of ``axis``: those of ``watched`` in their place, others as they are.

    Whether a device can turn, remember or watch its host is asked by its members (:mod:`rig.abilities.abilities`).
    """
    members = {**{name: getattr(axis, name, None) for name in _AS_THEY_ARE}, **watched}
    for name, member in members.items():
        if hasattr(axis, name):
            setattr(supervised, name, member)
