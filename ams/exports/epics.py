"""EPICS database: every number a control system needs as a constant record with a PV name, the set itself in comments.

PV names are ``$(P=SENSOR:)`` and the document's own names in capitals, such as ``SN1047:X:OFFSET_V``; give the macro P
to place them elsewhere. Numbers are ``ai`` records whose INP is a constant, which an IOC reads to the same double.
The database holds numbers, no equation: ``info`` tags and the comments say which.
"""

import re
from collections.abc import Iterator

from ams.exports.checksum_line import ChecksumLine
from ams.exports.csv_text import unit_below
from ams.exports.embedded import comment_lines, document_from, document_lines, harmless
from ams.exports.format import Format
from ams.exports.plain_values import check_same
from ams.exports.statement import check_status, statement
from ams.sets.canonical import Document, Json, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.instructions import use_of

HEAD = "# calrig coefficient set as EPICS database, version 1"
CHECKSUM_LINE = ChecksumLine("EPICS database", f"{HEAD}\n".encode(), b"# sha256 of all bytes above this line: ", b"\n")
LOSES = (
    "records hold coefficients, standard uncertainties, validity, polarity, gravity and test vectors; the full "
    "covariance, provenance and equations stand in comments and info tags, which an IOC does not serve"
)
LONGEST_DESCRIPTION = 40
LONGEST_STRING = 39
STATUS = "SET:STATUS"
Field = tuple[str, str]


def to_epics(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of an EPICS database."""
    lines = [
        HEAD,
        *(f"# {line}" for line in comment_lines([f"Loses: {LOSES}.", *statement(coefficients)])),
        "",
        *_records(coefficients),
        "# The whole set as JSON: join the lines after the bar.",
        *(f"# {line}" for line in document_lines(coefficients)),
    ]
    return CHECKSUM_LINE.append_to(("\n".join(lines) + "\n").encode("ascii"))


def from_epics(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its records hold other values than the
    document in it.
    """
    body = CHECKSUM_LINE.checked_body(content, where)
    coefficients = document_from(body, "# ", where)
    expected = "\n".join(_records(coefficients)).encode("ascii")
    read, wanted = _values(body), _values(expected)
    status = f"$(P={_pv(coefficients.sensor)}:){STATUS}"
    check_status(read.pop(status, ""), body.decode("ascii", "replace"), "records", where)
    check_same(read, {name: value for name, value in wanted.items() if name != status}, "records", where)
    return coefficients


def _values(body: bytes) -> dict[str, str]:
    """Return the value that each record holds, by PV name."""
    text = body.decode("ascii", "replace")
    found = re.findall(r'^record\(\w+, "([^"]+)"\) \{.*?^    field\((?:INP|VAL), "([^"]*)"\)', text, re.M | re.S)
    return dict(found)


def _records(coefficients: CoefficientSet) -> list[str]:
    sensor = _pv(coefficients.sensor)
    texts = [
        ("SET:SHA256_A", coefficients.sha256[:32], "checksum of the set, first half"),
        ("SET:SHA256_B", coefficients.sha256[32:], "checksum of the set, second half"),
        (STATUS, coefficients.standing.partition(",")[0], "engineering or approved"),
        ("SET:CONVENTION", coefficients.convention, "axes, signs, order of rotations"),
        ("SET:SENSOR", harmless(coefficients.sensor)[:LONGEST_STRING], "sensor package"),
    ]
    lines = [line for name, value, what in texts for line in _text(f"$(P={sensor}:){name}", value, what)]
    for name, value, unit, what in _numbers(coefficients):
        lines += _number(f"$(P={sensor}:){name}", value, unit, what)
    return [*_with_equations(lines, coefficients), ""]


def _with_equations(lines: list[str], coefficients: CoefficientSet) -> list[str]:
    """Return the records, the first of them with the equations as info tags."""
    tags = [("convention", str(table(coefficients.document["convention"])["text"]))]
    for axis, section in table(coefficients.document["axes"]).items():
        tags.append((f"equation_{axis}", str(table(table(section)["equation"])["primary"])))
    shown = [f'    info("{_pv(name)}", "{_quoted(text)}")' for name, text in tags]
    end = lines.index("}")
    return [*lines[:end], *shown, *lines[end:]]


def _numbers(coefficients: CoefficientSet) -> Iterator[tuple[str, float, str, str]]:
    """Yield name, value, unit and description of every number."""
    document = coefficients.document
    yield "SET:GRAVITY_MPS2", number(table(document["acceleration_unit"])["value_mps2"]), "m/s^2", "local g"
    for name, limits in table(document["validity"]).items():
        for end, value in zip(("MIN", "MAX"), listed(limits), strict=False):
            yield f"VALID:{_pv(name)}:{end}", number(value), unit_below({}, name, ""), f"valid: {name} {end.lower()}"
    use = use_of(document)
    for axis, sign in ({} if use is None else table(use["polarity"])).items():
        yield f"{_pv(axis)}:POLARITY", number(sign), "", "sign of the sensitivity"
    for axis, section in table(document["axes"]).items():
        yield from _axis(_pv(axis), table(section))
    for index, vector in enumerate(listed(coefficients.test_vectors["forward"])):
        yield from _vector(f"TEST{index}", table(vector))


def _axis(axis: str, section: Document) -> Iterator[tuple[str, float, str, str]]:
    primary = table(section["primary"])
    covariance = [listed(row) for row in listed(primary["covariance"])]
    for index, name in enumerate(listed(primary["order"])):
        unit, key = str(table(primary["units"])[str(name)]), _pv(str(name))
        yield f"{axis}:{key}", number(table(primary["values"])[str(name)]), unit, f"{axis} {name}"
        yield from _if_known(f"{axis}:{key}:SD", _root(covariance[index][index]), unit, f"{axis} {name}: u")
    for name, entry in table(section["parameters"]).items():
        parameter, key = table(entry), _pv(name)
        unit = str(parameter["unit"])
        if name not in table(primary["values"]):
            yield from _if_known(f"{axis}:{key}", parameter["value"], unit, f"{axis} {name}")
            yield from _if_known(f"{axis}:{key}:SD", parameter["standard_uncertainty"], unit, f"{axis} {name}: u")


def _vector(name: str, vector: Document) -> Iterator[tuple[str, float, str, str]]:
    for key, value in vector.items():
        if not isinstance(value, dict):
            yield f"{name}:{_pv(key)}", number(value), unit_below({}, key, ""), f"test vector: {key}"
        else:
            outputs = key.removeprefix("outputs_")
            for axis, output in value.items():
                what = f"test vector: output of {axis}"
                yield f"{name}:{_pv(axis)}_{_pv(outputs)}", number(output), unit_below({}, key, ""), what


def _if_known(name: str, value: Json, unit: str, what: str) -> Iterator[tuple[str, float, str, str]]:
    """Yield the field of a record, nothing for null: a record would have to hold some number."""
    if value is not None:
        yield name, number(value), unit, what


def _root(variance: Json) -> float | None:
    return None if variance is None else float(number(variance) ** 0.5)


def _number(name: str, value: float, unit: str, what: str) -> list[str]:
    return _record("ai", name, [("DESC", what), ("INP", repr(value)), ("EGU", unit), ("PREC", "12"), ("PINI", "YES")])


def _text(name: str, value: str, what: str) -> list[str]:
    return _record("stringout", name, [("DESC", what), ("VAL", value), ("PINI", "YES")])


def _record(kind: str, name: str, fields: list[Field]) -> list[str]:
    shown = [
        f'    field({field}, "{_quoted(value)[: LONGEST_DESCRIPTION if field == "DESC" else None]}")'
        for field, value in [*fields, ("DISP", "1")]
    ]
    return [f'record({kind}, "{name}") {{', *shown, "}"]


def _pv(name: str) -> str:
    """Return the name as part of a PV name."""
    return re.sub(r"[^A-Z0-9_-]", "_", name.upper())


def _quoted(text: str) -> str:
    return harmless(text).replace("\\", "\\\\").replace('"', '\\"')


FORMAT = Format("epics", ".db", to_epics, from_epics, LOSES)
