"""What a visitor may do: by role, and by where the browser is.

What makes the rig stand still is never refused for a place. What begins motion while nobody watches the rig (a
``continue``, the arming of the queue, a jog) is refused to a browser of another machine, unless the rig file allows it
and the visitor told the code that stands on the console's own terminal: who has the hands in the rig is asked first.
"""

from collections.abc import Mapping
from typing import Literal

from procedures.accounts.people import ROLES, Role
from procedures.console.sessions import Visitor
from procedures.queue.state import LETS_START
from rig.description.rig_file import RigDescription

Act = Literal[
    "pause", "continue", "stop", "abort", "note", "ack", "void", "redo",
    "add", "arm", "disarm", "move", "remove", "attest", "decide", "jog", "halt",
]  # fmt: skip
NEEDED: Mapping[Act, Role] = {
    "pause": "operate",
    "continue": "operate",
    "stop": "operate",
    "abort": "operate",
    "note": "operate",
    "ack": "operate",
    "void": "operate",
    "redo": "operate",
    "add": "operate",
    "disarm": "operate",
    "move": "operate",
    "remove": "operate",
    "attest": "operate",
    "arm": "move",
    "decide": "move",
    "jog": "move",
    "halt": "operate",
}
BEGINS_MOTION: tuple[Act, ...] = ("continue", "arm", "decide", "jog")
LETS_MOVE: frozenset[str] = frozenset({*LETS_START, "void", "redo"})
"""What begins no motion, and after which an armed queue could begin some that would not have come: who may not arm it
disarms it by each of these."""
STOPS: tuple[Act, ...] = ("stop", "abort", "halt")


def refusal(act: Act, visitor: Visitor, rig: RigDescription | None, *, is_elsewhere: bool) -> str:
    """Return why the visitor may not do it; empty where it may. ``rig``: that of the run; None where it is unknown."""
    needed = NEEDED[act]
    if ROLES.index(visitor.role) < ROLES.index(needed):
        return f"{act} needs the role {needed}, and {visitor.name} has the role {visitor.role}; nothing was done"
    if act in BEGINS_MOTION and is_elsewhere:
        return refused_elsewhere(act, rig) or _without_code(act, visitor)
    return ""


def refused_elsewhere(act: Act, rig: RigDescription | None) -> str:
    """Return why motion is not begun from another machine; empty where the rig file allows it."""
    if rig is not None and rig.console.motion_from_elsewhere:
        return ""
    return (
        f"{act} begins motion, and this browser is on another machine than the rig; nothing was done; do it at the "
        "rig, or allow it in the rig file ([console] motion_from_elsewhere = true)"
    )


def _without_code(act: Act, visitor: Visitor) -> str:
    if visitor.may_move:
        return ""
    return f"{act} begins motion; nothing was done; tell first the code that stands on the terminal of the console"
