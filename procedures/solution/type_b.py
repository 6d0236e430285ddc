"""What a rig file declares of its instruments, as the errors that all readings of a calibration share (type B).

A certificate states a limit, a standard or an expanded uncertainty; here each becomes a standard uncertainty on what it
acts on. A meter's one figure is taken for its zero and, over its range, for its gain: both, each whole, since the
certificate does not say which. Source: GUM 4.3, F.2.4.5.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import degrees, radians, sqrt
from typing import Literal

from ams.frames import ANGLES
from ams.gravity import ANOMALY_MPS2, Gravity, disagreement, normal_gravity_mps2
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import G_SENSITIVITY, NONLINEARITY, SHIFTS, SHIFTS_WITHIN, SharedError
from ams.inputs.table_uncertainty import IndexErrors, KnownErrors, TableUncertainty, known_errors
from ams.rounding import two_digits
from ams.units import ARCSEC_PER_DEG
from procedures.solution.crosstalk import crosstalk_errors
from procedures.solution.earth_turn import earth_errors
from procedures.solution.level_of_base import level_errors
from procedures.solution.temperature_of_use import use_errors
from rig.description.device_settings import AxisSettings
from rig.description.index_table import IndexTable
from rig.description.rig_file import RigDescription, Sensor, Standard

Kind = Literal["limit", "standard", "expanded"]


def divisor(standard: Standard | None) -> float:
    """Return what a stated uncertainty is divided by; a limit where no certificate says otherwise."""
    return sqrt(3.0) if standard is None else standard.divisor


def standard_uncertainty_arcsec(rig: RigDescription, axis: str) -> float:
    """Return the standard uncertainty of one attitude; 0 where there is no such axis.

    What a reference sensor tells it to, else of the axis' index: a limit divided by √3 unless its standard says
    otherwise.
    """
    reference = rig.attitude_reference
    if reference is not None and axis in reference.channels:
        return ARCSEC_PER_DEG * reference.uncertainty_deg
    settings = rig.axes.get(axis)
    if settings is None:
        return 0.0
    return settings.uncertainty_arcsec / divisor(rig.standards.get(settings.standard) if settings.standard else None)


def single_approach(rig: RigDescription) -> frozenset[str]:
    """Return the axes that come to every target from one side, so that their play does not show."""
    return frozenset(name for name, axis in rig.axes.items() if axis.approach_deg != 0.0)


def table_uncertainty(rig: RigDescription) -> TableUncertainty | None:
    """Return the rig's indices as its axes and their standards declare them; None where no axis has any uncertainty."""
    names = ("pitch", "roll", "yaw")
    pitch_rad, roll_rad, yaw_rad = (radians(standard_uncertainty_arcsec(rig, name) / ARCSEC_PER_DEG) for name in names)
    errors = {name: declared for name in names if (declared := _index_errors(rig, name)) is not None}
    if pitch_rad == roll_rad == yaw_rad == 0.0 and not errors:
        return None
    return TableUncertainty(pitch_rad, roll_rad, kind="standard", yaw_rad=yaw_rad, errors=errors)


def on_table(request: CalibrationRequest, rig: RigDescription | None) -> CalibrationRequest:
    """Return a request with what a rig declares of its table; as it is where there is no rig."""
    if rig is None:
        return request
    return replace(request, table=table_uncertainty(rig), single_approach=single_approach(rig))


def _index_errors(rig: RigDescription, name: str) -> IndexErrors | None:
    """As attitudes: what the machine's own angles say, turned by the sign of the axis. None where nothing is declared,
    or a reference sensor tells the attitude.
    """
    axis = rig.axes.get(name)
    is_referred = rig.attitude_reference is not None and name in rig.attitude_reference.channels
    if axis is None or is_referred:
        return None
    by = divisor(rig.standards.get(axis.standard) if axis.standard else None)
    declared = IndexErrors(
        axis.index_errors,
        None if axis.index_zero_deg is None else radians(axis.attitude_deg(axis.index_zero_deg)),
        radians(axis.index_zero_uncertainty_arcsec / by / ARCSEC_PER_DEG),
        _known(axis, by),
    )
    return None if declared == IndexErrors() else declared


def _known(axis: AxisSettings, divided_by: float) -> KnownErrors | None:
    rows = axis.index_table
    if not isinstance(rows, IndexTable):
        return None
    listed = sorted(
        (axis.attitude_deg(angle_deg), axis.sign * error_arcsec, uncertainty_arcsec / divided_by)
        for angle_deg, error_arcsec, uncertainty_arcsec in zip(
            rows.angle_deg, rows.error_arcsec, rows.uncertainty_arcsec, strict=True
        )
    )
    return known_errors(*zip(*listed, strict=True))


def table_in_words(rig: RigDescription) -> str:
    """Describe what is declared of the table's indices; a shape of several axes is told once, behind the last."""
    in_words = {
        name: (f"{name} u {two_digits(u_arcsec)}″{_teller(rig, name)}", _shape_in_words(rig, name))
        for name in ("pitch", "yaw", "roll")
        if (u_arcsec := standard_uncertainty_arcsec(rig, name)) > 0.0
    }
    shapes = {shape for _, shape in in_words.values()}
    if len(shapes) == 1:
        return ", ".join(size for size, _ in in_words.values()) + shapes.pop()
    return ", ".join(f"{size}{shape}" for size, shape in in_words.values())


def _teller(rig: RigDescription, name: str) -> str:
    """Name the channel that tells the attitude in place of the axis, if any."""
    channel_of = rig.attitude_reference.channels if rig.attitude_reference else {}
    return next((f" by {channel}" for axis, channel in channel_of.items() if axis == name), "")


def _shape_in_words(rig: RigDescription, name: str) -> str:
    declared = _index_errors(rig, name) or IndexErrors()
    words = {
        "unknown": "shape unknown: 0.9 of the limit as teeth, once and twice a turn",
        "independent": "",
        "smooth": "smooth: 0.9 of the limit as one to eight times a turn",
    }
    zero = [] if declared.zero_rad is None else [f"zero at {degrees(declared.zero_rad):g}°"]
    listed = [] if declared.known is None else [f"corrected by a list of {declared.known.angle_rad.size} angles"]
    in_words = "; ".join(word for word in (words[declared.shape], *zero, *listed) if word)
    return f" ({in_words})" if in_words else ""


def gravity_on_gyros_remarks(shared: Mapping[str, tuple[SharedError, ...]], *, senses_rates: bool) -> tuple[str, ...]:
    """Say that nothing tells what gravity does to gyros, which is no term of their model; nothing where a limit does.

    ``shared``: sensor axis to the errors that its calibration was solved with.
    """
    is_declared = any(error.name == G_SENSITIVITY for errors in shared.values() for error in errors)
    if not senses_rates or is_declared:
        return ()
    return (
        "g-sensitivity of the gyros was not measured and is in no uncertainty: their offset holds at the attitudes of "
        "the calibration only, and changes elsewhere by what the data sheet states per g, by twice that upside down "
        "(largest_g_sensitivity_dps_per_g of the sensor, or of calrig fit, brings it in); where the calibration had "
        "several attitudes, part of it shows as lack of fit",
    )


def gravity_warnings(rig: RigDescription, sensor: Sensor | None) -> tuple[str, ...]:
    """Say that the stated gravity is not that of the place; what a sensor gives per local g stands all the same.

    Without a sensor the caller knows that acceleration is measured.
    """
    location = rig.rig
    if (sensor is not None and sensor.measures != "acceleration") or location.latitude_deg is None:
        return ()
    if location.gravity_mps2 is None:
        return ()
    found = disagreement(location.gravity_mps2, location.latitude_deg, location.height_m)
    return (
        () if found is None else (f"{found.text}; sensitivities per local g do not depend on it, use elsewhere does",)
    )


def gravity_of(rig: RigDescription) -> Gravity:
    """Return the local gravity as the rig file states it, else by the formula of WGS 84 at its latitude and height.

    What anomalies may do to the latter is its uncertainty, unless the laboratory declares what it knows of them.
    """
    stated = rig.rig
    if stated.gravity_mps2 is not None:
        return Gravity(stated.gravity_mps2, stated.gravity_uncertainty_mps2, stated.gravity_source)
    latitude_deg, height_m = stated.latitude_deg, stated.height_m
    if latitude_deg is None or height_m is None:
        raise ValueError("a rig section without gravity, latitude or height does not pass its own check")
    return Gravity(
        round(normal_gravity_mps2(latitude_deg, height_m), 5),
        stated.gravity_uncertainty_mps2 or ANOMALY_MPS2,
        f"normal gravity (WGS 84) at latitude {latitude_deg:g}° and {height_m:g} m",
    )


def shared_errors(
    rig: RigDescription,
    sensor: Sensor | None,
    temperature: str | None = None,
    calibrated_degc: float | None = None,
    *,
    counts_earth: bool = True,
    counts_shift: bool = True,
) -> dict[str, tuple[SharedError, ...]]:
    """Sensor axis to its errors. ``temperature``: the environment whose reading stands for the sensor's temperature.

    ``calibrated_degc``: where the sensor was calibrated without a model of temperature; None where it has one.
    ``counts_earth``: whether what is not known of the Earth's rotation is an error of a gyro.
    ``counts_shift``: whether it is asked for use until the next calibration.

    Without a sensor only the level of the base is known, for x, y and z.
    """
    level = tuple(level_errors(rig))
    if sensor is None:
        return dict.fromkeys("xyz", level)
    common = (
        *level,
        *_thermometer(rig, sensor, temperature),
        *use_errors(sensor, calibrated_degc),
        *_nonlinearity(sensor),
        *_g_sensitivity(sensor),
        *(_shift(sensor) if counts_shift else ()),
        *(earth_errors(rig, sensor) if counts_earth else ()),
        *_directions(rig, sensor),
    )
    return {
        str(axis): (*_chain(rig, channel), *crosstalk_errors(rig, sensor, channel), *common)
        for axis, channel in sensor.channels.items()
    }


def _chain(rig: RigDescription, channel: str) -> Iterator[SharedError]:
    """Yield the errors of the meter behind a channel, and of its load resistor."""
    readout, _, name = channel.partition(".")
    meter = _standard(rig, rig.readouts[readout].standard) if readout in rig.readouts else None
    if meter is not None and meter[1].uncertainty_v:
        u_v, stated = meter[1].uncertainty_v / divisor(meter[1]), _in_words(meter, meter[1].uncertainty_v, "V")
        yield SharedError("multimeter zero", "reading", u_v, meter[1].kind, stated)
        range_v = rig.readouts[readout].range_of_channel_v(name)
        if range_v is not None:
            yield SharedError("multimeter gain", "gain", u_v / range_v, meter[1].kind, f"{stated}, over {range_v:g} V")
    chain = rig.chain.get(channel)
    if chain is not None and chain.load_resistor_ohm and readout in rig.readouts:
        input_ohm = rig.readouts[readout].input_ohm(name)
        if input_ohm is not None:
            divider = f"{chain.load_resistor_ohm:g} Ω on an input of {input_ohm:g} Ω"
            u = chain.load_resistor_ohm / input_ohm / sqrt(3.0)
            yield SharedError("multimeter input", "gain", u, "limit", divider, is_of_one_channel=True)
    resistor = None if chain is None else _standard(rig, chain.standard)
    if chain is not None and chain.load_resistor_ohm and resistor is not None and resistor[1].uncertainty_ohm:
        u = resistor[1].uncertainty_ohm / divisor(resistor[1]) / chain.load_resistor_ohm
        stated = _in_words(resistor, resistor[1].uncertainty_ohm, "Ω")
        stated = f"{stated}, of {chain.load_resistor_ohm:g} Ω"
        yield SharedError("load resistor", "gain", u, resistor[1].kind, stated, is_of_one_channel=True)


def _thermometer(rig: RigDescription, sensor: Sensor, temperature: str | None) -> Iterator[SharedError]:
    if sensor.temperature is not None:
        chain = rig.chain.get(sensor.temperature.channel)
        probe = None if chain is None else _standard(rig, chain.standard)
    else:
        probe = None if temperature is None else _standard(rig, rig.environment[temperature].standard)
    if probe is not None and probe[1].uncertainty_degc:
        u_degc = probe[1].uncertainty_degc / divisor(probe[1])
        stated = _in_words(probe, probe[1].uncertainty_degc, "°C")
        yield SharedError("thermometer", "temperature", u_degc, probe[1].kind, stated)


def _nonlinearity(sensor: Sensor) -> Iterator[SharedError]:
    """Yield by what an output leaves its equation at most, each axis for itself."""
    if sensor.largest_nonlinearity_v > 0.0:
        u_v = sensor.largest_nonlinearity_v / sqrt(3.0)
        stated = f"limit {1e6 * sensor.largest_nonlinearity_v:g} µV at every attitude"
        yield SharedError(NONLINEARITY, "departure", u_v, stated=stated, is_of_one_channel=True)


def g_sensitivity_error(limit_dps_per_g: float) -> SharedError:
    """Return what gravity does to a gyro at most: a vector of that length, whose part along any line is a rectangle."""
    stated = f"limit {limit_dps_per_g:g} °/s per g, used at any attitude"
    u_dps_per_g = limit_dps_per_g / sqrt(3.0)
    return SharedError(G_SENSITIVITY, "specific-force", u_dps_per_g, "limit", stated, is_of_one_channel=True)


def direction_error(axis: str, u_arcsec: float, stated: str) -> SharedError:
    """Return how far an axis of the table leans to either side, by a standard uncertainty."""
    at, u_rad = ANGLES.index(axis), radians(u_arcsec / ARCSEC_PER_DEG)
    return SharedError(f"direction of the {axis} axis", "spin-direction", u_rad, stated=stated, columns=(at,))


def _directions(rig: RigDescription, sensor: Sensor) -> Iterator[SharedError]:
    """Yield how far the axes lean that turn a gyro."""
    for name in ANGLES if sensor.measures == "rate" else ():
        axis = rig.axes.get(name)
        if axis is not None and axis.direction_uncertainty_arcsec > 0.0:
            standard = rig.standards.get(axis.standard) if axis.standard else None
            u_arcsec = axis.direction_uncertainty_arcsec / divisor(standard)
            yield direction_error(name, u_arcsec, f"axes.{name}: u {two_digits(u_arcsec)}″ to either side")


def _g_sensitivity(sensor: Sensor) -> Iterator[SharedError]:
    if sensor.largest_g_sensitivity_dps_per_g > 0.0:
        yield g_sensitivity_error(sensor.largest_g_sensitivity_dps_per_g)


def _shift(sensor: Sensor) -> Iterator[SharedError]:
    """Yield what an axis shifts by at most, while it is calibrated and until the next time, each for itself."""
    words, within = "until the next calibration", "within the calibration, as far as its readings leave it open"
    if sensor.largest_offset_shift_v > 0.0:
        limit, u_v = f"limit {1e6 * sensor.largest_offset_shift_v:g} µV", sensor.largest_offset_shift_v / sqrt(3.0)
        yield SharedError(SHIFTS[0], "reading", u_v, "limit", f"{limit} {words}", is_of_one_channel=True)
        stated = f"{limit} {within}"
        yield SharedError(SHIFTS_WITHIN[0], "reading-course", u_v, stated=stated, is_of_one_channel=True)
    if sensor.largest_sensitivity_shift > 0.0:
        limit, u = f"limit {1e6 * sensor.largest_sensitivity_shift:g} ppm", sensor.largest_sensitivity_shift / sqrt(3.0)
        yield SharedError(SHIFTS[1], "gain", u, "limit", f"{limit} {words}", is_of_one_channel=True)
        stated = f"{limit} {within}"
        yield SharedError(SHIFTS_WITHIN[1], "gain-course", u, stated=stated, is_of_one_channel=True)


def _standard(rig: RigDescription, name: str | None) -> tuple[str, Standard] | None:
    return (name, rig.standards[name]) if name is not None and name in rig.standards else None


def _in_words(standard: tuple[str, Standard], stated: float, unit: str) -> str:
    name, declared = standard
    coverage = f", k = {declared.k:g}" if declared.kind == "expanded" else ""
    size = f"{1e6 * stated:g} µV" if unit == "V" else f"{stated:g} {unit}"
    return f"standards.{name}: {declared.kind} {size}{coverage}"
