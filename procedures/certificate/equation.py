"""The equation of a certificate: that of the set itself, in the symbols of the table above it, each with its meaning.

A number that no equation stands on is of no use to the reader. Source: ISO/IEC 17025:2017, 7.8.1.2.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ams.models.accelerometer import PITCH_ROLL
from ams.models.extended import EXTENDED
from ams.parameter_words import words_of
from ams.sets.canonical import Document, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers

_TYPE = {"*": "·", "^2": "²", "^3": "³", "alpha": "α", "pitch_deg": "pitch", "yaw_deg": "yaw", "roll_deg": "roll"}
_NEAREST = (
    "Each q and K₃ multiplies what stands behind it (factors of 2 included) less the best linear approximation of "
    "that, c₀ + c_x·f_x + c_y·f_y + c_z·f_z, so that b, S, Ω and A are those of the linear sensor that comes closest "
    "over the attitudes calibrated."
)
_NEAREST_RATE = (
    "K₂ multiplies the square and K₃ the third power of the rate about the nominal axis, each less its best linear "
    "approximation, c₀ + c_x·w_x + c_y·w_y + c_z·w_z, so that b, S, Ω and A are those of the straight line that comes "
    "closest over the rates calibrated (scale factor and nonlinearity as IEEE Std 528 has them)."
)
_PRINTED: Mapping[str, str] = {EXTENDED.name: PITCH_ROLL.name}
"""What is printed of a model that nobody chooses by its name; its terms are told beside the sources."""
_BENT = ", with terms of second and third order fᵀQf, tr Q = 0, and K₃ as IEEE Std 1293 has them"
_BENT_RATE = ", with the nonlinearity of the scale factor, K₂ and K₃"
_MEANINGS: Mapping[str, str] = {
    "b₀": "the constant where nothing is taken off the terms of second and third order: b less the sum of each "
    "coefficient times its c₀; it stands in no equation here",
    "q_zz": "−q_xx − q_yy; it is in the equation by these two",
    "Ω": "between the sensitive and the nominal axis",
    "angle towards x": "of the sensitive axis: the field along x times its tangent adds to that along the nominal axis",
    "angle towards y": "of the sensitive axis: the field along y times its tangent adds to that along the nominal axis",
    "angle towards z": "of the sensitive axis: the field along z times its tangent adds to that along the nominal axis",
}


@dataclass(frozen=True)
class PrintedForm:
    """The equation of one axis."""

    axis: str
    text: str
    taken_off: tuple[tuple[str, tuple[str, ...]], ...]
    """Symbol of each coefficient and c₀, c_x, c_y, c_z of what it multiplies; empty where nothing is taken off."""


def method_of(coefficients: CoefficientSet) -> str:
    """Name the models of all axes with where each stands."""
    found: dict[str, dict[str, None]] = {}
    bent: dict[str, str] = {}
    for axis, section in table(coefficients.document["axes"]).items():
        equation = table(table(section)["equation"])
        printed = found.setdefault(str(equation["name"]), {})
        printed[str(equation["source"])] = None
        if _is_bent(coefficients.axes[axis]):
            bent[str(equation["name"])] = _BENT_RATE if coefficients.axes[axis].form.senses_rates else _BENT
    return "; ".join(
        f"“{_PRINTED.get(name, name)}” ({', '.join(sources)}{bent.get(name, '')})" for name, sources in found.items()
    )


def forms_of(coefficients: CoefficientSet) -> Iterator[PrintedForm]:
    """Yield the equation of every axis."""
    for axis, section in table(coefficients.document["axes"]).items():
        equation = table(table(section)["equation"])
        centring = listed(equation["centring"]) if "centring" in equation else []
        rows = [tuple(f"{number(c):z.7f}".replace("-", "−") for c in listed(row)) for row in centring]
        symbols = [_symbol(name) for name in coefficients.axes[axis].centred_terms]
        yield PrintedForm(axis, _text(equation, coefficients.axes[axis]), tuple(zip(symbols, rows, strict=True)))


def meanings_of(coefficients: CoefficientSet) -> list[str]:
    """Return what every symbol of the table means, once."""
    found: dict[str, None] = {}
    for section in table(coefficients.document["axes"]).values():
        for name in table(table(section)["parameters"]):
            words = words_of(name)
            more = _MEANINGS.get(words.symbol) or _MEANINGS.get(words.label)
            words_used = [word for word in (words.label if words.symbol else "", more) if word]
            if words_used:
                found[f"{words.symbol or words.label} = {', '.join(words_used)}"] = None
    return list(found)


def nearest(coefficients: CoefficientSet) -> str:
    """Say what the terms of second and third order multiply; empty where none is taken off anything."""
    centred = [numbers for numbers in coefficients.axes.values() if numbers.centred_terms]
    if not centred:
        return ""
    return _NEAREST_RATE if centred[0].form.senses_rates else _NEAREST


def _is_bent(numbers: AxisNumbers) -> bool:
    return any(name.startswith(("q_", "k2_", "k3_")) for name in numbers.primary)


def _symbol(name: str) -> str:
    return words_of(name).symbol or name


def _text(equation: Document, numbers: AxisNumbers) -> str:
    """Return the form in the parameters of the table, and what temperature does to it."""
    formula, _, rest = str(equation["derived"]).partition("; ")
    primary = str(equation["primary"])
    at = primary.find("; with temperature T")
    known = []
    for pair in rest.split(", ") if rest else ():
        letter, _, name = pair.partition(" = ")
        name = name.partition(" = ")[0]
        symbol = words_of(name).symbol if name in numbers.parameters else ""
        if symbol:
            formula = re.sub(rf"\b{letter}\b", symbol, formula)
        else:
            known.append(pair)
    text = "; ".join(part for part in (formula, ", ".join(known)) if part) + (primary[at:] if at >= 0 else "")
    for name in sorted({*numbers.primary, *numbers.parameters}, key=len, reverse=True):
        text = text.replace(name, _symbol(name))
    for plain, printed in _TYPE.items():
        text = text.replace(plain, printed)
    text = re.sub(r"level_([xyz])_\w+", r"level \1", text)
    return text.replace(" - ", " − ").replace("(-", "(−")
