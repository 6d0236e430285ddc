"""Which uncertainty a plan should reach: the parameters' standard uncertainties, for a noise that is stated with them.

Only precision and the table's index errors are in it; what drifts, and what the model does not fit, shows in the run.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians, sqrt

import numpy as np

from ams.analysis.design_variance import expected_standard_uncertainty
from ams.analysis.design_without_roll import expected_without_roll
from ams.frames import Attitude
from ams.inputs.table_uncertainty import TableUncertainty, index_columns
from ams.models.accelerometer import vector_from_angles
from ams.models.registry import model_named
from ams.solve.linear_form import factor
from procedures.check.evaluation import attitudes_rad
from procedures.description.procedure_file import ProcedureDescription
from procedures.plan.plan import Plan
from procedures.solution.request import model_name
from procedures.solution.type_b import table_uncertainty
from rig.description.rig_file import AxisTruth, RigDescription

RAD_PER_ARCSEC = radians(1.0 / 3600.0)
NOMINAL_CONING_DEG = 0.3
"""Assumed where no truth is known: only the azimuth's uncertainty depends on it, as its inverse."""


@dataclass(frozen=True)
class ExpectedAxis:
    """What to expect of one sensor axis."""

    sensor: str
    axis: str
    noise_v: float
    """Standard deviation of a dwell's mean."""
    noise_source: str
    """Where the figure comes from."""
    coning_deg: float
    standard_uncertainty: Mapping[str, float | None]
    """Parameter to standard uncertainty in its own unit; None where it will not be determined."""


def expected_uncertainties(
    rig: RigDescription, procedure: ProcedureDescription, plan: Plan
) -> tuple[ExpectedAxis, ...]:
    """One entry for every sensor axis of the plan."""
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
    sensitivity = plan.sensors[serial].nominal_sensitivity_v_per_g
    truth = _truth(rig, serial, axis)
    noise_v, source = _noise(procedure, plan, truth, sensitivity)
    coning_deg, azimuth_deg = (NOMINAL_CONING_DEG, 40.0) if truth is None else (truth.coning_deg, truth.azimuth_deg)
    pitch_rad, roll_rad = attitudes_rad(plan.design)
    if plan.solve.model == "pitch-only":
        values = expected_without_roll(pitch_rad, plan.replications, noise_v, sensitivity, axis, table=table)
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
    """Of models that know yaw. ``sensor``: sensitivity (V/g), coning and azimuth (degrees) in TP's terms."""
    angles = {
        name: np.deg2rad([getattr(point, f"{name}_deg") for point in plan.design.points])
        for name in ("pitch", "yaw", "roll")
    }
    model = model_named(model_name(plan.solve, serial), axis)
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
    """What the procedure states, else the twin's, else half an arc second a dwell (TP's precision)."""
    stated = "expected_noise_arcsec" in procedure.solve.model_fields_set
    if truth is not None and not stated:
        return truth.noise_v / sqrt(plan.dwell.samples), f"the twin's {truth.noise_v:g} V a reading"
    noise_arcsec = procedure.solve.expected_noise_arcsec
    source = "solve.expected_noise_arcsec" if stated else "assumed"
    return noise_arcsec * RAD_PER_ARCSEC * abs(sensitivity_v_per_g), f"{noise_arcsec:g}″ a dwell, {source}"
