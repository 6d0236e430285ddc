"""The EPICS database, read by a reader of its own after the grammar of the EPICS Application Developer's Guide.

An IOC of EPICS Base 7.0.10 loaded these files once by hand: every record NO_ALARM, its value the document's, no put
taken. It is not among the test dependencies.
"""

import re

import numpy as np
import pytest
from foreign_sets import hostile, quadratic, warm
from solved import provenance, solved_axis, solved_package

from ams.calibration_result import Calibration
from ams.errors import VectorsDisagree
from ams.exports.epics import CHECKSUM_LINE, from_epics, to_epics
from ams.sets.coefficients import CoefficientSet, build_set

TOKEN = re.compile(r'\s+|#[^\n]*|(?P<word>\w+)|"(?P<text>(?:[^"\\\n]|\\.)*)"|(?P<sign>[(){},])')
LONGEST_PV_NAME = 60
LONGEST_STRING = 39


def tokens(text: str) -> list[str]:
    found, location = [], 0
    while location < len(text):
        match = TOKEN.match(text, location)
        assert match is not None, text[location : location + 60]
        location = match.end()
        found += [part for part in (match["word"], match["text"], match["sign"]) if part is not None]
    return found


def records(content: bytes, prefix: str) -> dict[str, dict[str, str]]:
    """PV name to its fields: `record(type, "name") { field(NAME, "value") … info(…) }`, macro P replaced."""
    text = re.sub(r"\$\(P=([^)]*)\)", lambda default: prefix or default[1], content.decode("ascii"))
    assert "$(" not in text
    found: dict[str, dict[str, str]] = {}
    rest = iter(tokens(text))
    for word in rest:
        assert (word, next(rest)) == ("record", "(")
        kind, _, name, _, _ = (next(rest) for _ in range(5))
        assert name not in found
        found[name] = {"RTYP": kind}
        while (word := next(rest)) != "}":
            assert word in ("field", "info")
            _, key, _, value, _ = (next(rest) for _ in range(5))
            if word == "field":
                found[name][key] = value
    return found


@pytest.fixture(scope="module")
def package() -> CoefficientSet:
    return build_set(solved_package(), provenance())


def test_the_records_alone_reproduce_the_vectors(package: CoefficientSet) -> None:
    pv = {name: float(fields["INP"]) for name, fields in records(to_epics(package), "").items() if "INP" in fields}
    for index in range(9):
        alpha, roll = np.radians(pv[f"SN1047:TEST{index}:PITCH_DEG"]), np.radians(pv[f"SN1047:TEST{index}:ROLL_DEG"])
        f = [np.sin(alpha), -np.cos(alpha) * np.sin(roll), -np.cos(alpha) * np.cos(roll)]
        for axis in "XYZ":
            k = [pv[f"SN1047:{axis}:K_{c}_V_PER_G"] for c in "XYZ"]
            expected = pv[f"SN1047:TEST{index}:{axis}_V"]
            assert pv[f"SN1047:{axis}:OFFSET_V"] + np.dot(k, f) == pytest.approx(expected, rel=0, abs=2.5e-12)


def test_records_have_units_and_refuse_puts(package: CoefficientSet) -> None:
    found = records(to_epics(package), "tunnel:aoa:")
    sensitivity = found["tunnel:aoa:X:SENSITIVITY_V_PER_G"]
    assert sensitivity == {
        "RTYP": "ai",
        "DESC": "X sensitivity_v_per_g",
        "INP": "2.5",
        "EGU": "V/g",
        "PREC": "12",
        "PINI": "YES",
        "DISP": "1",
    }
    assert float(found["tunnel:aoa:Z:POLARITY"]["INP"]) == -1.0
    assert float(found["tunnel:aoa:SET:GRAVITY_MPS2"]["INP"]) == 9.79826
    assert float(found["tunnel:aoa:VALID:PITCH_DEG:MIN"]["INP"]) == -90.0
    assert float(found["tunnel:aoa:X:OFFSET_V:SD"]["INP"]) == pytest.approx(np.sqrt(1.1e-12), rel=1e-15)
    assert found["tunnel:aoa:SET:STATUS"]["VAL"] == "engineering"


def test_the_two_halves_of_the_checksum_are_the_set(package: CoefficientSet) -> None:
    found = records(to_epics(package), "")
    assert found["SN1047:SET:SHA256_A"]["VAL"] + found["SN1047:SET:SHA256_B"]["VAL"] == package.sha256


@pytest.mark.parametrize("make", [hostile, warm, quadratic])
def test_every_record_keeps_to_the_lengths_of_epics(make: object) -> None:
    for name, fields in records(to_epics(make()), "").items():  # type: ignore[operator]
        assert len(name) <= LONGEST_PV_NAME
        assert re.fullmatch(r"[A-Za-z0-9_:-]+", name)
        assert len(fields.get("DESC", "")) <= 40
        assert len(fields.get("VAL", "")) <= LONGEST_STRING
        if "INP" in fields:
            assert np.isfinite(float(fields["INP"]))


def test_what_is_not_determined_has_no_record() -> None:
    solved = Calibration({"x": solved_axis("x", with_angles=False)}, "pitch-roll", "TP")
    found = records(to_epics(build_set(solved, provenance())), "")
    assert "SN1047:X:SENSITIVITY_V_PER_G" in found
    assert "SN1047:X:AZIMUTH_DEG" not in found


def test_the_file_says_what_the_records_lose(package: CoefficientSet) -> None:
    head = " ".join(line[2:].strip() for line in to_epics(package).decode().splitlines()[:6])
    assert "Loses: records hold coefficients" in head
    assert "the full covariance, provenance and equations stand in comments" in head


@pytest.mark.parametrize(
    ("old", "new"), [(b'(INP, "0.005")', b'(INP, "0.006")'), (b'(VAL, "engineering")', b'(VAL, "approved")')]
)
def test_a_sealed_database_with_other_values_than_its_document_disagrees(
    old: bytes, new: bytes, package: CoefficientSet
) -> None:
    body = CHECKSUM_LINE.checked_body(to_epics(package), "file")
    assert old in body
    with pytest.raises(VectorsDisagree, match=r"file: records: the file's own are others than those of the document"):
        from_epics(CHECKSUM_LINE.append_to(body.replace(old, new)), "file")
