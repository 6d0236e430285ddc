"""What a laboratory declares when a certificate may be issued; the tests take single things away."""

from dataclasses import replace
from datetime import date

from solved import provenance, solved_package

from ams.finding_kinds import FindingKind
from ams.findings import Finding
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Standard

LABORATORY = {"name": "Instrument Laboratory", "address": "1 Granite Way, Hampton", "capability_deg": 0.002}
JOB = {
    "customer": "Tunnel Ltd",
    "customer_contact": "2 Wind Road, tunnel@example.com",
    "item": "inclinometer package, clean, no damage",
    "number": "J-7",
}
STANDARD = Standard("table", "77", "C-2025-14", date(2027, 1, 31), {"limit_arcsec": 1.0, "kind": "limit"})
METER = Standard("meter", "3", "C-2025-21", date(2027, 1, 31), {"uncertainty_v": 1e-5, "kind": "limit"})
LEVEL_STANDARD = Standard("level", "L-12", "C-2025-9", date(2027, 1, 31), {"uncertainty_arcsec": 0.5}, ("level",))
LEVEL = {
    "instrument": "Talyvel 6",
    "standard": "level",
    "uncertainty_arcsec": 0.5,
    "before": {"about_pitch_arcsec": 0.3, "about_roll_arcsec": -0.2},
}
RELEASED = {
    "approved_by": "B. Chief",
    "laboratory": LABORATORY,
    "job": JOB,
    "standards": (STANDARD, METER, LEVEL_STANDARD),
    "level": LEVEL,
    "gravity_uncertainty_mps2": 2e-6,
}


def set_with_findings(**declared: object) -> CoefficientSet:
    """Return a set whose y axis is cubic and has two wrong dwells, and whose quadratic term stood its test."""
    kinds: tuple[FindingKind, ...] = ("quadratic", "cubic", "wrong-dwell", "wrong-dwell")
    found = tuple(Finding(kind, f"said of {kind}.", kind != "quadratic", 0.001) for kind in kinds)
    plain = solved_package()
    axes = {**plain.axes, "y": replace(plain.axes["y"], findings=found)}
    return build_set(replace(plain, axes=axes), provenance(**{**RELEASED, **declared}))  # type: ignore[arg-type]
