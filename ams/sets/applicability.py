"""Whether a set belongs to the chain it is used with and to the place it is used at.

Sensitivities are in volts per local g, so at another g they are other numbers: 2e-5 m/s², a few metres of height, is
0.4 arc second at 45° of pitch, and as much as a set is moved without a word. The chain (conditioner, filter, meter) is
part of what was calibrated; a set that states no serial cannot be shown to belong to one.
"""

from collections.abc import Mapping
from typing import TypeAlias

from ams.errors import OutsideValidity
from ams.sets.canonical import table
from ams.sets.coefficients import CoefficientSet
from ams.sets.instructions import use_of

LARGEST_GRAVITY_DIFFERENCE_MPS2 = 2e-5
Serials: TypeAlias = str | Mapping[str, str]


def check_applicability(
    coefficients: CoefficientSet, chain_serial: Serials | None, site_gravity_mps2: float | None
) -> None:
    """Refuse a set that does not belong to where it is used.

    Raises: OutsideValidity where it was calibrated with another chain or at another g, or does not say; SetWithdrawn.
    """
    coefficients.require_standing(coefficients.sensor, "nothing was computed")
    if chain_serial is not None:
        _check_chain(coefficients, chain_serial)
    if site_gravity_mps2 is not None and coefficients.senses_gravity:
        _check_site(coefficients, site_gravity_mps2)


def _check_chain(coefficients: CoefficientSet, used: Serials) -> None:
    section = use_of(coefficients.document)
    calibrated = {} if section is None else table(section["chain_serials"])
    if isinstance(used, str):
        used = dict.fromkeys(calibrated or ["the sensor"], used)
    for channel, serial in used.items():
        stated = calibrated.get(channel)
        if stated != serial:
            known = "the set states no serial of it" if stated is None else f"calibrated with {stated!r}"
            raise OutsideValidity(
                f"{coefficients.sensor}: chain of {channel}: is not shown to be the calibrated one: got serial "
                f"{serial!r}, {known}; nothing was computed; use the set of this chain, or calibrate with it"
            )


def _check_site(coefficients: CoefficientSet, site_gravity_mps2: float) -> None:
    calibrated = coefficients.gravity_mps2
    if not abs(site_gravity_mps2 - calibrated) <= LARGEST_GRAVITY_DIFFERENCE_MPS2:
        raise OutsideValidity(
            f"{coefficients.sensor}: site gravity: is not that of the calibration: got {site_gravity_mps2!r} m/s², "
            f"calibrated at {calibrated!r} m/s², allowed difference {LARGEST_GRAVITY_DIFFERENCE_MPS2} m/s²; nothing "
            f"was computed; sensitivities scale with g: multiply every k by {site_gravity_mps2 / calibrated!r} and "
            "answer for it, or calibrate at the site"
        )
