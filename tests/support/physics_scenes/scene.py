"""A scene's entry: its name, its physics, its sizes, and the cause that a calibration ought to name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from physics_scenes.designs import Setup
from physics_scenes.world import draw_campaign

CAUSES = (
    "wrong-dwell", "lack-of-fit", "quadratic", "cubic", "asymmetry", "cross-coupling", "drift", "autocorrelation",
    "temperature-residual", "temperature-lag", "temperature-curvature", "table-rotation", "meter-gain", "meter-offset",
    "sensor-change", "level-undeclared", "time-confounded", "field-contradicted", "uneven-noise",
)  # fmt: skip
"""The closed list of findings."""


@dataclass(frozen=True)
class Scene:
    """One kind of thing that happens to a campaign, in sizes from nothing to obvious."""

    name: str
    build: Callable[..., Any]
    unit: str
    """Of the sizes."""
    sizes: tuple[float, ...]
    """From nothing through the threshold of detection at the default design to obvious."""
    true_cause: str | None = None
    """The finding that is right where the size is beyond what was declared; None where no data can tell: the stated
    uncertainty has to cover it, from the scatter or from a declared bound."""
    also: tuple[str, ...] = ()
    """Findings that say the same thing of the same data and are right as well."""
    declared_up_to: float | None = None
    """Largest size that is drawn from what was declared; None where the scene contradicts what was declared."""
    design: Mapping[str, Any] = field(default_factory=dict)
    """What the scene needs of `Setup`; a caller's keywords go before it."""
    zero_is_clean: bool = True
    """A scene of size nothing is the clean campaign of the same design."""
    flags_rows: bool = False
    """Rows in use that are grossly wrong ought to be flagged."""
    draws: Callable[..., Any] = draw_campaign
    """(build, size, setup, campaigns, chance) to what the scene shows: `Campaign`, or as `UseReadings` and others."""
    setup: Callable[..., Any] = Setup

    @property
    def physics(self) -> str:
        """What happens, and whose equations say so."""
        return str(self.build.__doc__)

    def is_declared(self, size: float) -> bool:
        """Whether the size lies inside of what was declared beforehand."""
        return size == 0.0 or (self.declared_up_to is not None and size <= self.declared_up_to)

    def causes(self, size: float) -> tuple[str, ...]:
        """Return the findings that are right for a size, the true one first; none where nothing is to be found."""
        if self.true_cause is None or self.is_declared(size):
            return ()
        return self.true_cause, *self.also

    def draw(self, size: float, chance: np.random.Generator, campaigns: int = 1, **design: Any) -> Any:
        """Draw campaigns with one leading axis; `design` are names of the scene's setup."""
        return self.draws(self.build, size, self.setup(**{**self.design, **design}), campaigns, chance)
