"""A run made of numbers alone, for tests of the report: no journal, no rig, and a solution by plain least squares.

The solution here is the pooled one, by numpy; what the report draws from it is what is tested, not the solver.
"""

from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

import numpy as np

from ams.calibration_result import AxisCalibration, FTest, ParameterEstimate, Replication, TpReplication
from ams.findings import Finding, significant_texts
from ams.gravity import Gravity
from ams.observations import Observations
from procedures.journal.audit.audit_trail import Interruption, Note  # fmt: skip
from procedures.report.conclusions import axis_view
from procedures.report.sections.equipment import Device, Equipment, StandardRow
from procedures.report.sections.provenance import Provenance
from procedures.report.sections.rejected import NotBelieved, RejectedDwell
from procedures.report.sections.run import check_rows
from procedures.report.verdict import judge
from procedures.report.view import (  # fmt: skip
    AxisFindings,
    CheckComparison,
    Counts,
    DesignView,
    ReferenceTrace,
    RunView,
    SensorView,
    TemperatureTrace,
)

GRAVITY = Gravity(9.79826, 2e-6, "survey 2024")
START = datetime(2026, 3, 1, 18, 0, tzinfo=UTC)
ARCSEC = np.deg2rad(1.0 / 3600.0)
SECONDS_PER_DWELL = 30.0
K = {"x": (2.5, 0.0, 0.0179, 0.0125), "y": (2.48, 1, 0.0122, -0.0044), "z": (2.52, 2, -0.0165, 0.006)}
EQUIPMENT = Equipment(
    (
        Device("axes.pitch", "indexing-table", "TWIN,INDEXING TABLE,0,1.0", "table"),
        Device("axes.roll", "indexing-table", "TWIN,INDEXING TABLE,0,1.0", "table"),
        Device("readouts.dmm", "hp3458a", "HP3458A", ""),
    ),
    (StandardRow("table", "AA-2216", "26-0117", "2027-06-30", "±1 ″ (limit)"),),
    {"laboratory": {"name": "Example", "address": "1 Granite Way"}},
)
PROVENANCE = Provenance({"journal content": "ab" * 32, "plan": "cd" * 32}, {"calrig": "0.1.0", "numpy": "2.4.0"})


@dataclass(frozen=True)
class Scene:
    """What is to be seen; the defaults are a small clean run."""

    pitch_deg: tuple[float, ...] = tuple(range(-90, 91, 30))
    roll_deg: tuple[float, ...] = tuple(range(-180, 181, 60))
    points: tuple[tuple[float, float], ...] = ()
    """(pitch, roll) in degrees, instead of the grid."""
    replications: int = 3
    sensors: tuple[str, ...] = ("SN1047",)
    axes: tuple[str, ...] = ("x", "y", "z")
    noise_arcsec: float = 0.5
    tooth_arcsec: float = 0.0
    offset_drift_v: float = 0.0
    null_azimuth: bool = False
    simulated: bool = True
    interruptions: int = 0
    rejected: int = 0
    state: str = "finished"
    note: str = ""
    table_explains: bool = False
    """What repeats is no more than the table's index errors."""
    seed: int = 7


def run_view(scene: Scene) -> RunView:
    """The scene as the view that a journal would give."""
    chance = np.random.default_rng(scene.seed)
    sensors = tuple(_sensor(scene, name, index, chance) for index, name in enumerate(scene.sensors, start=1))
    observations = sensors[0].observations
    assert observations is not None
    assert observations.time_s is not None
    first = observations.replication == 1
    interruptions = tuple(_interruption(index) for index in range(scene.interruptions))
    rows = observations.rows
    counts = Counts(rows + 6, rows + 6, scene.rejected, scene.rejected, rows, rows)
    hours = observations.time_s / 3600.0
    checks = _checks(scene, sensors[0])
    return RunView(
        title="three-axis, ±90°, replicated", run_id="20260301T180000Z-three-axis", state=scene.state,
        operator="A. Operator", rig="accelerometer laboratory, dual-axis table", gravity=GRAVITY,
        is_simulated=scene.simulated, approved_by=None,
        began_utc=START - timedelta(hours=1),
        started_utc=START, ended_utc=START + timedelta(seconds=SECONDS_PER_DWELL * rows),
        verdict=judge(scene.state, counts, sensors, interruptions, (), 0.8 if scene.tooth_arcsec < 1.5 else 0.2),
        design=DesignView(
            "D1", "there-and-back", scene.replications, observations.point[first],
            np.rad2deg(observations.pitch_rad[first]), np.rad2deg(observations.roll_rad[first]),
        ),
        counts=counts, sensors=sensors, interruptions=interruptions,
        notes=(Note(START, "A. Operator", scene.note),) if scene.note else (),
        temperature=(TemperatureTrace("air", hours, 20.0 + 0.1 * np.sin(hours) + 0.01 * chance.normal(size=rows)),),
        reference=tuple(
            ReferenceTrace(f"SN1047 {axis}", hours[::25], 1e-6 * chance.normal(size=hours[::25].size), 2.5)
            for axis in scene.axes
        ),
        checks=checks,
        of_sections={
            "run": check_rows(checks),
            "rejected": NotBelieved(tuple(_rejected(index) for index in range(scene.rejected)), ()),
            "equipment": EQUIPMENT,
            "provenance": PROVENANCE,
        },
    )  # fmt: skip


def _sensor(scene: Scene, name: str, index: int, chance: np.random.Generator) -> SensorView:
    observations = _observations(scene, chance)
    axes = tuple(
        axis_view(axis, f"dmm.{axis}", _solved(scene, axis, observations), observations, _truth(scene, axis))
        for axis in scene.axes
    )
    return SensorView(
        name,
        "three-axis package",
        "x +x, y +y, z +z",
        False,
        observations,
        axes,
        (),
        None,
        index,
        findings=tuple(AxisFindings(axis.axis, axis.channel, axis.calibration.findings) for axis in axes),
        verdict="usable" if any(axis.calibration.warnings for axis in axes) else "sound",
    )


def _vector(scene: Scene, axis: str) -> np.ndarray:
    s, *_ = K[axis]
    index = "xyz".index(axis)
    k = np.zeros(3)
    k[index], k[(index + 1) % 3], k[(index + 2) % 3] = (s, 0, 0) if scene.null_azimuth else (s, 0.0179, 0.0125)
    return k


def _truth(scene: Scene, axis: str) -> dict[str, float]:
    k, index = _vector(scene, axis), "xyz".index(axis)
    across = np.hypot(k[(index + 1) % 3], k[(index + 2) % 3])
    return {
        "offset_v": 0.005, "sensitivity_v_per_g": float(np.linalg.norm(k)),
        "coning_deg": float(np.rad2deg(np.arctan2(across, k[index]))),
        "azimuth_deg": float(np.rad2deg(np.arctan2(k[(index + 2) % 3], k[(index + 1) % 3]))),
    } if scene.simulated else {}  # fmt: skip


def _force(pitch: np.ndarray, roll: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=1)


def _observations(scene: Scene, chance: np.random.Generator) -> Observations:
    rows = [*scene.pitch_deg[::2], *scene.pitch_deg[1::2][::-1]]
    grid = [(p, r) for n, p in enumerate(rows) for r in scene.roll_deg[:: 1 if n % 2 else -1]]
    entry = np.array(scene.points or grid, dtype=float)
    pitch, roll = np.deg2rad(np.tile(entry, (scene.replications, 1))).T
    replication = np.repeat(np.arange(1, scene.replications + 1), len(entry))
    point = np.tile(np.arange(1, len(entry) + 1), scene.replications)
    tooth = scene.tooth_arcsec * ARCSEC * chance.normal(size=len(entry))[point - 1]
    outputs = {}
    for axis in scene.axes:
        k = _vector(scene, axis)
        noise = np.linalg.norm(k) * scene.noise_arcsec * ARCSEC * chance.normal(size=pitch.size)
        drift = scene.offset_drift_v * (replication - 1)
        outputs[axis] = 0.005 + _force(pitch, roll) @ k + np.linalg.norm(k) * tooth + noise + drift
    time_s = SECONDS_PER_DWELL * np.arange(pitch.size)
    return Observations(replication, point, pitch, roll, outputs, None, None, time_s)


def _solved(scene: Scene, axis: str, rows: Observations) -> AxisCalibration:
    phi = np.column_stack([np.ones(rows.rows), _force(rows.pitch_rad, rows.roll_rad)])
    y = rows.outputs[axis]
    primary = np.linalg.lstsq(phi, y, rcond=None)[0]
    residuals = y - phi @ primary
    dof = rows.rows - 4
    s = float(np.sqrt(residuals @ residuals / dof))
    covariance = s**2 * np.linalg.inv(phi.T @ phi)
    estimates = _parameters(scene, axis, primary, covariance, dof)
    findings = _findings(scene)
    return AxisCalibration(
        axis, "pitch-roll", axis, estimates, np.eye(4), ("offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g"),
        primary, covariance, covariance, np.full(4, float(dof)), s, dof, tuple(primary[1:]), phi @ primary, residuals,
        _replication(scene, axis, rows, phi, residuals) if scene.replications > 1 else None,
        (
            *(("azimuth not determined: the coning angle is within five standard uncertainties of zero",)
            if scene.null_azimuth else ()),
            *significant_texts(findings),
        ),
        findings=findings,
    )  # fmt: skip


def _findings(scene: Scene) -> tuple[Finding, ...]:
    repeats, drifts = bool(scene.tooth_arcsec) and not scene.table_explains, bool(scene.offset_drift_v)
    if scene.replications == 1:
        return ()
    return (
        Finding("wrong-dwell", "wrong dwell: not significant", False, 0.7, details={"test": "wrong dwell"}),
        Finding(
            "lack-of-fit", "the residuals repeat" if repeats else "lack of fit: not significant", repeats,
            1e-12 if repeats else 0.4, details={"test": "lack of fit", "size": 1e-6},
        ),
        Finding(
            "drift", "offset changed by 12″" if drifts else "drift of offset: not significant", drifts,
            1e-12 if drifts else 0.4, details={"test": "drift of offset"},
        ),
    )  # fmt: skip


def _derived(axis: str, primary: np.ndarray) -> dict[str, float]:
    index = 1 + "xyz".index(axis)
    j, m = 1 + index % 3, 1 + (index + 1) % 3
    across = float(np.hypot(primary[j], primary[m]))
    return {
        "offset_v": float(primary[0]), "sensitivity_v_per_g": float(np.linalg.norm(primary[1:])),
        "coning_deg": float(np.rad2deg(np.arctan2(across, primary[index]))),
        "azimuth_deg": float(np.rad2deg(np.arctan2(primary[m], primary[j]))),
    }  # fmt: skip


def _parameters(
    scene: Scene, axis: str, primary: np.ndarray, covariance: np.ndarray, dof: int
) -> tuple[ParameterEstimate, ...]:
    values = _derived(axis, primary)
    gradient = {name: np.array([_slope(axis, primary, name, at) for at in range(4)]) for name in values}
    estimates = []
    for name, value in values.items():
        u = float(np.sqrt(gradient[name] @ covariance @ gradient[name]))
        interval = (value - 1.965 * u, value + 1.965 * u)
        estimates.append(ParameterEstimate(name, value, u, 0.9 * u, float(dof), interval))
    if scene.null_azimuth:
        estimates[-2:] = [ParameterEstimate(n, None, None, None, None, None) for n in ("coning_deg", "azimuth_deg")]
    return tuple(estimates)


def _slope(axis: str, primary: np.ndarray, name: str, at: int) -> float:
    step = np.zeros(4)
    step[at] = 1e-7
    return (_derived(axis, primary + step)[name] - _derived(axis, primary - step)[name]) / 2e-7


def _replication(scene: Scene, axis: str, rows: Observations, phi: np.ndarray, residuals: np.ndarray) -> Replication:
    per = {}
    for label in range(1, scene.replications + 1):
        keep = rows.replication == label
        per[label] = _derived(axis, np.linalg.lstsq(phi[keep], rows.outputs[axis][keep], rcond=None)[0])
    mean = np.bincount(rows.point, residuals)[1:] / scene.replications
    lack_v = float(mean.std()) if scene.tooth_arcsec else 0.0
    precision_v = float((residuals - mean[rows.point - 1]).std())
    quiet = FTest(1.02, 1.18, 0.40, 243.0, 1215.0, False)
    loud = FTest(1.0 + scene.replications * (lack_v / precision_v) ** 2, 1.18, 1e-12, 243.0, 1215.0, True)
    drifting = dict.fromkeys(("offset", "sensitivity", "coning", "azimuth"), quiet)
    if scene.offset_drift_v:
        drifting["offset"] = replace(loud, t=19.2, f_95=2.22, numerator_dof=5.0)
    tp = TpReplication(1e-6, 6e-6, 1.0, 1.18, drifting)
    lack = loud if scene.tooth_arcsec else quiet
    if scene.table_explains:
        lack = replace(lack, p_value=0.4, is_significant=False)
    return Replication(scene.replications, mean.size, lack, drifting, tp, precision_v, lack_v, per)


def _interruption(index: int) -> Interruption:
    began = START + timedelta(minutes=20 * (index + 1))
    kinds = (("paused", "A. Operator", "lunch"), ("interrupted", "", "power cut"), ("stopped", "A. Operator", ""))
    what, by, reason = kinds[index % 3]
    return Interruption(what, began, began + timedelta(minutes=7, seconds=12), by, reason)


def _rejected(index: int) -> RejectedDwell:
    at = START + timedelta(minutes=3 * index)
    reason = "scatter 81 µV is 4.1 times the reference 20 µV, allowed 3 times"
    return RejectedDwell(at, 31 + index, "design", 1, 26 + index, 1, {"pitch": -30.0, "roll": 60.0}, (reason,))


def _checks(scene: Scene, sensor: SensorView) -> tuple[CheckComparison, ...]:
    if not scene.interruptions:
        return ()
    return tuple(
        CheckComparison(2, f"{sensor.name} {axis}", 6, 1.1e-6, -4.2e-6, "pitch 90°, roll 0°", 6e-6, 2.5)
        for axis in scene.axes
    )
