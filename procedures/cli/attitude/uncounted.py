"""What the standard deviations of angles do not count of their calibration, told once."""

from collections.abc import Iterator, Sequence
from typing import Final

from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.inference import Package
from ams.inference.package.counted_shifts import OFFSET_KEY, undeclared_shifts
from ams.statistics.distributions import student_t_quantile

_MANY_DEGREES: Final = 30.0
"""From there on Student's factor is within 5 % of the normal one."""


def untested_shifts(packages: Sequence[Package | GyroPackage]) -> Iterator[str]:
    """Say of every set what it counts nothing of: what offsets and sensitivities changed since its calibration.

    What the zeros of gyros did is said where it is said how they are taken.
    """
    for used in {used.coefficients.sha256: used for used in packages}.values():
        keys = undeclared_shifts(used.coefficients, used.columns)
        senses_rates = all(used.coefficients.axes[axis].form.unit == "dps" for axis in used.columns)
        if senses_rates:
            keys = tuple(key for key in keys if key != OFFSET_KEY)
        if not keys:
            continue
        flagged = "no row is flagged for it"
        if len(used.columns) > 2 and not senses_rates:
            flagged = "a row is flagged for it only where it makes the outputs contradict one another"
        yield (
            f"{used.coefficients.sensor}: what the sensor changed since its calibration is in no standard deviation "
            f"and in no interval ({' and '.join(keys)} {'is' if len(keys) == 1 else 'are'} not declared); {flagged}"
        )


def few_degrees_of_freedom(packages: Sequence[GyroPackage]) -> Iterator[str]:
    """Say of gyros how wide 95 % are by what their calibrations rest on, where that is wider than 1.96."""
    for used in packages:
        dof = used.least_degrees_of_freedom
        if dof < _MANY_DEGREES:
            factor = float(student_t_quantile(0.975, dof))
            yield (
                f"{used.coefficients.sensor}: what the calibration leaves open rests on {dof:.3g} degrees of freedom: "
                f"where that is most of a standard deviation, 95 % lie within {factor:.2f} of it and not within 1.96"
            )
