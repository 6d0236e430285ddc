"""A slip of any of a gimbal's three axes in mid-run: told by the next reference visit or dwell, the table named."""

from pathlib import Path

import pytest
from small_run import Bench
from turned_table import TWO, common_mode_events, several_sensors, slips
from unattended_run import UnattendedRun, asks, events, run_unattended

from procedures.delivery.deliver import solve_run
from procedures.records.states import State

YAW_AXIS = (
    "[readouts.dmm]",
    '[axes.yaw]\ndriver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\nlimits_deg = [-90.0, 90.0]\n'
    "speed_dps = 180.0\naxis = 3\n[readouts.dmm]",
)
YAWED = (
    ("roll_deg = {", "yaw_deg = [-30.0, 0.0, 30.0]\nroll_deg = {"),
    ("[check]", '[solve]\nmodel = "pitch-yaw-roll"\n[check]'),
)


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return several_sensors(tmp_path_factory.mktemp("three"), 3, (*TWO, *YAWED), (YAW_AXIS,))


@pytest.mark.parametrize(("axis", "by_deg"), [("roll", -0.02), ("pitch", 0.02), ("yaw", 0.02)])
def test_a_slip_of_an_axis_of_a_gimbal_is_held_at_the_next_reference_visit(
    three: Bench, tmp_path: Path, axis: str, by_deg: float
) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={13: slips(axis, by_deg)})
    assert run_unattended(three, unattended).state is State.STOPPED
    held = [event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held"]
    assert [event.detail["cause"] for event in held] == ["table"]
    reason = str(held[0].detail["reason"])
    assert reason.startswith("all three sensors turned by " + ("−7" if by_deg < 0 else "+7"))
    assert f"about {axis} between visits" in reason
    assert "the table, its base or the common fixture, not the sensors" in reason
    ((kinds, is_held, _),) = common_mode_events(unattended.run_dir)
    assert (kinds, is_held) == (["table-rotation"], True)


REPLICATED = {1: TWO[-1], 2: ("replications = 2", "replications = 2")}
ON_STING = "[sensors.SN{number}]\n", '[sensors.SN{number}]\nstage = ["pitch", "yaw"]\n'


def _with_stings(folder: Path, count: int, *numbers: int, replications: int = 1) -> Bench:
    """Packages of which some stand on the sting, which roll does not reach."""
    on_sting = tuple(
        (before.format(number=at), after.format(number=at)) for at in numbers for before, after in [ON_STING]
    )
    return several_sensors(folder, count, (*TWO[:-1], REPLICATED[replications], *YAWED), (YAW_AXIS, *on_sting))


@pytest.mark.parametrize(
    ("axis", "who"), [("pitch", "all three sensors"), ("yaw", "all three sensors"), ("roll", "two of three sensors")]
)
def test_beside_a_package_on_a_sting_a_slip_is_held_and_roll_is_none_of_its(
    tmp_path: Path, axis: str, who: str
) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={13: slips(axis, 0.02)})
    assert run_unattended(_with_stings(tmp_path, 3, 2), unattended).state is State.STOPPED
    (held,) = [event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held"]
    reason = str(held.detail["reason"])
    assert reason.startswith(f"{who} turned by +7")
    assert f"about {axis} between visits" in reason


@pytest.mark.parametrize("axis", ["pitch", "yaw", "roll"])
def test_of_packages_on_a_sting_alone_a_slip_of_what_carries_them_is_held(tmp_path: Path, axis: str) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={13: slips(axis, 0.02)})
    run_unattended(_with_stings(tmp_path, 2, 1, 2), unattended)
    held = [event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held"]
    if axis == "roll":
        assert not held
        assert not common_mode_events(unattended.run_dir)
        return
    assert str(held[0].detail["reason"]).startswith("both sensors turned by +7")
    assert f"about {axis} between visits" in str(held[0].detail["reason"])


def test_a_gimbal_that_stands_still_is_never_held(three: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(three, unattended).state is State.FINISHED
    assert not common_mode_events(unattended.run_dir)


@pytest.mark.parametrize("axis", ["pitch", "roll", "yaw"])
def test_an_axis_of_a_gimbal_on_a_wrong_tooth_is_told_by_the_dwells_before(
    three: Bench, tmp_path: Path, axis: str
) -> None:
    unattended = UnattendedRun(tmp_path / "run", after={22: slips(axis, 1.0)})
    assert run_unattended(three, unattended).state is State.TRIPPED
    reasons = [str(event.detail["reason"]) for event in events(unattended.run_dir, "state")]
    assert any(f"{axis}: every sensor reads as if it stood +1° from its own read-back" in reason for reason in reasons)


@pytest.mark.parametrize("replications", [1, 2])
@pytest.mark.parametrize("axis", ["roll", "yaw"])
def test_the_result_of_a_package_on_a_sting_rests_on_what_turned_it_and_not_on_roll(
    tmp_path: Path, axis: str, replications: int
) -> None:
    """Somebody keeps all dwells: what rolls is a mixture of both sides, what stands on the sting of a slip of yaw."""
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("continue")}, after={13: slips(axis, 0.02)})
    job = _with_stings(tmp_path, 3, 2, replications=replications)
    assert run_unattended(job, unattended).state is State.FINISHED
    solved = solve_run(unattended.run_dir)
    told = {
        name: {
            finding.kind
            for of_axis in sensor.calibration.axes.values()
            for finding in of_axis.findings
            if finding.is_significant and not finding.is_held
        }
        for name, sensor in solved.sensors.items()
        if sensor.calibration is not None
    }
    assert told.keys() == {"SN1", "SN2", "SN3"}
    assert "table-rotation" in told["SN1"] & told["SN3"]
    assert ("table-rotation" in told["SN2"]) == (axis == "yaw")
    assert "sensor-change" not in told["SN2"]
