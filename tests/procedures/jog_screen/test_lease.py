"""Laws of leases: each renewal lasts so long and no longer, and a lease that is over stays over."""

import pytest
from table_bench import virtual_clock

from procedures.jog_screen.lease import ANSWER_S, FIRST_REPEAT_S, PAGE, REPEAT_S, TERMINAL, MotionLease


def test_a_lease_lives_from_answer_to_answer() -> None:
    clock = virtual_clock()
    lease = MotionLease(clock, is_held=False)
    for _ in range(100):
        clock.sleep(ANSWER_S[TERMINAL] - 0.01)
        assert not lease.why_over()
        lease.answer()
    clock.sleep(ANSWER_S[TERMINAL] + 0.01)
    assert lease.why_over() == "the terminal did not answer for 0.3 s"


def test_a_held_rate_needs_its_key_as_well() -> None:
    clock = virtual_clock()
    lease = MotionLease(clock, is_held=True)
    times = [FIRST_REPEAT_S - 0.01, *[REPEAT_S - 0.01] * 20]
    for pause_s in times:
        _let_pass(clock, lease, pause_s)
        assert not lease.why_over()
        lease.press()
    _let_pass(clock, lease, REPEAT_S + 0.01)
    assert lease.why_over() == "the key was released"


@pytest.mark.parametrize("renewal", [MotionLease.answer, MotionLease.press])
def test_what_is_over_is_not_revived(renewal: object) -> None:
    clock = virtual_clock()
    lease = MotionLease(clock, is_held=True)
    clock.sleep(1.0)
    assert lease.why_over()
    renewal(lease)  # type: ignore[operator]
    assert lease.why_over()


def test_presses_do_not_stand_for_a_terminal() -> None:
    clock = virtual_clock()
    lease = MotionLease(clock, is_held=True)
    for _ in range(5):
        clock.sleep(0.1)
        lease.press()
    assert "terminal" in lease.why_over()


def test_an_answer_that_took_long_renews_from_the_moment_it_tells_of() -> None:
    clock = virtual_clock()
    lease = MotionLease(clock, is_held=False, whose=PAGE)
    for _ in range(100):  # a line that takes so long, for ever
        clock.sleep(0.05)
        lease.answer(clock.boottime_s() - 0.15)
        assert not lease.why_over()
    clock.sleep(ANSWER_S[PAGE] - 0.15 + 0.01)
    assert lease.why_over() == "the page did not answer for 0.25 s"


def test_a_lease_ends_while_the_machine_sleeps_and_no_step_of_its_clock_matters() -> None:
    clock = virtual_clock()
    lease = MotionLease(clock, is_held=False, whose=PAGE)
    clock.step_wall(-3600.0)
    clock.step_wall(7200.0)
    assert not lease.why_over()
    clock.suspend(1.0)
    lease.answer()
    assert lease.why_over()


def _let_pass(clock: object, lease: MotionLease, pause_s: float) -> None:
    """Time passes; the terminal goes on answering."""
    left_s = pause_s
    while left_s > 0.0:
        clock.sleep(min(0.05, left_s))  # type: ignore[attr-defined]
        left_s -= 0.05
        lease.answer()
