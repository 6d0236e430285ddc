"""What takes how much of U95, in words."""

from collections.abc import Mapping

from ams.analysis.angle_uncertainty import ADDED
from ams.units import ARCSEC_PER_DEG

LOW_ORDER = "low-order terms"
LOW_ORDER_MEANS = (
    f"{LOW_ORDER}: what the terms of second and third order add, since a table that is off once or twice a turn and a "
    "sensor that bends look alike"
)


def shares_in_words(shares_deg: Mapping[str, float]) -> str:
    """Return each source with what it takes, arc seconds, the largest first."""
    ordered = sorted(shares_deg.items(), key=lambda item: -abs(item[1]))
    return ", ".join(
        f"{LOW_ORDER if source == ADDED else source} {share * ARCSEC_PER_DEG:.2g}" for source, share in ordered
    )


def explained(shares_deg: Mapping[str, float]) -> list[str]:
    """Return what a word of the shares means, where it stands among them."""
    return [LOW_ORDER_MEANS] if ADDED in shares_deg else []
