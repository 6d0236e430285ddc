"""Bands with hysteresis and delay, alone and in a run; disk, lines and clocks."""

from collections.abc import Callable
from pathlib import Path

import pytest
from faulty_rig import FaultyRig, noisier
from resumed import resume_on
from small_run import Bench, bench, dwells_of, measured
from unattended_run import RigWithBadLine, UnattendedRun, asks, events, run_unattended, states

from procedures.errors import ExitStatus, RequestError
from procedures.journal.status.status import status
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.judgement.interlocks import Interlock, Watched, look_at
from procedures.run.judgement.run_limits import run_limits_of
from procedures.run.services import RunServices
from procedures.run.watch.disk_space import MB, needed_bytes
from rig.abilities.abilities import Burst
from rig.assembly.open_rig import open_rig
from rig.clock import VirtualClock
from rig.errors import DescriptionError
from rig.twins.physics.world import World

AIR = Interlock("environment.air", "°C", 19.0, 21.0, 0.2, 60.0, "hold", "rig file: interlocks.temperature.air")
CHECKS = "[check]"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


def _seen(values: list[tuple[float, float]]) -> Watched:
    watched = Watched()
    for now_s, value in values:
        watched = look_at(AIR, watched, value, now_s)
    return watched


def test_a_value_alarms_only_after_its_delay_outside() -> None:
    assert not _seen([(0.0, 20.0), (10.0, 21.5), (69.0, 21.5)]).is_alarmed
    alarmed = _seen([(0.0, 20.0), (10.0, 21.5), (70.0, 21.5)])
    assert alarmed.is_alarmed
    assert alarmed.kept_until_s == 0.0


def test_an_alarm_ends_only_inside_by_the_hysteresis_and_for_the_delay() -> None:
    alarm = [(0.0, 20.0), (10.0, 21.5), (70.0, 21.5)]
    assert _seen([*alarm, (80.0, 20.9), (200.0, 20.9)]).is_alarmed
    assert _seen([*alarm, (80.0, 20.7), (139.0, 20.7)]).is_alarmed
    assert not _seen([*alarm, (80.0, 20.7), (140.0, 20.7)]).is_alarmed
    assert _seen([*alarm, (80.0, 20.7), (100.0, 20.9), (139.0, 20.7), (150.0, 20.7)]).is_alarmed


def test_a_value_that_is_no_number_is_outside_every_band() -> None:
    assert _seen([(0.0, 20.0), (10.0, float("nan")), (70.0, float("nan"))]).is_alarmed


def test_an_interlock_on_nothing_is_refused_by_name_and_line(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"rig.toml:\d+: interlocks.voltage.dmm.w: nothing of that name"):
        bench(tmp_path, rig=(("[twin]", '[interlocks.voltage."dmm.w"]\nband_v = [1.0, 2.0]\n[twin]'),))


def test_a_band_narrower_than_its_hysteresis_is_refused(tmp_path: Path) -> None:
    text = "[interlocks.temperature.air]\nband_degc = [19.0, 20.0]\nhysteresis_degc = 0.5\n[twin]"
    with pytest.raises(DescriptionError, match="must be wider than twice the hysteresis"):
        bench(tmp_path, rig=(("[twin]", text),))


def test_the_band_of_a_supply_is_watched_without_being_asked_for(tmp_path: Path) -> None:
    chain = '[chain."dmm.x"]\nsupply_channel = "dmm.s"\nsupply_band_v = [4.9, 5.1]\n[twin]'
    channels = (
        "z = { scanner = 3, range_v = 10.0 } }",
        "z = { scanner = 3, range_v = 10.0 }, s = { scanner = 4, range_v = 10.0 } }",
    )
    small = bench(tmp_path, rig=(("[twin]", chain), channels))
    ((name, lock),) = run_limits_of(small.rig).voltages
    assert (name, lock.low, lock.high, lock.action) == ("dmm.s", 4.9, 5.1, "hold")


@pytest.mark.parametrize("is_reversed", [False, True], ids=["narrow last", "narrow first"])
def test_several_bands_of_one_supply_are_watched_where_all_of_them_allow_it(
    tmp_path: Path, *, is_reversed: bool
) -> None:
    """In whatever order they are written, and with the keys that state both ends."""
    tables = [
        f'[chain."dmm.{name}"]\nsupply_channel = "dmm.s"\nsupply_band_v = {band}\n'
        for name, band in (("x", "[4.9, 5.1]"), ("y", "[4.5, 5.05]"), ("z", "[4.0, 6.0]"))
    ]
    text = "".join(reversed(tables) if is_reversed else tables)
    channels = (
        "z = { scanner = 3, range_v = 10.0 } }",
        "z = { scanner = 3, range_v = 10.0 }, s = { scanner = 4, range_v = 10.0 } }",
    )
    small = bench(tmp_path, rig=(("[twin]", f"{text}[twin]"), channels))
    ((name, lock),) = run_limits_of(small.rig).voltages
    assert (name, lock.low, lock.high) == ("dmm.s", 4.9, 5.05)
    assert lock.key == "rig file: chain.dmm.x.supply_band_v and chain.dmm.y.supply_band_v"


def _air(unattended: UnattendedRun) -> World:
    chance = unattended.rig.chance
    assert isinstance(chance, World)
    return chance


def _warm(degc: float) -> Callable[[UnattendedRun], None]:
    return lambda unattended: _air(unattended).disturb("air", degc, unattended.rig.clock.monotonic_s())


TEMPERATURE = "[interlocks.temperature.air]\nband_degc = [18.0, 22.0]\nhysteresis_degc = 0.3\n[twin]"


def test_fault_65_air_that_leaves_its_band_and_comes_back_holds_voids_and_repeats(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=(("[twin]", TEMPERATURE),))
    unattended = UnattendedRun(tmp_path / "run", after={10: _warm(30.0)}, at={400: _warm(20.0)})
    assert run_unattended(small, unattended).state is State.FINISHED
    assert states(unattended.run_dir)[3:] == ["held", "running", "finished"]
    held = events(unattended.run_dir, "state")[3]
    assert "environment.air: got 2" in str(held.detail["reason"])
    assert "allowed 18 to 22 °C (rig file: interlocks.temperature.air)" in str(held.detail["reason"])
    accepted = [dwell for dwell in dwells_of(unattended.run_dir) if dwell.accepted and dwell.purpose == "design"]
    assert len(accepted) == len(small.plan.design_dwells)
    assert all(17.9 < dwell.temperature_degc["air"] < 22.1 for dwell in accepted)


def test_fault_65_dwells_taken_before_a_delayed_alarm_are_taken_back(tmp_path: Path) -> None:
    delayed = TEMPERATURE.replace("hysteresis_degc = 0.3", "hysteresis_degc = 0.3\ndelay_s = 40.0")
    small = bench(tmp_path, rig=(("[twin]", delayed),))
    unattended = UnattendedRun(tmp_path / "run", after={10: _warm(30.0)}, at={400: _warm(20.0)})
    assert run_unattended(small, unattended).state is State.FINISHED
    (void,) = events(unattended.run_dir, "voided")
    assert len(void.detail["dwells"]) >= 3  # type: ignore[arg-type]
    rejected = [dwell for dwell in dwells_of(unattended.run_dir) if not dwell.accepted]
    assert all(dwell.reasons[-1].startswith("voided: environment.air: got") for dwell in rejected)
    again = [dwell for dwell in dwells_of(unattended.run_dir) if dwell.accepted and dwell.attempt == 2]
    assert {dwell.step for dwell in again} == {dwell.step for dwell in rejected}
    assert status(unattended.run_dir).dwells_done == len(small.plan.design_dwells)


def test_fault_65_stuck_air_stays_held_until_stop(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=(("[twin]", TEMPERATURE),))
    unattended = UnattendedRun(tmp_path / "run", after={10: _warm(30.0)}, at={2000: asks("stop")})
    outcome = run_unattended(small, unattended)
    assert (outcome.state, outcome.exit_status) == (State.STOPPED, ExitStatus.ABORTED)


def test_fault_65_a_plateau_that_is_lost_is_waited_for_and_soaked_anew(tmp_path: Path) -> None:
    """Detected: band at every look, around every dwell and where the run stands still, with hysteresis and delay.
    Response: held, goes on by itself; dwells since the band was last kept are taken back; a plateau is soaked anew.
    """
    plateau = "[environment]\nplateaus_degc = [30.0]\nsoak_s = 300.0\nband_degc = 1.0\n[check]"
    small = bench(tmp_path, procedure=((CHECKS, plateau),))

    def door(unattended: UnattendedRun) -> None:
        _air(unattended).air["air"].hold(20.0, unattended.rig.clock.monotonic_s())

    unattended = UnattendedRun(tmp_path / "run", after={10: door})
    assert run_unattended(small, unattended).state is State.FINISHED
    assert states(unattended.run_dir)[3:] == ["held", "running", "finished"]
    assert len(events(unattended.run_dir, "soaked")) == 2
    accepted = [dwell for dwell in dwells_of(unattended.run_dir) if dwell.accepted]
    assert all(abs(dwell.temperature_degc["air"] - 30.0) <= 1.05 for dwell in accepted)


SUPPLY = '[interlocks.voltage."dmm.z"]\nband_v = [-2.6, 0.5]\naction = "trip"\n[twin]'


def test_a_trip_is_latched_until_a_person_resumes_with_name_and_reason(tmp_path: Path) -> None:
    """z reads −2.5 V level and +2.5 V on its back: a band that the design must leave."""
    small = bench(tmp_path, rig=(("[twin]", SUPPLY),))
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended)
    assert (outcome.state, outcome.exit_status) == (State.TRIPPED, ExitStatus.HELD)
    assert outcome.reason.startswith("dmm.z: got ")
    with open_rig(small.rig) as rig, pytest.raises(RequestError, match=r"tripped, so a person has to look first"):
        resume_on(unattended.run_dir, rig, "carla")
    assert status(unattended.run_dir).state is State.TRIPPED


def test_fault_63_too_many_rejected_dwells_ask_for_a_person(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=(("[twin]", "[interlocks]\nrejected = { most = 2, within = 20 }\n[twin]"),))

    def spoil(number: int, burst: Burst) -> Burst:
        return noisier(burst, 30.0) if number > 40 and number % 9 == 0 else burst

    unattended = UnattendedRun(tmp_path / "run", at={20: asks("continue"), 60: asks("continue"), 120: asks("continue")})
    assert run_unattended(small, unattended, rig_of=lambda rig: FaultyRig(rig, spoil=spoil)).state is State.FINISHED
    held = [event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held"]
    assert held
    assert all("dwells were rejected, allowed 2" in str(event.detail["reason"]) for event in held)


def _free(unattended: UnattendedRun, full_at: int, free_again_at: int) -> Callable[[Path], int]:
    def free_bytes(folder: Path) -> int:
        done = max((progress.dwells_done for progress in unattended.heard), default=0)
        return int(1.0 * MB) if done >= full_at and unattended.rests < free_again_at else 10**12

    return free_bytes


def test_fault_03_a_disk_that_fills_up_holds_before_the_next_dwell_and_goes_on_with_space(
    small: Bench, tmp_path: Path
) -> None:
    """Detected: a forecast for the whole plan, free space before every dwell, the system's refusal.
    Response: held before the next dwell, goes on by itself when there is room; a write that is refused ends the run
    with every finished dwell kept, and resume goes on; refused before the run where it cannot fit.
    """
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, RunServices(free_bytes=_free(unattended, 8, 100)))
    assert outcome.state is State.FINISHED
    assert states(unattended.run_dir)[3:] == ["held", "running", "finished"]
    assert "disk: 1.0 MB are free" in str(events(unattended.run_dir, "state")[3].detail["reason"])
    small.run(tmp_path / "clean")
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(tmp_path / "clean"))


def test_fault_03_a_disk_without_room_for_the_plan_is_refused_before_anything_is_written(
    small: Bench, tmp_path: Path
) -> None:
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    needed = needed_bytes(small.plan, len(small.plan.dwells)) + 64.0 * MB
    with open_rig(small.rig) as rig, pytest.raises(RequestError, match=r"MB are free, the run needs") as refusal:
        begin(
            run_dir, small.header(run_dir), small.plan, rig, services=RunServices(free_bytes=lambda _: int(needed) - 1)
        )
    assert refusal.value.exit_status == ExitStatus.WRONG_REQUEST
    assert not list(run_dir.iterdir())


def test_fault_03_the_forecast_covers_what_a_run_really_writes(small: Bench, tmp_path: Path) -> None:
    small.run(tmp_path / "run")
    written = sum(path.stat().st_size for path in (tmp_path / "run").glob("journal.*"))
    assert written < needed_bytes(small.plan, len(small.plan.dwells)) < 4.0 * written


def test_fault_37_a_line_that_answers_badly_asks_for_a_person(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={number: asks("continue") for number in range(20, 2000, 20)})
    assert run_unattended(small, unattended, rig_of=RigWithBadLine).state is State.FINISHED
    held = next(event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held")
    assert held.detail["cause"] == "link quality"
    assert str(held.detail["reason"]).startswith("axes.pitch: 1")
    assert "allowed 0.02 of them" in str(held.detail["reason"])


def test_fault_13_a_step_of_the_wall_clock_is_recorded_and_changes_no_dwell(small: Bench, tmp_path: Path) -> None:
    """Detected: wall clock against monotonic clock at every look.
    Response: recorded; dwells are timed by the monotonic clock and do not notice.
    """

    def step(unattended: UnattendedRun) -> None:
        assert isinstance(unattended.rig.clock, VirtualClock)
        unattended.rig.clock.step_wall(-3600.0)

    small.run(tmp_path / "clean")
    unattended = UnattendedRun(tmp_path / "run", after={8: step})
    assert run_unattended(small, unattended).state is State.FINISHED
    (noted,) = events(unattended.run_dir, "clock_step")
    assert noted.detail["step_s"] == pytest.approx(-3600.0)
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(tmp_path / "clean"))
    assert all(dwell.ended_s > dwell.started_s for dwell in dwells_of(unattended.run_dir))


@pytest.mark.parametrize("is_in_a_dwell", [False, True])
def test_fault_15_no_dwell_spans_a_suspension_and_nothing_is_trusted_after_it(
    small: Bench, tmp_path: Path, is_in_a_dwell: bool
) -> None:
    """Detected: boot clock against monotonic clock at every look; an inhibitor keeps the machine awake.
    Response: the dwell is void; lines opened anew, home, check set, seam test, on with the first missing dwell.
    """
    unattended = UnattendedRun(tmp_path / "run")

    def suspend() -> None:
        assert isinstance(unattended.rig.clock, VirtualClock)
        unattended.rig.clock.suspend(1800.0)

    def spoil(number: int, burst: Burst) -> Burst:
        if is_in_a_dwell and number == 50:
            suspend()
        return burst

    def between(progress: UnattendedRun) -> None:
        suspend()

    unattended = UnattendedRun(tmp_path / "run", after={} if is_in_a_dwell else {8: between})
    assert run_unattended(small, unattended, rig_of=lambda rig: FaultyRig(rig, spoil=spoil)).state is State.FINISHED
    assert states(unattended.run_dir)[3:] == ["held", "checking", "running", "finished"]
    held = events(unattended.run_dir, "state")[3]
    assert "the machine was suspended for 1800 s" in str(held.detail["reason"])
    step = (50 - 1) // 3
    assert not is_in_a_dwell or [
        d.epoch for d in dwells_of(unattended.run_dir) if d.step == step and d.purpose != "check"
    ] == [2]


def test_a_run_does_not_finish_on_a_value_that_may_yet_alarm(tmp_path: Path) -> None:
    delayed = TEMPERATURE.replace("hysteresis_degc = 0.3", "hysteresis_degc = 0.3\ndelay_s = 40.0")
    small = bench(tmp_path, rig=(("[twin]", delayed),))
    last = len(small.plan.design_dwells) - 2
    unattended = UnattendedRun(tmp_path / "run", after={last: _warm(30.0)}, at={400: _warm(20.0)})
    assert run_unattended(small, unattended).state is State.FINISHED
    accepted = [dwell for dwell in dwells_of(unattended.run_dir) if dwell.accepted and dwell.purpose == "design"]
    assert len(accepted) == last + 2
    assert all(dwell.temperature_degc["air"] < 22.1 for dwell in accepted)
