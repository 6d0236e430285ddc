"""What the studies count is what a run tells: the same dwells have the same findings, by ``solve_sensors`` and there.

The studies and the count of false alarms give campaigns to :func:`ams.calibration.packages.calibrate_packages`,
as ``calrig fit`` does; a run solves its dwells by what its procedure says of each sensor. Here the campaigns are made
into the dwells of a run, and both are asked.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from many_packages import PROCEDURE, rig_text, serial
from physics_scenes import Campaign, campaigns
from solved_campaigns import rows_of_package

from ams.calibration.packages import calibrate_packages
from ams.calibration_result import Calibration
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.kinds.solve import solve_sensors
from procedures.plan.plan import Plan
from procedures.records.dwells import ChannelReading, DwellRecord
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

DWELL_S = 10.0
BEGAN = datetime(2026, 3, 1, 8, 0, tzinfo=UTC)
SMALL = {"pitch_count": 7, "roll_count": 6, "replications": 4}
ESTIMATED = '[solve]\ntemperature = "estimate"\n[check]'
CASES = (
    ("clean", 0.0, 3),
    ("wrong-dwell", 10.0, 2),
    ("wrong-tooth", 1.0, 2),
    ("slip-roll", 5.0, 2),
    ("swapped-channel", 5.0, 1),
    ("k2", 3.0, 2),  # near the limit of what is told: another level would tell otherwise
    ("k2", 8.0, 2),
    ("drift-replications", 1.0, 2),
    ("drift-step", 5.0, 2),
    ("temperature-in-step", 0.5, 1),
)
"""Scene, size, and of how many campaigns; each of one, of two and of three packages."""


def _files(folder: Path, packages: int, procedure: str = PROCEDURE) -> tuple[RigDescription, Plan]:
    (folder / "rig.toml").write_text(rig_text(packages), encoding="utf-8")
    (folder / "procedure.toml").write_text(procedure, encoding="utf-8")
    rig = read_rig(folder / "rig.toml")
    return rig, make_plan(rig, read_procedure(folder / "procedure.toml"))


def _dwells(packages: Mapping[str, Observations]) -> Iterator[DwellRecord]:
    """Yield the dwells of a run in which all packages were read at the same rows."""
    first = next(iter(packages.values()))
    assert first.time_s is not None
    assert first.temperature_degc is not None
    for step, row in enumerate(np.argsort(first.time_s).tolist(), start=1):
        angles_deg = {"pitch": float(np.rad2deg(first.pitch_rad[row])), "roll": float(np.rad2deg(first.roll_rad[row]))}
        started_s, ended_s = (float(first.time_s[row]) + part * DWELL_S for part in (-0.5, 0.5))
        readings = {
            f"daq.{name.lower()}{axis}": np.array([values[row]])
            for name, rows in packages.items()
            for axis, values in rows.outputs.items()
        }
        yield DwellRecord(
            step=step,
            purpose="design",
            replication=int(first.replication[row]),
            point=int(first.point[row]),
            attempt=1,
            epoch=1,
            accepted=True,
            reasons=(),
            targets_deg=angles_deg,
            measured_deg=angles_deg,
            temperature_degc={"air": float(first.temperature_degc[row])},
            readings={name: ChannelReading(name, value, started_s, 1.0) for name, value in readings.items()},
            started_utc=BEGAN + timedelta(seconds=started_s),
            ended_utc=BEGAN + timedelta(seconds=ended_s),
            started_s=started_s,
            ended_s=ended_s,
            settle_s=1.0,
            sha256="",
        )


def _told(calibration: Calibration) -> dict[tuple[str, str, str], tuple[bool, bool, float | None]]:
    """Return by axis, kind and test what is said of the dwells; of what the files do not declare there is no test."""
    found = {}
    for axis, solved in calibration.axes.items():
        for finding in (said for said in solved.findings if "undeclared" not in said.kind):
            key = (axis, finding.kind, str(finding.details.get("test")))
            assert key not in found, key
            found[key] = (finding.is_significant, finding.is_held, finding.p_value)
    return found


def _as_run(packages: Mapping[str, Observations], rig: RigDescription, plan: Plan) -> Mapping[str, Calibration]:
    solved = solve_sensors(tuple(_dwells(packages)), rig, plan, "run")
    assert all(sensor.calibration is not None for sensor in solved.values()), solved
    return {name: sensor.calibration for name, sensor in solved.items() if sensor.calibration is not None}


def _require_the_same(solved: Mapping[str, Calibration], studied: Mapping[str, Calibration]) -> set[str]:
    """Return the kinds of what both tell as significant."""
    kinds = set()
    for name, calibration in solved.items():
        ours, theirs = _told(calibration), _told(studied[name])
        assert {key: said[:2] for key, said in ours.items()} == {key: said[:2] for key, said in theirs.items()}
        chances = [{key: said[2] for key, said in told.items() if said[2] is not None} for told in (ours, theirs)]
        assert chances[0] == pytest.approx(chances[1], rel=1e-5, abs=1e-300)  # scatter is iterated
        kinds |= {kind for (_, kind, _), (is_significant, *_) in ours.items() if is_significant}
    return kinds


@pytest.mark.parametrize("packages", [1, 2, 3])
def test_a_run_tells_what_the_studies_count(tmp_path: Path, packages: int) -> None:
    rig, plan = _files(tmp_path, packages)
    request = CalibrationRequest(tested_axes=3 * packages)
    kinds = set[str]()
    for scene, size, count in CASES:
        drawn = campaigns(scene, size, np.random.default_rng(4), count, sensors=packages, **SMALL)
        for index in range(count):
            read = _packages(drawn, index)
            kinds |= _require_the_same(_as_run(read, rig, plan), calibrate_packages(read, request))
    assert {"wrong-dwell", "table-rotation", "quadratic", "drift", "temperature-residual"} <= kinds


def test_a_run_over_temperature_tells_what_the_studies_count(tmp_path: Path) -> None:
    rig, plan = _files(
        tmp_path, 1, PROCEDURE.replace("[check]", ESTIMATED).replace("[20.0]", "[10.0, 20.0, 30.0, 20.0]")
    )
    request = CalibrationRequest(temperature="estimate")
    kinds = set[str]()
    for scene, size in (("temperature-curvature", 1.0), ("temperature-lag", 0.3), ("temperature-curvature", 0.0)):
        drawn = campaigns(scene, size, np.random.default_rng(3), 2)
        for index in range(2):
            read = _packages(drawn, index)
            kinds |= _require_the_same(_as_run(read, rig, plan), calibrate_packages(read, request))
    assert {"temperature-curvature", "temperature-lag"} <= kinds


def _packages(drawn: Campaign, index: int) -> dict[str, Observations]:
    every = range(drawn.setup.sensors)
    rows = {serial(sensor + 1): rows_of_package(drawn, index, sensor) for sensor in every}
    return {name: replace(each, source=name) for name, each in rows.items()}
