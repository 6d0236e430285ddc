"""The certificate by the official schemas, and its numbers by an XML parser alone."""

import base64
import json
import os
from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from foreign_sets import HOSTILE, hostile, quadratic, warm
from solved import PARAMETERS, provenance, solved_axis, solved_package
from solved_sets import gyro_set

from ams.calibration_result import Calibration
from ams.errors import SetError, VectorsDisagree
from ams.exports.dcc import CHECKSUM_LINE, from_dcc, to_dcc
from ams.exports.dcc_administration import IssuedCertificate
from ams.exports.dcc_elements import D_SI
from ams.exports.dcc_schema import check_against_schemas
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Standard
from ams.sets.signature import Signature
from ams.sets.stated_verdict import Withdrawal
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


def elsewhere() -> CoefficientSet:
    """A set of work done at the customer's, whose contact is declared."""
    return package(job={"customer": "Tunnel Ltd", "customer_contact": "2 Wind Road", "location": "hall 3, 2 Wind Road"})


def capable(capability_deg: float = 0.002) -> CoefficientSet:
    """A set of a laboratory that declares a capability."""
    return package(laboratory={"name": "Instrument Laboratory", "capability_deg": capability_deg})


def approved() -> CoefficientSet:
    """A set that three persons signed, of a laboratory that is accredited."""
    return signed(package(laboratory={"name": "Instrument Laboratory", "accreditation": "D-K-00000"}))


AMENDING = IssuedCertificate("N-2", date(2026, 3, 5), "N-1", "address of the  customer")


def root_of(coefficients: CoefficientSet, certificate: IssuedCertificate | None = None) -> Any:
    return ElementTree.fromstring(to_dcc(coefficients, certificate))


def test_the_customers_contact_and_the_place_of_the_work_stand_in_it() -> None:
    def said(root: Any, path: str) -> list[str]:
        return [str(found.text) for found in root.iterfind(path, NS)]

    root, there = root_of(elsewhere()), ".//dcc:customer/dcc:location/dcc:further/dcc:content"
    assert said(root, there) == ["2 Wind Road"]
    assert said(root, ".//dcc:performanceLocation") == ["other"]
    assert "hall 3, 2 Wind Road" in said(root, ".//dcc:statement/dcc:declaration/dcc:content")
    at_home = root_of(package(job={"customer": "Tunnel Ltd"}))
    assert (said(at_home, there), said(at_home, ".//dcc:performanceLocation")) == (["not stated"], ["laboratory"])


def quantity(root: Any, identifier: str) -> Any:
    (found,) = root.iterfind(f".//dcc:quantity[@id='id-{identifier}']", NS)
    return found


@needs_schemas
@pytest.mark.parametrize(
    "make",
    [
        package,
        warm,
        quadratic,
        hostile,
        undetermined,
        bare,
        ordered,
        gyro_set,
        with_rejected_dwells,
        with_conditions,
        elsewhere,
        capable,
        approved,
    ],
)
def test_the_official_schemas_allow_it(make: Any, tmp_path: Path) -> None:
    path = tmp_path / "SN.xml"
    for certificate in (None, replace(AMENDING, replaces=None), AMENDING, replace(AMENDING, is_specimen=True)):
        path.write_bytes(to_dcc(make(), certificate))
        check_against_schemas(path, Path(str(SCHEMAS)))


def test_the_certificate_it_is_attached_to_identifies_it_and_the_one_that_is_replaced_is_named() -> None:
    """ISO/IEC 17025:2017, 7.8.2.1 d, 7.8.8.3; two certificates on one set are two files, each read as that set."""
    coefficients = package()
    core = root_of(coefficients, AMENDING).find(".//dcc:coreData", NS)
    told = {name: core.findtext(f"dcc:{name}", namespaces=NS) for name in ("uniqueIdentifier", "issueDate")}
    assert told == {"uniqueIdentifier": "N-2", "issueDate": "2026-03-05"}
    change = core.find("dcc:reportAmendedSubstituted", NS)
    assert [part.text for part in change] == ["substituted", "N-1"]
    assert statements(root_of(coefficients, AMENDING))["amendment"] == (
        "this certificate replaces certificate N-1, which is void; reason: address of the customer"
    )
    first = IssuedCertificate("N-1", date(2026, 3, 3))
    files = [to_dcc(coefficients, certificate) for certificate in (first, AMENDING)]
    assert files[0] != files[1]
    for content in files:
        assert from_dcc(content, "file").sha256 == coefficients.sha256
        assert f"<dcc:value>{coefficients.sha256}</dcc:value>".encode() in content
    assert b"reportAmendedSubstituted" not in files[0]


def test_a_mere_export_is_identified_by_the_checksum_of_its_set() -> None:
    coefficients = package()
    root = root_of(coefficients)
    assert root.findtext(".//dcc:uniqueIdentifier", namespaces=NS) == f"calrig-{coefficients.sha256}"
    assert root.find(".//dcc:issueDate", NS) is None


def test_no_uncertainty_is_stated_below_the_capability() -> None:
    """By hand: 0.002 deg is 3.4907e-5 rad, of S on an output; 0.002 deg on the coning angle; over sin of it on A."""
    root = root_of(capable())
    for axis, (_, sensitivity, coning_deg, _) in PARAMETERS.items():
        effect_v = abs(sensitivity) * 3.4906585e-5
        for name in ("offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g"):
            stated = quantity(root, f"{axis}.primary.{name.replace('_', '_5f_')}").find("si:real/si:expandedUnc", NS)
            assert float(stated.findtext("si:uncertainty", namespaces=NS)) == pytest.approx(effect_v, rel=1e-6)
            assert float(stated.findtext("si:coverageFactor", namespaces=NS)) == 2.0
        azimuth_deg = 0.002 / np.sin(np.radians(coning_deg))
        derived = {"sensitivity_v_per_g": effect_v, "coning_deg": 0.002, "azimuth_deg": azimuth_deg}
        for name, floor in derived.items():
            real = quantity(root, f"{axis}.parameters.{name.replace('_', '_5f_')}").find("si:real", NS)
            value, *ends, u = (
                float(real.findtext(f"si:{key}", namespaces=NS))
                for key in ("value", *(f"coverageInterval/si:{key}" for key in ("intervalMin", "intervalMax")),
                            "coverageInterval/si:standardUnc")
            )  # fmt: skip
            assert [value - ends[0], ends[1] - value] == pytest.approx([floor, floor], rel=1e-6)
            assert u == pytest.approx(floor / 2, rel=1e-6)
    assert statements(root)["capability"].startswith(
        "no expanded uncertainty or interval is stated below the laboratory's capability of 0.002°"
    )


def test_a_capability_below_what_was_calculated_changes_no_uncertainty() -> None:
    found = [
        {entry.get("id"): "".join(entry.itertext()) for entry in root_of(made).iterfind(".//dcc:quantity", NS)}
        for made in (capable(1e-9), package())
    ]
    assert found[0] == found[1]
    assert "capability" not in statements(root_of(package()))


def statements(root: Any) -> dict[str, str]:
    """Return what the DCC declares, by its name."""
    entries = root.iterfind(".//dcc:statement", NS)
    return {
        entry.findtext("dcc:name/dcc:content", namespaces=NS): entry.findtext(
            "dcc:declaration/dcc:content", namespaces=NS
        )
        for entry in entries
    }


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
    printed = {"offset_v": "5", "k_x_v_per_g": "> 10 000", "k_z_v_per_g": "∞"}
    axis = type(solved)(**{**vars(solved), "primary_dof": np.array([5.0, 2963126830.39 / 1e3, 5.0, np.inf])})
    root = root_of(build_set(Calibration({"x": axis}, "pitch-roll", "TP"), provenance()))
    for name, factor in zip(dof, (2.5706, 1.9600), strict=True):
        real = quantity(root, f"x.primary.{name.replace('_', '_5f_')}").find("si:real", NS)
        stated = float(real.findtext("si:expandedUnc/si:coverageFactor", namespaces=NS))
        expanded = float(real.findtext("si:expandedUnc/si:uncertainty", namespaces=NS))
        variance = solved.primary_covariance[list(solved.primary_names).index(name)].max()
        assert stated == pytest.approx(factor, abs=5e-5)
        assert expanded == pytest.approx(stated * np.sqrt(variance), rel=1e-9)
        assert real.findtext("si:unit", namespaces=NS) == r"\volt"
    for name, words in printed.items():
        about = quantity(root, f"x.primary.{name.replace('_', '_5f_')}").findtext(
            "dcc:description/dcc:content", namespaces=NS
        )
        assert about.endswith(f"effective degrees of freedom {words}")


def test_the_parts_of_a_covariance_stand_apart() -> None:
    root = root_of(package())
    row = quantity(root, "x.covariance_2c__20_part_3a__20_table.offset_5f_v")
    assert [float(part) for part in row.findtext(".//si:valueXMLList", namespaces=NS).split()] == [1e-13] * 4


def persons(root: Any) -> list[tuple[str, str, str]]:
    """Return name, role and whether it is the main signer of everybody who answers for a DCC."""
    paths = ("dcc:person/dcc:name/dcc:content", "dcc:role", "dcc:mainSigner")
    found = root.iterfind(".//dcc:respPerson", NS)
    return [tuple(person.findtext(path, namespaces=NS) for path in paths) for person in found]


def signed(coefficients: CoefficientSet) -> CoefficientSet:
    """Return the set as an archive hands it out in which three persons signed it."""
    moment, words = datetime(2026, 3, 2, 9, 5, tzinfo=UTC), {"A. Ray": "prepared", "C. Reader": "reviewed"}
    before = [Signature(role, name, moment, "") for name, role in words.items()]
    return replace(
        coefficients, signatures=(*before, Signature("approved", "B. Chief", moment, "", "head of the laboratory"))
    )


def test_a_line_of_the_rig_file_makes_nobody_a_signer() -> None:
    """ISO/IEC 17025:2017, 7.8.2.1 o: who authorises is who signed; the schema wants a person, who then signed not."""
    for approved_by, status in (
        (None, "engineering: not approved, not a certificate"),
        ("M. Chief", "rig and procedure were approved by M. Chief, as the rig file says and nobody signed; no approval "
         "of this set by signature is known here: not a certificate"),
    ):  # fmt: skip
        root = root_of(package(approved_by=approved_by))
        assert persons(root) == [("J. Doe", "operator; no signature on this set is known here", "false")]
        assert statements(root)["status"] == status
    assert persons(root_of(bare()))[0][1:] == ("no signature on this set is known here", "false")


def test_the_persons_are_those_who_signed_with_their_roles_and_the_approver_is_the_main_signer() -> None:
    coefficients = signed(package(approved_by="M. Chief"))
    root = root_of(coefficients, AMENDING)
    assert persons(root) == [
        ("A. Ray", "prepared", "false"),
        ("C. Reader", "reviewed", "false"),
        ("B. Chief", "approved, head of the laboratory", "true"),
    ]
    assert statements(root)["status"] == "approved"
    assert "approved since by B. Chief" in statements(root)["attached set"]
    gone = replace(coefficients, withdrawal=Withdrawal("A. Ray", datetime(2026, 3, 5, tzinfo=UTC), "loose mount"))
    assert {main for *_, main in persons(root_of(gone))} == {"false"}
    withdrawn = "withdrawn by A. Ray on 2026-03-05 (UTC): loose mount: not a certificate"
    assert statements(root_of(gone))["status"] == withdrawn


def test_a_specimen_says_so_to_readers_and_to_machines() -> None:
    specimen = replace(AMENDING, is_specimen=True)
    root = root_of(signed(package()), specimen)
    first = root.find(".//dcc:statement", NS)
    assert first.findtext("dcc:declaration/dcc:content", namespaces=NS).startswith("SPECIMEN: NOT A CERTIFICATE")
    assert first.findtext("dcc:valid", namespaces=NS) == "false"
    assert root.findtext(".//dcc:uniqueIdentifier", namespaces=NS).startswith("SPECIMEN: NOT A CERTIFICATE")
    assert {main for *_, main in persons(root)} == {"false"}
    assert root.find(".//dcc:issueDate", NS) is None
    assert b"N-2" not in to_dcc(package(), specimen)


def test_the_accreditation_of_the_laboratory_stands_in_it() -> None:
    root = root_of(package(laboratory={"name": "Instrument Laboratory", "accreditation": "D-K-00000"}))
    assert root.findtext(".//dcc:calibrationLaboratoryCode", namespaces=NS) == "D-K-00000"
    assert statements(root)["accreditation of the laboratory"] == "D-K-00000"


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
