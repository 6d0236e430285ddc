"""The level of the base as the rig file declares it: what was read of it, and what the instrument is wrong by.

A level that was read is not corrected for, so the tilt that it showed is an error of unknown sign up to that size: a
limit. The instrument's own is stated as its standard states it, a limit where none is named. Source: GUM 4.3, F.2.4.5.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot, radians, sqrt
from typing import Literal

from ams.inputs.shared_errors import Effect, SharedError
from ams.units import ARCSEC_PER_DEG
from rig.description.rig_file import RigDescription

_FARTHEST = 2.0
"""Standard uncertainties that a reading of an instrument without a limit may be wrong by."""


def level_warnings(rig: RigDescription) -> tuple[str, ...]:
    """Say that the base moved between its two readings by more than the instrument may be wrong by."""
    before, after = rig.level.before, rig.level.after
    if before is None or after is None:
        return ()
    turned = {
        "pitch": after.about_pitch_arcsec - before.about_pitch_arcsec,
        "roll": after.about_roll_arcsec - before.about_roll_arcsec,
    }
    instrument = _instrument(rig)
    wrong_arcsec = instrument.largest_arcsec
    moved = [f"{by:+.3g}″ about {about}" for about, by in turned.items() if abs(by) > 2.0 * wrong_arcsec]
    if not moved:
        return ()
    return (
        f"the base turned by {' and '.join(moved)} between the readings of its level before and after, more than the "
        f"instrument may be wrong by (±{wrong_arcsec:g}″ each, level.uncertainty_arcsec): the dwells do not stand at "
        "one level; the uncertainties count the larger reading as a limit, and nothing tells when it moved; find what "
        "moved and calibrate again",
    )


def level_errors(rig: RigDescription) -> Iterator[SharedError]:
    """Yield the errors of the base, as it was read before and after, and of the instrument itself.

    Their distribution is that of the larger of the two.
    """
    read = [reading for reading in (rig.level.before, rig.level.after) if reading is not None]
    instrument = _instrument(rig)
    directions: tuple[tuple[str, Effect], ...] = (("about_pitch", "pitch"), ("about_roll", "base-tilt"))
    for key, effect in directions:
        largest_arcsec = max((abs(getattr(reading, f"{key}_arcsec")) for reading in read), default=0.0)
        of_reading_arcsec = largest_arcsec / sqrt(3.0)
        u_rad = radians(hypot(of_reading_arcsec, instrument.u_arcsec) / ARCSEC_PER_DEG)
        if u_rad > 0.0:
            kind = instrument.kind if instrument.u_arcsec > of_reading_arcsec else "limit"
            stated = f"level: read up to {largest_arcsec:g}″, instrument {instrument.stated}"
            yield SharedError(f"level of the base {key.replace('_', ' ')}", effect, u_rad, kind, stated)


@dataclass(frozen=True)
class _Instrument:
    """What is known of the instrument that read the level; arc seconds."""

    kind: Literal["limit", "standard", "expanded"]
    u_arcsec: float
    largest_arcsec: float
    """What one reading may be wrong by."""
    stated: str


def _instrument(rig: RigDescription) -> _Instrument:
    stated_arcsec, name = rig.level.uncertainty_arcsec, rig.level.standard
    standard = rig.standards.get(name or "")
    if standard is None:
        return _Instrument("limit", stated_arcsec / sqrt(3.0), stated_arcsec, f"±{stated_arcsec:g}″")
    u_arcsec = stated_arcsec / standard.divisor
    largest_arcsec = stated_arcsec if standard.kind == "limit" else _FARTHEST * u_arcsec
    coverage = f", k = {standard.k:g}" if standard.kind == "expanded" else ""
    words = f"standards.{name}: {standard.kind} {stated_arcsec:g}″{coverage}"
    return _Instrument(standard.kind, u_arcsec, largest_arcsec, words)
