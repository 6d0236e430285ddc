"""Use at other temperatures than that of the calibration: what it does at most, and what of it is in no figure.

One way for packages, single axes, straight lines and joint fits, of runs and of files, and for what a plan foresees:
where a temperature was recorded and is not modelled, the data sheet's limits count up to the farther end of the
declared range of use; where none was recorded, or no limit is declared, a reservation says so.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import sqrt

from ams.arrays import FloatArray
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.sets.verdict_conditions import NO_TEMPERATURE
from ams.solve.whole_plots import SMALLEST_GAP_DEGC
from rig.description.rig_file import Sensor


def calibrated_degc(temperature: str, recorded_degc: FloatArray | None) -> float | None:
    """Return the mean temperature of a calibration that does not model it; None where it does or none was recorded.

    ``temperature``: what is done about it, as ``[solve] temperature`` has it.
    """
    return None if recorded_degc is None or temperature != "none" else float(recorded_degc.mean())


def warnings_of_use(sensor: Sensor | None, temperature: str, recorded_degc: FloatArray | None) -> tuple[str, ...]:
    """Return the reservations about the range of use of a calibration; nothing without a sensor."""
    if sensor is None:
        return ()
    degc = calibrated_degc(temperature, recorded_degc)
    used = use_warnings(sensor, degc, is_recorded=recorded_degc is not None)
    return (*used, *beyond_measured(sensor, temperature, recorded_degc))


def beyond_measured(sensor: Sensor, temperature: str, recorded_degc: FloatArray | None) -> tuple[str, ...]:
    """Say that coefficients are used beyond the temperatures that they were estimated over, where they are."""
    used = sensor.use_temperature_degc
    if used is None or recorded_degc is None or temperature != "estimate":
        return ()
    low, high = float(recorded_degc.min()), float(recorded_degc.max())
    beyond_degc = max(low - used[0], used[1] - high)
    if beyond_degc <= SMALLEST_GAP_DEGC:
        return ()
    return (
        f"the sensor is to be used at {used[0]:g} to {used[1]:g} °C and its temperature coefficients were measured "
        f"over {low:.4g} to {high:.4g} °C: up to {beyond_degc:.2g} °C beyond, offset and sensitivities hold only if "
        "they run on as they were fitted, and what they do otherwise is in no figure stated here; measure up to the "
        "ends of the range of use",
    )


def at_use(request: CalibrationRequest, sensor: Sensor | None, recorded_degc: FloatArray | None) -> CalibrationRequest:
    """Return the request of a file with what its sensor does at most where it is to be used."""
    degc = calibrated_degc(request.temperature, recorded_degc)
    errors = () if sensor is None else tuple(use_errors(sensor, degc))
    shared = {axis: (*others, *errors) for axis, others in request.shared_errors.items()}
    return replace(request, shared_errors=shared)


def use_errors(sensor: Sensor, calibrated_degc: float | None) -> Iterator[SharedError]:
    """Yield what use at other temperatures than that of the calibration does at most, by the sensor's data sheet."""
    used = sensor.use_temperature_degc
    if used is None or calibrated_degc is None:
        return
    away_degc = max(abs(end - calibrated_degc) for end in used)
    where = f"used at {used[0]:g} to {used[1]:g} °C, calibrated at {calibrated_degc:.4g} °C"
    offset_v, gain = (
        largest * away_degc for largest in (sensor.largest_offset_tc_v_per_degc, sensor.largest_sensitivity_tc_per_degc)
    )
    if offset_v > 0.0:
        stated = f"limit {1e6 * sensor.largest_offset_tc_v_per_degc:g} µV/°C, {where}"
        yield SharedError("temperature of use, offset", "reading", offset_v / sqrt(3.0), "limit", stated)
    if gain > 0.0:
        stated = f"limit {1e6 * sensor.largest_sensitivity_tc_per_degc:g} ppm/°C, {where}"
        yield SharedError("temperature of use, sensitivity", "gain", gain / sqrt(3.0), "limit", stated)


def use_warnings(sensor: Sensor, calibrated_degc: float | None, *, is_recorded: bool = True) -> tuple[str, ...]:
    """Say that the range of use is not in the uncertainties, where neither a model nor a data sheet has its effect.

    ``is_recorded``: whether a temperature was, or will be, recorded with the readings; nothing is counted without.
    """
    used = sensor.use_temperature_degc
    if used is not None and not is_recorded:
        return (
            f"the sensor is to be used at {used[0]:g} to {used[1]:g} °C, as declared, and {NO_TEMPERATURE}: how far "
            "that is from the calibration's is not known, and what it does, whatever limits are declared, is not in "
            "these uncertainties; record it: temperature of the sensor in the rig file, or the column temperature_degc "
            "of a file",
        )
    is_known = sensor.largest_offset_tc_v_per_degc > 0.0 or sensor.largest_sensitivity_tc_per_degc > 0.0
    if used is None or calibrated_degc is None or is_known:
        return ()
    return (
        f"the sensor is to be used at {used[0]:g} to {used[1]:g} °C and was calibrated at {calibrated_degc:.4g} °C "
        "without a model of temperature: what that does is not in these uncertainties; declare "
        "largest_offset_tc_v_per_degc and largest_sensitivity_tc_per_degc from its data sheet, or estimate temperature "
        "coefficients",
    )
