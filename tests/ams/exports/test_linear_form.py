"""SR's linear form by tomllib alone, its bound by brute force, its covariance by Monte Carlo."""

import tomllib

import numpy as np
import pytest
from changed_sets import changed
from foreign_sets import bending, hostile, quadratic, warm
from solved import PARAMETERS, provenance, solved_package

from ams.errors import SetError, VectorsDisagree
from ams.exports.linear_form import CHECKSUM_LINE, from_linear_form, linear_axis, to_linear_form
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set, from_document

RNG = np.random.default_rng(7)


@pytest.fixture(scope="module")
def package() -> CoefficientSet:
    return build_set(solved_package(), provenance())


def read(coefficients: CoefficientSet) -> dict:
    return tomllib.loads(to_linear_form(coefficients).decode("ascii"))


def test_two_numbers_give_the_specific_force_within_the_stated_error(package: CoefficientSet) -> None:
    """x at pitch 30°, roll 0: a gravimetric ½ g, up to what the coning angle of 0.5° does."""
    file = read(package)
    axis = file["axes"]["x"]
    assert file["equation"].startswith("real_g = a_g_per_v * measured_v + b_g")
    b, s, coning_deg, azimuth_deg = PARAMETERS["x"]
    w, a, alpha = np.radians([coning_deg, azimuth_deg, 30.0])
    measured_v = b + s * (np.cos(w) * np.sin(alpha) - np.sin(w) * np.cos(alpha) * np.sin(a))  # TP (2) at R = 0
    real_g = axis["a_g_per_v"] * measured_v + axis["b_g"]
    assert real_g == pytest.approx(0.5, abs=axis["largest_error_g"])
    assert real_g == pytest.approx(0.5 - np.tan(w) * np.cos(alpha) * np.sin(a), abs=1e-14)
    assert axis["largest_error_deg"] == pytest.approx(0.5, abs=2e-5)
    assert (axis["polarity"], file["axes"]["z"]["polarity"]) == (1, -1)


def test_the_test_vectors_of_the_file_are_its_own(package: CoefficientSet) -> None:
    file = read(package)
    for vector in file["test_vectors"]:
        for name, pair in vector.items():
            axis = file["axes"][name]
            assert axis["a_g_per_v"] * pair["measured_v"] + axis["b_g"] == pytest.approx(pair["real_g"], rel=1e-12)


@pytest.mark.parametrize("make", [lambda: build_set(solved_package(), provenance()), warm, bending, quadratic])
def test_no_attitude_and_no_temperature_exceeds_the_bound(make: object) -> None:
    coefficients: CoefficientSet = make()  # type: ignore[operator]
    pitch, roll = np.arcsin(RNG.uniform(-1, 1, 20_000)), RNG.uniform(-np.pi, np.pi, 20_000)
    f = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    limits = coefficients.validity.temperature_degc or (20.0, 20.0)
    for name in coefficients.axes:
        axis = linear_axis(coefficients, name)
        worst = 0.0
        for temperature_degc in limits:
            measured_v = apply(coefficients, pitch, roll, temperature_degc)[name]
            error = axis.gain * measured_v + axis.offset - f["xyz".index(name)]
            worst = max(worst, float(np.abs(error).max()))
        assert 0.6 * axis.largest_error < worst <= axis.largest_error * (1 + 1e-12)


def test_the_covariance_is_that_of_drawn_coefficients(package: CoefficientSet) -> None:
    """With an offset of 1.5 V, so that B hangs on the sensitivity too."""

    def shift(document: dict) -> None:
        document["axes"]["y"]["primary"]["values"]["offset_v"] = 1.5

    shifted = from_document(changed(package, shift), "shifted")
    covariance = np.array(shifted.document["axes"]["y"]["primary"]["covariance"])[np.ix_([0, 2], [0, 2])]  # type: ignore[index,call-overload]
    k_y = shifted.axes["y"].primary["k_y_v_per_g"]
    b, k = RNG.multivariate_normal([1.5, k_y], covariance, 400_000).T
    drawn = np.cov(1.0 / k, -b / k)
    assert abs(drawn[0, 1]) > 0.3 * np.sqrt(drawn[0, 0] * drawn[1, 1])
    assert linear_axis(shifted, "y").covariance == pytest.approx(drawn, rel=0.02, abs=0)


def test_the_file_says_what_it_loses(package: CoefficientSet) -> None:
    assert read(package)["loses"].startswith("neglects cross axes, quadratic terms and temperature")


def test_texts_of_others_stay_texts() -> None:
    assert read(hostile())["sensor"] == 'SN*/ 10"47$(P)'


def test_a_sensor_that_does_not_sense_along_its_axis_is_refused(package: CoefficientSet) -> None:
    def turn(document: dict) -> None:
        values = document["axes"]["x"]["primary"]["values"]
        values["k_x_v_per_g"], values["k_y_v_per_g"] = values["k_y_v_per_g"], values["k_x_v_per_g"]

    turned = from_document(changed(package, turn), "turned")
    with pytest.raises(SetError, match=r"axis x: linear form: got 0\.0178709 V/g along the nominal axis x of 2\.5 V/g"):
        to_linear_form(turned)


def test_a_sealed_file_with_other_numbers_than_its_document_disagrees(package: CoefficientSet) -> None:
    body = CHECKSUM_LINE.checked_body(to_linear_form(package), "file")
    other = body.replace(b"b_g = -0.00200007615", b"b_g = -0.00200007616")
    assert other != body
    with pytest.raises(VectorsDisagree, match="file: numbers: the file's own are others than those of the document"):
        from_linear_form(CHECKSUM_LINE.append_to(other), "file")


def test_a_sealed_file_that_is_no_toml_is_refused(package: CoefficientSet) -> None:
    body = CHECKSUM_LINE.checked_body(to_linear_form(package), "file")
    with pytest.raises(SetError, match="file: is no TOML file with the key document_json: "):
        from_linear_form(CHECKSUM_LINE.append_to(body.replace(b"document_json =", b"document_json")), "file")
