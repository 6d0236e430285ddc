"""``calrig fit``: from observations in a file to coefficients, by every model there is; no rig needed."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from cyclopts import Parameter

from ams.calibration.findings_document import full_document
from ams.calibration.linear_levels import calibrated_levels, linear_document, read_levels
from ams.errors import DesignError
from ams.inference.inference import Package
from ams.inference.sting_reference import WARNING, read_with_sting
from ams.inputs.csv_table import CsvForm, header_of, parse_csv
from ams.inputs.observations_csv import read_csv
from ams.inputs.reading_times import STARTED, last_reading_utc
from ams.inputs.request import CalibrationRequest
from ams.models.registry import MODELS, names_by_option, senses_rates, takes_levels
from ams.models.thermal import TemperatureCoefficients
from procedures.cli.attitude.package_file import package_of
from procedures.cli.fit.coefficient_set import WishedSet, of_readings, refuse_per_g, wished_set, write_set
from procedures.cli.fit.joint import check_joint, joint_lines, parse_priors
from procedures.cli.fit.joint import joint as fit_jointly
from procedures.cli.options import Flag, Json, require_folder_of
from procedures.cli.output import note, print_json, say_lines
from procedures.cli.results.coefficients_text import axes_lines, verdict_lines
from procedures.cli.results.findings_text import check_trials
from procedures.errors import RequestError
from procedures.plan.gravity_of_site import read_rig_of_site
from procedures.records.overdue_standards import overdue_warnings
from procedures.solution.fit_options import (
    directions_of,
    errors_of_options,
    measured_utc,
    model_named,
    on_command_line,
    refuse_reference_temperature,
)
from procedures.solution.fitted import fitted
from procedures.solution.sensor_of_file import errors_of_file, named_sensor, require_sensor
from procedures.solution.type_b import on_table
from rig.description.rig_file import RigDescription
from rig.local_time import local_day

Named = Annotated[list[str] | None, Parameter(negative=())]
Value = TypeVar("Value")


def fit(
    file: Path,
    /,
    *,
    model: Annotated[str, Parameter(help=f"One of {', '.join(names_by_option())}.")] = "pitch-roll",
    package: Literal["sting", "model"] | None = None,
    axis: Named = None,
    polarity: Named = None,
    separator: Literal["comma", "semicolon", "tab"] = "comma",
    decimal: Literal["point", "comma"] = "point",
    sting: Path | None = None,
    sting_axis: Named = None,
    temperature: Literal["none", "apply", "estimate"] = "none",
    temperature_order: Literal[1, 2] = 1,
    known_temperature: Named = None,
    reference_temperature_degc: float | None = None,
    extended: Literal["no", "test", "yes"] = "yes",
    time_term: Literal["none", "linear"] = "none",
    hessian: Flag = False,
    monte_carlo: int = 0,
    rig: Path | None = None,
    rate_uncertainty_ppm: float | None = None,
    direction_uncertainty_arcsec: float | None = None,
    largest_g_sensitivity_dps_per_g: float | None = None,
    rates_include_earth: Flag = False,
    reference_uncertainty_ppm: float | None = None,
    reference_zero_uncertainty: float | None = None,
    joint: Flag = False,
    prior: Named = None,
    mount: str | None = None,
    set_: Annotated[Path | None, Parameter(name="--set")] = None,
    sensor: str | None = None,
    gravity_mps2: float | None = None,
    calibrated_on: str | None = None,
    json: Json = False,
) -> None:
    """Solve observations from a CSV file; no rig needed.

    The file has the columns replication, point, the angles of the model (pitch_deg, yaw_deg, roll_deg; for gyros also
    pitch_rate_dps, yaw_rate_dps, roll_rate_dps; for linear reference_<unit>), optionally temperature_degc and time_s,
    and one column for each sensor axis.

    Parameters
    ----------
    file
        The observations.
    package
        For pitch-yaw-roll: sting (roll does not reach it) or model.
    axis
        AXIS=COLUMN for each sensor axis, such as --axis x=sx_v --axis y=sy_v.
    polarity
        AXIS=+ or AXIS=-, the sign of an axis' sensitivity where it is known, such as --polarity z=-. Axes of which none
        is stated have to read with one sign in gyros and by pitch-yaw-roll.
    separator
        What stands between the columns of the file.
    decimal
        What stands before the decimals of its numbers; with comma, a number with a point is refused.
    sting
        For the model package: the sting package's set, whose outputs then stand for pitch and yaw (CR's second step).
    sting_axis
        AXIS=COLUMN of the sting package; by default sting_x_v and so on.
    temperature
        none; apply known temperature coefficients; or estimate them from the column temperature_degc.
    temperature_order
        2: offset and sensitivity may bend with temperature; for --temperature estimate.
    known_temperature
        AXIS=OFFSET_TC,SENSITIVITY_TC in V/°C and 1/°C, such as x=1.2e-5,-3e-5; two more numbers are their standard
        uncertainties.
    reference_temperature_degc
        Where the coefficients hold; by default the mean temperature rounded to 1 °C.
    extended
        Terms of second and third order: wherever the points determine them (yes), where a test asks for them
        (test), or never (no).
    time_term
        linear: a drift of the offset with time, from the column time_s, is estimated beside the parameters.
    hessian
        Also state H_E, the curvature of the residuals, and what it would do to the standard uncertainties.
    monte_carlo
        So many trials of a Monte Carlo check beside the uncertainty budget.
    rig
        A rig file whose certificates (table, meter, level, thermometer) are carried into the result and told in an
        uncertainty budget, and whose gravity a set states.
    rate_uncertainty_ppm
        For gyros: relative standard uncertainty of the rate table's rates, one error of all of them, in parts per
        million.
    direction_uncertainty_arcsec
        For gyros: standard uncertainty of the direction of every axis of the table to either side (squareness of the
        axes, seat of the package), in arc seconds.
    largest_g_sensitivity_dps_per_g
        For gyros: limit of the data sheet on what one g does to their zeros; it counts for use at any attitude.
    rates_include_earth
        For gyros: the rates of the file include the Earth's along every axis; without it the Earth's rotation, in a
        direction that nothing states, is in the uncertainties.
    reference_uncertainty_ppm
        For linear: relative standard uncertainty of the known levels (the gain of a coil or of its current source), one
        error of all of them, in parts per million.
    reference_zero_uncertainty
        For linear: standard uncertainty of what is added to all known levels (a field that stands there besides), in
        the unit of reference_<unit>.
    joint
        Fit package and table together, the table's errors under the rig's priors; says what stays confounded.
    prior
        For --joint, standard uncertainty of a whole-table error: NAME=ARCSEC with pitch-zero, roll-zero, base-tilt,
        squareness, droop or seat.
    mount
        For --joint, the column that says upright or reversed.
    set_
        Write a coefficient set to this JSON file.
    sensor
        The sensor's name in that set; with --rig one of the rig file. Of several in a rig file the one that all
        columns begin with, where none is named.
    gravity_mps2
        Local gravity of the calibration, for the set, where no rig file states it; what senses no gravity (gyros,
        straight lines of rates or fields) needs none.
    calibrated_on
        The day on which the readings were taken, such as 2026-03-01, for the set and for the due days of a rig file's
        standards; a file with the column started_utc tells it itself.
    """
    require_folder_of(set_, "--set")
    _refuse_temperatures(temperature_order, reference_temperature_degc, temperature)
    _refuse_without_result(sensor, gravity_mps2, rig, set_)
    form, columns = _form(separator, decimal), _columns(axis)
    name = model_named(model, package, on_command_line)
    stated_errors = (
        rate_uncertainty_ppm, direction_uncertainty_arcsec, largest_g_sensitivity_dps_per_g, reference_uncertainty_ppm,
        reference_zero_uncertainty,
    )  # fmt: skip
    of_options = errors_of_options(stated_errors, model, on_command_line, rates_include_earth=rates_include_earth)
    description = None if rig is None else read_rig_of_site(rig)
    require_sensor(description, sensor, str(rig))
    sensor = named_sensor(description, sensor, columns.values())
    check_trials(monte_carlo, is_possible=not takes_levels(model) and not joint)
    takes_rig = not (senses_rates(model) or takes_levels(model))
    _refuse_rig(description, model, takes_rig=takes_rig)
    request = CalibrationRequest(
        model=name,
        nominal_axes={label: label for label in columns},
        temperature=temperature,
        temperature_order=temperature_order,
        known_temperature=_coefficients(known_temperature, temperature),
        reference_temperature_degc=reference_temperature_degc,
        extended=extended,
        time_term=time_term == "linear",
        residual_curvature=hessian,
        declared=directions_of(_signs(polarity), columns, model, (description, sensor), on_command_line),
        shared_errors=of_options if description is None else errors_of_file(description, sensor),
    )
    request = on_table(request, description)
    reference = sting_package(sting, sting_axis, name, is_joint=joint)
    _refuse_priors(is_given=bool(prior or mount), is_joint=joint)
    measured = _measured_utc(file, form, calibrated_on, is_of_use=(rig or set_) is not None)
    wish: WishedSet | None = None
    if set_ is not None:
        wished = wished_set(set_, sensor, gravity_mps2, description, measured, senses_gravity=takes_rig)
        wish = of_readings(wished, file, calibrated_on)
    overdue = () if description is None else overdue_warnings(description, local_day(datetime.now(UTC)), measured)
    with _refusals_name(file):
        if joint:
            stated, given = check_joint(request, description), parse_priors(prior)
            document = fit_jointly(
                file, form, columns, stated, given, mount, wish, sensor=sensor, request=request, doubts=overdue
            )
        elif takes_levels(model):
            _refuse_curvature(hessian)
            document = _linear(file, form, columns, request, wish)
        else:
            document = _solved(file, form, columns, request, wish, reference, description, sensor, monte_carlo, overdue)
    _show(document, wish, as_json=json, is_joint=joint)


@contextmanager
def _refusals_name(file: Path) -> Iterator[None]:
    """Let every refusal of a design begin with the file whose rows it is about. Raises: DesignError."""
    try:
        yield
    except DesignError as error:
        sentence = str(error)
        raise DesignError(sentence if sentence.startswith(str(file)) else f"{file}: {sentence}") from None


def _show(document: dict[str, Any], wish: WishedSet | None, *, as_json: bool, is_joint: bool) -> None:
    """Print the result as its document, or as lines of text, and where the set is that was wished for."""
    if as_json:
        print_json(document)
    else:
        say_lines((*axes_lines(document["axes"]), *(joint_lines(document) if is_joint else ())))
        say_lines(("", *verdict_lines(document)))
    if wish is not None:
        note(f"coefficient set: {wish.path}")


def _solved(
    file: Path,
    form: CsvForm,
    columns: Mapping[str, str],
    request: CalibrationRequest,
    wish: WishedSet | None,
    sting: Package | None,
    rig: RigDescription | None,
    sensor: str | None,
    trials: int,
    overdue: tuple[str, ...],
) -> dict[str, Any]:
    if sting is None:
        wanted = MODELS[request.model]
        observations = read_csv(file, columns, wanted.columns, rates=wanted.needs_rates, form=form)
    else:
        observations, error = read_with_sting(file, columns, sting, form)
        request = request.with_error(error)
        overdue = (WARNING, *overdue)
    solved = fitted(sensor or "", observations, columns, request, rig, doubts=overdue, trials=trials)
    assert solved.calibration is not None
    if wish is not None:
        write_set(wish, observations, solved.calibration)
    return full_document(solved.calibration, observations, solved.budgets)


def _measured_utc(file: Path, form: CsvForm, stated: str | None, *, is_of_use: bool) -> datetime | None:
    """Return when the readings were taken, as file or command tells. Raises: ObservationsError, RequestError.

    ``is_of_use``: whether anything is asked for that has a day.
    """
    if stated is not None and not is_of_use:
        raise RequestError("--calibrated-on: belongs to --set or --rig, which are missing; nothing was solved")
    last_utc = last_reading_utc(parse_csv(file, form)) if STARTED in header_of(file, form).columns else None
    return measured_utc(last_utc, stated, local_day(datetime.now(UTC)), on_command_line)


def _form(separator: str, decimal: str) -> CsvForm:
    """Return what stands between columns and before decimals. Raises: RequestError where both are commas."""
    if separator == decimal == "comma":
        raise RequestError(
            "--decimal comma: columns are separated by commas too; nothing was solved; add --separator semicolon or tab"
        )
    return CsvForm({"comma": ",", "semicolon": ";", "tab": "\t"}[separator], {"point": ".", "comma": ","}[decimal])


def sting_package(path: Path | None, pairs: list[str] | None, model: str, *, is_joint: bool) -> Package | None:
    """Return the sting's set and its columns. Raises: RequestError unless a model package is to be solved."""
    if path is None:
        if pairs:
            raise RequestError("--sting-axis: belongs to --sting, which is missing")
        return None
    if not MODELS[model].follows_sting or is_joint:
        raise RequestError(f"--sting {path}: belongs to --model pitch-yaw-roll --package model")
    return package_of(path, pairs, "--sting-axis", "sting_")


def _refuse_curvature(hessian: bool) -> None:
    if hessian:
        raise RequestError("--hessian: a straight line has none; it belongs to the models of attitude and rates")


def _linear(
    file: Path, form: CsvForm, columns: Mapping[str, str], request: CalibrationRequest, wish: WishedSet | None
) -> dict[str, Any]:
    levels = read_levels(file, columns, form)
    if wish is not None:
        refuse_per_g(wish, (axis.model.unit for axis in levels.values()))
        first = next(iter(levels.values())).observations
        write_set(wish, first, calibrated_levels(levels, request))
    return linear_document(levels, request)


def _refuse_temperatures(temperature_order: int, reference_degc: float | None, temperature: str) -> None:
    refuse_reference_temperature(reference_degc, temperature, on_command_line)
    if temperature_order != 1 and temperature != "estimate":
        raise RequestError(
            f"--temperature-order: belongs to --temperature estimate, not to --temperature {temperature}"
        )


def _refuse_without_result(sensor: str | None, gravity_mps2: float | None, rig: Path | None, set_: Path | None) -> None:
    """Refuse what would be in no result."""
    if sensor is not None and rig is None and set_ is None:
        raise RequestError("--sensor: belongs to --set or --rig, which are missing; nothing was solved")
    if gravity_mps2 is not None and set_ is None:
        raise RequestError("--gravity-mps2: belongs to --set, which is missing; nothing was solved")


def _refuse_priors(*, is_given: bool, is_joint: bool) -> None:
    if is_given and not is_joint:
        raise RequestError("--prior and --mount: belong to --joint, which is missing")


def _refuse_rig(rig: RigDescription | None, model: str, *, takes_rig: bool) -> None:
    if rig is not None and not takes_rig:
        raise RequestError(f"--rig: carries the indices of a table at rest: not allowed with --model {model}")


def _columns(pairs: list[str] | None) -> dict[str, str]:
    """Return sensor axis to column. Raises: RequestError, also for one column of two axes: one column is one sensor."""
    columns = _by_axis(pairs, "--axis", "COLUMN", lambda text: text)
    taken: dict[str, str] = {}
    for label, column in columns.items():
        if column in taken:
            raise RequestError(
                f"--axis {label}={column}: the column is already axis {taken[column]}; each is one sensor"
            )
        taken[column] = label
    return columns


def _signs(pairs: list[str] | None) -> Mapping[str, str]:
    return _by_axis(pairs, "--polarity", "SIGN", str) if pairs else {}


def _coefficients(pairs: list[str] | None, temperature: str) -> Mapping[str, TemperatureCoefficients]:
    if not pairs:
        return {}
    if temperature != "apply":
        raise RequestError(f"--known-temperature: belongs to --temperature apply, not to --temperature {temperature}")
    return _by_axis(pairs, "--known-temperature", "OFFSET_TC,SENSITIVITY_TC", _two_or_four)


def _two_or_four(text: str) -> TemperatureCoefficients:
    """Read two or four temperature coefficients: two values, then their uncertainties. Raises: ValueError."""
    values = [float(part) for part in text.split(",")]
    if len(values) not in (2, 4) or not all(isfinite(value) for value in values) or any(u < 0.0 for u in values[2:]):
        raise ValueError(text)
    return TemperatureCoefficients(*values)


def _by_axis(pairs: list[str] | None, option: str, what: str, parse: Callable[[str], Value]) -> dict[str, Value]:
    """``["x=sx_v"]`` as ``{"x": "sx_v"}``."""
    if not pairs:
        raise RequestError(f"{option} is missing: give AXIS={what} for each sensor axis, such as {option} x={what}")
    found: dict[str, Value] = {}
    for pair in pairs:
        name, _, text = pair.partition("=")
        if name not in ("x", "y", "z") or not text:
            raise RequestError(f"{option} {pair}: allowed is x={what}, y={what} or z={what}")
        if name in found:
            raise RequestError(f"{option} {pair}: axis {name} is given twice; each axis is given once")
        try:
            found[name] = parse(text)
        except ValueError:
            raise RequestError(f"{option} {pair}: got {text!r}, allowed {what}, finite numbers with points") from None
    return found
