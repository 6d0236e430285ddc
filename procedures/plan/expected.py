"""Which uncertainty a plan should reach: the parameters' standard uncertainties, for a noise that is stated with them.

Only precision and the table's index errors are in it; what drifts, and what the model does not fit, shows in the run.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians, sqrt
from typing import TYPE_CHECKING

import numpy as np

from procedures.description import ProcedureDescription
from procedures.plan.evaluation import attitudes_rad
from procedures.plan.felt import equivalent_rad
from procedures.plan.plan import Plan
from procedures.plan.refusals import basis
from procedures.solving import table_uncertainty
from rig.description import AxisTruth, RigDescription

if TYPE_CHECKING:
    from ams.uncertainty.table import TableUncertainty

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
    table: "TableUncertainty | None",
    serial: str,
    axis: str,
) -> ExpectedAxis:
    from ams.uncertainty.design_variance import expected_standard_uncertainty
    from ams.uncertainty.design_without_roll import expected_without_roll

    sensitivity = plan.sensors[serial].nominal_sensitivity_v_per_g
    truth = _truth(rig, serial, axis)
    noise_v, source = _noise(procedure, plan, truth, sensitivity)
    coning_deg, azimuth_deg = (NOMINAL_CONING_DEG, 40.0) if truth is None else (truth.coning_deg, truth.azimuth_deg)
    pitch_rad, roll_rad = attitudes_rad(plan.design)
    if plan.solve.model == "pitch-only":
        values = expected_without_roll(pitch_rad, plan.replications, noise_v, sensitivity, axis, table=table)
    elif plan.solve.model == "linear":
        values = _expected_line(plan, axis, noise_v, sensitivity)
    else:
        if plan.solve.model == "pitch-yaw-roll":
            pitch_rad, roll_rad = equivalent_rad(plan.design.points, plan.solve.packages.get(serial, "model"))
            table, source = None, f"{source}, table errors not in it"
        coning_rad, azimuth_rad = np.deg2rad(coning_deg), np.deg2rad(azimuth_deg)
        values = expected_standard_uncertainty(
            pitch_rad, roll_rad, plan.replications, noise_v, sensitivity, axis, coning_rad, azimuth_rad, table
        )
    return ExpectedAxis(serial, axis, noise_v, source, coning_deg, values)


def _expected_line(plan: Plan, axis: str, noise_v: float, sensitivity_v_per_g: float) -> dict[str, float | None]:
    """Of real = A·measured + B with A = 1/S, for an offset of nothing."""
    columns = basis("linear", plan.design.points, axis=axis)
    offset, slope = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)) / plan.replications) * noise_v
    return {
        "gain_g_per_v": float(slope) / sensitivity_v_per_g**2,
        "offset_g": float(offset) / abs(sensitivity_v_per_g),
    }


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
