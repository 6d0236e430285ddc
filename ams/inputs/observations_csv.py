"""Observations from a CSV file.

Columns: ``replication,point,pitch_deg,roll_deg[,yaw_deg][,temperature_degc][,time_s],<name>_v…``, in any order; for
gyros also ``pitch_rate_dps,yaw_rate_dps,roll_rate_dps``, the rates of the angles.

Every refusal names file, line (the header is line 1) and column. Degrees become radians here and nowhere else.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.errors import ObservationsError
from ams.frames import body_rates_rad_s, wrap_deg
from ams.inputs.csv_table import PLAIN, CsvForm, CsvTable, parse_csv, refuse_cell
from ams.inputs.number_blocks import NumberTable, numbers_in, read_numbers
from ams.inputs.possible_outputs import OF_ANY_SENSOR
from ams.models.possible_temperature import POSSIBLE, impossible_temperatures, likely_unit
from ams.models.sensor_model import RATE_INPUTS
from ams.observations import Observations

_OPTIONAL = ("yaw_deg", "temperature_degc", "time_s")
_WHERE_THERE = ("pitch_deg", "roll_deg", *_OPTIONAL)
_LARGEST_SPREAD_DEG = 0.5
"""Attitudes of one point may differ by what a servo mechanism repeats to; more is another point."""
_LARGEST_RATE_SPREAD = 0.01
"""Rates of one point may differ by this part of the largest rate."""
_LARGEST_ANGLE_DEG = 360.0


def read_csv(
    path: str | Path,
    axes: Mapping[str, str],
    angles: Sequence[str] = ("pitch", "roll"),
    *,
    rates: bool = False,
    form: CsvForm = PLAIN,
) -> Observations:
    """Read observations; ``axes`` maps a sensor axis label to its column, such as ``{"x": "sx_v"}``.

    ``angles`` are the angles that the file must state; one that is neither asked for nor there is 0° (yaw: None).
    ``rates``: the file must state the three rates of the angles as well. ``form``: its separator and decimal sign.

    Raises:
        ObservationsError: the file cannot be read or says something impossible; nothing was solved.
    """
    if form != PLAIN:
        return observations_of_table(parse_csv(Path(path), form), axes, angles, rates=rates)
    wanted = _wanted(str(path), axes, angles, rates=rates)
    return _observations(read_numbers(Path(path), wanted, _WHERE_THERE), axes, rates=rates)


def observations_of_table(
    table: CsvTable, axes: Mapping[str, str], angles: Sequence[str] = ("pitch", "roll"), *, rates: bool = False
) -> Observations:
    """Return the observations of a table as :func:`read_csv` does. Raises: ObservationsError."""
    wanted = _wanted(table.file, axes, angles, rates=rates)
    return _observations(numbers_in(table, wanted, _WHERE_THERE), axes, rates=rates)


def _wanted(file: str, axes: Mapping[str, str], angles: Sequence[str], *, rates: bool) -> tuple[str, ...]:
    if not axes:
        raise ObservationsError(f"{file}: no sensor axis was named; nothing was solved; name at least one column")
    stimulus = (*(f"{angle}_deg" for angle in angles), *(RATE_INPUTS if rates else ()))
    return ("replication", "point", *stimulus, *axes.values())


def _observations(table: NumberTable, axes: Mapping[str, str], *, rates: bool) -> Observations:
    label = {name: table.labels(name) for name in ("replication", "point")}
    found = {name: values for name, values in table.values.items() if name not in label}
    _refuse_repeated(table, label)
    _refuse_impossible(table, found)
    nothing = np.zeros(table.lines.size)
    radians = {
        name: np.deg2rad(found.get(name, nothing)) for name in ("pitch_deg", "yaw_deg", "roll_deg", *RATE_INPUTS)
    }
    observations = Observations(
        replication=label["replication"],
        point=label["point"],
        pitch_rad=radians["pitch_deg"],
        roll_rad=radians["roll_deg"],
        outputs={name: found[column] for name, column in axes.items()},
        yaw_rad=radians["yaw_deg"] if "yaw_deg" in found else None,
        temperature_degc=found.get("temperature_degc"),
        time_s=found.get("time_s"),
        euler_rate_rad_s=np.stack([radians[name] for name in RATE_INPUTS], axis=-1) if rates else None,
        source=table.file,
    )
    if rates:
        _refuse_wandering_rates(table, observations)
    else:
        _refuse_wandering_points(table, label["point"], found)
    return observations


def unit_warnings(observations: Observations, columns: Mapping[str, str]) -> tuple[str, ...]:
    """Return the columns whose numbers can hardly be in the unit of their name, each in a sentence.

    ``columns``: sensor axis to the column that it was read from. Outputs of accelerometers that cannot be are refused,
    by :func:`ams.inputs.possible_outputs.refuse_impossible_outputs`.
    """
    warnings = []
    angles = {"pitch_deg": observations.pitch_rad, "roll_deg": observations.roll_rad}
    angles |= {} if observations.yaw_rad is None else {"yaw_deg": observations.yaw_rad}
    widest_deg = max(float(np.rad2deg(np.abs(angle).max())) for angle in angles.values())
    irregular = any(_looks_like_radians(np.rad2deg(angle)) for angle in angles.values())
    if 0.0 < widest_deg <= 2.0 * np.pi and irregular:
        warnings.append(
            f"{observations.source}: columns {' and '.join(angles)}: no angle is above {widest_deg:.4g}° and the steps "
            "are fractions of π: radians? nothing was converted"
        )
    rates = observations.euler_rate_rad_s
    if rates is not None and _looks_like_radians(np.rad2deg(rates[rates != 0.0])):
        warnings.append(
            f"{observations.source}: columns {', '.join(RATE_INPUTS)}: whole degrees come out when the rates "
            "are taken as radians per second: radians? nothing was converted"
        )
    for label, outputs in observations.outputs.items() if rates is not None else ():
        largest = float(np.abs(outputs).max())
        if largest > OF_ANY_SENSOR.largest_v:
            warnings.append(
                f"{observations.source}: column {columns.get(label, label)}: up to {largest:.4g} V, which hardly a "
                "gyro gives: millivolts? nothing was converted"
            )
    return tuple(warnings)


def _looks_like_radians(angle_deg: FloatArray) -> bool:
    """Return whether the numbers are whole degrees when they are taken as radians, and are not as they stand."""
    as_radians = np.rad2deg(angle_deg)
    moved = angle_deg[np.abs(angle_deg) > 0.0]
    if moved.size == 0:
        return False
    is_whole = np.abs(as_radians - np.round(as_radians)) < 1e-3
    stands = np.abs(angle_deg * 1e3 - np.round(angle_deg * 1e3)) < 1e-7
    return bool(is_whole.mean() > 0.9 and stands.mean() < 0.5)


def _refuse_repeated(table: NumberTable, labels: Mapping[str, IntArray]) -> None:
    seen: dict[tuple[int, int], int] = {}
    for line, replication, point in zip(table.lines, labels["replication"], labels["point"], strict=True):
        pair = (int(replication), int(point))
        if pair in seen:
            raise ObservationsError(
                f"{table.file}: line {line}: columns replication and point: replication {pair[0]}, point "
                f"{pair[1]} stands on "
                f"line {seen[pair]} already; allowed once; nothing was solved; remove one or give it a label of its own"
            )
        seen[pair] = line


def _refuse_impossible(table: NumberTable, numbers: Mapping[str, FloatArray]) -> None:
    for name, values in numbers.items():
        if name.endswith("_deg"):
            outside, allowed = np.abs(values) > _LARGEST_ANGLE_DEG, "−360° to 360°"
        elif name == "temperature_degc":
            outside, allowed = impossible_temperatures(values), f"{POSSIBLE}: {likely_unit(values)}"
        else:
            continue
        if outside.any():
            row = int(np.flatnonzero(outside)[0])
            refuse_cell(table, name, table.lines[row], f"{values[row]:g}", allowed)


def _refuse_wandering_points(table: NumberTable, point: IntArray, numbers: Mapping[str, FloatArray]) -> None:
    _, first, index = np.unique(point, return_index=True, return_inverse=True)
    for name in (column for column in ("pitch_deg", "roll_deg", "yaw_deg") if column in numbers):
        off = wrap_deg(numbers[name] - numbers[name][first][index])
        if np.abs(off).max() > _LARGEST_SPREAD_DEG:
            row = int(np.argmax(np.abs(off)))
            raise ObservationsError(
                f"{table.file}: line {table.lines[row]}: column {name}: point {point[row]} has "
                f"{numbers[name][row]:g}° here and "
                f"{numbers[name][first][index][row]:g}° on line {table.lines[int(first[index[row]])]}; "
                f"allowed a difference up to "
                f"{_LARGEST_SPREAD_DEG:g}°; nothing was solved; correct the angle or the point label"
            )


def _refuse_wandering_rates(table: NumberTable, observations: Observations) -> None:
    """Refuse a point whose angular velocity is not one and the same.

    A point is one angular velocity in the package's axes, whatever angle a turning axis has reached.
    """
    assert observations.euler_rate_rad_s is not None
    assert observations.yaw_rad is not None
    euler = np.stack([observations.pitch_rad, observations.yaw_rad, observations.roll_rad], axis=-1)
    velocity_dps = np.rad2deg(body_rates_rad_s(euler, observations.euler_rate_rad_s))
    _, first, index = np.unique(observations.point, return_index=True, return_inverse=True)
    off_dps = np.abs(velocity_dps - velocity_dps[first][index]).max(axis=1)
    allowed_dps = _LARGEST_RATE_SPREAD * float(np.abs(velocity_dps).max())
    if off_dps.max() > allowed_dps:
        row = int(np.argmax(off_dps))
        raise ObservationsError(
            f"{table.file}: line {table.lines[row]}: columns {', '.join(RATE_INPUTS)}: point {observations.point[row]} "
            f"has an angular velocity in package axes that differs by {off_dps[row]:.3g} °/s from that on line "
            f"{table.lines[int(first[index[row]])]}; allowed {allowed_dps:.3g} °/s; nothing was solved; correct the "
            "rates and angles or the point label"
        )
