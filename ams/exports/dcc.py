"""DCC: the Digital Calibration Certificate of PTB, XML 3.2.1, with the set as an attached file.

The certificate's own numbers (coefficients with expanded uncertainty, covariances, test vectors) are quantities in
D-SI units with identifiers; the attachment is the JSON export. Persons are those who signed the set in the archive; a
set that nobody signed as approved says so in its statements: then the file is a record in the certificate's form, not a
certificate.
Source: https://ptb.de/dcc, schemas dcc 3.2.1 and D-SI 2.1.0.
"""

import base64
import binascii
from typing import Any

from ams.errors import SetError
from ams.exports.checksum_line import INTACT, ChecksumLine
from ams.exports.dcc_administration import IssuedCertificate, administrative_data
from ams.exports.dcc_elements import NAMESPACES, Element, content, plain, tree
from ams.exports.dcc_results import measurement_result
from ams.exports.format import Format
from ams.exports.json_text import from_json, to_json
from ams.exports.optional_libraries import library
from ams.exports.plain_values import check_same
from ams.sets.coefficients import CoefficientSet

VERSION = "3.2.1"
DECLARATION = b'<?xml version="1.0" encoding="UTF-8"?>\n'
CHECKSUM_LINE = ChecksumLine("DCC", DECLARATION, b"<!-- sha256 of all bytes above this line: ", b" -->\n")
ATTACHMENT = "id-set"


def to_dcc(coefficients: CoefficientSet, certificate: IssuedCertificate | None = None) -> bytes:
    """Return a set as the bytes of a digital calibration certificate.

    ``certificate``: that it is attached to; without one the set's checksum identifies it.

    Raises: SetError where lxml is missing.
    """
    etree = library("lxml.etree", f"{coefficients.sensor}: DCC")
    root = tree(_certificate(coefficients, certificate), etree)
    return CHECKSUM_LINE.append_to(DECLARATION + etree.tostring(root, pretty_print=True, encoding="UTF-8"))


def from_dcc(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file: its attachment.

    Raises: SetError where the file is damaged or no set, or lxml is missing; VectorsDisagree where its quantities are
    not those of the attachment.
    """
    body = CHECKSUM_LINE.checked_body(content, where)
    etree = library("lxml.etree", where)
    root = _parsed(body, etree, where)
    attached = root.findtext(f".//dcc:byteData[@id='{ATTACHMENT}']/dcc:dataBase64", namespaces=NAMESPACES)
    try:
        document = base64.b64decode(attached or "", validate=True)
    except binascii.Error as error:
        raise SetError(f"{where}: the attached set is no base64: {error}; {INTACT}") from error
    if not document:
        raise SetError(f"{where}: has no attached set with the id {ATTACHMENT}; another laboratory's DCC? {INTACT}")
    coefficients = from_json(document, f"{where}: attached set")
    check_same(_quantities(root), _quantities(tree(_certificate(coefficients), etree)), "quantities", where)
    return coefficients


def _parsed(body: bytes, etree: Any, where: str) -> Any:
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        return etree.fromstring(body, parser)
    except etree.XMLSyntaxError as error:
        raise SetError(f"{where}: is no XML: {error}; {INTACT}") from error


def _certificate(coefficients: CoefficientSet, certificate: IssuedCertificate | None = None) -> Element:
    encoded = base64.b64encode(to_json(coefficients)).decode("ascii")
    parts = [
        content("dcc:name", "coefficient set"),
        plain("dcc:fileName", f"{coefficients.sensor}.json"),
        plain("dcc:mimeType", "application/json"),
        Element("dcc:dataBase64", encoded),
    ]
    result = measurement_result(coefficients, Element("dcc:byteData", parts, {"id": ATTACHMENT}))
    return Element(
        "dcc:digitalCalibrationCertificate",
        [administrative_data(coefficients, certificate), Element("dcc:measurementResults", [result])],
        {"schemaVersion": VERSION},
    )


def _quantities(root: Any) -> dict[str, list[str]]:
    """Return the numbers and units of every quantity by its identifier.

    Without the uncertainty, which is computed for the file.
    """
    inside = "si:real/si:value|si:real/si:unit|si:realListXMLList/*"
    return {
        found.get("id"): [str(part.text) for part in found.xpath(inside, namespaces=NAMESPACES)]
        for found in root.iterfind(".//dcc:quantity[@id]", NAMESPACES)
    }


FORMAT = Format("dcc", ".xml", to_dcc, from_dcc, needs=("lxml",))
