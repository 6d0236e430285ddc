"""What visits prove of table or meter over all sensors blames no sensor beside them, in the shortest of runs.

Twelve attitudes, twice: twelve degrees of freedom are left to tell what differs between the replications, too few for
a package to look for changes by itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from faulty_rig import FaultyRig
from turned_table import TWO, several_sensors, slips
from unattended_run import UnattendedRun, asks, run_unattended

from ams.arrays import FloatArray
from ams.findings import HOLDING_ARCSEC
from procedures.delivery.deliver import solve_run
from procedures.kinds.solve import solve_record
from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from procedures.report.assemble import assemble_view
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from rig.abilities.abilities import Burst


@pytest.mark.parametrize(("axis", "by_deg", "after"), [("pitch", 0.02, 16), ("roll", 0.005, 13)])
def test_no_sensor_is_blamed_for_a_slip_that_the_visits_prove(
    tmp_path: Path, axis: str, by_deg: float, after: int
) -> None:
    bench = several_sensors(tmp_path, 3, procedure=TWO[:1])
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("continue")}, after={after: slips(axis, by_deg)})
    assert run_unattended(bench, unattended).state is State.FINISHED
    for name, sensor in solve_run(unattended.run_dir).sensors.items():
        assert sensor.calibration is not None
        assert sensor.calibration.verdict == "not usable"
        for label, solved_axis in sensor.calibration.axes.items():
            significant = [finding for finding in solved_axis.findings if finding.is_significant]
            assert [finding.kind for finding in significant] == ["table-rotation"], (name, label, significant)
            assert f"about {axis} between visits" in significant[0].text


@pytest.mark.parametrize(("channels", "by"), [(9 * 12, 1.0005), (9 * 12 + 4, 0.9998)])
def test_neither_sensors_nor_table_are_blamed_for_a_gain_of_the_meter_that_the_visits_prove(
    tmp_path: Path, channels: int, by: float
) -> None:
    """From one channel on, in the middle of a dwell as well: six check dwells, six of the design and a visit before."""

    def turned_up(number: int, burst: Burst) -> Burst:
        return replace(burst, samples=burst.samples * by) if number >= channels else burst

    bench = several_sensors(tmp_path, 3, procedure=TWO[:1])
    unattended = UnattendedRun(tmp_path / "run")
    state = run_unattended(bench, unattended, rig_of=lambda rig: FaultyRig(rig, spoil=turned_up)).state
    assert state is State.FINISHED
    for name, sensor in solve_run(unattended.run_dir).sensors.items():
        assert sensor.calibration is not None
        for label, solved_axis in sensor.calibration.axes.items():
            significant = [finding for finding in solved_axis.findings if finding.is_significant]
            assert {finding.kind for finding in significant} == {"meter-gain"}, (name, label, significant)
            assert "the meter (gain of dmm)" in significant[0].text


SIZES_ARCSEC = (2.0, 2.5, 3.0, 3.5, 4.3, 9.0)
PLAIN_ARCSEC = 3.0
"""Of so few dwells a smaller one is not always told; what is told is told so."""
MANY = (
    *TWO[:1],
    ("replications = 2", "replications = 6"),
    ("from = -30.0, to = 30.0, step = 30.0", "from = -60.0, to = 60.0, step = 60.0"),
)
"""To ±60°, where half of a slip of roll is left and all of a tilt of the base: at ±30° they are nearly one."""


def turn_about(axis: str, angle_rad: float) -> FloatArray:
    """The rotation of the package by one axis of the table: roll about its x, pitch about its y."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    of = {"roll": [[1, 0, 0], [0, c, -s], [0, s, c]], "pitch": [[c, 0, s], [0, 1, 0], [-s, 0, c]]}
    return np.array(of[axis])


def force_g(pitch_rad: float, roll_rad: float) -> FloatArray:
    down_g = np.array([0.0, 0.0, -1.0])
    return np.asarray(turn_about("roll", roll_rad).T @ turn_about("pitch", pitch_rad).T @ down_g)


@dataclass(frozen=True)
class Quiet:
    """A run of three packages in which nothing turned, and what each channel reads per g, by its own solution."""

    record: RunRecord
    k_v_per_g: Mapping[str, FloatArray]

    @property
    def in_time(self) -> list[DwellRecord]:
        return sorted(self.record.dwells, key=lambda dwell: (dwell.epoch, dwell.started_s))

    def solved(self, axis: str, arcsec: float, first: int) -> tuple[dict[str, SolvedSensor], str]:
        """Solve it with a table that slipped before the dwell ``first`` in time; sensors, and the trust in the run."""
        dwells = self.in_time
        slipped = [self.slipped(dwell, axis, np.deg2rad(arcsec / 3600.0)) for dwell in dwells[first:]]
        record = replace(self.record, dwells=(*dwells[:first], *slipped))
        sensors = solve_record(record)
        return sensors, assemble_view(record, sensors).verdict.trust

    def slipped(self, dwell: DwellRecord, axis: str, slip_rad: float) -> DwellRecord:
        at = {name: float(np.deg2rad(dwell.targets_deg[name])) for name in ("pitch", "roll")}
        by_g = force_g(**{f"{name}_rad": angle + slip_rad * (name == axis) for name, angle in at.items()}) - force_g(
            at["pitch"], at["roll"]
        )
        readings = {
            channel: replace(reading, samples=reading.samples + float(self.k_v_per_g[channel] @ by_g))
            for channel, reading in dwell.readings.items()
        }
        return replace(dwell, readings=readings)

    def moments(self) -> dict[str, int]:
        """The dwell before which it slips: in the middle between two visits, right before one, and in its middle."""
        purposes = [dwell.purpose for dwell in self.in_time]
        begins = [at for at in range(1, len(purposes)) if purposes[at] == "reference" and purposes[at - 1] == "design"]
        visit = begins[len(begins) // 3]
        return {"between": visit - 1, "at": visit, "across": visit + 1}


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> Quiet:
    folder = tmp_path_factory.mktemp("quiet")
    unattended = UnattendedRun(folder / "run")
    small = several_sensors(folder, 3, procedure=MANY)
    assert run_unattended(small, unattended).state is State.FINISHED
    solved = solve_run(unattended.run_dir)
    k_v_per_g = {
        channel: np.array(sensor.calibration.axes[axis].sensitive_axis_v_per_g)
        for name, sensor in solved.sensors.items()
        if sensor.calibration is not None
        for axis, channel in solved.record.plan.sensors[name].channels.items()
    }
    return Quiet(solved.record, k_v_per_g)


@pytest.mark.parametrize(
    ("axis", "moment"),
    [
        ("roll", "at"),
        ("pitch", "between"),
        *(
            pytest.param(axis, moment, marks=pytest.mark.thorough)
            for axis, moment in (("roll", "between"), ("roll", "across"), ("pitch", "at"), ("pitch", "across"))
        ),
    ],
)
def test_a_larger_slip_never_has_a_better_verdict_whatever_the_visits_made_of_it(
    quiet: Quiet, axis: str, moment: str
) -> None:
    """What the few dwells of a visit told, in form and size, displaced what the dwells of the design tell better."""
    ranks, order = [], ("sound", "reserved", "unusable")
    for size in SIZES_ARCSEC:
        sensors, trust = quiet.solved(axis, size, quiet.moments()[moment])
        ranks.append(order.index(trust))
        for sensor in sensors.values():
            assert sensor.calibration is not None
            told = sensor.calibration.axes["z"].findings
            turns = [
                found
                for found in told
                if found.kind == "table-rotation"
                and found.is_significant
                and "little by little" not in found.text
                and not (found.is_held and found.details["confounded_with"])
            ]
            if size < PLAIN_ARCSEC and sensor.calibration.verdict != "not usable":
                continue
            assert sensor.calibration.verdict == "not usable", (size, [found.text for found in told])
            assert len(turns) == 1, "one change is told once"
            details = turns[0].details
            off, u = (float(details[f"{axis}_{key}arcsec"] or 0.0) for key in ("", "standard_uncertainty_"))
            assert abs(off - size) <= 4.0 * u, turns[0].text
            assert u < 0.3, "as forty dwells on either side know it, and not as two visits do"
            assert bool(sensor.calibration.turns) == (float(details["turned_arcsec"] or 0.0) > HOLDING_ARCSEC)
    assert ranks == sorted(ranks)
    assert ranks[-1] == order.index("unusable")


def test_a_run_in_which_nothing_turned_says_nothing_of_the_table(quiet: Quiet) -> None:
    sensors, trust = quiet.solved("roll", 0.0, 1)
    assert trust in ("sound", "reserved")
    for sensor in sensors.values():
        assert sensor.calibration is not None
        assert not any(found.is_significant for axis in sensor.calibration.axes.values() for found in axis.findings), (
            sensor.calibration.warnings
        )
