"""The g where a set is used, as somebody states it, and what it is wrong by."""

from collections.abc import Mapping
from typing import Final

from ams.errors import OutsideValidity
from ams.sets.coefficients import CoefficientSet

LEAST_GRAVITY_MPS2: Final = 9.7
LARGEST_GRAVITY_MPS2: Final = 9.9
LARGEST_UNCERTAINTY_MPS2: Final = 0.05
"""Half of what normal gravity spans between equator and poles: beyond it nothing is stated."""
_AT_CALIBRATION: Final = "local gravity"
_AT_USE: Final = "gravity at use"


def check_site_gravity(coefficients: CoefficientSet, site_mps2: float | None, uncertainty_mps2: float | None) -> None:
    """Refuse a g at use, or its standard uncertainty, that cannot be one. None: as calibrated; not declared.

    Raises: OutsideValidity.
    """
    if uncertainty_mps2 is not None and (site_mps2 is None or not 0.0 <= uncertainty_mps2 <= LARGEST_UNCERTAINTY_MPS2):
        stated = "no gravity at use" if site_mps2 is None else f"{uncertainty_mps2:g} m/s²"
        raise OutsideValidity(
            f"{coefficients.sensor}: uncertainty of gravity at use: got {stated}, allowed 0 to "
            f"{LARGEST_UNCERTAINTY_MPS2:g} m/s² beside a gravity at use; nothing was computed; give both"
        )
    if site_mps2 is None:
        return
    if not LEAST_GRAVITY_MPS2 <= site_mps2 <= LARGEST_GRAVITY_MPS2:
        raise OutsideValidity(
            f"{coefficients.sensor}: gravity at use: got {site_mps2:g} m/s², allowed {LEAST_GRAVITY_MPS2:g} to "
            f"{LARGEST_GRAVITY_MPS2:g} m/s²; nothing was computed"
        )
    if any(numbers.form.unit != "g" or numbers.model_output for numbers in coefficients.axes.values()):
        raise OutsideValidity(
            f"{coefficients.sensor}: gravity at use: belongs to accelerometers of the form v = b + k·f; "
            "nothing was computed; leave it out"
        )


def gravity_shares(
    coefficients: CoefficientSet, site_mps2: float | None, uncertainty_mps2: float | None
) -> Mapping[str, float]:
    """Return by cause the relative standard uncertainty of gravity in outputs at use; none at the calibration's g."""
    if site_mps2 is None:
        return {}
    gravity = coefficients.gravity
    stated = {
        _AT_CALIBRATION: gravity.standard_uncertainty_mps2 / gravity.value_mps2,
        _AT_USE: (uncertainty_mps2 or 0.0) / site_mps2,
    }
    return {name: share for name, share in stated.items() if share}


def shares_in_common(
    sets: tuple[CoefficientSet, CoefficientSet], site_mps2: float | None, uncertainty_mps2: float | None
) -> Mapping[str, float]:
    """Return those of two packages side by side that are one and the same error of both.

    They are at one place; that of the calibrations is where both state one gravity.
    """
    shares = gravity_shares(sets[0], site_mps2, uncertainty_mps2)
    have_same_gravity = sets[0].gravity == sets[1].gravity
    return {name: share for name, share in shares.items() if name == _AT_USE or have_same_gravity}
