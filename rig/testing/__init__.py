"""Laws that every driver keeps, for calrig's own and for those of other distributions.

``keep_promises`` holds one device of an open rig to the laws of its ability; ``survive_damage`` damages its line;
``rig_on`` opens a rig file of twins in memory, over TCP or over a pseudo-terminal. No test runner is needed: a broken
law is an AssertionError with a sentence. How they are used: docs/own-driver.md.
"""

from rig.testing.damage import DAMAGES, MISTAKEN, survive_damage
from rig.testing.promises import keep_promises
from rig.testing.rigs import LINES, rig_on

__all__ = ["DAMAGES", "LINES", "MISTAKEN", "keep_promises", "rig_on", "survive_damage"]
