"""Laws of what an axis may do after an order: machines that obey are never accused, those that do not always are."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.motion.expectation import (
    MARGIN_DEG,
    OVERSPEED,
    Bounds,
    Homing,
    Seen,
    Standing,
    Stopping,
    Turning,
    Unknown,
    Watched,
    after_home,
    expecting_move,
    expecting_stop,
    expecting_turn,
    judge,
)

BOUNDS = Bounds(limits_deg=(-90.0, 90.0), speed_dps=20.0, tolerance_deg=0.001)
ANGLES = st.floats(-90.0, 90.0)
PARTS = st.lists(st.floats(0.01, 2.0), min_size=1, max_size=30)


def _seen(position_deg: float, at_s: float, *, is_moving: bool | None = True, is_homed: bool = True) -> Seen:
    return Seen(position_deg, at_s, at_s + 0.01, is_moving, is_homed)


def _at_rest(position_deg: float) -> Watched:
    return judge(BOUNDS, Watched(), _seen(position_deg, 0.0, is_moving=False))[0]


@given(ANGLES, ANGLES, PARTS, st.floats(0.05, OVERSPEED))
def test_an_axis_that_goes_where_it_was_sent_is_never_accused(
    from_deg: float, target_deg: float, gaps_s: list[float], pace: float
) -> None:
    watched = expecting_move(_at_rest(from_deg), target_deg, BOUNDS.speed_dps)
    at_s, way = 0.01, 1.0 if target_deg >= from_deg else -1.0
    for gap_s in gaps_s:
        at_s += gap_s
        gone_deg = min(pace * BOUNDS.speed_dps * (at_s - 0.01), abs(target_deg - from_deg))
        watched, breach = judge(BOUNDS, watched, _seen(from_deg + way * gone_deg, at_s))
        assert breach == ""
    watched, breach = judge(BOUNDS, watched, _seen(target_deg, at_s + 10.0 / pace, is_moving=False))
    assert (breach, watched.task) == ("", Standing(target_deg, True))


@given(ANGLES, ANGLES, st.floats(-400.0, 400.0))
def test_no_place_beyond_the_way_and_its_margin_is_allowed(from_deg: float, target_deg: float, here_deg: float) -> None:
    watched = expecting_move(_at_rest(from_deg), target_deg, BOUNDS.speed_dps)
    _, breach = judge(BOUNDS, watched, _seen(here_deg, 1000.0))
    low_deg, high_deg = sorted((from_deg, target_deg))
    is_beyond = not low_deg - BOUNDS.margin_deg <= here_deg <= high_deg + BOUNDS.margin_deg
    assert bool(breach) == is_beyond


@given(ANGLES, ANGLES, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_an_axis_that_turns_back_on_its_way_is_accused(
    from_deg: float, target_deg: float, first: float, then: float
) -> None:
    watched = expecting_move(_at_rest(from_deg), target_deg, BOUNDS.speed_dps)
    span_deg = target_deg - from_deg
    watched, breach = judge(BOUNDS, watched, _seen(from_deg + first * span_deg, 1000.0))
    assert breach == ""
    _, breach = judge(BOUNDS, watched, _seen(from_deg + then * span_deg, 2000.0))
    back_deg = (first - then) * abs(span_deg)
    if abs(back_deg - BOUNDS.margin_deg) > 1e-6:
        assert ("turns away from its target" in breach) == (back_deg > BOUNDS.margin_deg)


@given(st.floats(-20.0, 20.0).filter(lambda rate: abs(rate) > 0.05), PARTS)
def test_an_axis_that_turns_at_its_rate_is_never_accused_and_one_that_turns_the_other_way_is(
    rate_dps: float, gaps_s: list[float]
) -> None:
    unlimited = replace(BOUNDS, limits_deg=(-180.0, 180.0))
    for sense in (1.0, -1.0):
        watched, at_s, breaches = expecting_turn(_at_rest(0.0), rate_dps), 0.0, []
        for gap_s in [*gaps_s, 200.0]:
            at_s += gap_s
            watched, breach = judge(unlimited, watched, _seen(sense * rate_dps * at_s, at_s, is_moving=None))
            breaches.append(breach)
            if breach:
                break
        assert any(breaches) == (sense < 0.0), breaches


def test_a_slow_wrong_way_does_not_hide_in_the_margin_of_every_look() -> None:
    watched, at_s, breach = expecting_turn(_at_rest(0.0), 0.1), 0.0, ""
    while not breach:
        at_s += 0.2
        assert at_s < 60.0
        watched, breach = judge(BOUNDS, watched, _seen(-0.1 * at_s, at_s, is_moving=None))
    assert "the wrong way" in breach
    assert 0.1 * at_s <= MARGIN_DEG + 0.1


def test_rates_of_a_motion_that_changes_its_sense_span_both() -> None:
    turning = expecting_turn(expecting_turn(_at_rest(0.0), 5.0), -3.0).task
    assert turning == Turning(-3.0, 5.0)


def test_a_rate_between_limits_may_not_pass_them() -> None:
    watched = expecting_turn(_at_rest(80.0), 10.0)
    _, breach = judge(BOUNDS, watched, _seen(91.0, 2.0, is_moving=None))
    assert "turned beyond its limits: at 91°, allowed -90 to 90°" in breach


@pytest.mark.parametrize(
    ("seen", "sentence"),
    [
        (_seen(10.004, 5.0, is_moving=False), ""),
        (_seen(10.5, 5.0, is_moving=False), "was moved, though nothing told it to: left at 10°, now at 10.5°"),
        (_seen(10.0, 5.0), "moves, though nothing told it to"),
        (_seen(0.0, 5.0, is_moving=False, is_homed=False), ""),
    ],
)
def test_an_axis_that_should_stand_stands(seen: Seen, sentence: str) -> None:
    """A controller that lost its home is no displacement: its positions mean nothing."""
    _, breach = judge(BOUNDS, _at_rest(10.0), seen)
    assert (sentence in breach) if sentence else breach == ""


def test_an_axis_without_a_home_may_be_turned_by_hand_but_not_move_by_itself() -> None:
    watched, _ = judge(BOUNDS, Watched(), _seen(0.0, 0.0, is_moving=False, is_homed=False))
    watched, breach = judge(BOUNDS, watched, _seen(33.0, 1.0, is_moving=False, is_homed=False))
    assert breach == ""
    _, breach = judge(BOUNDS, watched, _seen(34.0, 2.0, is_homed=False))
    assert "moves, though nothing told it to" in breach


def test_a_stopped_axis_stands_after_a_second_at_one_place() -> None:
    watched = expecting_stop(expecting_move(_at_rest(0.0), 50.0, 20.0))
    for at_s, deg, is_moving, task in (
        (1.0, 20.0, True, Stopping),
        (1.5, 21.0, False, Stopping),
        (2.0, 20.5, False, Stopping),  # it settles on its tooth
        (3.5, 20.5, False, Standing),
    ):
        watched, breach = judge(BOUNDS, watched, _seen(deg, at_s, is_moving=is_moving))
        assert (breach, type(watched.task)) == ("", task)
    assert expecting_stop(watched) == watched


@given(st.floats(-180.0, 180.0), PARTS, st.floats(0.05, OVERSPEED), st.floats(-400.0, 400.0), st.integers(0, 29))
def test_a_home_search_within_a_turn_is_never_accused_though_its_zero_is_set(
    from_deg: float, gaps_s: list[float], pace: float, zero_deg: float, set_at: int
) -> None:
    watched = replace(_at_rest(from_deg), task=Homing())
    at_s, gone_deg, offset_deg = 0.01, 0.0, 0.0
    for number, gap_s in enumerate(gaps_s):
        at_s += gap_s
        gone_deg = min(gone_deg + pace * BOUNDS.speed_dps * gap_s, 360.0)
        offset_deg = zero_deg if number >= set_at else 0.0
        watched, breach = judge(BOUNDS, watched, _seen(from_deg + gone_deg + offset_deg, at_s, is_homed=False))
        assert breach == ""
    watched, breach = judge(BOUNDS, watched, _seen(0.0, at_s + 1.0, is_moving=False))
    assert (breach, watched.task) == ("", Standing(0.0, True))


@pytest.mark.parametrize(("at_deg", "doubt"), [(0.3, ""), (40.0, "ended at 40°, not at its zero of 0°")])
def test_a_home_that_ends_elsewhere_than_at_zero_is_doubted_once_and_holds_from_then_on(
    at_deg: float, doubt: str
) -> None:
    """Found later: `HOME` became `MOVE +040` on the line, and 40 was believed to be home."""
    homing = replace(_at_rest(0.0), task=Homing())
    watched, breach = judge(BOUNDS, homing, _seen(at_deg, 60.0, is_moving=False))
    assert (breach, watched.task) == ("", Standing(at_deg, True, doubt))
    known = after_home(BOUNDS, at_deg)
    assert judge(known, homing, _seen(at_deg, 60.0, is_moving=False))[0].task == Standing(at_deg, True)
    assert "the search before it at" in judge(known, homing, _seen(at_deg - 40.0, 60.0, is_moving=False))[1]


@pytest.mark.parametrize("had_zero", [True, False])
def test_a_zero_that_moves_though_the_axis_had_one_is_doubted(had_zero: bool) -> None:
    watched = replace(_at_rest(60.0), task=Homing(had_zero=had_zero))
    for at_s, at_deg in ((1.0, 50.0), (2.0, 40.0), (3.0, -2.0)):
        watched, breach = judge(BOUNDS, watched, _seen(at_deg, at_s))
        assert breach == ""
    watched, breach = judge(BOUNDS, watched, _seen(0.0, 4.0, is_moving=False))
    assert breach == ""
    assert watched.task == Standing(0.0, True, "its zero moved by -42°, though it was homed" if had_zero else "")


@pytest.mark.parametrize(("at_deg", "is_believed"), [(0.3, True), (90.3, True), (-90.6, False), (170.0, False)])
def test_a_home_that_ends_beyond_the_limits_is_none_but_at_the_machine_s_zero(at_deg: float, is_believed: bool) -> None:
    """Found later: `HOME` became `MOVE +170` on the line, and 170 was believed to be home."""
    watched, breach = judge(BOUNDS, replace(_at_rest(0.0), task=Homing()), _seen(at_deg, 60.0, is_moving=False))
    assert (breach == "", isinstance(watched.task, Standing)) == (is_believed, is_believed)
    beyond = replace(BOUNDS, home_deg=at_deg)
    assert judge(beyond, replace(_at_rest(0.0), task=Homing()), _seen(at_deg, 60.0, is_moving=False))[1] == ""


@pytest.mark.parametrize(
    ("rate_dps", "word", "most_deg"), [(-29.0, "found none", 450.0), (31.5, "over its limit", 64.0)]
)
def test_a_home_search_that_goes_on_and_on_or_too_fast_is_accused(rate_dps: float, word: str, most_deg: float) -> None:
    watched, breach, at_s = replace(_at_rest(0.0), task=Homing()), "", 0.0
    while not breach and at_s < 60.0:
        at_s += 1.0
        watched, breach = judge(BOUNDS, watched, _seen(rate_dps * at_s, at_s, is_homed=False))
    assert word in breach
    assert abs(rate_dps * at_s) < most_deg


def test_without_a_look_before_nothing_is_expected() -> None:
    assert expecting_move(Watched(), 10.0, 5.0).task == Unknown(may_move=True)
