"""What a rig cannot do and what a design cannot determine, each a sentence with file, line, key and the way out.

Everything is told at once, before any port is opened.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from pydantic import ValidationError

from ams.arrays import FloatArray
from ams.errors import DesignError
from ams.models.model import Model
from ams.models.registry import MODELS, model_named
from ams.parameter_words import words_of
from ams.solve.linear_form import RANK_TOLERANCE
from procedures.description.procedure_file import EnvironmentPlan, ProcedureDescription
from procedures.errors import PlanError
from procedures.plan.channels import channels_of, temperature_source
from procedures.plan.designs import Design
from procedures.plan.gravity_of_site import KEY, gravity_of_another_site
from procedures.plan.specific_force import columns_of
from rig.description.rig_file import RigDescription, Sensor
from rig.errors import RequestRefused

LEAST_TEMPERATURE_SPAN_DEGC = 5.0
"""Below it temperature terms are not estimated (mathematics, section 2)."""
MOST_TIME_CORRELATION = 0.8
"""Above it temperature would be time in disguise."""


def shared_refusals(
    rig: RigDescription,
    procedure: ProcedureDescription,
    sensors: Mapping[str, Sensor],
    environment: EnvironmentPlan | None,
) -> Iterator[PlanError]:
    """Tell what a plan of no kind may have: unknown packages, unmeasured temperatures, plateaus out of reach."""
    yield from _gravity_of_another_site(rig)
    yield from _unknown_packages(rig, procedure)
    yield from _nothing_to_fit_jointly(rig, procedure)
    yield from _temperature_terms(rig, procedure, sensors, environment)
    if environment is not None:
        yield from _outside_interlocks(rig, procedure, environment)
    yield from _setpoints_beyond_limits(rig, procedure, environment)
    yield from _integration_not_offered(rig, procedure, sensors)
    yield from _bursts_too_long(rig, procedure, channels_of(rig, sensors))


def _gravity_of_another_site(rig: RigDescription) -> Iterator[PlanError]:
    """Say it of a rig that was not read by ``read_rig_of_site``, which knows the line: one that a run has stored."""
    complaint = gravity_of_another_site(rig)
    if complaint is not None:
        yield PlanError(f"rig file: {'.'.join(KEY)}: {complaint}")


def _nothing_to_fit_jointly(rig: RigDescription, procedure: ProcedureDescription) -> Iterator[PlanError]:
    """Say where a joint fit has no table in pitch and roll to part the package from."""
    if not procedure.solve.joint:
        return
    if "roll" not in rig.axes:
        yield procedure.error(
            ("solve", "joint"),
            f"a joint fit needs the axes pitch and roll; the rig file has {', '.join(rig.axes)}; remove joint",
        )


def _outside_interlocks(
    rig: RigDescription, procedure: ProcedureDescription, environment: EnvironmentPlan
) -> Iterator[PlanError]:
    """Tell of plateaus at which an interlock would stop the run."""
    lock = None if environment.name is None else rig.interlocks.temperature.get(environment.name)
    if lock is None:
        return
    low, high = lock.band_degc
    outside = [f"{degc:g}" for degc in sorted(set(environment.plateaus_degc)) if not low <= degc <= high]
    if outside:
        yield procedure.error(
            ("environment", "plateaus_degc"),
            f"{' and '.join(outside)} °C lies outside interlocks.temperature.{environment.name} of the rig file "
            f"({low:g} to {high:g} °C): the run would {lock.action} there; nothing moved; widen band_degc or take "
            "plateaus inside it",
        )


def _integration_not_offered(
    rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor]
) -> Iterator[PlanError]:
    """Ask the readouts' own descriptions whether they would stand with the integrations that the dwells ask for."""
    nplc, adaptive = procedure.dwell.nplc, procedure.dwell.adaptive
    outputs = [channel for sensor in sensors.values() for channel in sensor.channels.values()]
    wanted = product(() if nplc is None else (nplc,), channels_of(rig, sensors), (("dwell", "nplc"),))
    choices = product(() if adaptive is None else adaptive.nplc or (), outputs, (("dwell", "adaptive", "nplc"),))
    readouts = dict.fromkeys((channel.partition(".")[0], cycles, key) for cycles, channel, key in (*wanted, *choices))
    for name, cycles, key in readouts:
        if name not in rig.readouts:
            continue
        settings = rig.readouts[name]
        try:
            type(settings).model_validate({**settings.model_dump(by_alias=True), "nplc": cycles})
        except ValidationError as error:
            why = error.errors(include_url=False)[0]["msg"].removeprefix("Value error, ")
            yield procedure.error(key, f"readouts.{name} cannot integrate over {cycles:g} power-line cycles: {why}")


def _bursts_too_long(
    rig: RigDescription, procedure: ProcedureDescription, channels: Sequence[str]
) -> Iterator[PlanError]:
    """Compare the readings of a dwell with what each readout holds."""
    adaptive = procedure.dwell.adaptive
    samples = procedure.dwell.samples if adaptive is None else adaptive.most_samples
    key = ("dwell", "samples") if adaptive is None else ("dwell", "adaptive", "most_samples")
    for name in dict.fromkeys(channel.partition(".")[0] for channel in channels):
        most = rig.readouts[name].most_samples() if name in rig.readouts else None
        if most is not None and samples > most:
            yield procedure.error(
                key, f"readouts.{name} holds {most} readings of a burst, got {samples}; ask for fewer"
            )


def design_refusals(
    rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor], design: Design
) -> Iterator[PlanError]:
    """Tell why a design of attitudes cannot be gone to or cannot determine the models of its sensors."""
    yield from _missing_axes(rig, procedure, sensors, design)
    models: dict[tuple[str, str], Model] = {}
    for serial, sensor in sensors.items():
        for axis in map(str, sensor.channels):
            try:
                models[serial, axis] = model_named(procedure.solve.model_of(serial, rolls=sensor.rolls), axis)
            except DesignError as error:
                yield procedure.error(("solve", "model"), f"{serial}.{axis}: {error}")
    if models:
        yield from _undetermined(sensors, procedure, design, models)
        if _yaws(design) and not _knows_yaw(next(iter(models.values())), design):
            farthest_deg = max((point.yaw_deg for point in design.points), key=abs)
            yield procedure.error(
                ("solve", "model"),
                f'the model "{procedure.solve.model}" has no yaw, the design goes to yaw {farthest_deg:g}°; '
                'use "pitch-yaw-roll" or remove yaw_deg',
            )


def _setpoints_beyond_limits(
    rig: RigDescription, procedure: ProcedureDescription, environment: EnvironmentPlan | None
) -> Iterator[PlanError]:
    if environment is None or environment.name is None:
        return
    at_the_end = () if environment.end_degc is None else (environment.end_degc,)
    for key, setpoints in (("plateaus_degc", environment.plateaus_degc), ("end_degc", at_the_end)):
        for setpoint_degc in setpoints:
            try:
                rig.environment[environment.name].refuse_beyond_limits(environment.name, setpoint_degc)
            except RequestRefused as error:
                yield procedure.error(("environment", key), str(error))


def _missing_axes(
    rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor], design: Design
) -> Iterator[PlanError]:
    models = (procedure.solve.model_of(serial, rolls=sensor.rolls) for serial, sensor in sensors.items())
    states_yaw = any("yaw" in MODELS[model].columns for model in models)
    needed = {"pitch": "pitch_deg"}
    needed |= {"roll": "roll_deg"} if any(point.roll_deg != 0.0 for point in design.points) else {}
    needed |= {"yaw": "yaw_deg"} if _yaws(design) or states_yaw else {}
    for axis, key in needed.items():
        if axis not in rig.axes:
            has = ", ".join(rig.axes)
            yield procedure.error(
                ("design", key), f"needs the axis {axis}, which the rig does not have (it has: {has})"
            )


def _yaws(design: Design) -> bool:
    return any(point.yaw_deg != 0.0 for point in design.points)


def _knows_yaw(model: Model, design: Design) -> bool:
    """Return whether the columns of the model follow the yaw of the design."""
    level = [replace(point, yaw_deg=0.0) for point in design.points]
    return not np.allclose(columns_of(model, design.points, 1.0), columns_of(model, level, 1.0))


def _unknown_packages(rig: RigDescription, procedure: ProcedureDescription) -> Iterator[PlanError]:
    for name in procedure.solve.packages:
        if name not in rig.sensors:
            yield procedure.error(
                ("solve", "packages", name), f"the rig has no sensor {name} (it has: {', '.join(rig.sensors)})"
            )
    for name, package in procedure.solve.packages.items():
        stage = rig.sensors[name].stage if name in rig.sensors else None
        if stage is not None and (package == "model") != ("roll" in stage):
            yield procedure.error(
                ("solve", "packages", name),
                f'{name} is a "{package}" package here, but the rig file says that {", ".join(stage)} carry it '
                f"(sensors.{name}.stage); say so in one place",
            )


def _undetermined(
    sensors: Mapping[str, Sensor],
    procedure: ProcedureDescription,
    design: Design,
    models: Mapping[tuple[str, str], Model],
) -> Iterator[PlanError]:
    model = max(models.values(), key=lambda candidate: len(candidate.primary_names))
    needed = len(model.primary_names)
    warmed = 2 * procedure.solve.temperature_order if procedure.solve.temperature == "estimate" else 0
    estimated = needed + warmed + (procedure.solve.time_term == "linear")
    attitudes = {(point.pitch_deg, point.yaw_deg, point.roll_deg) for point in design.points}
    if len(attitudes) < needed:
        names = ", ".join(_labels(model.parameter_names))
        yield procedure.error(
            ("design",),
            f"{len(attitudes)} different attitudes for {needed} parameters ({names}) of model "
            f"{procedure.solve.model}; nothing can be solved; give at least {needed + 1}",
        )
    elif procedure.replications * len(design.points) <= estimated:
        yield procedure.error(
            ("procedure", "replications"),
            f"{procedure.replications} × {len(design.points)} dwells for {estimated} parameters leave no "
            "degree of freedom, so no uncertainty; give more replications or points",
        )
    else:
        yield from _rank_deficient(sensors, procedure, design, models)


def _labels(names: Iterable[str]) -> list[str]:
    return [words_of(name).label for name in names]


def _rank_deficient(
    sensors: Mapping[str, Sensor],
    procedure: ProcedureDescription,
    design: Design,
    models: Mapping[tuple[str, str], Model],
) -> Iterator[PlanError]:
    """Tell once what no axis is told by these attitudes, else axis by axis."""
    reasons: set[str] = set()
    for (serial, axis), model in models.items():
        nominal = sensors[serial].nominal_v_per_g(axis) or 1.0
        try:
            lost = _lost(columns_of(model, design.points, nominal), _labels(model.primary_names))
        except DesignError as error:
            yield procedure.error(("solve", "model"), str(error))
            return
        if not lost:
            continue
        reason = _why_lost(procedure, design, model, lost, f"{serial}.{axis}")
        if str(reason) not in reasons:
            reasons.add(str(reason))
            yield reason


def _why_lost(
    procedure: ProcedureDescription, design: Design, model: Model, lost: Sequence[str], sensor_axis: str
) -> PlanError:
    if not MODELS[model.name].has_misalignment:
        return procedure.error(
            ("design",),
            f"all attitudes give the {model.nominal_axis} axis the same share of gravity: a straight line needs two "
            "levels or more; give attitudes with the axis up and down",
        )
    for axis, values in (("roll", design.roll_values_deg), ("pitch", design.pitch_values_deg)):
        if len(set(values)) == 1 and axis in MODELS[model.name].columns:
            return procedure.error(
                ("design", f"{axis}_deg"),
                f"{axis} at one value only ({values[0]:g}°): {_cannot(axis, model, lost)} cannot be determined; "
                f"give {axis} values over the whole range"
                + (', or use solve.model = "pitch-only"' if axis == "roll" else ""),
            )
    whose = "" if model.basis_key is not None else f" for {sensor_axis}"
    return procedure.error(
        ("design",),
        f"these attitudes cannot tell {', '.join(lost)} of model {procedure.solve.model} apart{whose}; "
        "add pitch or roll values between",
    )


def _lost(columns: FloatArray, names: Sequence[str]) -> list[str]:
    """Return the linear parameters that some direction without effect on the outputs has a share in."""
    _, singular, directions = np.linalg.svd(columns, full_matrices=False)
    blind = directions[singular < RANK_TOLERANCE * singular[0]]
    return [name for name, share in zip(names, np.abs(blind).max(axis=0, initial=0.0), strict=True) if share > 1e-6]


def _cannot(axis: str, model: Model, lost: Iterable[str]) -> str:
    has_cone = {"coning_deg", "azimuth_deg"} <= set(model.parameter_names)
    return "coning and azimuth" if axis == "roll" and has_cone else " and ".join(lost)


def _temperature_terms(
    rig: RigDescription,
    procedure: ProcedureDescription,
    sensors: Mapping[str, Sensor],
    environment: EnvironmentPlan | None,
) -> Iterator[PlanError]:
    wanted = procedure.solve.temperature
    if wanted == "none":
        return
    for serial, sensor in sensors.items():
        if temperature_source(rig, sensor) is None:
            yield procedure.error(
                ("solve", "temperature"),
                f'"{wanted}" needs a temperature reading, but {serial} has no temperature channel and the rig has '
                f"{len(rig.environment)} environments where one would stand for it; nothing is guessed; declare one in "
                'the rig file or use temperature = "none"',
            )
    if wanted == "apply":
        yield from _unknown_coefficients(sensors, procedure)
    elif environment is not None:
        yield from _plateaus_too_poor(procedure, environment)


def _unknown_coefficients(sensors: Mapping[str, Sensor], procedure: ProcedureDescription) -> Iterator[PlanError]:
    needed = {f"{serial}.{axis}" for serial, sensor in sensors.items() for axis in sensor.channels}
    given = set(procedure.solve.known_temperature)
    for name in sorted(needed - given):
        yield procedure.error(("solve", "known_temperature"), f"coefficients of {name} are missing; nothing is guessed")
    for name in sorted(given - needed):
        yield procedure.error(
            ("solve", "known_temperature", name), f"the rig has no {name} (it has: {', '.join(sorted(needed))})"
        )


def _plateaus_too_poor(procedure: ProcedureDescription, environment: EnvironmentPlan) -> Iterator[PlanError]:
    plateaus = environment.plateaus_degc
    span_degc = max(plateaus) - min(plateaus)
    if span_degc < LEAST_TEMPERATURE_SPAN_DEGC:
        yield procedure.error(
            ("environment", "plateaus_degc"),
            f"span {span_degc:g} °C, needed {LEAST_TEMPERATURE_SPAN_DEGC:g} °C or more to estimate temperature terms",
        )
        return
    if len(set(plateaus)) <= procedure.solve.temperature_order:
        yield procedure.error(
            ("environment", "plateaus_degc"),
            f"{len(set(plateaus))} different temperatures do not determine terms of second order; add one between, "
            "or solve with temperature_order = 1",
        )
    with_time = abs(float(np.corrcoef(np.arange(len(plateaus)), plateaus)[0, 1]))
    if with_time > MOST_TIME_CORRELATION:
        yield procedure.error(
            ("environment", "plateaus_degc"),
            f"temperature and time are correlated by {with_time:.2f}, allowed {MOST_TIME_CORRELATION:g}: a drift would "
            "pass for a temperature coefficient; visit the plateaus from both sides, such as [10.0, 20.0, 30.0, 20.0]",
        )
