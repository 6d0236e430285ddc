"""Motions over time: CR's ramp and harmonic profiles, led by rates and measured where they really went."""

import math

import numpy as np
import pytest
from motion_bench import motion_bench

from procedures.plan.profiles import profile_deg, range_deg, top_rate_dps
from procedures.plan.steps import Follow
from procedures.run.dwell.following import _Led as Led
from rig.errors import DeviceFault

AXES = {"pitch": 10.0, "yaw": 10.0, "roll": 10.0}
# CR IV-C: Θ = 10 sin(0.125·2πt), Ψ = 10 sin(0.0625·2πt), Φ = 10 sin(0.25·2πt) deg for 10 s; CR IV-A: 0 to 10° in 10 s.
HARMONIC = Follow("harmonic", 10.0, AXES, {"pitch": 0.125, "yaw": 0.0625, "roll": 0.25}, 0.027, 0.108)
RAMP = Follow("ramp", 10.0, AXES, {}, 0.027, 0.108)


@pytest.mark.parametrize("after_s", [0.0, 0.7, 3.3, 10.0])
def test_the_profiles_are_those_of_the_report(after_s: float) -> None:
    expected = {"pitch": 0.125, "yaw": 0.0625, "roll": 0.25}
    for axis, hz in expected.items():
        assert profile_deg(HARMONIC, axis, after_s) == pytest.approx(10.0 * math.sin(2.0 * math.pi * hz * after_s))
        assert profile_deg(RAMP, axis, after_s) == pytest.approx(after_s)


def test_before_and_behind_a_motion_the_axis_rests() -> None:
    assert profile_deg(HARMONIC, "pitch", -1.0) == 0.0
    assert profile_deg(RAMP, "pitch", 99.0) == 10.0


def test_rates_and_ranges_are_those_of_the_derivative() -> None:
    assert top_rate_dps(HARMONIC, "roll") == pytest.approx(10.0 * 2.0 * math.pi * 0.25)
    assert top_rate_dps(RAMP, "yaw") == 1.0
    assert range_deg(HARMONIC, "roll") == pytest.approx((-10.0, 10.0), abs=1e-4)
    assert range_deg(HARMONIC, "yaw") == pytest.approx((10.0 * math.sin(1.25 * math.pi), 10.0), abs=1e-3)


class _Rig:
    def __init__(self, clock: object) -> None:
        self.clock = clock


def _led(motion: Follow, axis: str) -> tuple[Led, list[float], object]:
    bench = motion_bench("zaber", speed_dps=90.0)
    bench.home_all()
    entry, began_s, off_deg = Led(bench.pitch, 0.0), bench.clock.monotonic_s(), list[float]()
    for update in range(int(motion.seconds / motion.update_s)):
        now_s = update * motion.update_s
        bench.clock.sleep(began_s + now_s - bench.clock.monotonic_s())
        entry.lead(_Rig(bench.clock), lambda at: profile_deg(motion, axis, at), now_s, motion.update_s)  # type: ignore[arg-type]
        off_deg.append(bench.true_deg - profile_deg(motion, axis, now_s))
    bench.pitch.stop()
    return entry, off_deg, bench


@pytest.mark.parametrize(("motion", "axis"), [(HARMONIC, "roll"), (HARMONIC, "pitch"), (RAMP, "pitch")])
def test_an_axis_with_limited_acceleration_catches_up_and_stays(motion: Follow, axis: str) -> None:
    _, off_deg, _ = _led(motion, axis)
    assert max(abs(off) for off in off_deg) < 4.0  # it begins at rest and at once should be at 16 °/s
    assert max(abs(off) for off in off_deg[150:]) < 0.15


def test_what_is_kept_is_where_the_axis_was_not_where_it_should_have_been() -> None:
    entry, off_deg, _ = _led(HARMONIC, "roll")
    looked = np.array([look.angle_deg for look in entry.looks])
    request = np.array([profile_deg(HARMONIC, "roll", index * HARMONIC.update_s) for index in range(looked.size)])
    np.testing.assert_allclose(looked - request, off_deg, atol=3e-4)  # a microstep


def test_an_axis_that_does_not_follow_is_at_fault() -> None:
    fast = Follow("harmonic", 10.0, {"pitch": 40.0}, {"pitch": 1.0}, 0.027, 0.108)
    with pytest.raises(DeviceFault, match=r"pitch: [-+][0-9.]+° off its profile, allowed 5°"):
        _led(fast, "pitch")
