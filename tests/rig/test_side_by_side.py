"""Laws of work side by side: one runs at a moment, the time is that of the longest, and nobody outlives an error."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from table_bench import virtual_clock

from rig.errors import DeviceFault, WaitEnded
from rig.side_by_side import side_by_side

PAUSES = st.lists(st.floats(0.0, 10.0), max_size=5)


@given(st.dictionaries(st.sampled_from("abcd"), PAUSES))
def test_all_is_done_in_the_time_of_the_longest_and_each_sees_its_own_waits(pauses: dict[str, list[float]]) -> None:
    clock = virtual_clock()
    at_work: list[str] = []

    def work(name: str) -> Callable[[Callable[[float], None]], list[float]]:
        def do(wait: Callable[[float], None]) -> list[float]:
            seen_s = []
            for pause_s in pauses[name]:
                at_work.append(name)
                before_s = clock.monotonic_s()
                assert at_work.pop() == name  # nobody else came between
                wait(pause_s)
                seen_s.append(clock.monotonic_s() - before_s)
            return seen_s

        return do

    found = side_by_side({name: work(name) for name in pauses}, clock, clock.sleep)
    assert list(found) == list(pauses)
    for name, seen_s in found.items():
        assert seen_s == pytest.approx(pauses[name], abs=1e-9)
    assert clock.monotonic_s() == pytest.approx(max(map(sum, pauses.values()), default=0.0), abs=1e-9)


def test_the_first_error_ends_the_waits_of_all_others_and_is_what_is_raised() -> None:
    clock = virtual_clock()
    ended: list[float] = []

    def fails(wait: Callable[[float], None]) -> None:
        wait(3.0)
        raise DeviceFault("lifted")

    def goes_on(wait: Callable[[float], None]) -> None:
        try:
            wait(100.0)
        except WaitEnded:
            ended.append(clock.monotonic_s())
            raise

    with pytest.raises(DeviceFault, match="lifted"):
        side_by_side({"a": goes_on, "b": fails, "c": goes_on}, clock, clock.sleep)
    assert ended == [3.0, 3.0]


def test_a_stop_reaches_every_work_and_none_begins_behind_it() -> None:
    clock = virtual_clock()
    begun: list[str] = []

    def stop(_duration_s: float) -> None:
        raise WaitEnded("stop", "anna")

    def goes_on(name: str) -> Callable[[Callable[[float], None]], None]:
        def do(wait: Callable[[float], None]) -> None:
            begun.append(name)
            wait(1.0)
            begun.append(f"{name} went on")

        return do

    with pytest.raises(WaitEnded, match="stop, asked for by anna"):
        side_by_side({"a": goes_on("a"), "b": goes_on("b")}, clock, stop)
    assert begun == ["a", "b"]
