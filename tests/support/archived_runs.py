"""Runs for an archive: one sensor on a small grid, with a day, a gain and standards of one's choice."""

from dataclasses import replace
from datetime import UTC, date, datetime, timedelta
from functools import cache

import numpy as np
from package_outputs import TRUTH, output_v

from ams.archive.runs import MeasuredSensor, RunEntry
from ams.calibration.calibrate import calibrate
from ams.findings import Finding
from ams.inputs.declared_direction import DeclaredDirection, NominalSensitivity
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.sets.provenance import Provenance, Standard

GRID_DEG = [(p, r) for p in range(-60, 61, 30) for r in range(-180, 180, 90)]
_PITCH, _ROLL = np.deg2rad(np.array(GRID_DEG, dtype=float)).T
_CLEAN = {axis: np.array([output_v(axis, TRUTH[axis], p, r) for p, r in GRID_DEG]) for axis in TRUTH}
IN_TIME, EXPIRED = date(2027, 6, 30), date(2025, 12, 31)
TABLE = Standard("table", "AA-2216", "26-0117", IN_TIME, {"uncertainty_arcsec": 1.0, "kind": "limit", "k": 2})
DECLARED = {
    axis: DeclaredDirection(axis, 1, polarity, NominalSensitivity(2.5))
    for axis, polarity in (("x", 1), ("y", 1), ("z", -1))
}
STARTED = datetime(2026, 1, 10, 18, 0, tzinfo=UTC)


def a_run(day: int = 0, *, simulated: bool = False, version: str = "0.1.0") -> RunEntry:
    """The run of a day; the same day is the same run."""
    started = STARTED + timedelta(days=day)
    return RunEntry(
        f"{day:064x}", f"run-{day}", "small grid", "bench", "J. Doe", simulated, started,
        started + timedelta(hours=9), f"/runs/run-{day}", version,
    )  # fmt: skip


@cache
def a_sensor(
    day: int = 0,
    sensor: str = "SN1",
    *,
    gain: float = 1.0,
    due: date = IN_TIME,
    simulated: bool = False,
    version: str = "0.1.0",
    is_check: bool = False,
    standard: str = TABLE.serial,
    customer: str = "",
    read_times: float | None = None,
) -> MeasuredSensor:
    """A sensor as the run of that day measured it; ``gain`` is its x axis' against nominal.

    ``read_times``: its sensitivities are declared, and every output was read times this.
    """
    chance, count = np.random.default_rng(day), len(GRID_DEG)
    grown = {**_CLEAN, "x": gain * _CLEAN["x"]}
    outputs = {axis: np.tile(entry, 3) + 1e-6 * chance.normal(size=3 * count) for axis, entry in grown.items()}
    outputs = {axis: (read_times or 1.0) * output for axis, output in outputs.items()}
    request = CalibrationRequest(extended="no", declared=DECLARED if read_times is not None else {})
    rows = Observations(
        np.repeat([1, 2, 3], count), np.tile(np.arange(count), 3), np.tile(_PITCH, 3), np.tile(_ROLL, 3), outputs
    )
    run = a_run(day)
    provenance = Provenance(
        sensor=sensor, gravity_mps2=9.79826, gravity_source="survey", pitch_range_deg=(-60.0, 60.0),
        roll_range_deg=(-180.0, 180.0), created_utc=run.ended_utc, software_version=version, rig="bench",
        procedure="small grid", simulated=simulated, run_id=run.run_id, serial=sensor.removeprefix("SN"),
        journal_sha256=run.journal_sha256, standards=(replace(TABLE, due=due, serial=standard),),
        acceptance={"pitch_limit_deg": 0.02, "decision_rule": "guard-band"},
        job={"customer": customer} if customer else None,
    )  # fmt: skip
    return MeasuredSensor(build_set(calibrate(rows, request), provenance), rows, is_check)


TURNED = Finding(
    "table-rotation", "all three sensors turned by −72″ about roll between visits 2 and 3: the table", True, 1e-9,
    details={"turned_arcsec": 72.0, "confounded_with": None},
)  # fmt: skip


def turned(measured: MeasuredSensor, finding: Finding = TURNED) -> MeasuredSensor:
    """Return what a run measured whose table turned."""
    return replace(measured, findings=(finding,))
