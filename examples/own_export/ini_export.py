"""An export format of your own: an INI file for LabVIEW's configuration VIs (docs/coefficient-sets.md).

One section an axis with b and k of v = b + k·f; the whole set stands in comments, and the last line seals the file, so
that ``calrig verify`` reads it back as it does every other format.
"""

import configparser

from ams.exports.checksum_line import ChecksumLine
from ams.exports.embedded import document_from, document_lines
from ams.exports.format import Format
from ams.exports.plain_values import check_same
from ams.sets.coefficients import CoefficientSet

HEAD = "; calrig coefficient set as INI file, version 1"
CHECKSUM_LINE = ChecksumLine("INI file", f"{HEAD}\n".encode(), b"; sha256 of all bytes above this line: ", b"\n")


def to_ini(coefficients: CoefficientSet) -> bytes:
    """Write the set, the same bytes for the same set."""
    lines = [HEAD, *(f"; {line}" for line in document_lines(coefficients))]
    for section, keys in _numbers(coefficients).items():
        lines += [f"[{section}]", *(f"{key}={value}" for key, value in keys.items())]
    return CHECKSUM_LINE.append_to(("\n".join(lines) + "\n").encode("ascii"))


def from_ini(content: bytes, where: str) -> CoefficientSet:
    """Read the set. Raises: SetError where the file is damaged, VectorsDisagree where its numbers are not the set's."""
    body = CHECKSUM_LINE.checked_body(content, where)
    coefficients = document_from(body, "; ", where)
    read = configparser.ConfigParser(interpolation=None, comment_prefixes=(";",))
    read.read_string(body.decode("ascii"))
    check_same({name: dict(read[name]) for name in read.sections()}, _numbers(coefficients), "sections", where)
    return coefficients


def _numbers(coefficients: CoefficientSet) -> dict[str, dict[str, str]]:
    """Return every number as text that reads back exactly."""
    axes = coefficients.axes.values()
    return {f"axis {axis.axis}": {name: repr(value) for name, value in axis.primary.items()} for axis in axes}


FORMAT = Format("ini", ".ini", to_ini, from_ini, "holds b and k alone outside its comments")
