"""The certificate by the official schemas, and its numbers by an XML parser alone."""

import base64
import json
import os
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from foreign_sets import HOSTILE, hostile, quadratic, warm
from solved import provenance, solved_axis, solved_package
from solved_sets import gyro_set

from ams.calibration_result import Calibration
from ams.errors import SetError, VectorsDisagree
from ams.exports.dcc import CHECKSUM_LINE, from_dcc, to_dcc
from ams.exports.dcc_elements import D_SI
from ams.exports.dcc_schema import check_against_schemas
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Standard
from ams.units import UNITS

SCHEMAS = os.environ.get("CALRIG_DCC_SCHEMAS")
needs_schemas = pytest.mark.skipif(not SCHEMAS, reason="CALRIG_DCC_SCHEMAS is not set: no official schemas to ask")
NS = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}


def package(**changes: object) -> CoefficientSet:
    return build_set(solved_package(), provenance(**changes))


def undetermined() -> CoefficientSet:
    return build_set(Calibration({"x": solved_axis("x", with_angles=False)}, "pitch-roll", "TP"), provenance())


def bare() -> CoefficientSet:
    """A set of which nothing is declared but what is required."""
    nothing = dict.fromkeys(
        ("serial", "sensor_model", "operator", "run_id", "journal_sha256", "temperature_range_degc")
    )
    nothing |= dict.fromkeys(("mount", "chain", "job", "laboratory"))
    return package(**nothing, environment={}, standards=())


def ordered() -> CoefficientSet:
    """A set whose work order says something of its own."""
    return package(job={"number": "J-7", "fields": {"cost centre": "30-221"}})


def with_rejected_dwells() -> CoefficientSet:
    """A set that states the uncertainty of gravity, what a standard was used for and which dwell does not count."""
    dwell = {"purpose": "design", "replication": 2, "point": 7, "attempt": 1, "measured_again": True}
    return package(
        gravity_uncertainty_mps2=2e-6,
        standards=(Standard("table", "77", "C-1", None, {"kind": "limit"}, ("axes.pitch", "axes.roll")),),
        dwells={"measured": 40, "rejected": [{**dwell, "reasons": ["dmm.x: noise <3 µV & more>"]}]},
    )


def with_conditions() -> CoefficientSet:
    """A set that states what read the outputs, the volts of the supply and the humidity."""
    dmm = {"driver": "hp3458a", "identity": "HP3458A", "axes": ["x"], "scanned": True, "crosstalk_ratio": 1e-5}
    return package(
        job={"relative_humidity_percent": [38.0, 46.5]},
        readouts={"dmm": dmm},
        supplies={"dmm.s": {"mean_v": 5.0, "min_v": 4.99, "max_v": 5.01}},
    )


def root_of(coefficients: CoefficientSet) -> Any:
    return ElementTree.fromstring(to_dcc(coefficients))


def quantity(root: Any, identifier: str) -> Any:
    (found,) = root.iterfind(f".//dcc:quantity[@id='id-{identifier}']", NS)
    return found


@needs_schemas
@pytest.mark.parametrize(
    "make",
    [package, warm, quadratic, hostile, undetermined, bare, ordered, gyro_set, with_rejected_dwells, with_conditions],
)
def test_the_official_schemas_allow_it(make: Any, tmp_path: Path) -> None:
    path = tmp_path / "SN.xml"
    path.write_bytes(to_dcc(make()))
    check_against_schemas(path, Path(str(SCHEMAS)))


def test_a_field_of_the_work_order_is_an_identification_of_the_certificate() -> None:
    core = root_of(ordered()).find(".//dcc:coreData/dcc:identifications", NS)
    told = [" ".join(entry.itertext()) for entry in core.iterfind("dcc:identification", NS)]
    assert [text.split() for text in told][:2] == [
        ["calibrationLaboratory", "J-7", "job"], ["other", "30-221", "cost", "centre"],
    ]  # fmt: skip


@needs_schemas
def test_what_the_official_schemas_do_not_allow_is_told_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "SN.xml"
    path.write_bytes(to_dcc(package()).replace(b'schemaVersion="3.2.1"', b'schemaVersion="2.0.0"'))
    with pytest.raises(SetError, match=r"SN\.xml: is no DCC by dcc_3_2_1\.xsd: line 2: .*schemaVersion"):
        check_against_schemas(path, Path(str(SCHEMAS)))


def test_schemas_that_are_not_there_are_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "SN.xml"
    path.write_bytes(to_dcc(package()))
    with pytest.raises(SetError, match=r"the DCC schemas cannot be read: .*No such file.*was not validated"):
        check_against_schemas(path, tmp_path)


def test_the_quantities_alone_reproduce_the_vectors() -> None:
    root = root_of(package())

    def column(name: str) -> np.ndarray:
        return np.array(quantity(root, name).findtext(".//si:valueXMLList", namespaces=NS).split(), dtype=float)

    alpha, roll = np.radians(column("vectors.pitch_5f_deg")), np.radians(column("vectors.roll_5f_deg"))
    f = [np.sin(alpha), -np.cos(alpha) * np.sin(roll), -np.cos(alpha) * np.cos(roll)]
    for axis in "xyz":
        names = ["offset_v", *(f"k_{c}_v_per_g" for c in "xyz")]
        ids = [f"{axis}.primary.{name.replace('_', '_5f_')}" for name in names]
        b, *k = (float(quantity(root, entry).findtext("si:real/si:value", namespaces=NS)) for entry in ids)
        outputs_v = b + sum(k[i] * f[i] for i in range(3))
        assert outputs_v == pytest.approx(column(f"vectors.output_20_of_20_{axis}"), rel=0, abs=2.5e-12)


def test_an_expanded_uncertainty_names_its_coverage_factor() -> None:
    """Student's t for 95 %: 2.5706 at 5 degrees of freedom, 1.9600 at infinitely many (GUM, table G.2)."""
    solved = solved_axis("x")
    dof = {"offset_v": 5.0, "k_z_v_per_g": np.inf}
    axis = type(solved)(**{**vars(solved), "primary_dof": np.array([5.0, 5.0, 5.0, np.inf])})
    root = root_of(build_set(Calibration({"x": axis}, "pitch-roll", "TP"), provenance()))
    for name, factor in zip(dof, (2.5706, 1.9600), strict=True):
        real = quantity(root, f"x.primary.{name.replace('_', '_5f_')}").find("si:real", NS)
        stated = float(real.findtext("si:expandedUnc/si:coverageFactor", namespaces=NS))
        expanded = float(real.findtext("si:expandedUnc/si:uncertainty", namespaces=NS))
        variance = solved.primary_covariance[list(solved.primary_names).index(name)].max()
        assert stated == pytest.approx(factor, abs=5e-5)
        assert expanded == pytest.approx(stated * np.sqrt(variance), rel=1e-9)
        assert real.findtext("si:unit", namespaces=NS) == r"\volt"


def test_the_parts_of_a_covariance_stand_apart() -> None:
    root = root_of(package())
    row = quantity(root, "x.covariance_2c__20_part_3a__20_table.offset_5f_v")
    assert [float(part) for part in row.findtext(".//si:valueXMLList", namespaces=NS).split()] == [1e-13] * 4


def test_a_set_that_nobody_approved_says_so_and_an_approved_one_names_who() -> None:
    def told(root: Any) -> tuple[str, str, str]:
        status = root.find(".//dcc:statement/dcc:declaration/dcc:content", NS).text
        person = root.findtext(".//dcc:respPerson/dcc:person/dcc:name/dcc:content", namespaces=NS)
        return status, person, root.findtext(".//dcc:mainSigner", namespaces=NS)

    assert told(root_of(package())) == ("engineering: not approved, not a certificate", "J. Doe", "false")
    assert told(root_of(package(approved_by="A. Smith"))) == ("approved", "A. Smith", "true")


def test_dates_place_and_standards_are_the_runs() -> None:
    root = root_of(package(laboratory={"name": "Instrument Laboratory", "country_code": "US"}))
    dates = [root.findtext(f".//dcc:{end}PerformanceDate", namespaces=NS) for end in ("begin", "end")]
    assert dates == ["2026-02-28", "2026-03-01"]
    assert root.findtext(".//dcc:countryCodeISO3166_1", namespaces=NS) == "US"
    names = [entry.text for entry in root.iterfind(".//dcc:measuringEquipment/dcc:name/dcc:content", NS)]
    assert names == ["table", "meter", "local gravity"]


def test_the_attachment_is_the_set() -> None:
    coefficients = hostile()
    attached = root_of(coefficients).findtext(".//dcc:byteData[@id='id-set']/dcc:dataBase64", namespaces=NS)
    document = json.loads(base64.b64decode(attached))
    assert document["provenance"]["operator"] == HOSTILE
    assert document == coefficients.document


def test_a_sealed_certificate_with_other_quantities_than_its_attachment_disagrees() -> None:
    body = CHECKSUM_LINE.checked_body(to_dcc(package()), "file")
    assert body.count(b"<si:value>2.5</si:value>") == 1
    other = body.replace(b"<si:value>2.5</si:value>", b"<si:value>2.6</si:value>")
    with pytest.raises(VectorsDisagree, match="file: quantities: the file's own are others than those of the document"):
        from_dcc(CHECKSUM_LINE.append_to(other), "file")


def test_another_laboratorys_certificate_is_refused() -> None:
    body = CHECKSUM_LINE.checked_body(to_dcc(package()), "file").replace(b'id="id-set"', b'id="id-other"')
    with pytest.raises(SetError, match="file: has no attached set with the id id-set; another laboratory's DCC"):
        from_dcc(CHECKSUM_LINE.append_to(body), "file")


@pytest.mark.parametrize("bomb", [b"<!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/hostname'>]><a>&b;</a>\n", b"<a>\n"])
def test_entities_fetch_nothing_and_broken_xml_is_refused(bomb: bytes) -> None:
    content = CHECKSUM_LINE.append_to(b'<?xml version="1.0" encoding="UTF-8"?>\n' + bomb)
    with pytest.raises(SetError, match=r"file: (is no XML|has no attached set)"):
        from_dcc(content, "file")


def test_every_unit_of_a_set_is_written_in_d_si() -> None:
    """A term of second order in temperature among them: one unit that was forgotten leaves a run without its PDF."""
    assert set(UNITS.values()) <= set(D_SI)
