"""The C header as somebody meets it who has a compiler and nothing else of ours."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from c_program import needs_compiler, printed
from cr_outputs import TABLE_4, accelerometer_v, gyro_v
from foreign_sets import bending, hostile, quadratic, warm
from line_sets import triad_set
from not_usable import set_not_usable, set_usable
from solved import provenance, solved_package
from solved_sets import TRUTH, bent_set, gyro_set, package_set

from ams.errors import SetError, VectorsDisagree
from ams.exports.c_fixed import CHECKSUM_LINES as FIXED_LINES
from ams.exports.c_fixed import from_c_fixed, to_c_fixed
from ams.exports.c_header import CHECKSUM_LINES, from_c_header, to_c_header
from ams.exports.linear_form import to_linear_form
from ams.sets.coefficients import CoefficientSet, build_set

pytestmark = needs_compiler
OWN_FORMULA = """
    for (int i = 0; i < 9; i++) {
        const double *t = calrig_sn1047_vectors[i], d = acos(-1.0) / 180.0;
        const double x = sin(t[0] * d), y = -cos(t[0] * d) * sin(t[1] * d), z = -cos(t[0] * d) * cos(t[1] * d);
        printf("%.17g %.17g\\n", t[3], CALRIG_SN1047_X_OFFSET_V + CALRIG_SN1047_X_K_X_V_PER_G * x
            + CALRIG_SN1047_X_K_Y_V_PER_G * y + CALRIG_SN1047_X_K_Z_V_PER_G * z);
        printf("%.17g %.17g\\n", t[5], CALRIG_SN1047_Z_OFFSET_V + CALRIG_SN1047_Z_K_X_V_PER_G * x
            + CALRIG_SN1047_Z_K_Y_V_PER_G * y + CALRIG_SN1047_Z_K_Z_V_PER_G * z);
    }
"""


@pytest.fixture(scope="module")
def package() -> CoefficientSet:
    return build_set(solved_package(), provenance())


def test_the_macros_alone_reproduce_the_vectors(package: CoefficientSet, tmp_path: Path) -> None:
    pairs = np.array(printed(tmp_path, {"SN1047.h": to_c_header(package)}, OWN_FORMULA))
    assert pairs.shape == (18, 2)
    assert pairs[:, 0] == pytest.approx(pairs[:, 1], rel=0, abs=1e-12 * 2.5)


@pytest.mark.parametrize(
    "make", [warm, bending, quadratic, bent_set, lambda: build_set(solved_package(), provenance())]
)
def test_the_functions_reproduce_the_vectors_of_the_document(
    make: Callable[[], CoefficientSet], tmp_path: Path
) -> None:
    coefficients = make()
    axis = list(coefficients.axes)[-1]
    calls = "".join(
        f"calrig_sn1047_force({v['pitch_deg']!r}, {v['roll_deg']!r}, f);"
        f'printf("%.17g\\n", calrig_sn1047_{axis}_v(f, {v.get("temperature_degc", 0.0)!r}));\n'
        for v in coefficients.document["test_vectors"]["forward"]
    )
    outcome = printed(
        tmp_path,
        {"SN1047.h": to_c_header(coefficients)},
        f'double f[3];\n{calls}printf("%.17g\\n", calrig_sn1047_self_test());',
    )
    expected = [v["outputs_v"][axis] for v in coefficients.document["test_vectors"]["forward"]]
    assert [line[0] for line in outcome[:-1]] == pytest.approx(expected, rel=0, abs=2.5e-12)
    assert outcome[-1][0] <= 1e-12


def test_macros_and_tables_by_the_names_of_coefficients_hold_those_of_the_set(tmp_path: Path) -> None:
    coefficients = bent_set()
    for axis, entry in coefficients.document["axes"].items():
        primary, start = entry["primary"], f"CALRIG_SN1047_{axis.upper()}_"
        order = primary["order"]
        names = [*order, *(f"sensed_{name}" for name in order[1:4]), "sensed_constant_v"]
        main = "".join(f'printf("%.17g\\n", {start}{name.upper()});\n' for name in names)
        size = len(order)
        main += f'for (int i = 0; i < {size * size}; i++) printf("%.17g\\n", calrig_sn1047_{axis}_covariance[0][i]);'
        values = [line[0] for line in printed(tmp_path, {"SN1047.h": to_c_header(coefficients)}, main)]
        assert dict(zip(order, values, strict=False)) == {name: primary["values"][name] for name in order}
        assert values[size + 4 :] == [entry for row in primary["covariance"] for entry in row]
        # Every term stands as K*(term(f) - c_0 - c·f): K*c comes off k and constant when the bracket is opened.
        off = np.array([primary["values"][name] for name in order[4:]]) @ np.array(entry["equation"]["centring"])
        k = [primary["values"][name] for name in order[1:4]]
        assert values[size : size + 4] == pytest.approx([*(np.array(k) - off[1:]), -off[0]], rel=0, abs=1e-15)
        assert np.abs(off[1:]).max() > 1e-6, "else nothing is told apart"


def test_the_comment_tells_coefficients_from_what_the_functions_take(package: CoefficientSet) -> None:
    told = "CALRIG_SN1047_X_SENSED_K_X_V_PER_G and so on are no coefficients"
    text = re.sub(r"\s*\n \* +", " ", to_c_header(bent_set()).decode())
    assert told in text
    assert text.count("/* of the set's coefficients, in the order offset_v, k_x_v_per_g,") == 3
    assert "SENSED" not in to_c_header(package).decode(), "nothing is centred there"


@pytest.mark.parametrize("to_header", [to_c_header, to_c_fixed])
@pytest.mark.parametrize(
    "make",
    [
        warm,
        bending,
        quadratic,
        bent_set,
        hostile,
        triad_set,
        gyro_set,
        lambda: package_set("sting"),
        lambda: package_set("model"),
        lambda: build_set(solved_package(), provenance()),
        lambda: build_set(solved_package(), provenance(sensor="VOLTS-PREFIX-OUTPUT UNIT INPUTS")),
    ],
)
def test_every_name_of_ours_that_the_comment_says_is_in_the_code(
    make: Callable[[], CoefficientSet], to_header: Callable[[CoefficientSet], bytes]
) -> None:
    try:
        text = to_header(make()).decode()
    except SetError:
        assert to_header is to_c_fixed
        return
    opening, code = text.split(" */\n", 1)
    in_code = set(re.findall(r"\w+", re.sub(r"/\*.*?\*/", "", code, flags=re.DOTALL)))
    said = set(re.findall(r"\bcalrig_\w+", opening, flags=re.IGNORECASE))
    assert len(said) >= 2
    assert said <= in_code, said - in_code
    assert not re.search(r"@|\b(PREFIX|AXIS)_", opening.split(" * sensor: ")[0])


@pytest.mark.parametrize("make", [warm, bending, bent_set, lambda: build_set(solved_package(), provenance())])
def test_the_angles_come_back_from_the_outputs(make: Callable[[], CoefficientSet], tmp_path: Path) -> None:
    main = """
    double pitch_deg, roll_deg;
    for (int i = 0; i < 9; i++) {
        const double *t = calrig_sn1047_vectors[i];
        const double degc = TEMPERATURE;
        const int expected = fabs(t[0]) == 90.0 ? CALRIG_SN1047_ROLL_UNDETERMINED : 0;
        if (calrig_sn1047_angles(t + 3, degc, &pitch_deg, &roll_deg) != expected) return 1;
        printf("%.17g %.17g %.17g %.17g\\n", t[0], pitch_deg, t[1], roll_deg);
    }
    """
    coefficients = make()
    is_warm = any(numbers.needs_temperature for numbers in coefficients.axes.values())
    main = main.replace("TEMPERATURE", "t[2]" if is_warm else "NAN")
    rows = np.array(printed(tmp_path, {"SN1047.h": to_c_header(coefficients)}, main))
    rows = rows[np.abs(rows[:, 0]) < 80.0]
    assert rows[:, 1] == pytest.approx(rows[:, 0], abs=1.8e-10)
    assert (rows[:, 3] - rows[:, 2] + 180.0) % 360.0 - 180.0 == pytest.approx(0.0 * rows[:, 0], abs=1.8e-10)


@pytest.mark.parametrize("package", ["sting", "model"])
def test_a_package_of_cr_gives_the_outputs_of_explicit_rotations(package: str, tmp_path: Path) -> None:
    main = """
    double f[3];
    calrig_cr1_force(-35.5, 44.0, -12.0, f);
    printf("%.17g %.17g %.17g\\n", calrig_cr1_x_v(f, 0.0), calrig_cr1_y_v(f, 0.0), calrig_cr1_z_v(f, 0.0));
    printf("%.17g\\n", calrig_cr1_self_test());
    """
    outputs_v, self_test = printed(tmp_path, {"CR1.h": to_c_header(package_set(package))}, main)
    euler_deg = (-35.5, -12.0, 44.0)
    expected = [accelerometer_v(axis, truth, euler_deg, package) for axis, truth in TRUTH[package].items()]
    assert outputs_v == pytest.approx(expected, rel=0, abs=1e-12)
    assert self_test[0] <= 1e-12


def test_gyros_of_cr_give_the_outputs_of_differentiated_rotations(tmp_path: Path) -> None:
    main = """
    double f[3];
    calrig_g1_force(10.0, -20.0, 15.0, 20.0, -30.0, 10.0, f);
    printf("%.17g %.17g %.17g\\n", calrig_g1_x_v(f, 0.0), calrig_g1_y_v(f, 0.0), calrig_g1_z_v(f, 0.0));
    printf("%.17g\\n", calrig_g1_self_test());
    """
    outputs_v, self_test = printed(tmp_path, {"G1.h": to_c_header(gyro_set())}, main)
    expected = [gyro_v(a, truth, (10.0, 15.0, -20.0), (20.0, -30.0, 10.0)) for a, truth in TABLE_4.items()]
    assert outputs_v == pytest.approx(expected, rel=0, abs=1e-10)
    assert self_test[0] <= 1e-12


@pytest.mark.parametrize("refuse", [to_c_fixed, to_linear_form])
@pytest.mark.parametrize("make", [gyro_set, lambda: package_set("model")])
def test_forms_of_pitch_and_roll_alone_refuse_crs_models(
    refuse: Callable[[CoefficientSet], bytes], make: Callable[[], CoefficientSet]
) -> None:
    with pytest.raises(SetError, match=r"got convention CR, model .*, needed are accelerometers of pitch and roll"):
        refuse(make())


def test_outputs_that_are_no_numbers_give_no_angles(package: CoefficientSet, tmp_path: Path) -> None:
    main = """
    double pitch_deg = 7.0, roll_deg = 7.0, nan_v[3] = {NAN, 0.0, 0.0};
    const double zero_g[3] = {CALRIG_SN1047_X_OFFSET_V, CALRIG_SN1047_Y_OFFSET_V, CALRIG_SN1047_Z_OFFSET_V};
    printf("%d\\n", calrig_sn1047_angles(nan_v, 0.0, &pitch_deg, &roll_deg));
    printf("%d %g\\n", calrig_sn1047_angles(zero_g, 0.0, &pitch_deg, &roll_deg), pitch_deg);
    """
    assert printed(tmp_path, {"SN1047.h": to_c_header(package)}, main) == [[-1.0], [-1.0, 7.0]]


def test_a_self_test_sees_one_wrong_digit(package: CoefficientSet, tmp_path: Path) -> None:
    wrong = to_c_header(package).replace(b"Z_K_Z_V_PER_G (-2.519994473023556)", b"Z_K_Z_V_PER_G (-2.519994473033556)")
    outcome = printed(tmp_path, {"SN1047.h": wrong}, 'printf("%.17g\\n", calrig_sn1047_self_test());')
    assert outcome[0][0] == pytest.approx(1e-11 / 2.5267, rel=0.01)


def test_texts_of_others_end_no_comment_and_both_headers_serve_one_program(tmp_path: Path) -> None:
    headers = {"a.h": to_c_header(hostile()), "b.h": to_c_fixed(hostile()), "c.h": to_c_header(quadratic())}
    assert printed(tmp_path, headers, 'printf("%g\\n", calrig_sn1047_self_test() > 1e-12 ? 1.0 : 0.0);') == [[0.0]]


def test_the_comment_says_what_a_user_must_know(package: CoefficientSet) -> None:
    text = re.sub(r"\s*\n \* +", " ", to_c_header(package).decode())
    for part in ("local g = 9.79826 m/s^2", "x forward, y right, z down", "fixture_to_package", "wind_off_rezero"):
        assert part in text
    assert "k_x_v_per_g*f_x" in text
    assert "#define CALRIG_SN1047_Z_POLARITY (-1)" in text


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"X_OFFSET_V 0.005", b"X_OFFSET_V 0.006"),
        (b"Z_POLARITY (-1)", b"Z_POLARITY (+1)"),
        (b"{37.8, -133.2,", b"{37.9, -133.2,"),
        (b"GRAVITY_MPS2 9.79826", b"GRAVITY_MPS2 9.80665"),
    ],
)
def test_a_sealed_header_with_other_numbers_than_its_document_disagrees(
    old: bytes, new: bytes, package: CoefficientSet
) -> None:
    body = CHECKSUM_LINES[-1].checked_body(to_c_header(package), "file")
    assert body.count(old) == 1
    with pytest.raises(
        VectorsDisagree, match="file: macros and tables: the file's own are others than those of the doc"
    ):
        from_c_header(CHECKSUM_LINES[-1].append_to(body.replace(old, new)), "file")


def test_a_sealed_header_without_the_set_is_refused(package: CoefficientSet) -> None:
    body = CHECKSUM_LINES[-1].checked_body(to_c_header(package), "file")
    with pytest.raises(SetError, match=r"file: has no line that begins with ' \* document_json| '"):
        from_c_header(CHECKSUM_LINES[-1].append_to(body.replace(b"document_json|", b"document_json:")), "file")


@pytest.mark.parametrize("export", [to_c_header, to_c_fixed])
@pytest.mark.parametrize("make", [set_usable, set_not_usable])
@pytest.mark.parametrize("is_simulated", [False, True])
def test_a_program_refuses_a_set_as_it_is_compiled(
    export: Callable[[CoefficientSet], bytes], make: Callable[..., CoefficientSet], is_simulated: bool, tmp_path: Path
) -> None:
    """Not usable, or of a twin: the preprocessor tells, with no line of the program run."""
    coefficients = make(simulated=is_simulated)
    prefix = "CALRIG_SN1047_FIXED" if export is to_c_fixed else "CALRIG_SN1047"
    tell = f"""
#if !{prefix}_USABLE
printf("1 ");
#else
printf("0 ");
#endif
#if {prefix}_SIMULATED
printf("1\\n");
#else
printf("0\\n");
#endif
"""
    header = export(coefficients)
    assert printed(tmp_path, {"SN1047.h": header}, tell) == [[float(make is set_not_usable), float(is_simulated)]]
    assert f"#if !{prefix}_USABLE or {prefix}_SIMULATED, #error" in re.sub(r"\s+\*\s+", " ", header.decode())


def test_a_header_of_version_2_is_read_and_its_macros_are_held_against_its_set() -> None:
    content = (Path(__file__).parents[2] / "data" / "coefficient_set_v2.h").read_bytes()
    assert b"REDUNDANCY_LIMIT" not in content
    assert from_c_header(content, "v2.h").sensor == "SN1047"
    body = CHECKSUM_LINES[1].checked_body(content, "v2.h")
    changed = re.sub(rb"(_USABLE) 1", rb"\1 0", body, count=1)
    with pytest.raises(VectorsDisagree, match="macros and tables"):
        from_c_header(CHECKSUM_LINES[1].append_to(changed), "v2.h")


def test_a_header_of_version_3_is_read_and_its_macros_are_held_against_its_set() -> None:
    content = (Path(__file__).parents[2] / "data" / "coefficient_set_v3.h").read_bytes()
    assert b"READING_SD_V" not in content
    assert from_c_header(content, "v3.h").sensor == "SN1047"
    body = CHECKSUM_LINES[2].checked_body(content, "v3.h")
    changed = re.sub(rb"(_REDUNDANCY_LIMIT) [-.e0-9]+", rb"\1 0.5", body, count=1)
    with pytest.raises(VectorsDisagree, match="macros and tables"):
        from_c_header(CHECKSUM_LINES[2].append_to(changed), "v3.h")


@pytest.mark.parametrize("name", ["coefficient_set_v1.h", "coefficient_set_v1.fixed.h"])
def test_a_header_of_version_1_is_read_and_its_macros_are_held_against_its_set(name: str) -> None:
    content = (Path(__file__).parents[2] / "data" / name).read_bytes()
    line, read = (FIXED_LINES[0], from_c_fixed) if ".fixed" in name else (CHECKSUM_LINES[0], from_c_header)
    assert b"_USABLE" not in content
    assert read(content, name).sensor == "SN1047"
    body = line.checked_body(content, name)
    changed = re.sub(rb"(_POLARITY) \(?-?1\)?", rb"\1 7", body, count=1)
    with pytest.raises(VectorsDisagree, match="macros and tables"):
        read(line.append_to(changed), name)


def test_a_header_whose_verdict_was_changed_or_taken_out_is_refused(package: CoefficientSet) -> None:
    body = CHECKSUM_LINES[-1].checked_body(to_c_header(package), "SN1047.h")
    for changed in (body.replace(b"_USABLE 1\n", b"_USABLE 0\n"), re.sub(rb"#define \w+_USABLE 1\n", b"", body)):
        assert changed != body
        with pytest.raises(VectorsDisagree, match="macros and tables"):
            from_c_header(CHECKSUM_LINES[-1].append_to(changed), "SN1047.h")
