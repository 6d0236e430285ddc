"""Whatever happens to an axis whose cables wind up, in whatever order, nobody believes them less wound than they are.

Moves, reference moves, rates, kills, new processes, power cuts and a frozen process, against a table whose true angle
is known. Only the person who looks at the cables ends a doubt.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import pytest
from counting_table import TOP_RATE_DPS, CountingTable, Driver
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test
from table_bench import virtual_clock

from ams.whole_file import replace_file
from rig.abilities.abilities import Wait
from rig.cables.cable import CableGuard
from rig.cables.cable_memory import KeptInFile
from rig.cables.winding import AGREES_DEG, Machine, UnseenTurns, Winding, first_look, next_look, without_home
from rig.errors import DeviceFault, LinkLost, RequestRefused, RigError
from rig.motion.jog import home, jog_to, seen_at_rest, stop, turn_for

WRAP_TURNS = 3.0
LIMIT_DEG = WRAP_TURNS * 360.0
LIMITS_DEG = (-250.0, 250.0)
LOOK_DEG = 0.2 * TOP_RATE_DPS + AGREES_DEG
"""How far it turns between two looks, and no count is nearer than this."""
UNTIL_KILLED = st.none() | st.integers(0, 40)
TARGETS_DEG = st.sampled_from((-240.0, -180.0, -170.0, -10.0, 0.0, 10.0, 90.0, 170.0, 180.0, 240.0))
RATES_DPS = st.sampled_from((-TOP_RATE_DPS, -40.0, 40.0, TOP_RATE_DPS))
SECONDS = st.sampled_from((3.0, 5.0, 9.0))


class Bench:
    """A table, the file of its winding, and the process that has both open now."""

    def __init__(self, path: Path, *, wraps: bool) -> None:
        self.path = path
        self.clock = virtual_clock()
        self.table = CountingTable(self.clock, wraps=wraps)
        self.planned_deg = 0.0
        self.open()

    def guard(self) -> CableGuard:
        """What a process that begins now has."""
        self.driver = Driver(self.table, self.clock, LIMITS_DEG, self._require_room)
        memory = KeptInFile(self.path, replace_file)
        return CableGuard(self.driver, WRAP_TURNS, memory, self.clock, Machine(0.0, self.table.wraps))

    def open(self) -> None:
        self.axis = self.guard()
        self.alive = self.driver
        self.rig: Any = SimpleNamespace(axes={"yaw": self.axis}, clock=self.clock, stranger_axes=lambda _names: {})

    def waiting(self, looks: int | None, frozen_s: float = 0.0) -> Wait:
        """Return a wait after so many of which the process is killed, or frozen while its stop guard stops the axis."""
        left = [looks]

        def wait(duration_s: float) -> None:
            self.clock.sleep(duration_s)
            if left[0] is None:
                return
            left[0] -= 1
            if left[0] < 0:
                left[0] = None
                if not frozen_s:
                    self.alive.is_dead = True
                    raise LinkLost("killed")
                self.clock.sleep(2.0)
                self.table.stop()
                self.clock.sleep(frozen_s)

        return wait

    def turn(self, rate_dps: float, seconds: float, wait: Wait | None = None) -> None:
        self.planned_deg = rate_dps * seconds
        with seen_at_rest(self.rig, "yaw"):
            turn_for(self.rig, "yaw", rate_dps, seconds, wait or self.clock.sleep)

    def home(self, wait: Wait | None = None) -> None:
        with seen_at_rest(self.rig, "yaw"):
            home(self.rig, "yaw", wait or self.clock.sleep)

    def go(self, target_deg: float, wait: Wait | None = None) -> None:
        with seen_at_rest(self.rig, "yaw"):
            jog_to(self.rig, "yaw", target_deg, wait or self.clock.sleep)

    def _require_room(self, rate_dps: float) -> None:
        """The machine is told to turn: would the cables bear what it was told for?"""
        here_deg = self.table.true_deg
        there_deg = here_deg + self.planned_deg
        assert self.planned_deg * rate_dps > 0.0
        assert abs(there_deg) <= max(LIMIT_DEG + AGREES_DEG, abs(here_deg)), f"from {here_deg:g} to {there_deg:g}°"


class Stories(RuleBasedStateMachine):
    """Anything, in any order."""

    wraps = False

    def __init__(self) -> None:
        super().__init__()
        self.folder = TemporaryDirectory()
        self.bench = Bench(Path(self.folder.name) / "yaw.json", wraps=self.wraps)
        self.was_in_doubt = False
        self.bench.home()

    def teardown(self) -> None:
        self.folder.cleanup()

    def _live(self, act: Any) -> None:
        try:
            act()
        except RigError:
            if self.bench.alive.is_dead:
                self.bench.open()

    @rule(target_deg=TARGETS_DEG, looks=UNTIL_KILLED)
    def move(self, target_deg: float, looks: int | None) -> None:
        self._live(lambda: self.bench.go(target_deg, self.bench.waiting(looks)))

    @rule(looks=UNTIL_KILLED)
    def search_home(self, looks: int | None) -> None:
        self._live(lambda: self.bench.home(self.bench.waiting(looks)))

    @rule(rate_dps=RATES_DPS, seconds=SECONDS, looks=UNTIL_KILLED)
    def turn(self, rate_dps: float, seconds: float, looks: int | None) -> None:
        self._live(lambda: self.bench.turn(rate_dps, seconds, self.bench.waiting(looks)))

    @rule(rate_dps=RATES_DPS, seconds=SECONDS, looks=st.integers(0, 15), frozen_s=st.sampled_from((1.0, 5.0, 60.0)))
    def turn_and_freeze(self, rate_dps: float, seconds: float, looks: int, frozen_s: float) -> None:
        self._live(lambda: self.bench.turn(rate_dps, seconds, self.bench.waiting(looks, frozen_s)))

    @rule()
    def lose_power(self) -> None:
        self.bench.table.power_cycle()

    @rule()
    def begin_a_new_process(self) -> None:
        self.bench.open()

    @rule(seconds=SECONDS, is_stopped=st.booleans())
    def let_time_pass(self, seconds: float, is_stopped: bool) -> None:
        self.bench.clock.sleep(seconds)
        if is_stopped:  # by the stop guard of a process that was killed
            self.bench.table.stop()

    @rule()
    def stop(self) -> None:
        self._live(lambda: stop(self.bench.rig, "yaw"))

    @rule()
    def let_a_person_look(self) -> None:
        """As the sentence says: unwind by hand, home, remove the file, start anew."""
        if self.bench.axis.is_in_doubt:
            self.bench.table.unwind_by_hand()
            self.bench.home()
            self.bench.path.unlink()
            self.bench.open()
            self.was_in_doubt = False

    @invariant()
    def nobody_believes_less_than_the_truth(self) -> None:
        table = self.bench.table
        if table.is_moving:
            return
        new = self.bench.guard()
        new.state()
        kept = KeptInFile(self.bench.path, replace_file).read()
        assert not self.was_in_doubt or (kept is not None and kept.is_lost), "a doubt ended, and no person ended it"
        if new.is_in_doubt:
            self.was_in_doubt = True
            return
        if table.is_homed:
            assert abs(new.wound_deg - table.true_deg) <= LOOK_DEG
        else:  # a reference move ends where the count begins
            assert abs(table.true_deg) <= 180.0

    @invariant()
    def an_axis_in_doubt_turns_at_no_rate(self) -> None:
        if self.bench.axis.is_in_doubt and not self.bench.table.is_moving:
            self.bench.planned_deg = 0.0
            with pytest.raises(RequestRefused, match="nobody knows how far its cables are wound"):
                self.bench.axis.start_rate(10.0)


class WrappingStories(Stories):
    """The same of a table that tells angles within a turn only, and goes the near way."""

    wraps = True


@pytest.mark.timeout(600)
@pytest.mark.parametrize("examples", [40, pytest.param(400, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("stories", [Stories, WrappingStories])
def test_nobody_believes_cables_less_wound_than_they_are(stories: type[Stories], examples: int) -> None:
    run_state_machine_as_test(
        stories,
        settings=settings(
            max_examples=examples, stateful_step_count=15, deadline=None, suppress_health_check=list(HealthCheck)
        ),
    )


LINEAR, WRAPPING = Machine(), Machine(wraps=True)


@pytest.mark.parametrize("machine", [LINEAR, WRAPPING])
@pytest.mark.parametrize("read_deg", [-820.0, 0.0, 10.0, 97.0, 817.0])
@pytest.mark.parametrize("is_turning", [False, True])
def test_no_look_ends_a_doubt(machine: Machine, read_deg: float, is_turning: bool) -> None:
    lost = Winding(817.0, 817.0, is_turning, is_lost=True)
    for look in (first_look, next_look):
        assert look(lost, read_deg, machine) == lost
    assert without_home(lost, machine) == lost


@pytest.mark.parametrize(
    ("kept", "read_deg", "wound_deg"),
    [
        (None, 5.0, 5.0),
        (Winding(720.0, 720.0, False), 720.3, 720.3),  # it rested, and rests there
        (Winding(720.0, 720.0, False), 0.0, None),  # wound, and counts from elsewhere
        (Winding(180.0, 180.0, False), 0.0, None),  # half a turn: its home may be at 0 or at 360
        (Winding(100.0, 100.0, False), 0.0, 0.0),  # unwound, homed anew
        (Winding(0.0, 0.0, True), 1500.0, 1500.0),  # it turned on, and the machine counted
    ],
)
def test_a_new_process_goes_on_from_the_machine_s_count_where_that_is_the_same(
    kept: Winding | None, read_deg: float, wound_deg: float | None
) -> None:
    found = first_look(kept, read_deg, LINEAR)
    assert found.is_lost == (wound_deg is None)
    assert wound_deg is None or found.wound_deg == pytest.approx(wound_deg)


@pytest.mark.parametrize(
    ("kept", "read_deg", "wound_deg"),
    [
        (Winding(817.0, 817.0, False), 97.2, 817.2),  # it rested: the same angle of the same turn
        (Winding(817.0, 817.0, False), 130.0, None),
        (Winding(-3.0, -3.0, False), 357.5, -2.5),
        (Winding(20.0, 20.0, False), 120.0, 120.0),  # it was moved, within half a turn
        (Winding(0.0, 0.0, True), 10.0, None),  # it turned unseen, nobody knows how often
        (Winding(0.0, 0.0, True), 0.0, None),
    ],
)
def test_a_new_process_knows_no_turns_of_a_machine_that_tells_angles_within_one(
    kept: Winding, read_deg: float, wound_deg: float | None
) -> None:
    found = first_look(kept, read_deg, WRAPPING)
    assert found.is_lost == (wound_deg is None)
    assert wound_deg is None or found.wound_deg == pytest.approx(wound_deg)


def test_a_machine_that_lost_its_zero_leaves_only_cables_at_rest_and_unwound_known() -> None:
    for kept, is_lost in (
        (Winding(720.0, 720.0, False), True),
        (Winding(10.0, 10.0, True), True),
        (Winding(100.0, 100.0, False), False),
    ):
        found = without_home(kept, LINEAR)
        assert found is not None
        assert found.is_lost == is_lost
    at_quarter = Machine(home_deg=-90.0)  # zero_deg = 90: half a turn is counted from the home
    assert at_quarter.is_wound(100.0)
    assert not at_quarter.is_wound(-260.0)


def _bench(tmp_path: Path, *, wraps: bool) -> Bench:
    bench = Bench(tmp_path / "yaw.json", wraps=wraps)
    bench.home()
    return bench


def test_a_wrapping_table_that_a_killed_process_left_turning_is_in_doubt_until_a_person_has_looked(
    tmp_path: Path,
) -> None:
    bench = _bench(tmp_path, wraps=True)
    with pytest.raises(RigError, match="killed"):
        bench.turn(90.0, 11.0, bench.waiting(45))
    bench.clock.sleep(2.0)
    bench.table.stop()
    assert bench.table.true_deg > 2.0 * 360.0
    for target_deg in (0.0, 10.0, 0.0):
        bench.open()
        bench.go(target_deg)
        with pytest.raises(RequestRefused, match=r"nobody knows.*or turned unseen: it counts within a turn only"):
            bench.turn(90.0, 8.0)


def test_a_move_of_a_wrapping_table_is_counted_by_the_way_that_it_takes(tmp_path: Path) -> None:
    bench = _bench(tmp_path, wraps=True)
    bench.turn(90.0, 5.0)
    bench.open()
    bench.go(10.0)  # the near way: back by a quarter turn, not by a turn and a quarter
    assert bench.table.true_deg == pytest.approx(370.0)
    assert bench.axis.wound_deg == pytest.approx(370.0)
    bench.open()
    with pytest.raises(
        RequestRefused, match=r"wound \+1\.03 revolutions.*--rate -60 --for 6\.17\): a move to 0° may go"
    ):
        bench.turn(90.0, 9.0)
    with pytest.raises(
        DeviceFault, match=r"home: its cables are wound \+1\.00 revolutions.*was not homed; turn the axis"
    ):
        bench.home()
    bench.turn(-60.0, 6.0)
    bench.home()
    assert bench.axis.wound_deg == pytest.approx(bench.table.true_deg)
    assert abs(bench.table.true_deg) < 180.0


def test_a_wrapping_table_that_turns_steadily_is_counted_through_a_long_reading(tmp_path: Path) -> None:
    bench = _bench(tmp_path, wraps=True)
    bench.planned_deg = -730.0
    bench.axis.start_rate(-90.0)
    for pause_s in (0.2, 0.2, 0.2, 7.0, 0.5):
        bench.clock.sleep(pause_s)
        bench.axis.turn_look(bench.clock)
    stop(bench.rig, "yaw")
    assert not bench.axis.is_in_doubt
    assert bench.axis.wound_deg == pytest.approx(bench.table.true_deg)


def test_a_wrapping_table_that_was_not_steady_before_it_turned_unseen_is_not_counted() -> None:
    unseen = UnseenTurns()
    unseen.start(90.0)
    assert not unseen.is_lost(0.0, 0.0, 90.0, is_at_rest=False)
    assert unseen.is_lost(-162.0, 2.2, 90.0, is_at_rest=False)  # it turned by 198, told as the near 162 the other way


def test_a_kill_on_a_way_that_a_wrapping_table_takes_either_way_leaves_a_doubt(
    tmp_path: Path,
) -> None:
    bench = _bench(tmp_path, wraps=True)
    bench.go(-170.0)
    with pytest.raises(RigError, match="killed"):
        bench.go(170.0, bench.waiting(0))
    bench.clock.sleep(5.0)
    assert bench.table.true_deg == pytest.approx(-190.0)
    bench.open()
    bench.axis.state()
    assert bench.axis.is_in_doubt


def test_a_move_that_is_refused_for_want_of_a_home_leaves_no_doubt(tmp_path: Path) -> None:
    bench = _bench(tmp_path, wraps=False)
    bench.go(90.0)
    bench.table.power_cycle()
    with pytest.raises(RequestRefused, match="not homed"):
        bench.axis.start_move(240.0)
    bench.axis.state()
    assert not bench.axis.is_in_doubt


def test_the_first_thing_that_a_process_does_may_be_to_unwind_and_be_killed_at_it(tmp_path: Path) -> None:
    bench = _bench(tmp_path, wraps=False)
    bench.turn(90.0, 9.0)
    bench.open()
    bench.axis.start_move(0.0)
    bench.clock.sleep(5.0)
    bench.table.stop()
    bench.open()
    bench.axis.state()
    assert not bench.axis.is_in_doubt
    assert bench.axis.wound_deg == pytest.approx(bench.table.true_deg)


def test_a_process_behind_one_that_was_killed_homes_at_once_and_knows_the_winding(tmp_path: Path) -> None:
    bench = _bench(tmp_path, wraps=False)
    with pytest.raises(RigError, match="killed"):
        bench.turn(90.0, 3.0, bench.waiting(6))
    bench.table.stop()
    assert 90.0 < bench.table.true_deg < 170.0
    bench.open()
    bench.home()
    assert not bench.axis.is_in_doubt
    bench.turn(90.0, 9.0)


def test_the_file_says_that_an_axis_turns_until_it_was_told_to_stop_and_seen_at_rest(tmp_path: Path) -> None:
    bench = _bench(tmp_path, wraps=False)
    bench.planned_deg = 90.0
    bench.axis.start_rate(90.0)
    bench.clock.sleep(1.0)
    bench.table.stop()  # by another hand; it may be told its next rate at any moment
    for _ in range(3):
        bench.axis.state()
        assert _filed(bench).is_turning
    bench.axis.stop()
    bench.axis.state()
    assert not _filed(bench).is_turning


def test_a_look_elsewhere_shows_no_rest(tmp_path: Path) -> None:
    bench = _bench(tmp_path, wraps=False)
    with pytest.raises(RigError, match="killed"):
        bench.turn(90.0, 5.0, bench.waiting(20))
    bench.table.stop()
    bench.open()
    bench.axis.state()
    assert _filed(bench).is_turning
    bench.axis.state()
    assert _filed(bench) == Winding(bench.table.true_deg, bench.table.true_deg, is_turning=False)


def test_turns_by_another_hand_that_a_process_sees_are_kept(tmp_path: Path) -> None:
    bench = _bench(tmp_path, wraps=False)
    bench.turn(40.0, 3.0)
    bench.table.turn(90.0)
    bench.clock.sleep(5.0)
    bench.table.stop()
    bench.axis.state()
    assert _filed(bench).wound_deg == pytest.approx(bench.table.true_deg)
    bench.table.power_cycle()
    bench.open()
    bench.home()
    assert bench.axis.is_in_doubt


def _filed(bench: Bench) -> Winding:
    kept = KeptInFile(bench.path, replace_file).read()
    assert kept is not None
    return kept
