"""The laws that every driver keeps, for drivers of other distributions: docs/own-driver.md."""

from rig.testing import (
    DAMAGES,
    LINES,
    MISTAKEN,
    keep_promises,
    rig_on,
    survive_damage,
)

__all__ = [
    "DAMAGES",
    "LINES",
    "MISTAKEN",
    "keep_promises",
    "rig_on",
    "survive_damage",
]
