"""What both C headers share: names, tables, the comment that holds the whole set, and reading numbers back.

A header is C99, needs ``math.h`` at most, defines nothing but macros, constants and ``static inline`` functions, and
prefixes every name with the sensor's, so that several headers serve one program.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence

from ams.errors import SetError
from ams.exports.checksum_line import ChecksumLine
from ams.exports.embedded import comment_lines, document_lines
from ams.exports.format import ForeseenSet
from ams.exports.statement import statement
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers
from ams.sets.stated_verdict import NOT_USABLE

COMMENT = " * "
_NEEDED = "needed are accelerometers of pitch and roll (TP) or straight lines (SR)"
Rows = Sequence[Sequence[float]]


def c_checksum_line(kind: str, head: str) -> ChecksumLine:
    """Return the checksum line of a header: its first line opens the comment, its last is a comment of its own."""
    return ChecksumLine(kind, f"/* {head}\n".encode(), b"/* sha256 of all bytes above this line: ", b" */\n")


def checked_header(content: bytes, where: str, lines: Sequence[ChecksumLine]) -> tuple[bytes, int]:
    """Return what stands above the checksum line of a header, and its version.

    ``lines``: of the versions, from 1 on. Raises: SetError for a damaged file and for another one.
    """
    version = next((index for index, line in enumerate(lines, 1) if content.startswith(line.head)), len(lines))
    return lines[version - 1].checked_body(content, where), version


def verdict_lines(coefficients: CoefficientSet, prefix: str) -> list[str]:
    """Return the macros by which a program refuses a set as it is compiled.

    One that nobody tells the verdict of is not usable, so that what is not defined, in a header of before, is refused.
    """
    is_usable = coefficients.verdict not in (None, NOT_USABLE)
    return [
        defined(f"{prefix}_usable", int(is_usable)),
        defined(f"{prefix}_simulated", int(coefficients.is_simulated)),
    ]


def refusal_text(prefix: str) -> str:
    """Say how a program refuses a set as it is compiled."""
    usable, simulated = f"{prefix}_usable".upper(), f"{prefix}_simulated".upper()
    return (
        f"To refuse what is not to be used as it is compiled: #if !{usable} or {simulated}, #error. {usable} is 1 "
        f"where the verdict of the calibration is sound or usable, else 0; {simulated} is 1 for twins, else 0."
    )


def prefix_of(coefficients: CoefficientSet) -> str:
    """Return the sensor's name as the beginning of C names, in lower case."""
    return "calrig_" + re.sub(r"[^a-z0-9]", "_", coefficients.sensor.lower())


def check_names(coefficients: CoefficientSet) -> None:
    """Refuse a set with an axis whose name cannot be part of a C name. Raises: SetError."""
    foreign = [name for name in coefficients.axes if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name)]
    if foreign:
        raise SetError(
            f"{coefficients.sensor}: C header: axis {foreign[0]!r}: its name is no part of a C name: allowed are "
            "letters, digits and underscores; nothing was written; export another format"
        )


def is_of_one_quantity(coefficients: CoefficientSet) -> bool:
    """Return whether it is of lines that are all from one quantity to readings of one unit."""
    forms = [numbers.form for numbers in coefficients.axes.values()]
    return coefficients.is_of_lines and len({(form.measured_unit, form.inputs) for form in forms}) == 1


def lacks_accelerometers(foreseen: ForeseenSet) -> str | None:
    """Return why :func:`check_accelerometers` will refuse a set that is to be measured; straight lines it does not."""
    form = foreseen.form
    if form is None or (form.convention == "TP" and form.output is None):
        return None
    return f"got convention {form.convention}, {_NEEDED}"


def check_accelerometers(coefficients: CoefficientSet, what: str, instead: str) -> None:
    """Refuse a set whose equation is not the accelerometer's of pitch and roll. Raises: SetError."""
    if coefficients.convention != "TP" or any(numbers.model_output for numbers in coefficients.axes.values()):
        raise SetError(
            f"{coefficients.sensor}: {what}: has no form of this set's equations: got convention "
            f"{coefficients.convention}, model {coefficients.model}, {_NEEDED}; nothing was written; {instead}"
        )


def opening(coefficients: CoefficientSet, head: str, extra: list[str]) -> list[str]:
    """Return the first comment: what the file is, in words."""
    lines = comment_lines([*extra, *statement(coefficients)])
    return [f"/* {head}", *(COMMENT + line for line in lines), " */"]


def closing(coefficients: CoefficientSet) -> list[str]:
    """Return the last comment: the whole set."""
    return [
        "/* The whole set as JSON: join the lines after the bar.",
        *(COMMENT + line for line in document_lines(coefficients)),
        " */",
    ]


def literal(value: float | None) -> str:
    """Return a double as text that reads back exactly; NAN where there is none."""
    return "NAN" if value is None or math.isnan(value) else repr(float(value))


def defined(name: str, value: float | int | str) -> str:
    """Return one ``#define``; negative numbers in parentheses."""
    text = value if isinstance(value, str) else literal(value) if isinstance(value, float) else str(value)
    return f"#define {name.upper()} {f'({text})' if text.startswith('-') else text}"


def defined_unless(name: str, value: float | int | str) -> list[str]:
    """Return one ``#define`` that stands back behind that of the program."""
    return [f"#ifndef {name.upper()}", defined(name, value), "#endif"]


def array(kind: str, name: str, rows: Rows) -> list[str]:
    """Return one constant table."""
    size = f"[{len(rows)}][{len(rows[0])}]"
    shown = (", ".join(literal(v) if isinstance(v, float) else str(v) for v in row) for row in rows)
    return [f"static const {kind} {name}{size} = {{", *(f"    {{{row}}}," for row in shown), "};"]


def numbers_in(body: bytes) -> dict[str, list[str]]:
    """Return every macro and table of a header: its name and its numbers as they are written."""
    text = re.sub(r"/\*.*?\*/", "", body.decode("ascii", "replace"), flags=re.DOTALL)
    macros = re.findall(r"^#define (\w+) \(?([-\w.+\"]+)\)?$", text, flags=re.MULTILINE)
    tables = re.findall(r"^static const \w+ (\w+(?:\[\d+\])+) = \{(.*?)\};", text, flags=re.MULTILINE | re.DOTALL)
    return {
        **{name: [value] for name, value in macros},
        **{name: re.findall(r"[-\w.+]+", inner) for name, inner in tables},
    }


def primary_lines(prefix: str, numbers: AxisNumbers) -> list[str]:
    """Return the macros of one axis' coefficients: b and k always, further terms and temperature where it has them.

    All of them are the set's. Where its terms are centred, what the functions take for k stands beside it by names of
    its own, k without what the centring takes off, and the constant that is taken off.
    """
    given = {name: numbers.primary.get(name, numbers.parameters.get(name)) for name in _names(numbers)}
    if numbers.centring is not None:
        sensed = numbers.direction - numbers.taken_off[1:]
        given |= dict(zip(sensed_names(numbers), map(float, sensed), strict=True))
        given["sensed_constant_v"] = -float(numbers.taken_off[0])
    return [defined(f"{prefix}_{numbers.axis}_{name}", float(value or 0.0)) for name, value in given.items()]


def sensed_names(numbers: AxisNumbers) -> tuple[str, ...]:
    """Return the names of what multiplies each component of the field where the terms stand as they are, uncentred.

    Those of k itself where nothing is centred: it is the same then.
    """
    names = numbers.form.directions
    return names if numbers.centring is None else tuple(f"sensed_{name}" for name in names)


def _names(numbers: AxisNumbers) -> Iterable[str]:
    if numbers.model_output is not None:
        return numbers.model_output.primary_names
    temperature = (*numbers.temperature_names, "reference_temperature_degc") if numbers.needs_temperature else ()
    return (numbers.form.offset, *numbers.form.directions, *numbers.bent_terms, *temperature)


def filled(template: str, values: Mapping[str, object]) -> list[str]:
    """Return the lines of a template with ``@NAME@`` filled in."""
    for name, value in values.items():
        template = template.replace(f"@{name}@", str(value))
    return template.strip("\n").split("\n")
