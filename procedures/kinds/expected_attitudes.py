"""Which uncertainty a plan should reach: the parameters' standard uncertainties, for a noise that is stated with them.

Only precision and the table's index errors are in it; what drifts, and what the model does not fit, shows in the run.
"""

from collections.abc import Iterable, Iterator, Mapping
from math import radians, sqrt

import numpy as np

from ams.analysis.design_variance import expected_standard_uncertainty
from ams.analysis.design_without_roll import expected_without_roll
from ams.frames import Attitude
from ams.inputs.table_uncertainty import TableUncertainty, index_columns
from ams.models.accelerometer import vector_from_angles
from ams.models.registry import model_named
from ams.solve.linear_form import factor
from ams.units import RAD_PER_ARCSEC
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.attitudes import OF_ATTITUDES
from procedures.kinds.expected import ExpectedAxis
from procedures.kinds.kind import DesignFigures, Forecast
from procedures.plan.judged_design import judge_design
from procedures.plan.plan import Plan
from procedures.plan.refusals import basis, model_parameters, nominal_jacobian
from procedures.plan.specific_force import attitudes_rad
from procedures.solution.request import model_name
from procedures.solution.type_b import table_uncertainty
from rig.description.rig_file import AxisTruth, RigDescription

LEAST_REPLICATIONS = 6
"""TP, recommendation 6."""
CALIBRATION_OVER_USAGE = 1.5
"""TP, recommendation 1."""
NOMINAL_CONING_DEG = 0.3
"""Assumed where no truth is known: only the azimuth's uncertainty depends on it, as its inverse."""


def forecast_of_design(
    rig: RigDescription, procedure: ProcedureDescription, plan: Plan, further: Iterable[str]
) -> Forecast:
    """Judge a design of attitudes and the uncertainties that it should reach. ``further``: advice of its kind."""
    judged = judge_design(plan.design, plan.usage_pitch_deg)
    parameters = model_parameters(procedure)
    columns = basis(plan.solve.model, plan.design.points)
    figures = DesignFigures(
        parameters=parameters,
        rank=int(np.linalg.matrix_rank(columns)) + len(parameters) - columns.shape[1],
        degrees_of_freedom=len(plan.design_dwells) - len(parameters),
        figure_of_merit_sqrt=judged.figures.figure_of_merit_sqrt,
        usage_figure_of_merit_sqrt=judged.figures.usage_figure_of_merit_sqrt,
        time_correlation=time_correlation(plan),
    )
    return Forecast(expected_uncertainties(rig, procedure, plan), (*_advice(plan), *further), figures)


def time_correlation(plan: Plan) -> float:
    """Return the correlation of time with the terms of the model in the first replication.

    Near 1, a drift passes for a parameter.
    """
    by_label = {point.label: point for point in plan.design.points}
    points = [by_label[dwell.point] for dwell in plan.design_dwells if dwell.replication == 1]
    terms = basis(plan.solve.model, points)[:, 1:]
    time = np.arange(len(points)) - (len(points) - 1) / 2.0
    varying = terms - terms.mean(axis=0)
    with_time = np.abs(time @ varying) / (np.linalg.norm(time) * np.maximum(np.linalg.norm(varying, axis=0), 1e-12))
    return float(with_time.max())


def expected_uncertainties(
    rig: RigDescription, procedure: ProcedureDescription, plan: Plan
) -> tuple[ExpectedAxis, ...]:
    """Return one entry for every sensor axis of the plan."""
    table = table_uncertainty(rig)
    return tuple(
        _expected_axis(rig, procedure, plan, table, serial, axis)
        for serial, sensor in plan.sensors.items()
        for axis in sensor.channels
    )


def _expected_axis(
    rig: RigDescription,
    procedure: ProcedureDescription,
    plan: Plan,
    table: TableUncertainty | None,
    serial: str,
    axis: str,
) -> ExpectedAxis:
    sensitivity = plan.sensors[serial].nominal_v_per_g(axis)
    truth = _truth(rig, serial, axis)
    noise_v, source = _noise(procedure, plan, truth, sensitivity)
    coning_deg, azimuth_deg = (NOMINAL_CONING_DEG, 40.0) if truth is None else (truth.coning_deg, truth.azimuth_deg)
    pitch_rad, roll_rad = attitudes_rad(plan.design)
    if plan.solve.model == "pitch-only":
        values = expected_without_roll(pitch_rad, plan.replications, noise_v, sensitivity, axis, table=table)
    elif plan.solve.model not in OF_ATTITUDES:
        columns = nominal_jacobian(plan.solve.model, axis, plan.design, plan.sensors[serial])
        covariance = noise_v**2 / plan.replications * np.linalg.inv(columns.T @ columns)
        names = model_named(plan.solve.model, axis).primary_names
        values = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    elif plan.solve.model in ("linear", "pitch-yaw-roll"):
        values = _expected_on_gimbal(plan, serial, axis, noise_v, (sensitivity, coning_deg, azimuth_deg), table)
    else:
        coning_rad, azimuth_rad = np.deg2rad(coning_deg), np.deg2rad(azimuth_deg)
        values = expected_standard_uncertainty(
            pitch_rad, roll_rad, plan.replications, noise_v, sensitivity, axis, coning_rad, azimuth_rad, table
        )
    return ExpectedAxis(serial, axis, noise_v, source, coning_deg, values)


def _expected_on_gimbal(
    plan: Plan,
    serial: str,
    axis: str,
    noise_v: float,
    sensor: tuple[float, float, float],
    table: TableUncertainty | None,
) -> Mapping[str, float | None]:
    """Return the expected uncertainties of a model that knows yaw.

    ``sensor``: sensitivity (V/g), coning and azimuth (degrees) in TP's terms.
    """
    angles = {
        name: np.deg2rad([getattr(point, f"{name}_deg") for point in plan.design.points])
        for name in ("pitch", "yaw", "roll")
    }
    model = model_named(model_name(plan.solve, serial, rolls=plan.sensors[serial].rolls), axis)
    attitude = Attitude(angles["pitch"], angles["roll"], angles["yaw"])
    k = vector_from_angles(axis, sensor[0], radians(sensor[1]), radians(sensor[2]))
    primary = np.array([0.0, k["xyz".index(axis)]]) if plan.solve.model == "linear" else np.array([0.0, *-k])
    form = factor(model.basis(attitude), model.primary_names, attitude)
    covariance = noise_v**2 / plan.replications * form.unscaled_covariance
    if table is not None:
        columns = form.estimator @ index_columns(table, angles, model.angle_jacobian(primary, attitude))
        covariance = covariance + columns @ columns.T
    rows = model.parameters_jacobian(primary)
    values = np.sqrt(np.einsum("mi,ij,mj->m", rows, covariance, rows))
    null = model.undetermined(primary, covariance)
    named = zip(model.parameter_names, values.tolist(), strict=True)
    return {name: None if name in null else float(value) for name, value in named}


def _truth(rig: RigDescription, serial: str, axis: str) -> AxisTruth | None:
    if rig.twin is None:
        return None
    return next((truth for name, truth in rig.twin.truth.get(serial, {}).items() if name == axis), None)


def _noise(
    procedure: ProcedureDescription, plan: Plan, truth: AxisTruth | None, sensitivity_v_per_g: float
) -> tuple[float, str]:
    """Return the noise of a dwell, V, and its source.

    What the procedure states, else the twin's, else half an arc second a dwell (TP's precision).
    """
    stated = "expected_noise_arcsec" in procedure.solve.model_fields_set
    if truth is not None and not stated:
        return truth.noise_v / sqrt(plan.dwell.samples), f"the twin's {truth.noise_v:g} V a reading"
    noise_arcsec = procedure.solve.expected_noise_arcsec
    source = "solve.expected_noise_arcsec" if stated else "assumed"
    return noise_arcsec * RAD_PER_ARCSEC * abs(sensitivity_v_per_g), f"{noise_arcsec:g}″ a dwell, {source}"


def _advice(plan: Plan) -> Iterator[str]:
    """Yield where TP's recommendations are not followed."""
    if plan.replications < LEAST_REPLICATIONS:
        yield (
            f"{plan.replications} replication{'s' if plan.replications > 1 else ''}: drift and lack of fit want "
            f"{LEAST_REPLICATIONS} or more (TP recommendation 6)"
        )
    if plan.reference is not None and plan.is_at_rest and not plan.reference.tells_slip_from_tilt:
        yield (
            "reference visits at attitudes that do not differ in pitch and in roll cannot tell a slip of the table "
            "from a tilt of its base, and of a lone sensor not from its own change: name two, such as [check] "
            "pitch_deg = [0, 30], roll_deg = [0, 60]"
        )


def advice_on_ranges(plan: Plan) -> Iterator[str]:
    """Tell where roll or pitch reach less far than TP recommends."""
    if plan.design.has_roll and max(plan.design.roll_values_deg) - min(plan.design.roll_values_deg) < 270.0:
        yield "roll should cover the full circle (TP recommendation 2)"
    yield from _advice_on_usage(plan)


def _advice_on_usage(plan: Plan) -> Iterator[str]:
    if plan.usage_pitch_deg is None:
        return
    low, high = min(plan.design.pitch_values_deg), max(plan.design.pitch_values_deg)
    if not low <= plan.usage_pitch_deg[0] < plan.usage_pitch_deg[1] <= high:
        yield (
            f"the usage range {plan.usage_pitch_deg[0]:g}° to {plan.usage_pitch_deg[1]:g}° reaches beyond the "
            f"calibration, {low:g}° to {high:g}°: nothing is validated there"
        )
    elif high - low < CALIBRATION_OVER_USAGE * (plan.usage_pitch_deg[1] - plan.usage_pitch_deg[0]) - 1e-9:
        yield "the calibration range should be 150 % of the usage range (TP recommendation 1)"
