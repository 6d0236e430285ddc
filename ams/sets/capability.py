"""What a laboratory has shown it can do, as the smallest expanded uncertainty that is stated of a coefficient.

The capability (CMC) is an angle, an expanded uncertainty of 95 % with k = 2. For each coefficient it is the angle's
effect: on the offsets, the sensitivity and the components of the sensitive axis S·capability, on the azimuth
capability/sin Ω. Certificate and Digital Calibration Certificate state it alike.
Source: ISO/IEC 17025:2017, 7.8.4.1; ILAC-P14:09/2020, 5.4.
"""

from math import hypot, radians, sin
from typing import Final

from ams.models.extended import TRACELESS_NAME
from ams.sets.canonical import Document, number, table
from ams.sets.coefficients import CoefficientSet

COVERAGE_FACTOR: Final = 2.0
"""With which a capability is declared: 95 %, normal."""
_ANGLES: Final = ("coning_deg", "pitch_misalignment_deg")
_OUTPUTS: Final = (
    "offset_v",
    TRACELESS_NAME,
    "sensitivity_v_per_g",
    *(f"k_{component}_v_per_g" for component in "xyz"),
)


def capability_deg_of(coefficients: CoefficientSet) -> float | None:
    """Return what the laboratory of a set declares; None where it declares none."""
    stated = table(coefficients.provenance["laboratory"] or {}).get("capability_deg")
    return None if stated is None else number(stated)


def smallest_expanded(name: str, section: Document, capability_deg: float | None) -> float:
    """Return the capability as an uncertainty of one coefficient, in its unit; 0 where it says nothing about it.

    ``section``: of the coefficient's axis. An angle that a laboratory can tell by gravity says nothing about a sensor
    of rates.
    """
    # Null or missing for a sensor of another unit.
    values = list(table(section.get("sensitive_axis_v_per_g", {})).values())
    if not capability_deg or None in values or not values:
        return 0.0
    if name in _OUTPUTS:
        return hypot(*map(number, values)) * radians(capability_deg)
    if name == "azimuth_deg":
        coning = table(table(section["parameters"])["coning_deg"])["value"]
        tilt = sin(radians(number(coning))) if coning is not None else 0.0
        return capability_deg / tilt if tilt > 0.0 else 0.0
    return capability_deg if name in _ANGLES else 0.0
