"""What a laboratory has not declared and a certificate must say, a phrase each: asked before a run and of its set.

Source: ISO/IEC 17025:2017, 7.8.2.1, 7.8.4.1.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

NOBODY_APPROVED = "nobody has signed the set as approved"
OF_A_TWIN = "the readings come from a twin (SIMULATED)"


@dataclass(frozen=True)
class Declared:
    """The tables of a rig file that a certificate is written from."""

    laboratory: Mapping[str, Any]
    job: Mapping[str, Any]
    level: Mapping[str, Any]
    has_standards: bool
    senses_gravity: bool


def declared_gaps(declared: Declared) -> Iterator[str]:
    """Yield what is not declared."""
    for key, what in (("name", "name"), ("address", "address"), ("capability_deg", "stated capability")):
        if not declared.laboratory.get(key):
            yield f"the laboratory's {what} is not declared ([laboratory] {key})"
    for key, what in (("customer", "customer"), ("item", "description of the item")):
        if not declared.job.get(key):
            yield f"the {what} is not declared ([job] {key})"
    if not declared.has_standards:
        yield "no standard is declared, so nothing is traceable ([standards] and standard = …)"
    if declared.senses_gravity and not (declared.level.get("before") or declared.level.get("after")):
        yield "the level of the base was not read ([level] before and after)"
