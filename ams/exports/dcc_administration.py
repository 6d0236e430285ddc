"""The administrative ring of a DCC: who calibrated what for whom, and with what right; the unknown is named so."""

import json
import re
from dataclasses import dataclass
from datetime import date

from ams.exports.dcc_elements import NOT_STATED, Element, Elements, clean, contact, content, identification, plain
from ams.sets.canonical import Document, Json, listed, table
from ams.sets.capability import capability_deg_of
from ams.sets.coefficients import CoefficientSet
from ams.sets.instructions import use_of
from ams.sets.stated_dwells import dwells_in_words, rejected_lines
from ams.sets.stated_findings import axis_reservations, fact_of
from ams.sets.stated_verdict import conditions_in_words
from ams.sets.verdict_conditions import NOT_BUDGETED

UNKNOWN_COUNTRY = "XX"
"""User-assigned in ISO 3166-1, used for 'unknown'."""
SPECIMEN = "SPECIMEN: NOT A CERTIFICATE"
SIMULATED = "; SIMULATED on a twin, not on hardware"
NO_SIGNATURE = "no signature on this set is known here"
"""A file that was exported from a file knows none; one from an archive knows what is signed there."""


@dataclass(frozen=True)
class IssuedCertificate:
    """The certificate that a DCC is attached to: its number is what identifies the DCC, as another does for the next.

    Source: ISO/IEC 17025:2017, 7.8.2.1 d, 7.8.8.
    """

    number: str
    issued: date
    replaces: str | None = None
    """Number of the certificate that is void since this one was issued."""
    reason: str = ""
    is_specimen: bool = False
    """To look at, never to be sent: it is no certificate, has no number to be found by and no signer."""


def administrative_data(coefficients: CoefficientSet, certificate: IssuedCertificate | None = None) -> Element:
    """Return the administrative data, the first ring of a certificate; ``certificate``: None of a mere export."""
    provenance = coefficients.provenance
    laboratory, job = declared(provenance["laboratory"]), declared(provenance["job"])
    lab = contact("dcc:contact", laboratory.get("name"), laboratory.get("address"))
    accreditation = laboratory.get("accreditation")
    code = [plain("dcc:calibrationLaboratoryCode", accreditation)] if accreditation else []
    sensor = table(coefficients.document["sensor"])
    model = [plain("dcc:model", sensor["model"])] if sensor["model"] else []
    described = [content("dcc:description", job["item"])] if job.get("item") else []
    known = [identification("manufacturer", sensor["serial"], "serial number")] if sensor["serial"] else []
    known.append(identification("calibrationLaboratory", sensor["name"], "name in the rig file"))
    name = content("dcc:name", sensor["name"])
    return Element(
        "dcc:administrativeData",
        [
            Element("dcc:dccSoftware", [software(coefficients)]),
            _core_data(coefficients, laboratory, job, certificate),
            Element(
                "dcc:items", [Element("dcc:item", [name, *described, *model, Element("dcc:identifications", known)])]
            ),
            Element("dcc:calibrationLaboratory", [*code, lab]),
            Element("dcc:respPersons", _persons(coefficients, certificate)),
            contact("dcc:customer", job.get("customer"), job.get("customer_contact")),
            Element("dcc:statements", _statements(coefficients, certificate)),
        ],
    )


def software(coefficients: CoefficientSet) -> Element:
    release = plain("dcc:release", coefficients.provenance["software_version"])
    return Element("dcc:software", [content("dcc:name", "calrig"), release])


def declared(value: Json) -> Document:
    """Return what the rig declared, empty where it did not."""
    return {} if value is None else table(value)


def _core_data(
    coefficients: CoefficientSet, laboratory: Document, job: Document, certificate: IssuedCertificate | None
) -> Element:
    country = str(laboratory.get("country_code") or UNKNOWN_COUNTRY)
    ended = coefficients.created_utc.date().isoformat()
    numbers = [identification("calibrationLaboratory", job["number"], "job")] if job.get("number") else []
    numbers += [identification("other", value, name) for name, value in declared(job.get("fields")).items()]
    received = [Element("dcc:receiptDate", str(job["received"]))] if job.get("received") else []
    run_id = coefficients.provenance["run_id"]
    if run_id is not None:
        numbers.append(identification("calibrationLaboratory", run_id, "run"))
    numbers.append(identification("calibrationLaboratory", coefficients.sha256, "coefficient set, SHA-256"))
    return Element(
        "dcc:coreData",
        [
            Element("dcc:countryCodeISO3166_1", country if re.fullmatch("[A-Z]{2}", country) else UNKNOWN_COUNTRY),
            Element("dcc:usedLangCodeISO639_1", "en"),
            Element("dcc:mandatoryLangCodeISO639_1", "en"),
            plain("dcc:uniqueIdentifier", _identifier(coefficients, certificate)),
            Element("dcc:identifications", numbers),
            *received,
            Element("dcc:beginPerformanceDate", _begun(run_id) or ended),
            Element("dcc:endPerformanceDate", ended),
            Element("dcc:performanceLocation", "other" if job.get("location") else "laboratory"),
            *_issue(certificate),
        ],
    )


def _identifier(coefficients: CoefficientSet, certificate: IssuedCertificate | None) -> str:
    if certificate is None:
        return f"calrig-{coefficients.sha256}"
    return f"{SPECIMEN}, {coefficients.sha256}" if certificate.is_specimen else certificate.number


def _issue(certificate: IssuedCertificate | None) -> Elements:
    """Return the day of issue, and the certificate that is replaced."""
    if certificate is None or certificate.is_specimen:
        return []
    day = Element("dcc:issueDate", certificate.issued.isoformat())
    if certificate.replaces is None:
        return [day]
    change = [Element("dcc:typeOfChange", "substituted"), plain("dcc:replacedUniqueIdentifier", certificate.replaces)]
    return [day, Element("dcc:reportAmendedSubstituted", change)]


def _begun(run_id: Json) -> str | None:
    """Return the date that a run's name begins with."""
    found = re.match(r"(\d{4})(\d{2})(\d{2})T\d{6}Z", str(run_id))
    return None if found is None else "-".join(found.groups())


def _persons(coefficients: CoefficientSet, certificate: IssuedCertificate | None) -> Elements:
    """Return who signed the set in the archive, each in what role; nobody else is named as one who answers for it.

    The schema wants a person: of a set without a signature it is who ran it, with the word that nobody signed.
    Source: ISO/IEC 17025:2017, 7.8.2.1 o.
    """
    if not coefficients.signatures:
        operator = coefficients.provenance["operator"]
        return [_person(operator or NOT_STATED, f"{'operator; ' if operator else ''}{NO_SIGNATURE}")]
    is_certificate = certificate is None or not certificate.is_specimen
    return [
        _person(
            signature.name,
            f"{signature.role}, {signature.function}" if signature.function else signature.role,
            f"signed {signature.signed_utc:%Y-%m-%d %H:%M} UTC, as the archive of the laboratory has it",
            is_main=is_certificate and signature == coefficients.approval,
        )
        for signature in coefficients.signatures
    ]


def _person(name: Json, role: str, *about: str, is_main: bool = False) -> Element:
    person = Element("dcc:person", [content("dcc:name", name)])
    described = [content("dcc:description", *about)] if about else []
    signer = Element("dcc:mainSigner", "true" if is_main else "false")
    return Element("dcc:respPerson", [person, *described, plain("dcc:role", role), signer])


def _statements(coefficients: CoefficientSet, certificate: IssuedCertificate | None) -> Elements:
    document = coefficients.document
    unit = table(document["acceleration_unit"])
    u_mps2 = coefficients.gravity.standard_uncertainty_mps2
    known = f", standard uncertainty {u_mps2:g} m/s^2" if u_mps2 else ""
    said: dict[str, object] = {
        "status": f"{_status(coefficients)}{SIMULATED if coefficients.is_simulated else ''}",
        **_amendment(certificate),
        **_accreditation(coefficients),
        **_as_sealed(coefficients),
        **_capability(coefficients),
        **_location(coefficients),
        **({"not budgeted": NOT_BUDGETED} if coefficients.senses_gravity else {}),
        "acceleration unit": f"local g = {unit['value_mps2']} m/s^2{known} ({unit['source']}); specific force is "
        "relative to it and of dimension one",
        "validity": json.dumps(document["validity"]),
        **{name.replace("_", " "): value for name, value in (use_of(document) or {}).items()},
        **(
            {"verdict of the calibration": f"{document['verdict']}{conditions_in_words(document)}"}
            if "verdict" in document
            else {}
        ),
        "dwells": dwells_in_words(document),
        **{
            f"dwell that does not count {index}": f"{line.where}: {line.why}"
            for index, line in enumerate(rejected_lines(document), 1)
        },
        **{f"warning {index}": text for index, text in enumerate(_warnings(document), 1)},
    }
    return [*_specimen(certificate), *(_statement(name, text) for name, text in said.items())]


def _statement(name: str, text: object, *behind: Element) -> Element:
    return Element("dcc:statement", [content("dcc:name", name), content("dcc:declaration", _flat(text)), *behind])


def _specimen(certificate: IssuedCertificate | None) -> Elements:
    """Return the statement that a specimen is not valid, for readers in words and for machines as a truth value."""
    if certificate is None or not certificate.is_specimen:
        return []
    return [
        _statement("SPECIMEN", f"{SPECIMEN}; it is to be looked at and not to be sent", Element("dcc:valid", "false"))
    ]


def _status(coefficients: CoefficientSet) -> str:
    """Say where the set stands; a line of the rig file approves rig and procedure, and is no signature on a set."""
    if coefficients.status == "withdrawn":
        return f"{coefficients.standing}: not a certificate"
    if coefficients.approval is not None:
        return coefficients.standing
    if coefficients.status == "approved":
        return (
            f"rig and procedure were approved by {coefficients.approved_by}, as the rig file says and nobody signed; "
            "no approval of this set by signature is known here: not a certificate"
        )
    return "engineering: not approved, not a certificate"


def _accreditation(coefficients: CoefficientSet) -> dict[str, object]:
    accreditation = declared(coefficients.provenance["laboratory"]).get("accreditation")
    return {"accreditation of the laboratory": accreditation} if accreditation else {}


def _location(coefficients: CoefficientSet) -> dict[str, object]:
    """Return where the work was done, if not at the laboratory's address. Source: ISO/IEC 17025:2017, 7.8.2.1 c."""
    location = declared(coefficients.provenance["job"]).get("location")
    return {"place of the calibration": location} if location else {}


def _amendment(certificate: IssuedCertificate | None) -> dict[str, object]:
    if certificate is None or certificate.replaces is None or certificate.is_specimen:
        return {}
    replaced = f"this certificate replaces certificate {certificate.replaces}, which is void"
    return {"amendment": f"{replaced}; reason: {certificate.reason}"}


def _as_sealed(coefficients: CoefficientSet) -> dict[str, object]:
    """Say whose word the attached set does not hold: it stays as it was sealed, signatures come after it."""
    approval = coefficients.approval
    if approval is None or coefficients.document["approved_by"] == approval.name:
        return {}
    return {
        "attached set": "attached as it was sealed when it was solved; its keys status and approved_by are those of "
        f"that moment; it was approved since by {approval.name}, whose signature the laboratory's archive "
        "holds"
    }


def _capability(coefficients: CoefficientSet) -> dict[str, object]:
    capability_deg = capability_deg_of(coefficients)
    if not capability_deg:
        return {}
    return {
        "capability": f"no expanded uncertainty or interval is stated below the laboratory's capability of "
        f"{capability_deg:g}° (95 %, k = 2; for offset and components of sensitivity: its effect on the output); "
        "covariances, their parts and the attached set are as calculated, without it"
    }


def _warnings(document: Document) -> list[str]:
    """Return those of the package, remarks among them, then those of single axes: what the data show of the item."""
    of_axes = (f"axis {axis}: {fact_of(document, text)}" for axis, text in axis_reservations(document))
    return [*(fact_of(document, str(text)) for text in listed(document["warnings"])), *of_axes]


def _flat(value: object) -> str:
    return clean(value if isinstance(value, str) else json.dumps(value, ensure_ascii=False))
