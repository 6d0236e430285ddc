"""The twin's truth in the terms of a solution: what the estimates stand beside when the run was simulated.

Only what has one value over the run is stated. A parameter that the twin lets drift has none, and a package that is
mounted turned has its truth in axes other than the solution's.
"""

import numpy as np

from ams.calibration_result import AxisCalibration
from ams.frames import AXES, wrap_deg
from ams.models.accelerometer import PitchRoll, vector_from_angles
from ams.models.extended import CUBIC_NAME, Q_NAMES, TRACELESS_NAME, ExtendedPitchRoll
from ams.models.rate_terms import RATE_TERM_NAMES
from ams.observations import Observations
from ams.sets.sensed_quantity import FIELDS
from rig.description.rig_file import AxisTruth, Mount, RigDescription

QUARTER_TURN_DEG = 90.0
"""CR's azimuth less TP's. The sensitivity of CR's accelerometers is minus TP's: they sense gravity, by
mathematics, section 1; that of its gyros is not."""


def truth_of(
    rig: RigDescription, sensor: str, axis: str, observations: Observations, calibration: AxisCalibration
) -> dict[str, float]:
    """Parameter name to the truth, at the reference temperature of the solution; empty where nothing is simulated."""
    if not rig.is_simulated or rig.twin is None:
        return {}
    truth = {str(name): value for name, value in rig.twin.truth.get(sensor, {}).items()}.get(axis)
    described = rig.sensors.get(sensor)
    if truth is None or described is None or not _is_straight(described.mount):
        return {}
    warmer_degc = _reference_degc(truth, observations, calibration) - truth.reference_temperature_degc
    s1, s2 = truth.sensitivity_tc_per_degc, truth.sensitivity_tc2_per_degc2
    warming = 1.0 + s1 * warmer_degc + s2 * warmer_degc**2
    values = {
        "coning_deg": truth.coning_deg,
        "azimuth_deg": truth.azimuth_deg,
        **_towards_deg(truth, calibration.nominal_axis),
        "offset_tc_v_per_degc": truth.offset_tc_v_per_degc + 2.0 * truth.offset_tc2_v_per_degc2 * warmer_degc,
        "sensitivity_tc_per_degc": (s1 + 2.0 * s2 * warmer_degc) / warming,
        "offset_tc2_v_per_degc2": truth.offset_tc2_v_per_degc2,
        "sensitivity_tc2_per_degc2": s2 / warming,
        **dict.fromkeys(RATE_TERM_NAMES, 0.0),  # twins of gyros are straight
    }
    form = FIELDS.get(calibration.model)
    if form is not None and form.convention == "CR":
        values["azimuth_deg"] = wrap_deg(truth.azimuth_deg + QUARTER_TURN_DEG)
    if truth.offset_drift_v_per_replication == 0.0:
        warmed_v = truth.offset_tc_v_per_degc * warmer_degc + truth.offset_tc2_v_per_degc2 * warmer_degc**2
        values["offset_v"] = truth.offset_v + warmed_v
    if truth.sensitivity_drift_per_replication == 0.0:
        sense = -1.0 if form is not None and form.is_gravity else 1.0
        values["sensitivity_v_per_g"] = sense * truth.sensitivity_v_per_g * warming
        values["sensitivity_v_per_dps"] = truth.sensitivity_v_per_dps * warming
    return values | _best_linear(truth, values, calibration)


def _towards_deg(truth: AxisTruth, axis: str) -> dict[str, float]:
    """Return the angles by which the sensitive axis lies towards the two others."""
    lies = dict(
        zip(AXES, vector_from_angles(axis, 1.0, *np.radians([truth.coning_deg, truth.azimuth_deg])), strict=True)
    )
    return {
        f"towards_{other}_deg": float(np.rad2deg(np.arctan2(lies[other], lies[axis])))
        for other in AXES
        if other != axis
    }


def _best_linear(truth: AxisTruth, values: dict[str, float], calibration: AxisCalibration) -> dict[str, float]:
    """Return what of the truth a sensor without terms of second order comes closest to, over the points of the run."""
    is_bent = calibration.model == ExtendedPitchRoll.name and bool(calibration.centring)
    if not is_bent or not {"offset_v", "sensitivity_v_per_g"} <= values.keys():
        return {}
    q = np.array(truth.q_v_per_g2 or np.zeros(len(Q_NAMES)))
    taken = q @ np.array(calibration.centring)[: len(Q_NAMES)]
    angles_rad = np.radians([values["coning_deg"], values["azimuth_deg"]])
    k = vector_from_angles(calibration.nominal_axis, values["sensitivity_v_per_g"], *angles_rad)
    linear = np.concatenate([[values["offset_v"]], k]) + taken
    model = PitchRoll(calibration.nominal_axis)
    return {
        **dict(zip(model.parameter_names, model.parameters(linear).tolist(), strict=True)),
        **dict(zip(Q_NAMES, q.tolist(), strict=True)),
        **({CUBIC_NAME: 0.0} if len(calibration.centring) > len(Q_NAMES) else {}),
        TRACELESS_NAME: values["offset_v"],
    }


def _is_straight(mount: Mount) -> bool:
    return (mount.x, mount.y, mount.z) == ("+x", "+y", "+z")


def _reference_degc(truth: AxisTruth, observations: Observations, calibration: AxisCalibration) -> float:
    """Return where the solution's offset and sensitivity hold: its own reference, or the mean of what was measured."""
    for parameter in calibration.parameters:
        if parameter.name == "reference_temperature_degc" and parameter.value is not None:
            return parameter.value
    if observations.temperature_degc is not None and observations.rows:
        return float(np.mean(observations.temperature_degc))
    return truth.reference_temperature_degc
