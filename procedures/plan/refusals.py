"""What a rig cannot do and what a design cannot determine, each a sentence with file, line, key and the way out.

Everything is told at once, before any port is opened.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from ams.arrays import FloatArray
from ams.frames import Attitude
from ams.models.registry import model_named
from ams.parameter_words import words_of
from procedures.description.procedure_file import EnvironmentPlan, ProcedureDescription
from procedures.errors import PlanError
from procedures.plan.channels import temperature_source
from procedures.plan.designs import Design, DesignPoint
from procedures.plan.specific_force import package_specific_force
from rig.description.rig_file import RigDescription, Sensor
from rig.errors import RequestRefused

PARAMETERS = {
    "pitch-roll": ("offset", "sensitivity", "coning", "azimuth"),
    "pitch-only": ("offset", "sensitivity", "pitch misalignment"),
    "pitch-yaw-roll": ("offset", "sensitivity", "coning", "azimuth"),
    "linear": ("gain", "offset"),
}
LINEAR_PARAMETERS = {
    "pitch-roll": ("offset", "k_x", "k_y", "k_z"),
    "pitch-only": ("offset", "k_x", "k_z"),
    "pitch-yaw-roll": ("offset", "k_x", "k_y", "k_z"),
    "linear": ("offset", "k"),
}
TEMPERATURE_PARAMETERS = ("offset temperature coefficient", "sensitivity temperature coefficient")
TIME_PARAMETERS = ("offset drift",)
YAWED_MODELS = ("pitch-yaw-roll", "linear")
"""Models that know what a yaw does to a package."""
_ANGLES = ("pitch_deg", "roll_deg", "yaw_deg")
RANK_TOLERANCE = 1e-9
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
    yield from _unknown_packages(rig, procedure)
    yield from _temperature_terms(rig, procedure, sensors, environment)
    yield from _plateaus_beyond_limits(rig, procedure, environment)


def design_refusals(
    rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor], design: Design
) -> Iterator[PlanError]:
    """Tell why a design of attitudes cannot be gone to or cannot determine its model."""
    yield from _missing_axes(rig, procedure, design)
    yield from _undetermined(sensors, procedure, design)
    yield from _yaw_without_a_model(procedure, design)
    yield from _senseless_channels(sensors, procedure)


def _plateaus_beyond_limits(
    rig: RigDescription, procedure: ProcedureDescription, environment: EnvironmentPlan | None
) -> Iterator[PlanError]:
    if environment is None or environment.name is None:
        return
    for plateau_degc in environment.plateaus_degc:
        try:
            rig.environment[environment.name].refuse_beyond_limits(environment.name, plateau_degc)
        except RequestRefused as error:
            yield procedure.error(("environment", "plateaus_degc"), str(error))


def _missing_axes(rig: RigDescription, procedure: ProcedureDescription, design: Design) -> Iterator[PlanError]:
    needed = {"pitch": "pitch_deg"}
    needed |= {"roll": "roll_deg"} if _rolls(design) else {}
    needed |= {"yaw": "yaw_deg"} if _yaws(design) or procedure.solve.model == "pitch-yaw-roll" else {}
    for axis, key in needed.items():
        if axis not in rig.axes:
            has = ", ".join(rig.axes)
            yield procedure.error(
                ("design", key), f"needs the axis {axis}, which the rig does not have (it has: {has})"
            )


def _rolls(design: Design) -> bool:
    return any(point.roll_deg != 0.0 for point in design.points)


def _yaws(design: Design) -> bool:
    return any(point.yaw_deg != 0.0 for point in design.points)


def _yaw_without_a_model(procedure: ProcedureDescription, design: Design) -> Iterator[PlanError]:
    if _yaws(design) and procedure.solve.model not in YAWED_MODELS:
        yield procedure.error(
            ("solve", "model"),
            f'the model "{procedure.solve.model}" has no yaw, the design goes to yaw {_farthest_yaw_deg(design):g}°; '
            'use "pitch-yaw-roll" or remove yaw_deg',
        )


def _farthest_yaw_deg(design: Design) -> float:
    return max((point.yaw_deg for point in design.points), key=abs)


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
    sensors: Mapping[str, Sensor], procedure: ProcedureDescription, design: Design
) -> Iterator[PlanError]:
    names = model_parameters(procedure)
    attitudes = {(point.pitch_deg, point.yaw_deg, point.roll_deg) for point in design.points}
    linear = parameters_of(procedure.solve.model)
    if len(attitudes) < len(linear):
        yield procedure.error(
            ("design",),
            f"{len(attitudes)} different attitudes for {len(linear)} parameters ({', '.join(linear)}) of model "
            f"{procedure.solve.model}; nothing can be solved; give at least {len(linear) + 1}",
        )
    elif procedure.procedure.replications * len(design.points) <= len(names):
        yield procedure.error(
            ("procedure", "replications"),
            f"{procedure.procedure.replications} × {len(design.points)} dwells for {len(names)} parameters leave no "
            "degree of freedom, so no uncertainty; give more replications or points",
        )
    else:
        yield from _rank_deficient(sensors, procedure, design)


def model_parameters(procedure: ProcedureDescription) -> tuple[str, ...]:
    """Names of what is estimated for each sensor axis."""
    further = TEMPERATURE_PARAMETERS if procedure.solve.temperature == "estimate" else ()
    with_time = TIME_PARAMETERS if procedure.solve.time_term == "linear" else ()
    return (*parameters_of(procedure.solve.model), *further, *with_time)


def parameters_of(model: str) -> tuple[str, ...]:
    """Return the parameters of a sensor axis in words."""
    if model in PARAMETERS:
        return PARAMETERS[model]
    return tuple(words_of(name).label for name in model_named(model, "x").parameter_names)


def basis(model: str, points: Sequence[DesignPoint], package: str = "model", axis: str = "x") -> FloatArray:
    """(K, P) linear form of the model at the points: TP (128), and without roll its pitch columns.

    ``package`` is CR's, ``axis`` the nominal axis of a straight line.
    """
    columns = package_specific_force(points, package)[:, _components(model, axis)]
    return np.concatenate([np.ones((len(points), 1)), columns], axis=1)


def _components(model: str, axis: str) -> list[int]:
    """Return the components of specific force that the model senses."""
    if model == "linear":
        return ["xyz".index(axis)]
    return [0, 2] if model == "pitch-only" else [0, 1, 2]


def _level_lines(sensors: Mapping[str, Sensor], procedure: ProcedureDescription, design: Design) -> Iterator[PlanError]:
    for axis in sorted({axis for sensor in sensors.values() for axis in sensor.channels}):
        if _lost(basis("linear", design.points, axis=axis), LINEAR_PARAMETERS["linear"]):
            yield procedure.error(
                ("design",),
                f"all attitudes give the {axis} axis the same share of gravity: a straight line needs two levels or "
                "more; give attitudes with the axis up and down",
            )


def _rank_deficient(
    sensors: Mapping[str, Sensor], procedure: ProcedureDescription, design: Design
) -> Iterator[PlanError]:
    model = procedure.solve.model
    if model == "pitch-only" and _rolls(design):
        yield procedure.error(
            ("solve", "model"), 'the model "pitch-only" needs roll 0° everywhere; use "pitch-roll" or remove roll_deg'
        )
        return
    if model == "linear":
        yield from _level_lines(sensors, procedure, design)
        return
    if model not in LINEAR_PARAMETERS:
        yield from _own_model_undetermined(sensors, procedure, design)
        return
    on_sting = "sting" in procedure.solve.packages.values() or not all(one.rolls for one in sensors.values())
    package = "sting" if on_sting else "model"
    lost = _lost(basis(model, design.points, package), LINEAR_PARAMETERS[model])
    if not lost:
        return
    for axis, values in (("roll", design.roll_values_deg), ("pitch", design.pitch_values_deg)):
        if len(set(values)) == 1:
            yield procedure.error(
                ("design", f"{axis}_deg"),
                f"{axis} at one value only ({values[0]:g}°): {_cannot(axis, model, lost)} cannot be determined; "
                f"give {axis} values over the whole range" + _or_without_roll(axis),
            )
            return
    yield procedure.error(
        ("design",),
        f"these attitudes cannot tell {', '.join(lost)} of model {model} apart; add pitch or roll values between",
    )


def _own_model_undetermined(
    sensors: Mapping[str, Sensor], procedure: ProcedureDescription, design: Design
) -> Iterator[PlanError]:
    """Judge another distribution's model by its own Jacobian at what a nominal sensor would read."""
    for serial, sensor in sensors.items():
        for axis in map(str, sensor.channels):
            lost = _lost(nominal_jacobian(procedure.solve.model, axis, design, sensor), _names(procedure, axis))
            if lost:
                yield procedure.error(
                    ("design",),
                    f"these attitudes cannot tell {', '.join(lost)} of model {procedure.solve.model} apart for "
                    f"{serial}.{axis}; add pitch or roll values between",
                )


def nominal_jacobian(name: str, axis: str, design: Design, sensor: Sensor) -> FloatArray:
    """Return (K, P) the columns of a model at the points, for a sensor that reads as it nominally should."""
    model = model_named(name, axis)
    attitude = Attitude(*(np.deg2rad([getattr(point, key) for point in design.points]) for key in _ANGLES))
    nominal_v = sensor.nominal_v_per_g(axis) * package_specific_force(design.points)[:, "xyz".index(axis)]
    if model.basis_key is not None:
        return model.basis(attitude)
    return model.jacobian(model.start(attitude, nominal_v), attitude)


def _names(procedure: ProcedureDescription, axis: str) -> tuple[str, ...]:
    return tuple(words_of(name).label for name in model_named(procedure.solve.model, axis).primary_names)


def _lost(columns: FloatArray, names: Sequence[str]) -> list[str]:
    """Linear parameters that some direction without effect on the outputs has a share in."""
    _, singular, directions = np.linalg.svd(columns, full_matrices=False)
    blind = directions[singular < RANK_TOLERANCE * singular[0]]
    return [name for name, share in zip(names, np.abs(blind).max(axis=0, initial=0.0), strict=True) if share > 1e-6]


def _cannot(axis: str, model: str, lost: Iterable[str]) -> str:
    return "coning and azimuth" if axis == "roll" and model != "pitch-only" else " and ".join(lost)


def _or_without_roll(axis: str) -> str:
    return ', or use solve.model = "pitch-only"' if axis == "roll" else ""


def _senseless_channels(sensors: Mapping[str, Sensor], procedure: ProcedureDescription) -> Iterator[PlanError]:
    if procedure.solve.model == "pitch-only":
        for serial, sensor in sensors.items():
            if "y" in sensor.channels:
                yield procedure.error(
                    ("solve", "model"),
                    f'the model "pitch-only" has nothing for {serial}.y: without roll it senses no gravity; '
                    'use "pitch-roll"',
                )


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
    with_time = abs(float(np.corrcoef(np.arange(len(plateaus)), plateaus)[0, 1]))
    if with_time > MOST_TIME_CORRELATION:
        yield procedure.error(
            ("environment", "plateaus_degc"),
            f"temperature and time are correlated by {with_time:.2f}, allowed {MOST_TIME_CORRELATION:g}: a drift would "
            "pass for a temperature coefficient; visit the plateaus from both sides, such as [10.0, 20.0, 30.0, 20.0]",
        )
