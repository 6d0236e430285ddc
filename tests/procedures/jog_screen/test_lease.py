"""Laws of leases: each renewal lasts so long and no longer, and a lease that is over stays over."""

import pytest
from table_bench import virtual_clock

from procedures.jog_screen.lease import FIRST_REPEAT_S, REPEAT_S, TERMINAL_S, RateLease


def test_a_lease_lives_from_answer_to_answer() -> None:
    clock = virtual_clock()
    lease = RateLease(clock, is_held=False)
    for _ in range(100):
        clock.sleep(TERMINAL_S - 0.01)
        assert not lease.why_over()
        lease.answer()
    clock.sleep(TERMINAL_S + 0.01)
    assert lease.why_over() == "the terminal did not answer for 0.3 s"


def test_a_held_rate_needs_its_key_as_well() -> None:
    clock = virtual_clock()
    lease = RateLease(clock, is_held=True)
    times = [FIRST_REPEAT_S - 0.01, *[REPEAT_S - 0.01] * 20]
    for pause_s in times:
        _let_pass(clock, lease, pause_s)
        assert not lease.why_over()
        lease.press()
    _let_pass(clock, lease, REPEAT_S + 0.01)
    assert lease.why_over() == "the key was released"


@pytest.mark.parametrize("renewal", [RateLease.answer, RateLease.press])
def test_what_is_over_is_not_revived(renewal: object) -> None:
    clock = virtual_clock()
    lease = RateLease(clock, is_held=True)
    clock.sleep(1.0)
    assert lease.why_over()
    renewal(lease)  # type: ignore[operator]
    assert lease.why_over()


def test_presses_do_not_stand_for_a_terminal() -> None:
    clock = virtual_clock()
    lease = RateLease(clock, is_held=True)
    for _ in range(5):
        clock.sleep(0.1)
        lease.press()
    assert "terminal" in lease.why_over()


def _let_pass(clock: object, lease: RateLease, pause_s: float) -> None:
    """Time passes; the terminal goes on answering."""
    left_s = pause_s
    while left_s > 0.0:
        clock.sleep(min(0.05, left_s))  # type: ignore[attr-defined]
        left_s -= 0.05
        lease.answer()
