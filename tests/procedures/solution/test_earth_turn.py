"""The Earth's rotation in the calibration of gyros: taken off where the table's place is known, budgeted where not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from motion_runs import motion_run
from small_run import bench

from ams.frames import body_rates_rad_s
from ams.observations import Observations
from procedures.errors import PlanError
from procedures.kinds.expected_attitudes import forecast_of_design
from procedures.kinds.read import read_procedure
from procedures.kinds.solve import solve_record
from procedures.plan.steps import Turn
from procedures.solution.earth_turn import earth_errors, mean_rotations, with_turned_earth
from rig.description.rig_file import RigDescription

EARTH_RAD_S = 7.292115e-5
"""WGS 84."""
OFFSETS_V = {"x": 0.051, "y": 0.052, "z": 0.053}
SENSITIVITIES = {"x": 1.25, "y": 1.26, "z": 1.27}


def rig_at(latitude_deg: float | None, heading_deg: float | None) -> RigDescription:
    location = {"name": "a", "gravity_mps2": 9.81, "latitude_deg": latitude_deg, "heading_deg": heading_deg}
    sensor = {"model": "single-axis package", "measures": "rate", "channels": {"x": "s.x"}}
    return RigDescription.model_construct(
        rig=RigDescription.model_fields["rig"].annotation.model_validate(location), axes={},
        sensors={"G": RigDescription.model_fields["sensors"].annotation.__args__[1].model_validate(sensor)},
    )  # fmt: skip


def rates_seen(rig: RigDescription, pitch_deg: float, roll_deg: float, turned: np.ndarray | None = None) -> np.ndarray:
    """What a package at rest senses, rad/s along its axes."""
    entry = np.zeros(1)
    rows = Observations(
        np.ones(1, dtype=int), np.ones(1, dtype=int), entry + np.deg2rad(pitch_deg), entry + np.deg2rad(roll_deg),
        {"x": entry}, euler_rate_rad_s=np.zeros((1, 3)),
    )  # fmt: skip
    found = with_turned_earth(rows, rig, rig.sensors["G"], turned)
    return body_rates_rad_s(np.stack([rows.pitch_rad, entry, rows.roll_rad], axis=-1), found.euler_rate_rad_s)[0]


@pytest.mark.parametrize(
    ("latitude_deg", "heading_deg", "pitch_deg", "roll_deg", "along"),
    [
        (90.0, 0.0, 0.0, 0.0, (0.0, 0.0, -1.0)),  # at the pole the ground turns about the vertical, up
        (90.0, 0.0, 0.0, 180.0, (0.0, 0.0, 1.0)),
        (90.0, 77.0, 0.0, 90.0, (0.0, -1.0, 0.0)),  # right wing down: y is down
        (0.0, 0.0, 0.0, 0.0, (1.0, 0.0, 0.0)),  # at the equator it lies along north
        (0.0, 90.0, 0.0, 0.0, (0.0, -1.0, 0.0)),  # looking east, north is to the left
        (0.0, 0.0, 90.0, 0.0, (0.0, 0.0, 1.0)),  # nose up: z, which was down, looks north
        (30.0, 0.0, 0.0, 0.0, (0.75**0.5, 0.0, -0.5)),
    ],
)
def test_a_package_at_rest_senses_its_share_of_the_earth(
    latitude_deg: float, heading_deg: float, pitch_deg: float, roll_deg: float, along: tuple[float, float, float]
) -> None:
    found = rates_seen(rig_at(latitude_deg, heading_deg), pitch_deg, roll_deg)
    np.testing.assert_allclose(found / EARTH_RAD_S, along, atol=1e-7)


def test_without_heading_the_vertical_part_is_known_and_without_latitude_nothing() -> None:
    np.testing.assert_allclose(rates_seen(rig_at(30.0, None), 0, 0) / EARTH_RAD_S, (0, 0, -0.5), atol=1e-7)
    np.testing.assert_array_equal(rates_seen(rig_at(None, None), 0, 0), np.zeros(3))


def test_over_whole_turns_only_what_lies_along_the_turning_axis_is_left_and_over_a_sweep_its_mean() -> None:
    at = {name: np.zeros(2) for name in ("pitch", "yaw", "roll")}
    turn = Turn("roll", 40.0, 9.0, 1, None, 0, 0.01)
    sweep = replace(turn, turned_axis="pitch", revolutions=0, sweep_deg=(-60.0, 60.0), sweeps=1)
    plan = SimpleNamespace(dwells=[SimpleNamespace(step=1, motion=turn), SimpleNamespace(step=2, motion=sweep)])
    whole, part = mean_rotations((SimpleNamespace(step=1), SimpleNamespace(step=2)), plan, at)  # type: ignore[arg-type]
    np.testing.assert_allclose(whole, np.diag([1.0, 0.0, 0.0]), atol=1e-15)
    mean_cosine = np.sin(np.pi / 3) / (np.pi / 3)
    np.testing.assert_allclose(part, np.diag([mean_cosine, 1.0, mean_cosine]), atol=1e-4)


def test_what_is_not_known_of_it_is_a_vector_of_its_length() -> None:
    """The squares of the standard uncertainties add up to its square: 15.041 °/h, ω cos φ on the level."""
    for rig, length in ((rig_at(None, None), 1.0), (rig_at(60.0, None), 0.5)):
        (error,) = earth_errors(rig, rig.sensors["G"])
        assert len(error.columns) * error.standard_uncertainty**2 == pytest.approx((length * 15.041067 / 3600) ** 2)
    known = rig_at(60.0, 10.0)
    assert not list(earth_errors(known, known.sensors["G"]))


@pytest.mark.thorough
def test_a_rate_table_on_the_turning_earth_gives_the_gyros_own_offset(tmp_path) -> None:
    """0.0042 °/s are 5 mV, a hundred times the noise; with it taken off CR table 4's offsets come back."""
    location = {"gravity_mps2 = 9.80665": "gravity_mps2 = 9.80665\nlatitude_deg = 45.5\nheading_deg = 30.0"}
    turning = {r"\[twin\]\n": "[twin.base]\nearth = [45.5, 30.0]\n[twin]\n"}
    faster = {r"replications = 4": "replications = 2", r"\[10.0, 40.0\]": "[90.0]", r"dwell_s = \S+": "dwell_s = 4.0"}
    run = motion_run(tmp_path, "rate-table", "rates", faster, {**location, **turning}).solved()
    text = run.sensors["ENC03J"]
    assert "latitude 45.5°, heading of the table 30°" in " ".join(text.calibration.remarks)
    rig = run.record.rig
    silent = rig.model_copy(update={"rig": rig.rig.model_copy(update={"latitude_deg": None, "heading_deg": None})})
    untold = solve_record(replace(run.record, rig=silent))["ENC03J"]
    for axis, truth in OFFSETS_V.items():
        known, unknown = (entry.calibration.axes[axis].parameters[0] for entry in (text, untold))
        earth_v = SENSITIVITIES[axis] * np.rad2deg(EARTH_RAD_S)
        assert abs(known.value - truth) < 0.05 * earth_v
        assert known.standard_uncertainty < 0.1 * earth_v
        assert unknown.interval_95[0] < truth < unknown.interval_95[1]
        assert unknown.standard_uncertainty > 3.0 * known.standard_uncertainty
        line = next(line for line in untold.budgets[axis].lines if line.source == "Earth's rotation")
        assert line.type == "B"
        assert line.contributions["offset_v"] > known.standard_uncertainty
        assert not any(line.source == "Earth's rotation" for line in text.budgets[axis].lines)


def test_a_gravity_of_another_place_is_refused_and_a_doubtful_one_is_told(tmp_path) -> None:
    location = ("gravity_mps2 = 9.80665", "gravity_mps2 = 9.80665\nlatitude_deg = 0.0\nheight_m = 0.0")
    with pytest.raises(PlanError, match=r"rig\.gravity_mps2: gravity is stated as 9\.80665.*0\.0263 m/s² more"):
        bench(tmp_path, (location,))
    made = bench(tmp_path, ((location[0], location[1].replace("latitude_deg = 0.0", "latitude_deg = 42.0")),))
    forecast = forecast_of_design(made.rig, read_procedure(tmp_path / "procedure.toml"), made.plan, [])
    (sentence,) = [reservation for reservation in forecast.reservations if "gravity" in reservation]
    assert "0.0032 m/s² more, allowed 0.0015" in sentence
