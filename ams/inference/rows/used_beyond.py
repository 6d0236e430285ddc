"""Where sets are used beyond what they are valid for: the row is answered, and its flag says so."""

from collections.abc import Iterable, Mapping

import numpy as np

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.models.possible_temperature import COLUMN, possible_temperatures
from ams.sets.coefficients import CoefficientSet
from ams.sets.vectors import ROUNDING_DEG


def senses_roll_within(coefficients: CoefficientSet) -> bool:
    """Return whether a set senses roll and is not valid all round, by the rule of :func:`ams.sets.apply.apply`."""
    validity = coefficients.validity
    senses = all(numbers.form.senses_roll for numbers in coefficients.axes.values())
    return senses and not validity.levels and not validity.goes_round


def codes_of_angles(
    coefficients: CoefficientSet, pitch_deg: FloatArray, yaw_deg: FloatArray | None, roll_deg: FloatArray | None
) -> flag_codes.AnswerCodes:
    """Return the codes of (N,) angles at which a set is not valid; an angle that is None is not looked at."""
    validity = coefficients.validity
    # A straight line is valid over levels, which reach over all attitudes; its run has a few positions alone.
    checked = [] if validity.levels else [(flag_codes.OUTSIDE_PITCH, pitch_deg, validity.pitch_deg)]
    if yaw_deg is not None and validity.yaw_deg is not None:
        checked.append((flag_codes.OUTSIDE_YAW, yaw_deg, validity.yaw_deg))
    codes = np.zeros(pitch_deg.size, dtype=np.uint32)
    for code, values, (low, high) in checked:
        codes[(values < low - ROUNDING_DEG) | (values > high + ROUNDING_DEG)] |= np.uint32(code)
    if roll_deg is None or not senses_roll_within(coefficients):
        return codes
    is_beyond = np.minimum(*validity.roll_margins_deg(roll_deg)) < -ROUNDING_DEG
    return codes | np.where(is_beyond, flag_codes.OUTSIDE_ROLL, 0).astype(np.uint64)


def codes_of_rates(coefficients: CoefficientSet, rates_rad_s: FloatArray) -> flag_codes.Codes:
    """Return (N,) codes of (3, N) rates beyond those that gyros were calibrated over; NaN is none."""
    limits = coefficients.validity.rate_dps
    if limits is None:
        return np.zeros(rates_rad_s.shape[1], dtype=np.uint32)
    rates_dps = np.rad2deg(rates_rad_s)
    is_beyond = ((rates_dps < limits[0]) | (rates_dps > limits[1])).any(axis=0)
    return np.where(is_beyond, flag_codes.OUTSIDE_RATE, 0).astype(np.uint32)


def codes_of_temperature(sets: Iterable[CoefficientSet], readings: Mapping[str, FloatArray]) -> flag_codes.Codes | None:
    """Return (N,) codes of rows whose temperature is one at which a set among them is not valid; None without any.

    Whatever the sets are of: accelerometers, gyros and magnetometers are as far from their calibration as it.
    """
    read, ranges = readings.get(COLUMN), [coefficients.validity.temperature_degc for coefficients in sets]
    valid = [degc for degc in ranges if degc is not None]
    if read is None or not valid:
        return None
    low, high = max(least for least, _ in valid), min(most for _, most in valid)
    read_degc = possible_temperatures(read)
    is_beyond = (read_degc < low - ROUNDING_DEG) | (read_degc > high + ROUNDING_DEG)
    return np.where(is_beyond, flag_codes.OUTSIDE_TEMPERATURE, 0).astype(np.uint32)
