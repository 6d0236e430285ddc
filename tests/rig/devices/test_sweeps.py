"""Servos that cross their range at a rate: whole units of the controller's speed, and what the body really does.

Source of the unit: Pololu Maestro user's guide, 0.25 µs per 10 ms.
"""

import pytest
from motion_bench import MotionBench, motion_bench, settings_of

from rig.abilities.rates import measured_rate
from rig.errors import RequestRefused

UNIT_DPS = 0.25 / 0.01 * 360.0 / 2000.0  # 25 µs/s on a servo of 2000 µs for 360°: 4.5 deg/s


def _bench() -> MotionBench:
    bench = motion_bench("maestro", speed_dps=40.0)
    bench.home_all()
    return bench


@pytest.mark.parametrize(("asked_dps", "units"), [(4.5, 1), (9.0, 2), (10.0, 2), (27.5, 6)])
def test_the_servo_turns_at_the_whole_units_below(asked_dps: float, units: int) -> None:
    bench = _bench()
    bench.pitch.start_sweep(90.0, asked_dps)
    bench.clock.sleep(0.5)
    first, true_deg = bench.pitch.turn_look(bench.clock), bench.true_deg
    bench.clock.sleep(2.0)
    measured = measured_rate(first, bench.pitch.turn_look(bench.clock))
    assert measured.rate_dps == pytest.approx((bench.true_deg - true_deg) / 2.0, abs=0.05)  # of its steps
    assert measured.rate_dps == pytest.approx(units * UNIT_DPS, abs=0.05)


def test_a_move_is_no_faster_than_its_speed() -> None:
    bench = motion_bench("maestro", speed_dps=10.0)
    bench.home_all()
    bench.pitch.start_move(90.0)
    bench.clock.sleep(0.5)
    begun_deg = bench.true_deg
    bench.clock.sleep(4.0)
    assert bench.true_deg - begun_deg == pytest.approx(4.0 * 2 * UNIT_DPS, abs=0.2)  # 2 units are 9, 3 would be 13.5


def test_after_a_sweep_a_move_has_its_own_speed_again() -> None:
    bench = _bench()
    bench.pitch.start_sweep(20.0, 4.5)
    bench.clock.sleep(10.0)
    bench.pitch.start_move(-20.0)
    bench.clock.sleep(40.0 / (8 * UNIT_DPS) + 0.2)
    assert not bench.pitch.state().is_moving


@pytest.mark.parametrize(
    ("rate_dps", "expected"),
    [
        (4.0, r"one unit of the servo's speed is 4\.5 °/s; nothing moved"),
        (41.0, r"allowed up to 40 °/s"),
        (0.0, r"and not 0"),
        (float("nan"), r"allowed up to 40 °/s"),
    ],
)
def test_what_the_controller_cannot_be_set_to_is_refused(rate_dps: float, expected: str) -> None:
    bench = _bench()
    with pytest.raises(RequestRefused, match=expected):
        bench.pitch.start_sweep(90.0, rate_dps)
    with pytest.raises(RequestRefused, match=expected):  # the plan knows it before any port is opened
        settings_of("maestro", speed_dps=40.0)["pitch"].refuse_rate("pitch", rate_dps)
    assert not bench.pitch.state().is_moving


def test_a_sweep_beyond_the_limits_is_refused() -> None:
    with pytest.raises(RequestRefused, match="181"):
        _bench().pitch.start_sweep(181.0, 9.0)


@pytest.mark.parametrize(
    ("driver", "turning"),
    [("maestro", "sweeps"), ("zaber", "revolves"), ("oriental-az", "revolves"), ("esp301", "no"), ("manual", "no")],
)
def test_the_rig_file_says_which_axes_turn(driver: str, turning: str) -> None:
    assert settings_of(driver)["pitch"].turning == turning


def test_an_axis_that_only_goes_to_positions_refuses_every_rate() -> None:
    with pytest.raises(RequestRefused, match="only goes to positions; nothing moved"):
        settings_of("esp301")["pitch"].refuse_rate("pitch", 10.0)
