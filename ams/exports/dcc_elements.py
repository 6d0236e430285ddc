"""Elements of the Digital Calibration Certificate as plain values: texts, contacts, quantities with D-SI units."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from ams.units import UNITS

NAMESPACES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}
NOT_STATED = "not stated"
_KEYS = ("v", "g", "dps", "ut", "counts", "mps2")
_BASE = {
    "V": r"\volt",
    "g": r"\one",
    "deg/s": r"\degree\second\tothe{-1}",
    "uT": r"\micro\tesla",
    "counts": r"\one",
    "m/s^2": r"\metre\second\tothe{-2}",
}
_INVERSE = {
    "V": r"\volt\tothe{-1}",
    "g": r"\one",
    "deg/s": r"\second\degree\tothe{-1}",
    "uT": r"\micro\tesla\tothe{-1}",
    "counts": r"\one",
    "m/s^2": r"\metre\tothe{-1}\second\tothe{2}",
}


def _ratio(unit: str, divisor: str) -> str:
    """Return one unit per another; what is of dimension one is left out beside what is not."""
    if unit == divisor:
        return r"\one"
    return product(_BASE[unit], _INVERSE[divisor])


def product(*units: str) -> str:
    """Return units in D-SI one behind the other, without those of dimension one."""
    return "".join(unit for unit in units if unit != r"\one") or r"\one"


D_SI = {
    **{UNITS[f"{a}_per_{b}"]: _ratio(UNITS[a], UNITS[b]) for a in _KEYS for b in _KEYS},
    **_BASE,
    "V/g^2": r"\volt",
    "V/g^3": r"\volt",
    "V/(deg/s)^2": r"\volt\degree\tothe{-2}\second\tothe{2}",
    "V/(deg/s)^3": r"\volt\degree\tothe{-3}\second\tothe{3}",
    "V/degC": r"\volt\degreecelsius\tothe{-1}",
    "V/degC^2": r"\volt\degreecelsius\tothe{-2}",
    "1/degC": r"\degreecelsius\tothe{-1}",
    "1/degC^2": r"\degreecelsius\tothe{-2}",
    "degC": r"\degreecelsius",
    "deg": r"\degree",
    "V/h": r"\volt\hour\tothe{-1}",
    "s": r"\second",
    "%": r"\percent",
    "": r"\one",
    "1": r"\one",
}
"""Specific force is taken relative to local g and therefore of dimension one: volts per g are volts."""


@dataclass(frozen=True)
class Element:
    """One element; children in the order of the schema."""

    tag: str
    children: "Sequence[Element] | str" = ()
    attributes: dict[str, str] = field(default_factory=dict)


Elements: TypeAlias = list[Element]


def clean(text: object) -> str:
    """Return the text as the schema's notEmptyString: what XML allows, single spaces, never empty."""
    allowed = re.sub(r"[^\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", " ", str(text))
    return " ".join(allowed.split()) or NOT_STATED


def content(tag: str, *texts: object) -> Element:
    """Return an element of localised text, in English."""
    return Element(tag, [Element("dcc:content", clean(text), {"lang": "en"}) for text in texts])


def plain(tag: str, text: object) -> Element:
    return Element(tag, clean(text))


def contact(tag: str, name: object, address: object) -> Element:
    """Return somebody with a place; the schema asks for both."""
    location = Element("dcc:location", [content("dcc:further", address or NOT_STATED)])
    return Element(tag, [content("dcc:name", name or NOT_STATED), location])


def identification(issuer: str, value: object, name: str) -> Element:
    return Element(
        "dcc:identification", [Element("dcc:issuer", issuer), plain("dcc:value", value), content("dcc:name", name)]
    )


def real(value: float, unit: str, uncertainty: Elements | None = None) -> Element:
    """Return a number with a unit of a set and, where known, its uncertainty."""
    return Element("si:real", [Element("si:value", repr(value)), Element("si:unit", D_SI[unit]), *(uncertainty or [])])


def expanded(uncertainty: float, factor: float) -> Elements:
    """Return the expanded uncertainty for 95 % coverage, its coverage factor from Student's distribution."""
    return [
        Element(
            "si:expandedUnc",
            [
                Element("si:uncertainty", repr(uncertainty)),
                Element("si:coverageFactor", f"{factor:.12f}"),
                Element("si:coverageProbability", "0.95"),
            ],
        )
    ]


def interval(standard_uncertainty: float, low: float, high: float) -> Elements:
    """Return the interval that covers with 95 %."""
    return [
        Element(
            "si:coverageInterval",
            [
                Element("si:standardUnc", repr(standard_uncertainty)),
                Element("si:intervalMin", repr(low)),
                Element("si:intervalMax", repr(high)),
                Element("si:coverageProbability", "0.95"),
            ],
        )
    ]


def numbers(values: Sequence[float], units: Sequence[str]) -> Element:
    """Return a list of numbers, each with its unit in D-SI already."""
    return Element(
        "si:realListXMLList",
        [
            Element("si:valueXMLList", " ".join(repr(value) for value in values)),
            Element("si:unitXMLList", " ".join(units)),
        ],
    )


def quantity(name: str, value: Element, identifier: str, *about: object) -> Element:
    description = [content("dcc:description", *about)] if about else []
    return Element("dcc:quantity", [content("dcc:name", name), *description, value], {"id": identifier_of(identifier)})


def identifier_of(text: str) -> str:
    """Return the text as an XML identifier, another for every text."""
    return "id-" + "".join(
        letter if letter.isascii() and (letter.isalnum() or letter in "-.") else f"_{ord(letter):x}_" for letter in text
    )


def tree(element: Element, etree: Any) -> Any:
    """Return the element as lxml knows it."""
    prefix, name = element.tag.split(":")
    made = etree.Element(f"{{{NAMESPACES[prefix]}}}{name}", element.attributes, nsmap=NAMESPACES)
    if isinstance(element.children, str):
        made.text = element.children
    else:
        made.extend(tree(child, etree) for child in element.children)
    return made
