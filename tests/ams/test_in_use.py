"""A set in use: scipy's rotations come back from volts, scalars as scalars, arrays as arrays, by name or in order."""

from pathlib import Path

import numpy as np
import pytest
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, accelerometer_v
from not_usable import set_not_usable
from package_outputs import TRUTH
from scipy.spatial.transform import Rotation
from solved_sets import bent_set, gyro_set, package_set, tp_set

import ams
from ams.errors import OutsideValidity, SetNotUsable
from ams.exports.formats import export_set
from ams.inference.inference import Inference, Package
from ams.sets.coefficients import CoefficientSet


@pytest.fixture(params=["str", "Path"])
def stored(request: pytest.FixtureRequest, tmp_path: Path) -> str | Path:
    path = tmp_path / "tp.json"
    export_set(tp_set(), "json", path)
    return str(path) if request.param == "str" else path


def test_a_scalar_gives_a_scalar_and_an_array_its_shape(stored: str | Path) -> None:
    package = ams.load(stored, reading_sd_v=1e-5)
    assert package.coefficients == ams.load_set(stored)
    table = package.coefficients
    pitch, roll = np.linspace(-60, 60, 6).reshape(2, 3), np.linspace(-170, 170, 6).reshape(2, 3)
    volts = outputs(table, pitch, roll)
    found = package.attitude(volts)
    assert found.pitch_deg.shape == found.codes.shape == (2, 3)
    np.testing.assert_allclose(found.pitch_deg, pitch, atol=1e-9)
    np.testing.assert_allclose(found.roll_deg, roll, atol=1e-9)
    entry = package.attitude(volts[1, 2])
    assert isinstance(entry.pitch_deg, float)
    assert (entry.pitch_deg, entry.roll_deg) == pytest.approx((pitch[1, 2], roll[1, 2]), abs=1e-9)
    assert entry.pitch_sd_deg > 0
    assert entry.is_good
    assert entry.flags == ("",)
    by_name = package.attitude(dict(zip("zyx", volts[0, 1, ::-1].tolist(), strict=True)))
    assert by_name.pitch_deg == pytest.approx(pitch[0, 1], abs=1e-9)


def test_a_set_that_is_not_usable_warns_once_where_it_is_loaded_and_answers(tmp_path: Path) -> None:
    export_set(set_not_usable(), "json", tmp_path / "s.json")
    with pytest.warns(SetNotUsable) as told:
        package = ams.load(tmp_path / "s.json", reading_sd_v=1e-5)
    (warning,) = told
    ground = "not usable: the stated uncertainties do not hold what the data show (x: cubic)"
    assert str(warning.message) == f"SN1047: verdict of the calibration: {ground}"
    assert warning.filename == __file__, "it names the line that loads"
    volts = outputs(package.coefficients, np.array([20.0]), np.array([30.0]))
    assert np.isfinite(package.attitude(volts).pitch_deg).all()


def outputs(coefficients: CoefficientSet, pitch_deg: np.ndarray, roll_deg: np.ndarray) -> np.ndarray:
    """Return what the set itself says that the axes read, the force by scipy's rotations."""
    turn = Rotation.from_euler("YX", np.stack([np.ravel(pitch_deg), np.ravel(roll_deg)], axis=-1), degrees=True)
    force = -turn.inv().apply([0.0, 0.0, 1.0])
    columns = [n.primary["offset_v"] + force @ n.direction_v_per_g for n in coefficients.axes.values()]
    return np.stack(columns, axis=-1).reshape(*np.shape(pitch_deg), len(columns))


def test_what_is_wrong_is_flagged_and_never_a_plausible_angle(stored: str | Path) -> None:
    package = ams.load(stored, reading_sd_v=1e-5)
    volts = outputs(package.coefficients, np.full(5, 20.0), np.full(5, 30.0))
    volts[1, 0] = np.nan
    volts[2, 1] = np.inf
    volts[3, 1] = package.coefficients.axes["y"].primary["offset_v"]
    stream = ams.PackageStream(package)
    found = stream.feed(volts)
    assert found.flags == (
        "", "reading missing or not a number", "reading missing or not a number", "redundancy: suspect y", ""
    )  # fmt: skip
    assert np.isnan(found.pitch_deg).tolist() == [False, True, True, False, False]
    assert np.isnan(found.pitch_sd_deg).tolist() == [False, True, True, False, False]
    stream.feed(volts[0])
    assert (stream.rows, stream.lost, stream.flagged) == (6, 2, 3)


def test_two_packages_give_yaw_too_and_a_missing_reading_spoils_its_row_alone(tmp_path: Path) -> None:
    for name in ("sting", "model"):
        export_set(package_set(name), "json", tmp_path / f"{name}.json")
    package = ams.load(tmp_path / "sting.json", tmp_path / "model.json", reading_sd_v=1e-6)
    assert package.axes == ("x", "y", "z", "model x", "model y", "model z")
    eulers = [(20.0, -15.0, -30.0), (-35.0, 10.0, 40.0)]
    truths = {"sting": TABLE_3_STING, "model": TABLE_3_MODEL}
    volts = np.array([[accelerometer_v(a, t[a], e, name) for name, t in truths.items() for a in "xyz"] for e in eulers])
    volts = np.insert(volts, 1, np.nan, axis=0)
    found = package.attitude(volts)
    assert found.yaw_deg is not None
    np.testing.assert_allclose(found.yaw_deg, [-15.0, np.nan, 10.0], atol=1e-7)
    np.testing.assert_allclose(found.roll_deg, [-30.0, np.nan, 40.0], atol=1e-7)
    assert found.flags[1] == "reading missing or not a number"


def test_many_rows_of_a_bent_package_are_what_one_at_a_time_is(tmp_path: Path) -> None:
    """The polynomials of the block kernels beside the way of every sensor asked at every row."""
    coefficients = bent_set(5e-3)
    chance = np.random.default_rng(2)
    pitch, roll = chance.uniform(-85, 85, 3000), chance.uniform(-180, 180, 3000)
    volts = outputs(coefficients, pitch, roll)
    turn = Rotation.from_euler("YX", np.stack([pitch, roll], axis=-1), degrees=True)
    force = -turn.inv().apply([0.0, 0.0, 1.0])
    volts += np.stack([numbers.terms_v(force) for numbers in coefficients.axes.values()], axis=-1)
    export_set(coefficients, "json", tmp_path / "bent.json")
    found = ams.load(tmp_path / "bent.json", reading_sd_v=1e-5).attitude(volts)
    np.testing.assert_allclose(found.pitch_deg, pitch, atol=1e-8)
    np.testing.assert_allclose(found.roll_deg, roll, atol=1e-7)
    each = Inference(Package(coefficients, dict(zip("xyz", "xyz", strict=True))), reading_sd_v=1e-5, intervals=True)
    noisy = volts[:200] + 1e-5 * chance.normal(size=(200, 3))
    slow = each.answer(dict(zip("xyz", noisy.T, strict=True)))
    quick = ams.load(tmp_path / "bent.json", reading_sd_v=1e-5).attitude(noisy)
    for name in ("pitch_deg", "roll_deg", "pitch_sd_deg", "roll_sd_deg"):
        np.testing.assert_allclose(getattr(quick, name), slow.columns[name], rtol=1e-10, err_msg=name)


def test_what_cannot_be_answered_is_a_sentence(stored: str | Path, tmp_path: Path) -> None:
    package = ams.load(stored)
    with pytest.raises(OutsideValidity, match=r"shape \(2,\), needed \(…, 3\) in the order x, y, z"):
        package.attitude([1.0, 2.0])
    with pytest.raises(OutsideValidity, match="got the axes x, y, needed are x, y, z"):
        package.attitude({"x": 1.0, "y": 2.0})
    export_set(tp_set("x"), "json", tmp_path / "x.json")
    single = ams.load(tmp_path / "x.json")
    with pytest.raises(OutsideValidity, match="roll_deg missing"):
        single.attitude([1.0])
    assert single.attitude([TRUTH["x"][0]], roll_deg=0.0).pitch_deg == pytest.approx(0.0, abs=1.0)
    export_set(gyro_set(), "json", tmp_path / "g.json")
    with pytest.raises(OutsideValidity, match="gyros sense rates"):
        ams.load(tmp_path / "g.json")


def test_gyros_come_as_a_stream_alone_and_with_accelerometers(tmp_path: Path) -> None:
    """A steady roll of 5 °/s, for which the closed form needs no integral."""
    export_set(gyro_set(), "json", tmp_path / "g.json")
    export_set(tp_set(), "json", tmp_path / "f.json")
    roll = 0.05 * np.arange(400)
    rates = np.tile([5.0, 0.0, 0.0], (400, 1))
    gyro_v = np.stack([n.primary["offset_v"] + rates @ n.direction for n in gyro_set().axes.values()], axis=-1)
    alone = ams.load_gyros(str(tmp_path / "g.json"), ams.Motion(100.0), reading_sd_v=1e-6)
    assert alone.axes == ("x", "y", "z")
    parts = [alone.feed(gyro_v[:150]), alone.feed(gyro_v[150:151]), alone.feed(gyro_v[151:]), alone.finish()]
    np.testing.assert_allclose(np.concatenate([part.roll_deg for part in parts]), roll, atol=1e-9)
    assert np.all(np.diff(np.concatenate([part.roll_sd_deg for part in parts])) > 0.0)
    volts = np.concatenate([gyro_v, outputs(tp_set(), np.zeros(400), roll)], axis=1)
    both = ams.load_gyros(tmp_path / "g.json", ams.Motion(100.0), accelerometers=tmp_path / "f.json", reading_sd_v=1e-4)
    assert both.axes[3:] == ("accelerometer x", "accelerometer y", "accelerometer z")
    np.testing.assert_allclose(both.feed(volts).roll_deg, roll, atol=1e-3)
    with pytest.raises(OutsideValidity, match=r"needed \(…, 3\) in the order x, y, z"):
        alone.feed(volts)


def test_a_set_is_printed_as_one_line_that_says_which_it_is(stored: str | Path) -> None:
    package = ams.load(stored)
    text = repr(package)
    assert "\n" not in text
    assert f"CoefficientSet(TP1: {package.coefficients.model}, axes x, y, z, " in text
    assert package.coefficients.sha256[:12] in text
