"""What a C program is told of the angles that it reads off three outputs."""

import re
from pathlib import Path

import numpy as np
import pytest
from c_program import needs_compiler, printed
from solved import PARAMETERS, direction, provenance, solved_package

from ams.exports.c_header import to_c_header
from ams.inference.inference import Package, inference
from ams.inference.package.package_bounds import package_bounds
from ams.sets.coefficients import CoefficientSet, build_set

pytestmark = needs_compiler
K = np.array([direction(axis, *values[1:]) for axis, values in PARAMETERS.items()])
OFFSET_V = np.array([values[0] for values in PARAMETERS.values()])
ROLL_UNDETERMINED, OUTPUTS_DISAGREE, OUTSIDE_VALIDITY = 1, 2, 4


@pytest.fixture(scope="module")
def package() -> CoefficientSet:
    return build_set(solved_package(), provenance())


def outputs_v(pitch_deg: float, roll_deg: float, gravity: float = 1.0) -> np.ndarray:
    """By the definition of the specific force, sensed by the axes of the package."""
    pitch, roll = np.radians(pitch_deg), np.radians(roll_deg)
    force = np.array([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    return OFFSET_V + gravity * K @ force


def told(
    folder: Path, header: bytes, rows: list[np.ndarray], *, degc: str = "NAN", before: str = ""
) -> list[tuple[int, float, float]]:
    """Return code, pitch and roll of each row of outputs, as a compiled program has them."""
    values = ", ".join("{" + ", ".join(repr(float(v)) for v in row) + "}" for row in rows)
    main = f"""
    static const double rows[{len(rows)}][3] = {{{values}}};
    double pitch_deg, roll_deg;
    for (int i = 0; i < {len(rows)}; i++) {{
        const int code = calrig_sn1047_angles(rows[i], {degc}, &pitch_deg, &roll_deg);
        printf("%d %.17g %.17g\\n", code, pitch_deg, roll_deg);
    }}
    """
    lines = printed(folder, {"SN1047.h": before.encode() + header}, main)
    return [(int(code), pitch, roll) for code, pitch, roll in lines]


def test_a_dead_a_clipped_and_a_common_fault_are_told(package: CoefficientSet, tmp_path: Path) -> None:
    """Y unplugged read 22.4 and −0.3 degrees at 20 and 30, and nothing said so."""
    good = outputs_v(20.0, 30.0)
    unplugged, clipped = good.copy(), good.copy()
    unplugged[1] = OFFSET_V[1]
    clipped[2] *= 0.985
    loud = OFFSET_V + 1.02 * (good - OFFSET_V)
    found = told(tmp_path, to_c_header(package), [good, unplugged, clipped, loud])
    assert [code for code, *_ in found] == [0, OUTPUTS_DISAGREE, OUTPUTS_DISAGREE, OUTPUTS_DISAGREE]
    assert found[0][1:] == pytest.approx((20.0, 30.0), abs=1e-9)
    assert abs(found[1][1] - 20.0) > 2.0, "else nothing was wrong"


def test_what_is_told_is_never_more_than_a_row_of_calrig_is_flagged_for(
    package: CoefficientSet, tmp_path: Path
) -> None:
    """Errors of one output from nothing to three times the bound: whatever C tells, the judgement of rows tells too."""
    rng = np.random.default_rng(5)
    bound = package_bounds(package).length
    rows, length = [], []
    for size in np.linspace(0.0, 3.0, 200) * bound:
        row = outputs_v(float(rng.uniform(-60.0, 60.0)), float(rng.uniform(-180.0, 180.0)))
        row += K @ (0.5 * size * rng.permutation([1.0, 0.0, 0.0]) * rng.choice([-1.0, 1.0]))
        rows.append(row)
        length.append(float(np.sum(np.linalg.solve(K, row - OFFSET_V) ** 2)) - 1.0)
    codes = np.array([code for code, *_ in told(tmp_path, to_c_header(package), rows)])
    is_told = (codes & OUTPUTS_DISAGREE) != 0
    readings = {f"{axis}_v": np.array(rows)[:, column] for column, axis in enumerate("xyz")}
    flags = inference(Package(package, {axis: f"{axis}_v" for axis in "xyz"})).infer(readings)["flag"]
    is_flagged = np.array(["redundancy" in str(flag) for flag in flags])
    assert 20 < is_told.sum() < 180
    assert np.all(is_flagged[is_told])
    clear = np.abs(np.abs(length) / bound - 1.0) > 0.1  # the macro is rounded up to two digits
    assert np.array_equal(is_told[clear], (np.abs(length) > bound)[clear])


def test_good_packages_are_told_once_in_a_thousand_rows_at_most(package: CoefficientSet) -> None:
    """Calibrations drawn from what is stated of them, one row each, every part as often off as its covariance says."""
    rng, bound, count = np.random.default_rng(8), package_bounds(package).length, 20000
    pitch, roll = np.radians(rng.uniform(-90.0, 90.0, count)), np.radians(rng.uniform(-180.0, 180.0, count))
    force = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=1)
    terms = np.column_stack([np.ones(count), force])
    scatter = np.sqrt([1e-12, 2e-12, 2e-12, 2e-12]) * rng.standard_t(5.0, (3, count, 4))
    common = np.sqrt(1e-13) * rng.normal(size=(3, count, 1))
    off = np.einsum("acp,cp->ca", scatter + common, terms) + 2e-5 * rng.normal(size=(count, 3))
    sensed = np.linalg.solve(K, (force @ K.T + off).T)
    share = float(np.mean(np.abs(np.sum(sensed**2, axis=0) - 1.0) > bound))
    assert share <= 0.002


def test_gravity_at_use_is_that_of_the_place(package: CoefficientSet, tmp_path: Path) -> None:
    """At the equator gravity is 0.2 % less: every row disagrees, none where it is defined as the comment says."""
    rows = [outputs_v(10.0, -40.0, gravity=9.78033 / 9.79826)]
    header = to_c_header(package)
    assert told(tmp_path, header, rows)[0][0] == OUTPUTS_DISAGREE
    comment = re.sub(r"\s*\n \* +", " ", header.decode())
    (name,) = re.findall(r"define (\w+) where gravity is another", comment)
    there = f"#define {name} 9.78033\n"
    ((code, pitch, roll),) = told(tmp_path, header, rows, before=there)
    assert code == 0
    assert (pitch, roll) == pytest.approx((10.0, -40.0), abs=1e-9)


def test_a_program_with_other_readings_states_its_own_bounds(package: CoefficientSet, tmp_path: Path) -> None:
    good = outputs_v(20.0, 30.0)
    shaken = OFFSET_V + 1.001 * (good - OFFSET_V)
    header = to_c_header(package)
    comment = re.sub(r"\s*\n \* +", " ", header.decode())
    ((limit, across),) = re.findall(r"and (\w+), the largest .*? and (\w+), the least part", comment)
    assert told(tmp_path, header, [shaken])[0][0] == OUTPUTS_DISAGREE
    assert told(tmp_path, header, [shaken], before=f"#define {limit} 0.01\n")[0][0] == 0
    wide = f"#define {across} 0.99\n"
    assert told(tmp_path, header, [good], before=wide)[0][0] == ROLL_UNDETERMINED


def test_near_the_vertical_there_is_no_roll(package: CoefficientSet, tmp_path: Path) -> None:
    rows = [outputs_v(90.0, 40.0), outputs_v(-90.0, 40.0), outputs_v(89.0, 40.0)]
    (up, down, beside) = told(tmp_path, to_c_header(package), rows)
    assert (up[0], down[0], beside[0]) == (ROLL_UNDETERMINED, ROLL_UNDETERMINED, 0)
    assert np.isnan([up[2], down[2]]).all()
    assert (up[1], down[1]) == pytest.approx((90.0, -90.0), abs=1e-5)
    assert beside[2] == pytest.approx(40.0, abs=1e-8)


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg", "degc", "code"),
    [
        (29.9, 44.9, "20.0", 0),
        (30.1, 0.0, "20.0", OUTSIDE_VALIDITY),
        (-30.1, 0.0, "20.0", OUTSIDE_VALIDITY),
        (0.0, 45.1, "20.0", OUTSIDE_VALIDITY),
        (0.0, -170.0, "20.0", OUTSIDE_VALIDITY),
        (0.0, -45.1, "20.0", OUTSIDE_VALIDITY),
        (0.0, 0.0, "21.1", OUTSIDE_VALIDITY),
        (0.0, 0.0, "18.9", OUTSIDE_VALIDITY),
        (0.0, 0.0, "NAN", 0),
        (30.0, 45.0, "21.0", 0),
        (-30.0, -45.0, "19.0", 0),
    ],
)
def test_a_row_outside_the_validity_is_told(
    pitch_deg: float, roll_deg: float, degc: str, code: int, tmp_path: Path
) -> None:
    narrow = build_set(solved_package(), provenance(pitch_range_deg=(-30.0, 30.0), roll_range_deg=(-45.0, 45.0)))
    assert narrow.validity.temperature_degc == (19.0, 21.0)
    assert told(tmp_path, to_c_header(narrow), [outputs_v(pitch_deg, roll_deg)], degc=degc)[0][0] == code
