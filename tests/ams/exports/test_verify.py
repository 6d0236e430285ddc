"""Verification of files: what is told apart, and that nothing changed passes. The frozen file is of version 1."""

import json
from collections.abc import Callable
from dataclasses import replace
from math import cos, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from changed_sets import changed, write_changed
from solved import provenance, solved_axis, solved_package

from ams.calibration_result import Calibration
from ams.errors import SetError, VectorsDisagree
from ams.exports.formats import FORMATS, export_set, load_set
from ams.exports.verify import verify
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set

DATA = Path(__file__).parents[2] / "data"
FLIPS = 400


@pytest.fixture(scope="module")
def coefficients() -> CoefficientSet:
    return build_set(solved_package(), provenance())


@pytest.fixture(scope="module")
def single() -> CoefficientSet:
    return build_set(solved_package("y"), provenance())


def smallest(name: str, single: CoefficientSet, coefficients: CoefficientSet) -> bytes:
    """Return the shortest file of a format: imucal takes triads alone."""
    return FORMATS[name].to_bytes(coefficients if name == "imucal" else single)


@pytest.mark.parametrize("name", FORMATS)
def test_every_export_is_verified_and_is_the_same_set(name: str, coefficients: CoefficientSet, tmp_path: Path) -> None:
    path = tmp_path / FORMATS[name].file_name("SN1047")
    export_set(coefficients, name, path)
    verification = verify(path)
    assert load_set(path) == coefficients
    assert (verification.sha256, verification.format) == (coefficients.sha256, name)
    assert (verification.forward_vectors, verification.inverse_vectors) == (9, 7)
    assert verification.largest_relative_error <= verification.tolerance_relative == 1e-12


@pytest.mark.parametrize("name", FORMATS)
def test_the_same_set_exports_to_the_same_bytes(name: str, coefficients: CoefficientSet) -> None:
    again = build_set(solved_package(), provenance())
    assert FORMATS[name].to_bytes(coefficients) == FORMATS[name].to_bytes(again)


@pytest.mark.parametrize("name", FORMATS)
def test_a_changed_byte_anywhere_is_damage(name: str, single: CoefficientSet, coefficients: CoefficientSet) -> None:
    content = smallest(name, single, coefficients)
    rng = np.random.default_rng(11)
    for position, mask in zip(rng.integers(0, len(content), FLIPS), rng.integers(1, 256, FLIPS), strict=True):
        assert_damaged(name, content, int(position), int(mask))


@pytest.mark.soak
@pytest.mark.parametrize("name", FORMATS)
def test_every_single_bit_counts(name: str, single: CoefficientSet, coefficients: CoefficientSet) -> None:
    content = smallest(name, single, coefficients)
    for position in range(len(content)):
        for bit in range(8):
            assert_damaged(name, content, position, 1 << bit)


def assert_damaged(name: str, content: bytes, position: int, mask: int) -> None:
    damaged = bytearray(content)
    damaged[position] ^= mask
    with pytest.raises(SetError, match=r"file: .+|file:\d+: .+"):
        FORMATS[name].from_bytes(bytes(damaged), "file")


def test_a_digit_that_rounds_to_the_same_double_is_a_changed_byte_too(single: CoefficientSet) -> None:
    """2.4699639…: the 17th digit of many doubles can change without changing the double."""
    content = FORMATS["json"].to_bytes(single)
    value = next(v for v in single.axes["y"].primary.values() if len(repr(v)) >= 19)
    text = repr(value)
    other = next(text[:-1] + d for d in "0123456789" if d != text[-1] and float(text[:-1] + d) == value)
    with pytest.raises(SetError, match="is not byte for byte what was written, though its values read the same"):
        FORMATS["json"].from_bytes(content.replace(text.encode(), other.encode()), "file")


@pytest.mark.parametrize(("ending", "line"), [(b"\r\n", 1), (b"\n\n", 2)])
def test_changed_line_ends_are_told(ending: bytes, line: int, single: CoefficientSet) -> None:
    content = FORMATS["json"].to_bytes(single).replace(b"\n", ending)
    with pytest.raises(SetError, match=rf"file:{line}: is not byte for byte what was written.*take an intact copy"):
        FORMATS["json"].from_bytes(content, "file")


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("part", [0.0, 0.001, 0.3, 0.9, 0.9999])
def test_a_truncated_file_is_damage(
    name: str, part: float, single: CoefficientSet, coefficients: CoefficientSet, tmp_path: Path
) -> None:
    content = smallest(name, single, coefficients)
    path = tmp_path / FORMATS[name].file_name("SN")
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(SetError, match=r"SN\.[\w.]+: (is empty|is truncated|is not|checksum)"):
        verify(path)


def test_every_prefix_of_a_json_set_is_called_truncated(single: CoefficientSet) -> None:
    content = FORMATS["json"].to_bytes(single)
    for length in range(1, len(content), 97):
        with pytest.raises(SetError, match=rf"file: is truncated: it breaks off after {length} bytes|no text in UTF-8"):
            FORMATS["json"].from_bytes(content[:length], "file")


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is empty: got 0 bytes"),
        (b"\n \n", "is empty: got 3 bytes"),
        (b"\xff\xfe\x00", "is no text in UTF-8: byte 0 is 0xff"),
        (b"hello", "is not JSON: Expecting value"),
        (b"{]}\n", "is not JSON: "),
        (b"[" * 100_000, "is not JSON: "),
        (b'{"a": NaN}\n', "a: got NaN, allowed is a number of at most"),
        (b'{"a": [1, {"b": 1e999}]}\n', "a/1/b: got 1e999, allowed is a number of at most"),
        (b'{"a": NaN, "b": ', "is truncated: it breaks off after 16 bytes"),
        (b'{"a": "\\ud800"}\n', "is not JSON: "),
        (b"[1, 2]\n", "is not a coefficient set: got a list"),
        (b'{"a": 1}\n', 'is not a coefficient set: got a document without "format"'),
        (b'{"format": "calrig plan"}\n', "is not a coefficient set: got \"format\": 'calrig plan'"),
        (b'{"format": "calrig coefficient set"}\n', "version: is no version of a coefficient set: got None"),
        (
            b'{"format": "calrig coefficient set", "version": 5}\n',
            "version: was written by a newer calrig: got version 5",
        ),
        (b'{"format": "calrig coefficient set", "version": 1}\n', "checksum: is missing"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_in_its_own_sentence(content: bytes, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "SN.json"
    path.write_bytes(content)
    with pytest.raises(SetError) as caught:
        verify(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert sentence in str(caught.value)


NO_DOUBLES = ("1e400", "-1e400", "NaN", "Infinity", "-Infinity", "1" + 400 * "0", "1" + 5000 * "0")


@pytest.mark.parametrize("number", NO_DOUBLES)
@pytest.mark.parametrize("end", [b"\n", b"", b"\r\n"])
def test_a_number_that_no_double_holds_is_told_by_its_key(number: str, end: bytes, single: CoefficientSet) -> None:
    """However the file ends: it is whole, whatever else is wrong with it."""
    document = json.loads(FORMATS["json"].to_bytes(single))
    document["axes"]["y"]["primary"]["values"]["offset_v"] = "here"
    content = json.dumps(document).replace('"here"', number).encode() + end
    with pytest.raises(SetError) as caught:
        FORMATS["json"].from_bytes(content, "file")
    shown = number if len(number) <= 40 else f"{number[:40]}…"
    assert f"file: axes/y/primary/values/offset_v: got {shown}, allowed is a number of at most" in str(caught.value)
    assert "the set is not used" in str(caught.value)


def test_a_changed_number_is_told_by_the_checksum(single: CoefficientSet) -> None:
    content = FORMATS["json"].to_bytes(single).replace(b'"value": 2.47,', b'"value": 2.48,')
    with pytest.raises(SetError, match=r"checksum: does not fit the content: stated [0-9a-f]{64}, computed"):
        FORMATS["json"].from_bytes(content, "file")


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda d: d.pop("validity"), "document: .*'validity' is a required property"),
        (lambda d: d.update(extra=1), "document: .*'extra' was unexpected"),
        (lambda d: d["axes"]["y"].update(nominal_axis="w"), "axes/y/nominal_axis: .*'w' is not one of"),
        (lambda d: d["axes"]["y"]["primary"]["values"].update(offset_v=None), "axes/y/primary/values/offset_v"),
        (lambda d: d["provenance"].update(created_utc="yesterday"), "provenance/created_utc"),
        (lambda d: d["test_vectors"].update(forward=[]), "test_vectors/forward"),
        (lambda d: d["convention"].update(name="WGS"), "convention/name"),
    ],
)
def test_a_sealed_file_of_another_shape_is_told_by_the_schema(
    change: Callable[[dict[str, Any]], object], where: str, single: CoefficientSet, tmp_path: Path
) -> None:
    with pytest.raises(SetError, match=where):
        verify(write_changed(tmp_path / "SN.json", single, change))


def test_a_sealed_file_with_another_convention_is_not_used(single: CoefficientSet, tmp_path: Path) -> None:
    path = write_changed(tmp_path / "SN.json", single, lambda d: d["convention"].update(name="CR"))
    with pytest.raises(SetError, match=r"convention: does not go with the equations of this set: got CR"):
        verify(path)


def test_a_sealed_file_with_vectors_for_other_axes_is_not_used(single: CoefficientSet, tmp_path: Path) -> None:
    path = write_changed(tmp_path / "SN.json", single, lambda d: d["axes"].update(q=d["axes"].pop("y")))
    with pytest.raises(SetError, match="test_vectors: are for other axes: got y, the set has q"):
        verify(path)


def to_cr_numbers(document: dict[str, Any]) -> None:
    """CR's numbers for the same sensor: sensitivity per g of gravity (opposite sign), azimuth a quarter turn on."""
    section = document["axes"]["y"]
    section["parameters"]["sensitivity_v_per_g"]["value"] *= -1.0
    section["parameters"]["azimuth_deg"]["value"] += 90.0
    for name in ("k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g"):
        section["primary"]["values"][name] *= -1.0


def test_the_numbers_of_another_convention_disagree_with_the_vectors(single: CoefficientSet, tmp_path: Path) -> None:
    path = write_changed(tmp_path / "SN.json", single, to_cr_numbers)
    with pytest.raises(VectorsDisagree, match=r"axis y: .*do not use this set"):
        verify(path)


def test_the_numbers_of_another_sensor_disagree_with_the_vectors(coefficients: CoefficientSet, tmp_path: Path) -> None:
    other = Calibration({"x": solved_axis("y"), "y": solved_axis("y"), "z": solved_axis("z")}, "pitch-roll", "TP")
    axes = build_set(other, provenance()).document["axes"]
    path = write_changed(tmp_path / "SN.json", coefficients, lambda d: d.update(axes=axes))
    with pytest.raises(VectorsDisagree, match=r"SN\.json: axis x: test vector at pitch 0\.0°, roll 0\.0° is not rep"):
        verify(path)


@pytest.mark.parametrize("kind", ["forward", "inverse"])
def test_a_vector_that_is_off_by_a_millionth_of_a_microvolt_counts(
    kind: str, coefficients: CoefficientSet, tmp_path: Path
) -> None:
    def nudge(document: dict[str, Any]) -> None:
        document["test_vectors"][kind][3]["outputs_v"]["z"] += 1e-11

    with pytest.raises(VectorsDisagree, match="test vector at"):
        verify(write_changed(tmp_path / "SN.json", coefficients, nudge))


def of_another_version(document: dict[str, Any]) -> None:
    document["version"] = 99


def of_another_convention(document: dict[str, Any]) -> None:
    document["convention"]["name"] = "CR"


def of_another_sensor(document: dict[str, Any]) -> None:
    other = Calibration({"x": solved_axis("y"), "y": solved_axis("y"), "z": solved_axis("z")}, "pitch-roll", "TP")
    document["axes"] = build_set(other, provenance()).document["axes"]


def _write_and_verify(name: str, coefficients: CoefficientSet, folder: Path) -> None:
    path = folder / FORMATS[name].file_name("SN")
    path.write_bytes(FORMATS[name].to_bytes(coefficients))
    verify(path)


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (of_another_version, "version"),
        (of_another_convention, "convention"),
        (of_another_sensor, "test vector at .* is not reproduced|the file's own are others than those of the document"),
    ],
)
def test_a_whole_file_that_means_something_else_is_refused_in_every_format(
    name: str,
    change: Callable[[dict[str, Any]], object],
    sentence: str,
    coefficients: CoefficientSet,
    tmp_path: Path,
) -> None:
    """Written by the format's own writer, seals and all: only the meaning is wrong. Some writers refuse it already."""
    other = replace(coefficients, document=changed(coefficients, change))
    with pytest.raises((SetError, VectorsDisagree), match=sentence):
        _write_and_verify(name, other, tmp_path)


@pytest.mark.parametrize("name", FORMATS)
def test_the_vectors_of_every_format_are_recomputed(name: str, coefficients: CoefficientSet, tmp_path: Path) -> None:
    """Each format's writer, given a set whose coefficients contradict its vectors."""
    json_path = write_changed(
        tmp_path / "SN.json", coefficients, lambda d: d["axes"]["x"]["primary"]["values"].update(offset_v=0.006)
    )
    path = tmp_path / FORMATS[name].file_name("SN")
    path.write_bytes(FORMATS[name].to_bytes(load_set(json_path)))
    with pytest.raises(VectorsDisagree, match="axis x"):
        verify(path)


@pytest.mark.parametrize("file_name", ["SN.xyz", "SN"])
def test_a_file_of_no_known_name_is_refused(file_name: str, tmp_path: Path) -> None:
    with pytest.raises(SetError, match=r"is no coefficient set by its name: .*allowed are \.h, \.fixed\.h, \.csv"):
        verify(tmp_path / file_name)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SetError, match=r"none\.json: cannot be read: No such file"):
        verify(tmp_path / "none.json")


@pytest.mark.parametrize("name", [name for name, known in FORMATS.items() if known.since == 1])
def test_a_file_of_version_1_is_still_read(name: str) -> None:
    path = DATA / FORMATS[name].file_name("coefficient_set_v1")
    assert verify(path).sha256 == "66873e5514e27816911d54be709f17ddb6f61bdead1c33c65af5c7ce789e9a6b"
    b, s, w, a = -0.0121, 2.47, radians(0.31), radians(-120.0)
    alpha, roll = radians(20.0), radians(-75.0)
    bracket = sin(a) * sin(alpha) - cos(a) * cos(roll) * cos(alpha)
    expected_v = b - s * (cos(w) * sin(roll) * cos(alpha) - sin(w) * bracket)  # TP (4)
    assert apply(load_set(path), alpha, roll)["y"] == pytest.approx(expected_v, abs=1e-14)


def test_no_format_that_has_a_file_of_version_1_claims_to_have_come_later() -> None:
    stored = {path.name for path in DATA.glob("coefficient_set_v1.*")}
    assert stored == {known.file_name("coefficient_set_v1") for known in FORMATS.values() if known.since == 1}


def test_the_frozen_file_is_read_by_json_alone() -> None:
    document = json.loads((DATA / "coefficient_set_v1.json").read_text("utf-8"))
    assert (document["format"], document["version"]) == ("calrig coefficient set", 1)


def test_the_difference_that_is_told_is_the_largest_of_all_vectors(single: CoefficientSet, tmp_path: Path) -> None:
    """One output is off by 5e-13 of the scale of its axis, which the tolerance allows: 500 times what rounding does."""
    numbers = single.axes["y"]

    def shift(document: dict[str, Any]) -> None:
        document["test_vectors"]["forward"][3]["outputs_v"]["y"] += 5e-13 * numbers.scale_v

    path = write_changed(tmp_path / "set.json", single, shift)
    assert verify(path).largest_relative_error == pytest.approx(5e-13, rel=2e-2, abs=0.0)
