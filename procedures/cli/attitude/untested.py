"""What accelerometers and gyros cannot test of themselves, told once: what is assumed of their use, and dead outputs.

Three outputs have a length that has to be g. One or two have an angle for every number that they give: a row cannot be
flagged, so the rows together are looked at.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from ams.attitude.earth_rate import EarthRate
from ams.inference.gyros.aided_rates import UNSTATED_ZERO_SD_DPS, AidedAngles
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles
from ams.inference.inference import Package
from ams.inference.watch.frozen_outputs import FrozenOutputs
from ams.sets.stated_findings import is_stated
from ams.sets.verdict_conditions import (
    CUBIC_BEND_UNDETERMINED,
    CURVATURE_UNDETERMINED,
    REFERENCE_NOT_MEASURED,
    TERMS_NOT_DETERMINED,
    TERMS_NOT_TESTED,
)

SD_OF_A_READING: Final = (
    "standard deviations count the noise of one reading, as the calibration saw it: how much less an average or a "
    "filtered output has depends on how the noise goes on from sample to sample; --reading-sd-v states its own"
)


def assumed_gravity(package: Package) -> str:
    """Say by which g the angles are told, and what of it and of the outputs nothing here tests."""
    site, names = package.site_gravity_mps2, ", ".join(package.columns)
    g_mps2 = package.coefficients.gravity_mps2 if site is None else site
    said = "that of the calibration; --gravity-mps2 states another" if site is None else f"as stated, {_known(package)}"
    is_single = len(package.columns) == 1
    axes = "one axis" if is_single else "two axes"
    moves = "roll_deg says that the package moves" if is_single else "the other one moves"
    return (
        f"{package.coefficients.sensor}: {axes} ({names}): g is taken as {g_mps2:.5f} m/s², {said}; nothing in the "
        "rows tests it, nor the gain and the offset of an output where it reads less than one g: what three axes would "
        f"flag stays unseen; an output at its zero is flagged where {moves}"
    )


def undetermined_terms(package: Package) -> Iterator[str]:
    """Say of one or two axes that their calibration tells no terms of second and third order, where it tells none."""
    if is_stated(package.coefficients.document, TERMS_NOT_DETERMINED, TERMS_NOT_TESTED):
        yield (
            f"{package.coefficients.sensor}: its calibration tells no terms of second and third order (a nonlinearity "
            "of the sensor, a soft mount): what they do between the attitudes of its points is in no angle, no "
            "standard deviation and, without a third axis, no flag"
        )


def _known(package: Package) -> str:
    u_mps2 = package.site_gravity_uncertainty_mps2
    if u_mps2 is None:
        return "with no uncertainty: --gravity-uncertainty-mps2 declares it, and the angles then count it"
    return f"standard uncertainty {u_mps2:g} m/s²"


def untested_temperature(packages: Sequence[Package | GyroPackage]) -> Iterator[str]:
    """Say of sets that no temperature was recorded for that readings at any other are taken as they are."""
    names = dict.fromkeys(
        used.coefficients.sensor for used in packages if used.coefficients.validity.temperature_degc is None
    )
    if names:
        yield (
            f"{', '.join(names)}: no temperature was recorded in the calibration: what the sensor reads otherwise at "
            "another one is in no angle, no standard deviation and no flag"
        )
    for name in dict.fromkeys(used.coefficients.sensor for used in packages if _is_declared_alone(used)):
        yield (
            f"{name}: no temperature was recorded in the calibration, its range of use is declared: rows "
            "outside it are flagged where temperature_degc tells theirs; what the sensor reads otherwise inside it is "
            "in no angle and no standard deviation"
        )


def untold_curvature(packages: Sequence[Package | GyroPackage]) -> Iterator[str]:
    """Say of sets whose temperature coefficients rest on too few temperatures what is taken for granted between."""
    sets = {used.coefficients.sensor: used.coefficients.document for used in packages}
    for name, document in sets.items():
        if is_stated(document, REFERENCE_NOT_MEASURED, CURVATURE_UNDETERMINED):
            yield (
                f"{name}: its calibration tells no curvature over temperature, or was stated away from where it was "
                "measured: offset and sensitivity are taken to run on straight, and what they do otherwise at a "
                "temperature that was not measured is in no angle, no standard deviation and no flag"
            )
        elif is_stated(document, CUBIC_BEND_UNDETERMINED):
            yield (
                f"{name}: it was calibrated at three temperatures: what a bend of third order does to offset and "
                "sensitivity between them is in no angle, no standard deviation and no flag"
            )


def rows_without_temperature(packages: Sequence[Package | GyroPackage], found: FrozenOutputs) -> Iterator[str]:
    """Say of sets that are valid over a range of temperatures how many rows told none, and were not held against it."""
    missing, rows = found.rows_without_temperature, found.rows
    if not missing:
        return
    of_rows = f"none of the {rows} rows has" if missing == rows else f"{missing} of {rows} rows lack"
    ranges = {used.coefficients.sensor: used.coefficients.validity.temperature_degc for used in packages}
    for name, degc in ranges.items():
        if degc is not None:
            yield (
                f"{name}: valid at {degc[0]:.4g} to {degc[1]:.4g} °C; {of_rows} a temperature (temperature_degc): "
                "whether the sensor was used at another, and what it then reads otherwise, is in no flag"
            )


def _is_declared_alone(used: Package | GyroPackage) -> bool:
    """Return whether a set is valid over temperatures that were declared, and none was recorded."""
    return used.coefficients.validity.temperature_degc is not None and not used.coefficients.is_temperature_recorded


def assumed_of_gyros(angles: GyroAngles) -> tuple[str, ...]:
    """Say what is taken for granted of gyros alone, in no standard deviation and in no flag."""
    motion, name = angles.motion, angles.package.coefficients.sensor
    said = []
    if motion.start_deg is None or motion.start_sd_deg is None:
        pitch, yaw, roll = motion.stated_start_deg
        sd = "exactly" if motion.start_sd_deg is None else f"within {motion.start_sd_deg:g}° (standard deviation)"
        options = "--start-deg and --start-sd-deg state it" if motion.start_deg is None else "--start-sd-deg states it"
        said.append(
            f"{name}: the start is taken as pitch {pitch:g}°, yaw {yaw:g}°, roll {roll:g}°, known {sd}; {options}"
        )
    if motion.earth is None and not motion.rest_s:
        said.append(
            f"{name}: the Earth's turn, up to 15° an hour, is left in the angles and is in no standard deviation; "
            "--latitude-deg and --heading-deg take it off"
        )
    if not motion.rest_s and not angles.package.counts_shift:
        said.append(
            f"{name}: the zeros are taken as those of the calibration: what they have gone since is in no standard "
            "deviation; --rest-s measures them"
        )
    if motion.interpolation != "cubic":
        said.append(f"{name}: --interpolation {motion.interpolation}: what it makes wrong is in no standard deviation")
    return tuple(said)


def assumed_of_filter(angles: AidedAngles) -> tuple[str, ...]:
    """Say how far the zeros of gyros beside accelerometers are taken to lie off, and what stands for the Earth."""
    motion, name = angles.motion, angles.gyros.coefficients.sensor
    said = []
    if not motion.rest_s and angles.aiding.zero_sd_dps is None:
        said.append(
            f"{name}: the zeros are taken to have gone by what the set counts of their shift since the calibration"
            if angles.gyros.counts_shift
            else f"{name}: nothing states how far the zeros have gone since the calibration: {UNSTATED_ZERO_SD_DPS:g} "
            "°/s (standard deviation) is taken; --zero-sd-dps states it, --rest-s measures the zeros"
        )
    if motion.earth is None:
        said.append(
            f"{name}: the Earth's turn, up to 15° an hour, is taken as a part of the zeros; --latitude-deg and "
            "--heading-deg take it off"
        )
    else:
        said.append(
            f"{name}: the heading, {motion.earth.heading_deg:g}°, is taken as exact: each degree that it is off leaves "
            f"{_earth_by_heading_dps(motion.earth):.1g} °/s in the rates"
        )
    return tuple(said)


def _earth_by_heading_dps(earth: EarthRate) -> float:
    """Return the rate that one degree of the heading takes for another one."""
    north, east, _ = earth.rate_rad_s
    return float(np.hypot(north, east))


def remarks_on_rest(angles: GyroAngles | AidedAngles) -> tuple[str, ...]:
    """Say what the rest at the beginning told of the zeros, and where it was none."""
    zero, package = angles.rest.zero, angles.rest.package
    if zero is None:
        return ()
    name = package.coefficients.sensor
    inverse = np.linalg.inv(package.k_v_per_rad_s)
    moved = np.rad2deg(inverse @ (zero.mean_v - package.at_rest_v))
    by_axis = ", ".join(f"{axis} {dps:+.2g}" for axis, dps in zip(package.columns, moved, strict=True))
    said = f"{name}: at rest the outputs lie {by_axis} °/s from the zeros of the calibration; they are taken as zeros"
    if zero.is_still:
        return (said,)
    widest = np.rad2deg(np.abs(inverse) @ zero.scatter_v).max()
    return (
        said,
        f"{name}: it did not rest: over the time of --rest-s the outputs moved by {widest:.2g} °/s, more than their "
        "noise explains; zeros and start are as uncertain as that makes them; give --rest-s a stretch over which "
        "nothing turns, or leave it out",
    )
