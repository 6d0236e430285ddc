"""Normal gravity of WGS 84, and whether a stated gravity can be that of a place.

Somigliana's closed form on the ellipsoid and the second-order free-air series above it. What mountains and rocks do to
it (free-air anomalies) reaches 0.003 m/s². Source: NIMA TR8350.2, third edition, 4.
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

EQUATOR_MPS2: Final = 9.7803253359
SOMIGLIANA_K: Final = 0.00193185265241
ECCENTRICITY_SQUARED: Final = 0.00669437999014
SEMI_MAJOR_M: Final = 6_378_137.0
FLATTENING: Final = 1.0 / 298.257223563
CENTRIFUGAL_RATIO: Final = 0.00344978650684
"""ω² a² b / GM."""

ANOMALY_MPS2: Final = 0.0005
"""Standard uncertainty of gravity that is told from latitude and height alone: anomalies at an ordinary place.

PTB states 1e-4 of g for normal gravity at any place on Earth, which is taken as an expanded uncertainty with k = 2.
Source: PTB, department 1.1, g-extractor.
"""
REMARKED_MPS2: Final = 0.0015
REFUSED_MPS2: Final = 0.005
HEIGHTS_M: Final = (-100.0, 3000.0)
"""Between which a laboratory lies whose height is not stated."""


@dataclass(frozen=True)
class Gravity:
    """Local gravity with its standard uncertainty."""

    value_mps2: float
    standard_uncertainty_mps2: float
    """0 where nobody declares it."""
    source: str = ""

    @property
    def in_words(self) -> str:
        """Its value, what is declared of it and where it comes from, as pages and certificates print it."""
        u_mps2 = self.standard_uncertainty_mps2
        known = f", standard uncertainty {1e6 * u_mps2:.3g} µm/s²" if u_mps2 else ", no uncertainty declared"
        return f"{self.value_mps2} m/s²{known}{f' ({self.source})' if self.source else ''}"


def normal_gravity_mps2(latitude_deg: float, height_m: float = 0.0) -> float:
    """Return normal gravity at a geodetic latitude and a height above the ellipsoid."""
    sine_squared = float(np.sin(np.deg2rad(latitude_deg)) ** 2)
    surface = EQUATOR_MPS2 * (1.0 + SOMIGLIANA_K * sine_squared) / (1.0 - ECCENTRICITY_SQUARED * sine_squared) ** 0.5
    first = 2.0 / SEMI_MAJOR_M * (1.0 + FLATTENING + CENTRIFUGAL_RATIO - 2.0 * FLATTENING * sine_squared)
    return float(surface * (1.0 - first * height_m + 3.0 * (height_m / SEMI_MAJOR_M) ** 2))


@dataclass(frozen=True)
class Disagreement:
    """A gravity that is not that of its place."""

    kind: Literal["told", "refused"]
    text: str
    """What is stated, what the place would have, and by how much they differ."""


def disagreement(gravity_mps2: float, latitude_deg: float, height_m: float | None) -> Disagreement | None:
    """Return how a stated gravity disagrees with its place; None where it does not by more than 0.0015 m/s²."""
    low, high = HEIGHTS_M if height_m is None else (height_m, height_m)
    least, most = normal_gravity_mps2(latitude_deg, high), normal_gravity_mps2(latitude_deg, low)
    nearest = min(max(gravity_mps2, least), most)
    off = gravity_mps2 - nearest
    if abs(off) <= REMARKED_MPS2:
        return None
    location = (
        f"{latitude_deg:g}° and {height_m:g} m is {most:.5f}"
        if height_m is not None
        else f"{latitude_deg:g}° is {least:.5f} to {most:.5f} (3000 m to below sea level; height_m says it exactly)"
    )
    is_refused = abs(off) > REFUSED_MPS2
    way_out = "correct one of them" if is_refused else "look whether both are right; anomalies reach 0.003 m/s²"
    text = (
        f"gravity is stated as {gravity_mps2:.5f} m/s²; normal gravity (WGS 84) at latitude {location} m/s²: "
        f"{abs(off):.4f} m/s² {'more' if off > 0 else 'less'}, "
        f"allowed {REFUSED_MPS2 if is_refused else REMARKED_MPS2:g} m/s²; {way_out}"
    )
    return Disagreement("refused" if is_refused else "told", text)
