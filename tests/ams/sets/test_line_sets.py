"""Sets of straight lines: what comes out is plain arithmetic on what was put in, in every unit and every format."""

import math
from pathlib import Path

import numpy as np
import pytest
from c_program import needs_compiler, printed
from changed_sets import changed
from line_sets import LEVELS_UT, MATRIX, ZERO_COUNTS, line_set, triad_set

from ams.errors import OutsideValidity, SetError, VectorsDisagree
from ams.exports.formats import FORMATS, export_set, load_set
from ams.exports.verify import verify
from ams.in_use import load
from ams.sets.apply import apply, sensed_level
from ams.sets.canonical import table
from ams.sets.coefficients import CoefficientSet, from_document
from ams.sets.triad_section import has_unmeasured_directions
from ams.surveillance.adjustment import acceptance_of, adjust, to_document
from ams.surveillance.adjustment import from_document as read_adjustment
from ams.surveillance.compare import compare

SR_GYRO = {"x": (1.0443, 2.44732), "y": (0.9744, -0.561), "z": (0.9962, -0.588447)}
SR_ACCELEROMETER = {"x": (1.0032, 0.02066), "y": (1.0278, -0.0659), "z": (1.0119, -0.0243)}
UP_AND_DOWN_G = np.tile([-1.0, 1.0], 8)


@pytest.fixture(scope="module")
def triad() -> CoefficientSet:
    return triad_set()


def test_a_matrix_with_offset_gives_back_the_field_of_any_reading(triad: CoefficientSet) -> None:
    field_ut = np.random.default_rng(4).uniform(-40.0, 40.0, (50, 3))
    counts = field_ut @ MATRIX.T + ZERO_COUNTS
    found = apply(triad, level=field_ut, beyond_validity=True)
    assert np.stack([found[axis] for axis in "xyz"], axis=-1) == pytest.approx(counts, rel=1e-12)
    assert sensed_level(triad, dict(zip("xyz", counts.T, strict=True))) == pytest.approx(field_ut, abs=1e-10)


def test_the_set_states_matrix_inverse_and_squareness(triad: CoefficientSet) -> None:
    stated = table(triad.document["triad"])
    assert np.array(stated["matrix_counts_per_ut"]) == pytest.approx(MATRIX, abs=1e-11)
    assert np.array(stated["inverse_ut_per_counts"]) @ MATRIX == pytest.approx(np.eye(3), abs=1e-12)
    assert stated["zero_level_counts"] == pytest.approx(ZERO_COUNTS, abs=1e-9)
    polarity = np.array([1.0, -1.0, 1.0])  # of y: the axis points where its reading falls
    x, y, _ = (sign * row / np.linalg.norm(row) for sign, row in zip(polarity, MATRIX, strict=True))
    assert table(stated["angle_between_deg"])["xy"] == pytest.approx(math.degrees(math.acos(x @ y)), abs=1e-9)
    assert table(triad.document["use"])["polarity"] == {"x": 1, "y": -1, "z": 1}


def test_lines_along_their_axes_claim_no_squareness() -> None:
    lines = line_set(SR_GYRO, "dps", "dps")
    assert "angle_between_deg" not in table(lines.document["triad"])
    assert has_unmeasured_directions(lines.axes)


def test_a_triad_that_was_measured_tells_how_its_axes_lie_and_one_line_alone_need_not(triad: CoefficientSet) -> None:
    assert not has_unmeasured_directions(triad.axes)
    assert not has_unmeasured_directions({"x": line_set(SR_GYRO, "dps", "dps").axes["x"]})


@pytest.mark.parametrize("change", ["matrix_counts_per_ut", "inverse_ut_per_counts"])
def test_a_matrix_that_is_not_that_of_the_axes_is_refused(triad: CoefficientSet, change: str) -> None:
    def wrong(document: dict) -> None:
        document["triad"][change][0][0] *= 1.0 + 1e-7

    with pytest.raises(VectorsDisagree, match=f"triad: {change}: not what the axes' coefficients make"):
        from_document(changed(triad, wrong), "set").check_vectors("set")


def test_sr_s_own_numbers_stand_beside_the_line() -> None:
    """SR, appendix: the ITG-3200's real = 1.0443·measured + 2.44732 °/s and so on."""
    found = line_set(SR_GYRO, "dps", "dps", levels=LEVELS_UT)
    for axis, (gain, offset) in SR_GYRO.items():
        numbers = found.axes[axis]
        assert numbers.parameters["gain_dps_per_dps"] == pytest.approx(gain, rel=1e-12)
        assert numbers.parameters["offset_dps"] == pytest.approx(offset, rel=1e-11)
        assert numbers.primary[f"k_{axis}_dps_per_dps"] == pytest.approx(1.0 / gain, rel=1e-12)
    assert found.document["inputs"] == ["level_x_dps", "level_y_dps", "level_z_dps"]
    assert found.validity.levels["level_x_dps"] == pytest.approx((-40.0, 40.0))


def test_every_key_of_the_section_is_in_the_unit_of_the_reading(triad: CoefficientSet) -> None:
    section = table(table(triad.document["axes"])["x"])
    assert {"standard_error_counts", "nominal_axis"} <= set(section)
    assert not [key for key in section if key.endswith(("_v", "_v_per_g"))]


@pytest.mark.parametrize("name", ["json", "csv", "mat", "hdf5", "parquet", "c", "c-fixed", "epics", "linear", "dcc"])
def test_a_set_of_lines_comes_back_from_every_format(triad: CoefficientSet, tmp_path: Path, name: str) -> None:
    path = tmp_path / FORMATS[name].file_name("M1")
    export_set(triad, name, path)
    assert load_set(path).sha256 == triad.sha256
    assert verify(path).forward_vectors == 9


@needs_compiler
def test_the_header_reads_in_the_units_of_the_set(triad: CoefficientSet, tmp_path: Path) -> None:
    header = FORMATS["c"].to_bytes(triad)
    main = (
        "double f[3]; calrig_m1_force(10.0, -20.0, 30.0, f);"
        'printf("%.17g %.17g\\n", calrig_m1_y_counts(f, 0.0), calrig_m1_self_test());'
    )
    ((y_counts, error),) = printed(tmp_path, {"m1.h": header}, main)
    assert y_counts == pytest.approx(float(MATRIX[1] @ [10.0, -20.0, 30.0] + ZERO_COUNTS[1]), rel=1e-12)
    assert error <= 1e-12


def test_the_linear_form_is_sr_s_line_and_bounds_what_lies_across(triad: CoefficientSet, tmp_path: Path) -> None:
    text = FORMATS["linear"].to_bytes(triad).decode()
    gain = next(float(line.split("=")[1]) for line in text.splitlines() if line.startswith("a_ut_per_counts ="))
    error = next(float(line.split("=")[1]) for line in text.splitlines() if line.startswith("largest_error_ut ="))
    assert gain == pytest.approx(1.0 / MATRIX[0, 0], rel=1e-11)
    field = triad.validity.levels
    across = [max(map(abs, field[f"level_{axis}_ut"])) for axis in "yz"]
    assert error == pytest.approx(float(np.abs(MATRIX[0, 1:]) @ across) / MATRIX[0, 0], rel=1e-9)


def test_a_level_beyond_the_calibration_is_refused() -> None:
    found = line_set(SR_GYRO, "dps", "dps")
    with pytest.raises(
        OutsideValidity, match=r"level_y outside the validity of the set: got 41 °/s, calibrated from -40"
    ):
        apply(found, level=[0.0, 41.0, 0.0])
    # An end was measured: a table's 90° reads a part in 1e8 less than 1 g.
    assert np.isfinite(apply(found, level=[0.0, 40.0 + 4e-7, 0.0])["y"])
    with pytest.raises(OutsideValidity, match=r"got 40\.0001 °/s, calibrated from -40 to 40 °/s"):
        apply(found, level=[0.0, 40.0001, 0.0])
    with pytest.raises(OutsideValidity, match="the level is missing"):
        apply(found)
    with pytest.raises(OutsideValidity, match=r"got an array of shape \(2,\), needed"):
        apply(found, level=[1.0, 2.0])


def test_lines_in_g_tell_the_attitude(tmp_path: Path) -> None:
    """Pitch and roll by arc tangents of A·measured + B."""
    path = tmp_path / "set.json"
    export_set(line_set(SR_ACCELEROMETER, "g", "g", levels=UP_AND_DOWN_G, scatter=1e-4), "json", path)
    force = np.array([math.sin(0.3), -math.cos(0.3) * math.sin(-0.7), -math.cos(0.3) * math.cos(-0.7)])
    package = load(path)
    real = {axis: table(table(table(package.coefficients.document["axes"])[axis])["parameters"]) for axis in "xyz"}
    measured = [
        (f - float(table(real[axis]["offset_g"])["value"])) / float(table(real[axis]["gain_g_per_g"])["value"])  # type: ignore[arg-type]
        for axis, f in zip("xyz", force, strict=True)
    ]
    found = package.attitude(measured)
    assert (found.pitch_deg, found.roll_deg) == pytest.approx((math.degrees(0.3), math.degrees(-0.7)), abs=1e-9)
    assert found.pitch_sd_deg > 0.0
    assert found.flags == ("",)


def test_a_field_tells_no_attitude_and_says_so(triad: CoefficientSet, tmp_path: Path) -> None:
    path = tmp_path / "set.json"
    export_set(triad, "json", path)
    with pytest.raises(OutsideValidity, match="senses µT, which tells no attitude by itself"):
        load(path)


def test_as_found_is_how_far_the_line_before_was_off_in_its_own_unit() -> None:
    """A 1 % larger and B 0.3 µT higher: at 40 µT of field 0.4 + 0.3 µT, by hand."""
    true, off = {"x": (0.032, -0.4)}, {"x": (0.032 * 1.01, -0.4 * 1.01 + 0.3)}
    new, old = line_set(true, scatter=0.5), line_set(off)
    exact = line_set(true)
    found = adjust(old, exact, None, acceptance_of({}))  # type: ignore[arg-type]  # lines take no rows
    assert found.as_found is not None
    errors = found.as_found.level_errors["x"]
    assert errors.error == pytest.approx([-0.4 + 0.3, 0.4 + 0.3], abs=1e-9)
    assert (errors.unit, errors.worst) == ("ut", 1)
    judged = adjust(old, new, None, acceptance_of({}))  # type: ignore[arg-type]
    assert judged.as_left.level_errors["x"].error == pytest.approx([0.0, 0.0])
    assert (judged.as_left.level_errors["x"].standard_uncertainty > 0.0).all()
    again = read_adjustment(to_document(judged))
    assert again.as_found is not None
    assert again.as_found.level_errors["x"].error == pytest.approx(judged.as_found.level_errors["x"].error)  # type: ignore[union-attr]


def test_lines_are_compared_in_their_own_unit_and_only_with_their_like(triad: CoefficientSet) -> None:
    old, new = line_set({"x": (0.032, -0.4)}), line_set({"x": (0.032, -0.7)})
    found = compare(old, new)
    assert (found.measured_unit, found.unit) == ("counts", "ut")
    assert found.axes["x"].offset_v.value == pytest.approx(0.3 / 0.032)
    with pytest.raises(SetError, match="units: cannot be compared: got dps per dps, the older set has counts per ut"):
        compare(old, line_set({"x": (1.0, 0.0)}, "dps", "dps"))
