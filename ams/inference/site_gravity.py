"""The g where a set is used, as somebody states it."""

from typing import Final

from ams.errors import OutsideValidity
from ams.sets.coefficients import CoefficientSet

LEAST_GRAVITY_MPS2: Final = 9.7
LARGEST_GRAVITY_MPS2: Final = 9.9
LARGEST_UNCERTAINTY_MPS2: Final = 0.05
"""Half of what normal gravity spans between equator and poles: beyond it nothing is stated."""


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
