"""Laws of the twins' world, against attitudes worked out by hand. Sources: TP (2), (4), (5) and the design's signs."""

import math
from typing import Any

import numpy as np
import pytest
from table_bench import example_rig

from rig.description.rig_file import AxisTruth, AxisTwin, Mount, RigDescription, TwinBase, TwinEnvironment
from rig.twins.physics.geometry import about_x, about_y, about_z, sensitive_direction
from rig.twins.physics.world import World

S = 2.5
IDEAL = AxisTruth(offset_v=0.0, sensitivity_v_per_g=S)
ARCSEC_RAD = math.pi / 648000
NO_ERROR = {"pitch": AxisTwin(index_error_arcsec=0.0), "roll": AxisTwin(index_error_arcsec=0.0)}


def _described(truth: AxisTruth | dict[str, AxisTruth] = IDEAL, **twin: Any) -> RigDescription:
    rig = example_rig()
    assert rig.twin is not None
    truths = truth if isinstance(truth, dict) else dict.fromkeys("xyz", truth)
    update = {"truth": {"SN1047": truths}, "axes": NO_ERROR, **twin}
    return rig.model_copy(update={"twin": rig.twin.model_copy(update=update)})


def _at(description: RigDescription, pitch_deg: float, roll_deg: float) -> World:
    world = World(description)
    world.rotate("pitch", pitch_deg, 0.0)
    world.rotate("roll", roll_deg, 0.0)
    return world


def _outputs(world: World, now_s: float = 1e6) -> list[float]:
    return [world.mean_v(f"dmm.{axis}", now_s) for axis in "xyz"]


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg", "outputs_v"),
    [
        (0, 0, (0, 0, -S)),  # level gives −S on z
        (90, 0, (S, 0, 0)),  # nose up gives +S on x
        (0, 90, (0, -S, 0)),  # right wing down gives −S on y
        (0, 180, (0, 0, S)),
        (-90, 0, (-S, 0, 0)),
        (30, 0, (S / 2, 0, -S * math.sqrt(3) / 2)),
        (30, 90, (S / 2, -S * math.sqrt(3) / 2, 0)),
    ],
)
def test_attitudes_known_by_heart(pitch_deg: float, roll_deg: float, outputs_v: tuple[float, float, float]) -> None:
    assert _outputs(_at(_described(), pitch_deg, roll_deg)) == pytest.approx(outputs_v, abs=1e-12)


@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(20, 30), (-70, 110), (45, -160), (170, 10)])
def test_misaligned_outputs_follow_the_report(pitch_deg: float, roll_deg: float) -> None:
    b, omega, azimuth = 0.01, math.radians(3.0), math.radians(40.0)
    truth = AxisTruth(offset_v=b, sensitivity_v_per_g=S, coning_deg=3.0, azimuth_deg=40.0)
    a, r = math.radians(pitch_deg), math.radians(roll_deg)
    cos, sin = math.cos, math.sin
    x = b + S * (cos(omega) * sin(a) - sin(omega) * cos(a) * sin(r + azimuth))  # TP (2)
    outputs = _outputs(_at(_described(truth), pitch_deg, roll_deg))
    assert outputs[0] == pytest.approx(x, abs=1e-12)
    f = (sin(a), -cos(a) * sin(r), -cos(a) * cos(r))
    y = b + S * (cos(omega) * f[1] + sin(omega) * (cos(azimuth) * f[2] + sin(azimuth) * f[0]))
    z = b + S * (cos(omega) * f[2] + sin(omega) * (cos(azimuth) * f[0] + sin(azimuth) * f[1]))
    assert outputs[1:] == pytest.approx([y, z], abs=1e-12)


def test_elementary_rotations_turn_the_axes_the_declared_way() -> None:
    forward, right, down = np.eye(3)
    up_45 = about_y(math.pi / 4)  # nose up: forward of the body is forward and up outside
    assert up_45[0] == pytest.approx((forward - down) / math.sqrt(2))
    assert about_x(math.pi / 4)[1] == pytest.approx((right + down) / math.sqrt(2))  # right wing down
    assert about_z(math.pi / 4)[0] == pytest.approx((forward + right) / math.sqrt(2))  # nose right


def test_sensitive_direction_counts_the_azimuth_cyclically() -> None:
    assert sensitive_direction("x", math.pi / 2, 0.0) == pytest.approx([0, 1, 0])
    assert sensitive_direction("y", math.pi / 2, 0.0) == pytest.approx([0, 0, 1])
    assert sensitive_direction("z", math.pi / 2, 0.0) == pytest.approx([1, 0, 0])
    assert sensitive_direction("z", math.pi / 2, math.pi / 2) == pytest.approx([0, 1, 0])


def _pitch_seen_arcsec(world: World) -> float:
    """At level, 1 arc second of pitch is 1 arc second on x."""
    return world.mean_v("dmm.x", 1e6) / S / ARCSEC_RAD


def _roll_seen_arcsec(world: World) -> float:
    return -world.mean_v("dmm.y", 1e6) / S / ARCSEC_RAD


def test_base_tilt_droop_and_zero_error_are_seen_at_level() -> None:
    assert _pitch_seen_arcsec(_at(_described(base=TwinBase(tilt_about_pitch_arcsec=7.0)), 0, 0)) == pytest.approx(7.0)
    assert _roll_seen_arcsec(_at(_described(base=TwinBase(tilt_about_roll_arcsec=5.0)), 0, 0)) == pytest.approx(5.0)
    assert _pitch_seen_arcsec(_at(_described(base=TwinBase(droop_arcsec=4.0)), 0, 0)) == pytest.approx(-4.0)
    zero = {**NO_ERROR, "pitch": AxisTwin(index_error_arcsec=0.0, zero_error_arcsec=3.0)}
    assert _pitch_seen_arcsec(_at(_described(axes=zero), 0, 0)) == pytest.approx(3.0)


def test_droop_vanishes_nose_up_and_orthogonality_is_seen_there() -> None:
    rig = _described(base=TwinBase(droop_arcsec=4.0, orthogonality_arcsec=6.0))
    upright = _at(rig, 90, 0)
    assert upright.mean_v("dmm.z", 1e6) == pytest.approx(0.0, abs=1e-12)
    # Nose up, the roll axis off by ε about the body's down leans the force by ε towards −y.
    assert upright.mean_v("dmm.y", 1e6) / S / ARCSEC_RAD == pytest.approx(-6.0)


def test_teeth_are_fixed_bounded_and_the_same_after_a_full_turn() -> None:
    axes = {**NO_ERROR, "pitch": AxisTwin(index_error_arcsec=2.0)}
    world = World(_described(axes=axes))
    seen = []
    for pitch_deg in [*range(-180, 181), *range(-180, 181)]:
        world.rotate("pitch", pitch_deg, 0.0)
        force = world.stage_force_g(1e6)
        angle = math.atan2(force[0], -force[2])
        seen.append(math.remainder(angle - math.radians(pitch_deg), 2 * math.pi) / ARCSEC_RAD)
    assert seen[:361] == pytest.approx(seen[361:], abs=1e-9)
    assert seen[0] == pytest.approx(seen[360], abs=1e-6)  # −180° and 180° are one tooth
    assert max(map(abs, seen)) <= 2.0 + 1e-6
    # Rectangular within ±2: standard deviation 2/√3.
    assert np.std(seen[:360]) == pytest.approx(2.0 / math.sqrt(3.0), rel=0.1)
    assert len({round(error, 6) for error in seen[:360]}) > 300


def test_another_seed_draws_other_teeth() -> None:
    rig = _described(axes={})
    other = rig.model_copy(update={"twin": rig.twin.model_copy(update={"seed": 8})})  # type: ignore[union-attr]
    assert _outputs(_at(rig, 30, 0)) != _outputs(_at(other, 30, 0))


def test_temperature_drift_and_soft_mount_enter_as_declared() -> None:
    truth = AxisTruth(
        offset_v=0.1,
        sensitivity_v_per_g=2.0,
        offset_tc_v_per_degc=1e-3,
        sensitivity_tc_per_degc=1e-4,
        offset_drift_v_per_replication=1e-2,
        sensitivity_drift_per_replication=1e-3,
        q_v_per_g2=(0.01, 0.02, 0.03, 0.04, 0.05),
    )
    rig = _described(truth, environment={"air": TwinEnvironment(temperature_degc=25.0)})
    world = _at(rig, 90, 0)  # f = (1, 0, 0): fᵀQf = Q_xx
    world.announce(3, "read", 0, 2.0)
    expected = 0.1 + 5e-3 + 2e-2 + 2.0 * (1 + 5e-4) * (1 + 2e-3) + 0.01
    assert world.mean_v("dmm.x", 1e6) == pytest.approx(expected, abs=1e-12)
    level = _at(rig, 0, 0)  # f = (0, 0, −1): fᵀQf = Q_zz = −Q_xx − Q_yy
    assert level.mean_v("dmm.x", 1e6) == pytest.approx(0.1 + 5e-3 - 0.05, abs=1e-12)


def test_a_mount_permutes_and_a_new_mounting_turns_a_little() -> None:
    rig = _described()
    sensor = rig.sensors["SN1047"].model_copy(update={"mount": Mount(x="+z", y="+y", z="-x")})
    turned = rig.model_copy(update={"sensors": {"SN1047": sensor}})
    assert _outputs(_at(turned, 0, 0)) == pytest.approx([-S, 0, 0], abs=1e-12)  # body x points along table down
    first = _outputs(_at(_described(base=TwinBase(remount_arcsec=30.0), mounting=1), 0, 0))
    again = _outputs(_at(_described(base=TwinBase(remount_arcsec=30.0), mounting=1), 0, 0))
    second = _outputs(_at(_described(base=TwinBase(remount_arcsec=30.0), mounting=2), 0, 0))
    assert first == again
    assert first != second
    assert abs(first[0]) < S * 30.0 * ARCSEC_RAD * 5


def test_a_reading_at_rest_does_not_depend_on_time() -> None:
    early, late = _at(example_rig(), 30, 20), _at(example_rig(), 30, 20)
    for world in (early, late):
        world.announce(4, "read", 0, 0.5)
    assert [early.read_voltage_v("dmm.x", 100.0 + n) for n in range(40)] == [
        late.read_voltage_v("dmm.x", 9e5 + 7 * n) for n in range(40)
    ]


def test_creep_fades_after_a_move_and_is_over() -> None:
    axes = {**NO_ERROR, "pitch": AxisTwin(index_error_arcsec=0.0, creep_arcsec=10.0, creep_s=2.0)}
    world = World(_described(axes=axes))
    arrival_s = world.rotate("pitch", 5.0, 0.0)
    resting = math.sin(math.radians(5.0)) * S

    def off_arcsec(after_s: float) -> float:
        return (world.mean_v("dmm.x", arrival_s + after_s) - resting) / S / math.cos(math.radians(5.0)) / ARCSEC_RAD

    assert off_arcsec(0.0) == pytest.approx(10.0, rel=1e-3)
    assert off_arcsec(2.0) == pytest.approx(10.0 / math.e, rel=1e-3)
    assert off_arcsec(40.0) == pytest.approx(0.0, abs=1e-9)


def test_motion_takes_its_time() -> None:
    world = World(_described())
    assert world.rotate("pitch", 90.0, 10.0) == pytest.approx(10.0 + 90.0 / 5.0)
    assert world.mean_v("dmm.x", 10.0) == pytest.approx(0.0, abs=1e-12)
    assert world.mean_v("dmm.x", 10.0 + 6.0) == pytest.approx(S * 0.5)  # 30° after 6 s at 5 °/s
    assert world.mean_v("dmm.x", 28.0) == pytest.approx(S)


def test_a_reading_follows_what_changed_since_the_last_one() -> None:
    truth = AxisTruth(offset_v=0.0, sensitivity_v_per_g=S, offset_drift_v_per_replication=0.5)
    world = World(_described(truth))
    world.announce(0, "read", 0, 0.0)
    assert world.read_voltage_v("dmm.x", 0.0) == pytest.approx(0.0, abs=1e-12)
    world.announce(1, "read", 0, 1.0)
    assert world.read_voltage_v("dmm.x", 0.0) == pytest.approx(0.5)  # drift
    world.rotate("pitch", 90.0, 0.0)
    assert world.read_voltage_v("dmm.x", 6.0) == pytest.approx(0.5 + S / 2)  # on the way, at 30°
    assert world.read_voltage_v("dmm.x", 100.0) == pytest.approx(0.5 + S)


def test_noise_has_the_declared_standard_deviation() -> None:
    truth = AxisTruth(offset_v=0.0, sensitivity_v_per_g=S, noise_v=1e-4)
    world = _at(_described(truth), 0, 0)
    readings = []
    for step in range(200):
        world.announce(step, "read", 0, 0.0)
        readings += [world.read_voltage_v("dmm.x", 1e6) for _ in range(10)]
    assert np.std(readings) == pytest.approx(1e-4, rel=0.06)


def test_air_ramps_to_its_setpoint_and_rests_there() -> None:
    world = World(_described())
    world.hold("air", 25.0, 0.0)
    assert world.air["air"].temperature_degc(0.0, 50.0) == pytest.approx(22.5)  # 0.05 °C/s from 20 °C
    assert world.air["air"].temperature_degc(0.0, 1e4) == 25.0
    assert world.setpoint_degc("air") == 25.0


def test_a_stream_has_the_air_of_a_moment_ago_also_when_a_set_point_is_told() -> None:
    world = World(_described())
    world.hold("air", 20.0, 10.0)  # where it stands already
    assert world.air["air"].temperature_degc(0.0, 9.9) == 20.0
    world.hold("air", 25.0, 20.0)
    assert world.air["air"].temperature_degc(0.0, 19.9) == 20.0


def test_a_channel_with_nothing_behind_it_is_a_short() -> None:
    assert World(_described()).read_voltage_v("dmm.unused", 0.0) == 0.0


@pytest.mark.parametrize("sign", [1, -1])
def test_a_scale_is_off_by_its_waves_and_its_list_at_the_angles_of_the_machine(sign: int) -> None:
    """0.6 sin(30° + 40°) + 0.2 sin 60° + (1.0 + 2.0) / 2 arc seconds at the machine's 30°."""
    axes = {
        **NO_ERROR,
        "pitch": AxisTwin(index_harmonics=((1, 0.6, 40.0), (2, 0.2, 0.0)), index_list=((0, 1), (60, 2))),
    }
    rig = _described(axes=axes)
    turned = {**rig.axes, "pitch": rig.axes["pitch"].model_copy(update={"sign": sign})}
    world = World(rig.model_copy(update={"axes": turned}))
    world.rotate("pitch", 30.0, 0.0)
    force = world.stage_force_g(1e6)
    expected = 0.6 * math.sin(math.radians(70.0)) + 0.2 * math.sin(math.radians(60.0)) + 1.5
    off_rad = math.atan2(force[0], -force[2]) - sign * math.radians(30.0)
    assert off_rad / ARCSEC_RAD == pytest.approx(sign * expected, abs=1e-6)
