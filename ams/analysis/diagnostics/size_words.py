"""Sizes as words, and what the words of all tests of one axis are made with."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

import numpy as np

from ams.findings import Said
from ams.rounding import significant, with_uncertainty
from ams.units import ARCSEC_PER_DEG, printed


@dataclass(frozen=True)
class Scale:
    """What turns an output into words: as an angle where the sensitivity is known, in its unit elsewhere."""

    unit: str
    volts_per_radian: float | None

    def words(self, size: float) -> str:
        if self.volts_per_radian is None or abs(size) > self.volts_per_radian:
            return f"{significant(size)} {printed(self.unit)}"
        return f"{significant(np.rad2deg(size / self.volts_per_radian) * ARCSEC_PER_DEG)}″"

    def within(self, size: float, expanded: float) -> str:
        """Return an output with its expanded uncertainty."""
        if self.volts_per_radian is None:
            return f"{within(size, expanded)} {printed(self.unit)}"
        factor = float(np.rad2deg(1.0 / self.volts_per_radian)) * ARCSEC_PER_DEG
        return f"{within(factor * size, factor * expanded)}″"

    def per_g(self, size: float, uncertainty: float) -> str:
        """Return an output per g with twice its standard uncertainty."""
        if self.volts_per_radian is None:
            return f"{within(abs(size), 2.0 * uncertainty)} {printed(self.unit)} a g"
        micro = 1e6 / self.volts_per_radian
        return f"{within(micro * abs(size), 2.0 * micro * uncertainty)} µg a g ({self.words(abs(size))})"


@dataclass(frozen=True)
class AxisWords:
    """What the words of one axis are made with."""

    scale: Scale
    conviction_level: float
    has_table: bool
    """Whether index errors of a table are declared."""
    is_of_levels: bool
    """Whether known levels, not attitudes, are what the points differ by."""
    order_repeats: bool
    """Whether every replication visits the points in the same order."""
    lack_is: Said
    """Whether a lack of fit is in the stated uncertainties."""
    drift_is: str
    """Whether a drift is."""
    drifts: Mapping[str, str]
    """How far each quantity moved from replication to replication."""

    @property
    def or_the_table(self) -> str:
        """What else has the form of a term: nothing where index errors of a table are declared."""
        return "" if self.has_table else "; or indices of the table are wrong, of which nothing is declared"


def within(value: float, expanded: float) -> str:
    """Return a value to the last of the two digits of its ±, which a rounder value would lie outside of."""
    if not (isfinite(value) and isfinite(expanded)) or expanded <= 0.0:
        return f"{significant(value)} ± {significant(expanded)}"
    return " ± ".join(with_uncertainty(value, expanded)).replace("-", "−")
