"""What every text export says in words before its numbers: whose set, by which equations, where and how to use it."""

import json
from collections.abc import Mapping

from ams.exports.plain_values import check_same
from ams.sets.canonical import Document, Json, listed, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.instructions import use_of
from ams.sets.stated_verdict import conditions_in_words
from ams.sets.vectors import LEVEL


def statement(coefficients: CoefficientSet) -> list[str]:
    """Return the set's statement as sentences, in the document's own names."""
    document = coefficients.document
    unit, validity = table(document["acceleration_unit"]), table(document["validity"])
    u_mps2 = coefficients.gravity.standard_uncertainty_mps2
    known = f", standard uncertainty {u_mps2:g} m/s^2" if u_mps2 else ""
    return [
        f"sensor: {_flat(document['sensor'])}; status: {coefficients.standing}"
        f"{'; SIMULATED on a twin' if coefficients.is_simulated else ''}",
        f"set: sha256 {coefficients.sha256}, by calrig {coefficients.provenance['software_version']} on "
        f"{coefficients.provenance['created_utc']}",
        f"convention {coefficients.convention}: {table(document['convention'])['text']}",
        f"acceleration unit: local g = {unit['value_mps2']} m/s^2{known} ({unit['source']}); units are the ends of the "
        "names",
        _valid(validity),
        *(_axis(name, table(section)) for name, section in table(document["axes"]).items()),
        *_use(document),
        *(
            [f"verdict of the calibration: {document['verdict']}{conditions_in_words(document)}"]
            if "verdict" in document
            else []
        ),
        *(f"{kind_of_warning(document, text)}: {text}" for text in map(str, listed(document["warnings"]))),
    ]


def kind_of_warning(document: Mapping[str, Json], text: str) -> str:
    """Return ``remark`` for what is no reservation; sets of before the key ``remarks`` call all of it a warning."""
    return "remark" if text in listed(document.get("remarks", [])) else "warning"


def check_status(read: str, text: str, part: str, where: str) -> None:
    """Check a file's own status against that of its statement, which knows of an approval after the set was sealed.

    ``text``: the whole file, the statement in lines of comment that begin with ``#``.

    Raises: VectorsDisagree.
    """
    stated = " ".join(line.removeprefix("#").strip() for line in text.splitlines() if line.startswith("#"))
    check_same(read.startswith("approved"), "; status: approved" in stated, part, where)


def _valid(validity: Document) -> str:
    levels = [f"{name} {_flat(limits)}" for name, limits in validity.items() if name.startswith(LEVEL)]
    if levels:
        return f"valid: {', '.join(levels)}"
    return (
        f"valid: pitch {validity['pitch_deg']} deg, roll {validity['roll_deg']} deg, temperature "
        f"{_flat(validity['temperature_degc'])} degC"
    )


def _axis(name: str, section: Document) -> str:
    equation, primary = table(section["equation"]), table(section["primary"])
    return (
        f"axis {name}: {equation['primary']}. Equally, with the derived parameters: {equation['derived']} "
        f"[{equation['source']}]. Covariance in the order {_flat(primary['order'])}: {_flat(primary['covariance'])}; "
        f"its independent parts: {_flat(primary['components'])}"
    )


def _use(document: Document) -> list[str]:
    use = use_of(document)
    if use is None:
        return ["use: this set was written before sets said how to use them: ask who calibrated it"]
    return [f"{name}: {_flat(value)}" for name, value in use.items()]


def _flat(value: Json) -> str:
    return json.dumps(value, ensure_ascii=False)
