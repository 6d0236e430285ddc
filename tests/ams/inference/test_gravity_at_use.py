"""A set used at another g: outputs of the equation at so much more force become the angles that made them."""

import numpy as np
import pytest
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, accelerometer_v
from line_sets import triad_set
from solved_sets import SITE, bent_set, gyro_set, package_set, tp_set

from ams.attitude import flag_codes
from ams.errors import OutsideValidity
from ams.frames import specific_force
from ams.inference.inference import Inference, Package
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import predicted_v

SITE_MPS2 = SITE["gravity_mps2"] * 1.003  # type: ignore[operator]
PITCH_DEG, ROLL_DEG = np.array([-35.0, 10.0, 60.0]), np.array([-120.0, 15.0, 40.0])


def angles_of(coefficients: CoefficientSet, axes: str, site_mps2: float | None) -> dict[str, np.ndarray]:
    """Infer what the set's own equation gives at 1.003 times the force of its calibration."""
    force = 1.003 * specific_force(np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG))
    readings = {f"{axis}_v": predicted_v(coefficients.axes[axis], force, None) for axis in axes}
    package = Package(coefficients, {axis: f"{axis}_v" for axis in axes}, site_mps2)
    return dict(Inference(package, reading_sd_v=1e-5).answer({**readings, "roll_deg": ROLL_DEG}).columns)


@pytest.mark.parametrize(("make", "axes"), [(tp_set, "xyz"), (tp_set, "x"), (bent_set, "xyz")])
def test_angles_at_another_site_are_those_that_made_the_outputs(make: object, axes: str) -> None:
    coefficients = make()  # type: ignore[operator]
    found = angles_of(coefficients, axes, SITE_MPS2)
    assert found["pitch_deg"] == pytest.approx(PITCH_DEG, abs=1e-9)
    if len(axes) > 1:
        assert found["roll_deg"] == pytest.approx(ROLL_DEG, abs=1e-9)


@pytest.mark.parametrize(("axes", "is_bent"), [("x", True), ("xy", True), ("xyz", False)])
def test_what_the_gravity_of_the_calibration_is_wrong_by_turns_one_axis_and_no_three(axes: str, is_bent: bool) -> None:
    """A part δ of every k turns the pitch of one axis by δ tan(pitch), and the direction of three by nothing.

    By next to nothing: a length that is not g is shared among axes whose sensitivities differ by a percent.
    """
    relative = 1e-3
    u_mps2 = relative * SITE["gravity_mps2"]  # type: ignore[operator]
    wrong = tp_set(gravity_uncertainty_mps2=u_mps2)
    force = 1.003 * specific_force(np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG))
    readings = {f"{axis}_v": predicted_v(wrong.axes[axis], force, None) for axis in axes} | {"roll_deg": ROLL_DEG}

    def sd_deg(site_mps2: float | None) -> np.ndarray:
        package = Package(wrong, {axis: f"{axis}_v" for axis in axes}, site_mps2)
        return np.array(Inference(package, reading_sd_v=1e-9).answer(readings).columns["pitch_sd_deg"])

    tangent_deg = np.rad2deg(relative * np.abs(np.tan(np.deg2rad(PITCH_DEG))))
    if axes == "x":
        assert sd_deg(SITE_MPS2) == pytest.approx(tangent_deg, rel=0.05)
    else:
        assert (sd_deg(SITE_MPS2).max() > 0.2 * tangent_deg.max()) == is_bent
    if not is_bent:
        assert sd_deg(SITE_MPS2).max() < 1e-3 * tangent_deg.max()
    assert sd_deg(None).max() < 1e-6, "at the gravity of the calibration no angle depends on it"


def test_one_axis_is_off_by_the_tangent_where_the_site_is_not_told() -> None:
    off_deg = angles_of(tp_set(), "x", None)["pitch_deg"] - PITCH_DEG
    assert off_deg == pytest.approx(np.rad2deg(0.003 * np.tan(np.deg2rad(PITCH_DEG))), rel=0.05)


def test_what_knows_no_g_and_what_is_no_g_of_the_earth_is_refused() -> None:
    for coefficients in (gyro_set(), triad_set()):
        with pytest.raises(OutsideValidity, match="gravity at use: belongs to accelerometers"):
            Package(coefficients, {"x": "x_v"}, 9.81)
    with pytest.raises(OutsideValidity, match=r"got 1\.62 m/s², allowed 9\.7 to 9\.9"):
        Package(tp_set(), {"x": "x_v"}, 1.62)


@pytest.mark.parametrize(("axes", "is_bent"), [("x", True), ("xy", True), ("xyz", False)])
def test_what_the_gravity_at_use_is_wrong_by_turns_one_axis_and_no_three(axes: str, is_bent: bool) -> None:
    """As that of the calibration does, whose own is not declared here."""
    relative, sound = 1e-3, tp_set()
    force = 1.003 * specific_force(np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG))
    readings = {f"{axis}_v": predicted_v(sound.axes[axis], force, None) for axis in axes} | {"roll_deg": ROLL_DEG}

    def sd_deg(u_mps2: float | None) -> np.ndarray:
        columns = {axis: f"{axis}_v" for axis in axes}
        package = Package(sound, columns, SITE_MPS2, site_gravity_uncertainty_mps2=u_mps2)
        return np.array(Inference(package, reading_sd_v=1e-9).answer(readings).columns["pitch_sd_deg"])

    alone_deg = np.sqrt(np.maximum(sd_deg(relative * SITE_MPS2) ** 2 - sd_deg(None) ** 2, 0.0))
    tangent_deg = np.rad2deg(relative * np.abs(np.tan(np.deg2rad(PITCH_DEG))))
    if axes == "x":
        assert alone_deg == pytest.approx(tangent_deg, rel=0.05)
    assert (alone_deg.max() > 0.2 * tangent_deg.max()) == is_bent
    assert sd_deg(0.0) == pytest.approx(sd_deg(None), rel=1e-12)


def test_an_uncertainty_of_no_gravity_at_use_is_refused() -> None:
    with pytest.raises(OutsideValidity, match="uncertainty of gravity at use: got no gravity at use, allowed 0 to"):
        Package(tp_set(), {"x": "x_v"}, site_gravity_uncertainty_mps2=1e-4)
    for wrong in (-1e-4, 1.0, float("nan")):
        with pytest.raises(OutsideValidity, match=r"uncertainty of gravity at use: got .* m/s², allowed 0 to 0\.05"):
            Package(tp_set(), {"x": "x_v"}, 9.81, site_gravity_uncertainty_mps2=wrong)


EULERS_DEG = [(-30.0, 15.0, 20.0), (-12.0, -18.0, -40.0), (20.0, 10.0, 35.0)]


def of_two_packages(
    sting_part: float, model_part: float, u_mps2: float | None = None, reading_sd_v: float = 1e-7
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Infer what explicit rotations give where g is so many parts more than is stated; return angles and flags."""
    readings = {}
    for prefix, package, table, part in (
        ("", "sting", TABLE_3_STING, sting_part),
        ("model_", "model", TABLE_3_MODEL, model_part),
    ):
        for axis, truth in table.items():
            read = np.array([accelerometer_v(axis, truth, euler, package) for euler in EULERS_DEG])
            readings[f"{prefix}{axis}_v"] = truth[0] + (read - truth[0]) * SITE_MPS2 / SITE["gravity_mps2"] * (
                1.0 + part
            )
    pair = [
        Package(package_set(name), {a: f"{prefix}{a}_v" for a in "xyz"}, SITE_MPS2, None, u_mps2)
        for prefix, name in (("", "sting"), ("model_", "model"))
    ]
    found = Inference(*pair, reading_sd_v=reading_sd_v).answer(readings)
    return dict(found.columns), (found.codes & flag_codes.REDUNDANCY) != 0


def test_two_packages_at_one_place_are_wrong_by_one_gravity() -> None:
    """What both are wrong by alike is judged as one error, and by opposite parts of it they cannot be wrong at all."""
    part = 1e-3
    assert not of_two_packages(2.9 * part, 2.9 * part, part * SITE_MPS2)[1].any()
    assert of_two_packages(4.2 * part, 4.2 * part, part * SITE_MPS2)[1].all()
    assert of_two_packages(0.5 * part, -0.5 * part, part * SITE_MPS2)[1].all()


def test_angles_of_two_packages_count_what_one_gravity_turns_them_by() -> None:
    part = 1e-3
    turned, _ = of_two_packages(part, part)
    straight, _ = of_two_packages(0.0, 0.0)
    counted, _ = of_two_packages(0.0, 0.0, part * SITE_MPS2)
    for angle in ("pitch", "yaw", "roll"):
        by_gravity_deg = np.sqrt(np.maximum(counted[f"{angle}_sd_deg"] ** 2 - straight[f"{angle}_sd_deg"] ** 2, 0.0))
        moved_deg = np.abs(turned[f"{angle}_deg"] - straight[f"{angle}_deg"])
        assert by_gravity_deg == pytest.approx(moved_deg, rel=0.02, abs=2e-6)
        assert moved_deg.max() > 1e-5
