"""The axis at fault is named over many rows, by what physics gives it to say, and a good one never is."""

from collections import Counter

import pytest
from judged_packages import judged
from physics_scenes import SCENES

from ams.inference.watch.faulty_axis import Cause

OF_ONE_AXIS = {
    "use-dead-axis": (1e-4, 1.0),
    "use-shifted-offset": (10.0, 300.0),
    "use-clipped-z": (5.0,),
    "use-stuck-axis": (0.1, 0.9),
    "use-reversed": (1.0,),
}
"""Scenes with the sizes that nobody could miss."""
OF_NO_AXIS = ("use-good", "use-all-high", "use-site-gravity", "use-swapped", "use-noisy-axis", "use-acceleration")
FEW = 2


def _suspects(flags: tuple[str, ...]) -> set[int]:
    """Return the axes that rows name."""
    return {"xyz".index(flag.partition("suspect ")[2][0]) for flag in flags if "suspect" in flag}


def _assert_only_the_true_axis(scene: str, size: float, sets: int, seed: int) -> Counter[Cause]:
    causes: Counter[Cause] = Counter()
    for axis, judgement, flags in judged(scene, size, sets, seed):
        causes[judgement.cause] += 1
        assert judgement.axis in (None, axis), (scene, size, judgement)
        assert _suspects(flags) <= {axis}, (scene, size)
    return causes


@pytest.mark.parametrize(("scene", "size"), [(scene, size) for scene, sizes in OF_ONE_AXIS.items() for size in sizes])
def test_one_axis_at_fault_is_named(scene: str, size: float) -> None:
    assert _assert_only_the_true_axis(scene, size, FEW, seed=11)[Cause.AXIS] == FEW


@pytest.mark.parametrize("scene", OF_NO_AXIS)
def test_no_axis_is_named_where_none_is_at_fault(scene: str) -> None:
    causes = _assert_only_the_true_axis(scene, SCENES[scene].sizes[-1], FEW, seed=12)
    told = {"use-good": Cause.NOTHING, "use-all-high": Cause.ALIKE, "use-site-gravity": Cause.ALIKE}
    assert causes[told.get(scene, Cause.UNEXPLAINED)] == FEW


@pytest.mark.thorough
@pytest.mark.parametrize("scene", [*OF_ONE_AXIS, *OF_NO_AXIS])
def test_a_good_axis_is_named_at_no_size(scene: str) -> None:
    for size in SCENES[scene].sizes:
        _assert_only_the_true_axis(scene, size, 10, seed=13)


@pytest.mark.soak
def test_no_axis_of_two_thousand_good_packages_is_named() -> None:
    causes = sum((_assert_only_the_true_axis("use-good", 0.0, 200, 100 + part) for part in range(10)), Counter())
    assert sum(causes.values()) == 2000
    assert causes[Cause.NOTHING] >= 1998


@pytest.mark.parametrize(("size", "gain"), [(0.03, 0.97), (0.3, 0.7)])
def test_the_gain_is_told_with_the_axis(size: float, gain: float) -> None:
    for _, judgement, _ in judged("use-dead-axis", size, FEW, seed=14):
        fault = judgement.possible[0]
        assert not fault.standing
        assert abs(fault.gain - gain) < 5.0 * fault.gain_sd
        assert fault.gain_sd < 1e-4


def test_rows_of_at_rest_name_no_axis() -> None:
    for _, judgement, flags in judged("use-dead-axis", 0.1, FEW, seed=15, at_rest=True):
        assert any(flags)
        assert judgement.cause is Cause.UNMOVED
        assert judgement.axis is None


def test_attitudes_that_cannot_part_two_causes_name_none() -> None:
    """Within a degree of level z alone tells the length: its gain and that of all outputs are one."""
    for axis, judgement, flags in judged("use-all-high", 2.0, FEW, seed=16, near_level=True):
        assert axis == -1
        assert judgement.cause is Cause.SEVERAL
        assert {one.axis for one in judgement.possible} >= {2, None}
        assert not _suspects(flags)
