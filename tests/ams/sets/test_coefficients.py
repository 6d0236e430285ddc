"""What a built set holds, and what is refused."""

import json
from dataclasses import replace
from datetime import datetime

import jsonschema
import numpy as np
import pytest
from foreign_sets import bending
from solved import NAMES, PARAMETERS, direction, provenance, solved_axis, solved_package
from solved_sets import bent_set

from ams.calibration_result import AxisCalibration, Calibration, ParameterEstimate
from ams.errors import SetError, VectorsDisagree
from ams.exports.json_text import to_json
from ams.sets.apply import apply
from ams.sets.canonical import checksum, render
from ams.sets.coefficients import build_set, from_document
from ams.sets.vectors import angles_of, inferred_force
from ams.sets.verdict_conditions import NO_TEMPERATURE


def one_axis(axis: AxisCalibration) -> Calibration:
    return Calibration({axis.axis: axis}, axis.model, "TP")


def pitch_only(nominal_axis: str) -> AxisCalibration:
    """TP (1), v = b + S sin(α − φ); along z the same sensor turned: v = b − S cos(α − φ)."""
    b, s, p_deg = 0.01, 2.4, 0.7
    cosine, sine = np.cos(np.radians(p_deg)), np.sin(np.radians(p_deg))
    k = (s * cosine, s * sine) if nominal_axis == "x" else (-s * sine, s * cosine)
    names = ("offset_v", "sensitivity_v_per_g", "pitch_misalignment_deg")
    return replace(
        solved_axis("x"),
        axis="a",
        model="pitch-only",
        nominal_axis=nominal_axis,
        parameters=tuple(
            ParameterEstimate(n, v, 1e-6, 1e-6, 5.0, None) for n, v in zip(names, (b, s, p_deg), strict=True)
        ),
        covariance=np.eye(3) * 1e-12,
        primary_names=("offset_v", "k_x_v_per_g", "k_z_v_per_g"),
        primary=np.array([b, *k]),
        primary_covariance=np.eye(3) * 1e-12,
        tp_primary_covariance=np.eye(3) * 1e-12,
        primary_dof=np.array([5.0, 5.0, 5.0]),
        variance_components=(),
        replication=None,
    )


def with_temperature(axis: AxisCalibration) -> AxisCalibration:
    extra = (("offset_tc_v_per_degc", 1e-4), ("sensitivity_tc_per_degc", -2e-4), ("reference_temperature_degc", 20.0))
    return replace(
        axis,
        parameters=(*axis.parameters, *(ParameterEstimate(n, v, 1e-7, 1e-7, 5.0, None) for n, v in extra)),
        covariance=np.eye(7) * 1e-12,
        primary_names=(*axis.primary_names, "offset_tc_v_per_degc", "sensitivity_tc_per_degc"),
        primary=np.array([*axis.primary, 1e-4, -2e-4]),
        primary_covariance=np.eye(6) * 1e-12,
        tp_primary_covariance=np.eye(6) * 1e-12,
        primary_dof=np.full(6, 5.0),
        variance_components=(),
    )


def test_a_set_carries_every_number_of_the_calibration() -> None:
    axis = solved_axis("x")
    section = build_set(one_axis(axis), provenance()).document["axes"]["x"]
    assert [section["parameters"][name]["value"] for name in NAMES] == list(PARAMETERS["x"])
    assert section["covariance_order"] == list(NAMES)
    assert section["covariance"] == axis.covariance.tolist()
    assert section["primary"]["order"] == list(axis.primary_names)
    assert list(section["primary"]["values"].values()) == axis.primary.tolist()
    assert section["primary"]["covariance"] == axis.primary_covariance.tolist()
    assert section["primary"]["tp_covariance"] == axis.tp_primary_covariance.tolist()
    assert section["primary"]["components"]["table"] == {"covariance": [[1e-13] * 4] * 4, "degrees_of_freedom": None}
    assert section["replication"]["tp"]["t_bias"] == 37.3
    assert section["replication"]["per_replication"]["1"]["azimuth_deg"] == 35.0
    assert (section["standard_error_v"], section["degrees_of_freedom"]) == (2e-5, 490)
    assert [entry["unit"] for entry in section["parameters"].values()] == ["V", "V/g", "deg", "deg"]


def test_a_set_carries_its_provenance() -> None:
    document = build_set(solved_package(), provenance()).document
    assert document["sensor"] == {"name": "SN1047", "serial": "1047", "model": "three-axis package"}
    assert document["acceleration_unit"]["value_mps2"] == 9.79826
    assert document["convention"]["name"] == "TP"
    assert document["provenance"]["standards"][0]["due"] == "2027-01-31"
    assert document["provenance"]["created_utc"] == "2026-03-01T06:20:00+00:00"
    assert document["provenance"]["journal_sha256"] == "0123456789abcdef" * 4
    assert document["environment"]["air"]["mean_degc"] == 20.02


@pytest.mark.parametrize("is_recorded", [True, False])
def test_whether_a_temperature_was_recorded_is_a_key_and_no_sentence(is_recorded: bool) -> None:
    """A range may be declared and not measured; the remark that says so may read otherwise tomorrow."""
    said = replace(one_axis(solved_axis("x")), remarks=(NO_TEMPERATURE,) if is_recorded else ())
    built = build_set(said, replace(provenance(), temperature_recorded=is_recorded))
    assert built.validity.temperature_degc is not None
    read = from_document(json.loads(to_json(built)), "a set")
    assert (read.document["temperature_recorded"], read.is_temperature_recorded) == (is_recorded, is_recorded)


@pytest.mark.parametrize(
    ("remarks", "range_degc", "is_recorded"),
    [((), (15.0, 30.0), True), ((NO_TEMPERATURE,), (15.0, 30.0), False), ((), None, False)],
)
def test_of_a_set_without_the_key_remark_and_range_tell_whether_a_temperature_was_recorded(
    remarks: tuple[str, ...], range_degc: tuple[float, float] | None, is_recorded: bool
) -> None:
    calibration = replace(one_axis(solved_axis("x")), remarks=remarks)
    before = build_set(calibration, replace(provenance(), temperature_range_degc=range_degc))
    assert "temperature_recorded" not in before.document
    assert before.is_temperature_recorded is is_recorded


def test_without_an_approver_a_set_is_engineering() -> None:
    assert build_set(solved_package(), provenance()).status == "engineering"
    assert build_set(solved_package(), provenance(approved_by="A. Head")).status == "approved"


def test_what_is_not_determined_or_not_finite_is_null_and_never_nan() -> None:
    axis = replace(solved_axis("x", with_angles=False), notes={"condition_number": np.inf, "map": np.array([np.nan])})
    document = build_set(one_axis(axis), provenance()).document
    section = document["axes"]["x"]
    assert section["parameters"]["azimuth_deg"]["value"] is None
    assert section["covariance"][3][3] is None
    assert section["notes"] == {"condition_number": None, "map": [None]}
    assert section["primary"]["effective_degrees_of_freedom"]["k_z_v_per_g"] is None
    assert b"NaN" not in render(document)
    assert b"Infinity" not in render(document)


def test_a_sentence_has_one_rank_everywhere_in_a_set_and_a_reservation_of_any_axis_is_one() -> None:
    plain = solved_package()
    said = {"x": (("bends", "seen once"), ("linear",)), "y": ((), ("linear", "seen once")), "z": ((), ("linear",))}
    axes = {
        name: replace(axis, warnings=said[name][0], remarks=said[name][1], findings=())
        for name, axis in plain.axes.items()
    }
    calibration = replace(plain, axes=axes, warnings=("few",), remarks=("no temperature", "bends"))
    entry = build_set(calibration, provenance()).document
    everything = {*entry["warnings"], *(text for axis in entry["axes"].values() for text in axis["warnings"])}
    remarks = set(entry["remarks"])
    assert everything == {"bends", "seen once", "linear", "few", "no temperature"}
    assert remarks == {"linear", "no temperature"}, "what is no warning of the calibration, which its verdict counts"
    assert calibration.verdict == "usable"


def test_the_shipped_schema_is_a_valid_schema_and_describes_a_set() -> None:
    from importlib.resources import files

    schema = json.loads(files("ams.sets").joinpath("coefficient_set.schema.json").read_text("utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(build_set(solved_package(), provenance()).document, schema)


def test_the_same_calibration_gives_the_same_bytes() -> None:
    first, second = (render(build_set(solved_package(), provenance()).document) for _ in range(2))
    assert first == second


def test_the_checksum_does_not_depend_on_the_order_of_entries() -> None:
    document = build_set(solved_package(), provenance()).document
    assert checksum(dict(reversed(document.items()))) == document["checksum"]["sha256"]


def test_test_vectors_reach_both_ends_of_the_validity() -> None:
    narrow = provenance(pitch_range_deg=(-30.0, 25.0), roll_range_deg=(-180.0, 150.0))
    vectors = build_set(solved_package(), narrow).document["test_vectors"]["forward"]
    pitch, roll = ([vector[name] for vector in vectors] for name in ("pitch_deg", "roll_deg"))
    assert (min(pitch), max(pitch)) == (-30.0, 25.0)
    assert -180.0 <= min(roll) < max(roll) <= 150.0


def test_inverse_vectors_are_there_only_where_three_axes_determine_the_force() -> None:
    assert build_set(solved_package("xyz"), provenance()).document["test_vectors"]["inverse"]
    assert build_set(solved_package("xy"), provenance()).document["test_vectors"]["inverse"] is None


def test_a_package_that_is_hardly_bent_gives_its_force_back_and_one_that_is_bent_a_lot_does_not() -> None:
    bent = bent_set()
    assert not any(numbers.is_linear for numbers in bent.axes.values())
    straight = build_set(solved_package("xyz"), provenance()).document["test_vectors"]["inverse"]
    assert len(bent.document["test_vectors"]["inverse"]) == len(straight)
    f = np.random.default_rng(5).normal(size=(200, 3))
    f /= np.linalg.norm(f, axis=1)[:, None]
    outputs = apply(bent, *angles_of(f))
    np.testing.assert_allclose(inferred_force(bent.axes, outputs, None), f, rtol=0, atol=1e-14)
    assert bent_set(0.2).document["test_vectors"]["inverse"] is None


@pytest.mark.parametrize("nominal_axis", "xz")
def test_a_set_without_roll_gives_the_outputs_of_tp_1(nominal_axis: str) -> None:
    coefficients = build_set(one_axis(pitch_only(nominal_axis)), provenance(roll_range_deg=(0.0, 0.0)))
    for vector in coefficients.document["test_vectors"]["forward"]:
        turned = np.radians(vector["pitch_deg"] - 0.7)
        expected_v = 0.01 + 2.4 * (np.sin(turned) if nominal_axis == "x" else -np.cos(turned))
        assert vector["outputs_v"]["a"] == pytest.approx(expected_v, abs=1e-14)
        assert vector["roll_deg"] == 0.0


def test_temperature_terms_enter_the_vectors() -> None:
    coefficients = build_set(one_axis(with_temperature(solved_axis("x"))), provenance())
    assert coefficients.document["inputs"] == ["pitch_deg", "roll_deg", "temperature_degc"]
    k = direction("x", *PARAMETERS["x"][1:])
    for vector in coefficients.document["test_vectors"]["forward"]:
        alpha, roll, rise = (
            np.radians(vector["pitch_deg"]),
            np.radians(vector["roll_deg"]),
            vector["temperature_degc"] - 20,
        )
        f = np.array([np.sin(alpha), -np.cos(alpha) * np.sin(roll), -np.cos(alpha) * np.cos(roll)])
        expected_v = 0.005 + 1e-4 * rise + (1 - 2e-4 * rise) * (k @ f)
        assert vector["outputs_v"]["x"] == pytest.approx(expected_v, abs=1e-14)
    assert len({vector["temperature_degc"] for vector in coefficients.document["test_vectors"]["forward"]}) > 3


def test_a_bend_with_temperature_enters_the_vectors_and_the_equation() -> None:
    coefficients = bending()
    k = direction("x", *PARAMETERS["x"][1:])
    for vector in coefficients.document["test_vectors"]["forward"]:
        alpha, roll = np.radians([vector["pitch_deg"], vector["roll_deg"]])
        rise = vector["temperature_degc"] - 20.0
        f = np.array([np.sin(alpha), -np.cos(alpha) * np.sin(roll), -np.cos(alpha) * np.cos(roll)])
        gain = 1.0 - 2e-4 * rise + 5e-6 * rise**2
        expected_v = PARAMETERS["x"][0] + 1e-4 * rise - 3e-6 * rise**2 + gain * (k @ f)
        assert vector["outputs_v"]["x"] == pytest.approx(expected_v, abs=1e-14)
    section = coefficients.document["axes"]["x"]
    assert "+ offset_tc2_v_per_degc2*dT^2" in section["equation"]["primary"]
    assert section["parameters"]["sensitivity_tc2_per_degc2"]["unit"] == "1/degC^2"


def test_temperature_terms_need_a_temperature_range() -> None:
    with pytest.raises(SetError, match="SN1047: axis x: has temperature coefficients but no temperature range"):
        build_set(one_axis(with_temperature(solved_axis("x"))), provenance(temperature_range_degc=None))


def test_an_undetermined_primary_parameter_makes_no_set() -> None:
    axis = replace(solved_axis("x"), primary=np.array([0.0, 2.5, np.nan, 0.0]))
    with pytest.raises(SetError, match=r"axis x: a primary parameter is not determined: got .*nan.*; no set was built"):
        build_set(one_axis(axis), provenance())


def test_parameters_of_another_sensor_make_no_set() -> None:
    axis = replace(solved_axis("x"), primary=solved_axis("x").primary * [1.0, 1.001, 1.0, 1.0])
    with pytest.raises(VectorsDisagree, match="axis x: sensitivity and angles do not belong to the primary k"):
        build_set(one_axis(axis), provenance())


def test_a_convention_without_equations_here_makes_no_set() -> None:
    with pytest.raises(SetError, match=r"convention: does not go with the equations of this set: got CR, .*need TP"):
        build_set(replace(solved_package(), convention="CR"), provenance())


def test_an_unknown_primary_parameter_makes_no_set() -> None:
    axis = replace(solved_axis("x"), primary_names=("offset_v", "k_x_v_per_g", "k_y_v_per_g", "cubic_v_per_g"))
    with pytest.raises(SetError, match=r"does not take these primary parameters: got .*cubic_v_per_g"):
        build_set(one_axis(axis), provenance())


def test_a_name_without_a_unit_makes_no_set() -> None:
    axis = replace(solved_axis("x"), primary_names=("offset_v", "k_x_v_per_g", "k_y_v_per_g", "cubic"))
    with pytest.raises(SetError, match="parameter cubic: its name ends in no unit that sets know"):
        build_set(one_axis(axis), provenance())


def test_a_covariance_of_another_size_makes_no_set() -> None:
    with pytest.raises(SetError, match=r"axis x: covariance: has the wrong shape: got \(3, 3\), needed \(4, 4\)"):
        build_set(one_axis(replace(solved_axis("x"), covariance=np.eye(3))), provenance())


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"created_utc": datetime(2026, 3, 1)}, "created_utc has no time zone"),
        ({"pitch_range_deg": (30.0, -30.0)}, "pitch_range_deg is no range: got 30.0 to -30.0"),
        ({"roll_range_deg": (0.0, float("nan"))}, "roll_range_deg is no range"),
        ({"temperature_range_degc": (20.0, float("inf"))}, "temperature_range_degc is no range"),
    ],
)
def test_a_wrong_provenance_is_refused(changes: dict[str, object], sentence: str) -> None:
    with pytest.raises(SetError, match=sentence):
        provenance(**changes)


@pytest.mark.parametrize("value", [{1, 2}, b"bytes", object(), 1j])
def test_a_declared_value_without_a_form_in_json_is_refused(value: object) -> None:
    with pytest.raises(SetError, match=r"job\.key: cannot be written into a coefficient set: got a \w+"):
        build_set(solved_package(), provenance(job={"key": value}))


@pytest.mark.parametrize("text", ["a\0b", "\ud800", "x" * 100_001])
def test_text_that_no_format_can_carry_is_refused(text: str) -> None:
    with pytest.raises(SetError, match=r"job\.key: cannot be written into a coefficient set: got a? ?text"):
        build_set(solved_package(), provenance(job={"key": text}))


def test_a_document_is_read_back_as_the_same_set() -> None:
    coefficients = build_set(solved_package(), provenance())
    assert from_document(json.loads(render(coefficients.document)), "copy") == coefficients


def test_a_set_that_was_built_in_another_shape_does_not_leave() -> None:
    """What is built is held against the schema when it is written, and not each time that it is solved again."""
    built = build_set(solved_package(), provenance())
    wrong = replace(built, document={**built.document, "axes": {"x": {"primary": {}}}})
    with pytest.raises(SetError, match=r"axes/x: does not fit the schema of version \d: .*; the set is not used"):
        to_json(wrong)
    assert to_json(built) == render(built.document)
