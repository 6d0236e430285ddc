"""Catalogue 4.4: measurement. Each entry of FAULTS 57 to 68 that is not tested beside the code that meets it."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from grumbling import Grumbling, SpoiltReadout
from night import Night, asks, events, spend, states
from plagued import two_packages
from small_run import Bench, bench, dwells_of, measured

from procedures.delivery import solve_run
from procedures.run.states import State
from rig.assembly import Rig
from rig.devices.abilities import Burst, Readout, Wait


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


class SwappedReadout(SpoiltReadout):
    """From the n-th dwell reading on, channels carry one another's sensors: a connector put in the wrong socket."""

    def __init__(self, readout: Readout, places: Mapping[str, str], from_reading: int, to_reading: int = 10**9) -> None:
        super().__init__(readout, lambda _number, burst: burst)
        self._places, self._from, self._to = places, from_reading, to_reading

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        is_wrong = self._from <= self.read_so_far <= self._to
        asked = self._places.get(channel, channel) if is_wrong else channel
        return replace(super().read(asked, samples, wait, nplc), channel=channel)


class Rewired(Grumbling):
    def __init__(self, rig: Rig, places: Mapping[str, str], from_reading: int, to_reading: int = 10**9) -> None:
        super().__init__(rig)
        self.meter = SwappedReadout(rig.readouts["dmm"], places, from_reading, to_reading)


@pytest.mark.parametrize(
    "places",
    [{"dmm.y": "dmm.z", "dmm.z": "dmm.y"}, {"dmm.x": "dmm.y", "dmm.y": "dmm.z", "dmm.z": "dmm.x"}],
    ids=["swapped", "off by one"],
)
def test_fault_60_channels_that_change_places_in_mid_run_trip_within_three_points(
    small: Bench, tmp_path: Path, places: dict[str, str]
) -> None:
    """Detected: the running fit of every axis: a channel reads what another should.
    Response: trip within three points; dwells at which it would not have shown are taken back.
    """
    night = Night(tmp_path / "run")
    outcome = spend(small, night, rig_of=lambda rig: Rewired(rig, places, 45))
    assert outcome.state is State.TRIPPED
    assert "reads what" in outcome.reason
    assert "channels changed places; look at scanner and wiring" in outcome.reason
    wrong = [dwell for dwell in dwells_of(night.run_dir) if dwell.purpose != "check"][9:]
    assert 1 <= len(wrong) <= 3
    assert not any(dwell.accepted for dwell in wrong)


def test_fault_60_after_the_wiring_is_put_right_the_numbers_are_those_of_the_clean_run(
    small: Bench, tmp_path: Path
) -> None:
    from procedures.run.resume import resume_on
    from rig.assembly import open_rig

    small.run(tmp_path / "clean")
    night = Night(tmp_path / "run")
    spend(small, night, rig_of=lambda rig: Rewired(rig, {"dmm.y": "dmm.z", "dmm.z": "dmm.y"}, 45))
    with open_rig(small.rig) as rig:
        assert resume_on(night.run_dir, rig, "carla", "connector put right").state is State.FINISHED
    again = {step: told for step, (*_, told) in measured(dwells_of(night.run_dir)).items()}
    assert again.keys() == measured(dwells_of(tmp_path / "clean")).keys()
    solved = solve_run(night.run_dir).sensors["SN1"]
    assert solved.failure is None


@pytest.mark.parametrize(("scatter_v", "ids"), [(0.0, "gone"), (0.3, "noise only")])
def test_fault_61_a_sensor_that_is_unplugged_is_dropped_and_the_others_go_on(
    tmp_path: Path, scatter_v: float, ids: str
) -> None:
    """Detected: its channels alone are why a dwell is rejected, by stuck, noise or the running fit.
    Response: the sensor is dropped after the retries and has no result; the others go on; an alert is sent.
    """
    small = two_packages(tmp_path)
    chance = np.random.default_rng(1)

    def unplugged(number: int, burst: Burst) -> Burst:
        if number < 70 or burst.channel not in ("dmm.u", "dmm.v"):
            return burst
        return replace(burst, values_v=scatter_v * chance.standard_normal(burst.values_v.size))

    night = Night(tmp_path / "run")
    outcome = spend(small, night, rig_of=lambda rig: Grumbling(rig, spoil=unplugged))
    assert outcome.state is State.FINISHED
    (dropped,) = events(night.run_dir, "dropped")
    assert dropped.detail["sensor"] == "SN2"
    assert any(one.event == "dropped" for one in night.told)
    solved = solve_run(night.run_dir).sensors
    assert solved["SN1"].failure is None
    assert "it was dropped while the run went on without it" in str(solved["SN2"].failure)
    bare = bench(tmp_path)
    bare.run(tmp_path / "clean")
    clean = solve_run(tmp_path / "clean").sensors["SN1"].calibration
    assert solved["SN1"].calibration is not None
    assert clean is not None
    for axis, found in solved["SN1"].calibration.axes.items():
        for one, other in zip(found.parameters, clean.axes[axis].parameters, strict=True):
            assert one.value == pytest.approx(other.value, abs=8.0 * float(other.standard_uncertainty or 0.0))


def test_fault_61_the_only_sensor_is_not_dropped_but_held(small: Bench, tmp_path: Path) -> None:
    def unplugged(number: int, burst: Burst) -> Burst:
        return replace(burst, values_v=np.zeros(burst.values_v.size)) if number >= 45 else burst

    night = Night(tmp_path / "run", at={100: asks("stop")})
    assert spend(small, night, rig_of=lambda rig: Grumbling(rig, spoil=unplugged)).state is State.STOPPED
    assert "held" in states(night.run_dir)
    assert not events(night.run_dir, "dropped")


@pytest.mark.parametrize("slip_deg", [1.0, -1.0, 10.0])
def test_fault_48_a_wrong_tooth_is_caught_by_the_running_fit_alone(
    small: Bench, tmp_path: Path, slip_deg: float
) -> None:
    """Detected: the running fit: every sensor reads as if the axis stood elsewhere than its read-back says.
    Response: the dwell is rejected, those in doubt are taken back; home, check set; a slip that stays trips (seam).
    """
    from rig.twins.world import World

    def slip(night: Night) -> None:
        chance = night.rig.chance
        assert isinstance(chance, World)
        chance.slip("pitch", slip_deg, night.rig.clock.monotonic_s(), seen=False)

    night = Night(tmp_path / "run", after={8: slip})
    outcome = spend(small, night)
    reasons = [str(event.detail["reason"]) for event in events(night.run_dir, "state")]
    assert any(f"pitch: every sensor reads as if it stood {slip_deg:+g} deg" in reason for reason in reasons)
    assert outcome.state is State.TRIPPED
    assert "the restart made a step" in outcome.reason
    accepted = [dwell for dwell in dwells_of(night.run_dir) if dwell.accepted and dwell.purpose == "design"]
    assert len(accepted) <= 8
