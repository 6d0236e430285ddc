"""Threads that cannot be had, or die before they begin: nobody waits for one for ever, and the work is done."""

import threading
from collections.abc import Callable

import pytest

from rig import threads
from rig.threads import BegunThread, at_once

PATIENCE_S = 10.0


def _none_left(*_: object) -> int:
    raise RuntimeError("can't start new thread")


def _dies_before_it_begins(*_: object) -> int:
    """What a thread does whose first allocation fails: the system made it, and it says nothing."""
    return 0


TROUBLES = (_none_left, _dies_before_it_begins)


@pytest.mark.parametrize("trouble", TROUBLES)
def test_a_thread_that_does_not_begin_is_said_to_and_its_work_is_not_done(
    trouble: Callable[..., int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(threads, "start_new_thread", trouble)
    monkeypatch.setattr(threads, "BEGIN_S", 0.01)
    done: list[int] = []
    with pytest.raises(MemoryError, match="no thread could be begun for the reader"):
        BegunThread(lambda: done.append(1), "the reader").begin()
    assert not done


def test_a_thread_that_begins_late_finds_its_work_in_other_hands(monkeypatch: pytest.MonkeyPatch) -> None:
    late: list[Callable[[], None]] = []
    monkeypatch.setattr(threads, "start_new_thread", lambda run, _: late.append(run))
    done: list[int] = []
    assert at_once([lambda: done.append(1)], PATIENCE_S, "a stop") == [True]
    late[0]()
    assert done == [1]


@pytest.mark.parametrize("trouble", TROUBLES)
def test_work_for_which_no_thread_can_be_had_is_done_in_order_here(
    trouble: Callable[..., int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(threads, "start_new_thread", trouble)
    done: list[tuple[int, int]] = []

    def fails() -> None:
        raise MemoryError

    works = [lambda number=number: done.append((number, threading.get_ident())) for number in range(3)]
    assert at_once([works[0], fails, *works[1:]], PATIENCE_S, "a stop") == [True, False, True, True]
    assert done == [(number, threading.get_ident()) for number in range(3)]


def test_work_that_hangs_keeps_no_other_from_being_done_and_is_not_done() -> None:
    ends, done = threading.Event(), threading.Event()
    assert at_once([lambda: ends.wait(PATIENCE_S), done.set], 0.05, "a stop") == [False, True]
    ends.set()
