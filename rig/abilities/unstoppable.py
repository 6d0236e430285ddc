"""Axes that nobody stops when calrig dies, in the words that everybody says of them."""

from rig.abilities.abilities import Stoppable


def why_unstoppable(axis: object, name: str) -> str:
    """Return what to say of an axis that nobody stops when calrig dies; empty where the stop guard can."""
    if not isinstance(axis, Stoppable):
        why = "its driver has no stop_steps"
    elif not axis.stop_steps():
        why = "its machine has no stop"
    else:
        return ""
    return (
        f"axes.{name}: nothing stops it when calrig dies: {why}; a move that was started goes on to its target; keep"
        " the machine's own stop button within reach"
    )
