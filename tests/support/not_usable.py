"""A set whose calibration says of itself that it is not usable, and the words that approve it all the same."""

from dataclasses import replace
from datetime import datetime

from certificate_scene import RELEASED
from solved import provenance, solved_package

from ams.archive.signatures import accept, sign
from ams.findings import Finding
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.stated_verdict import NOT_USABLE

FINDING = "x.cubic"
REASON = "for a rehearsal of the mount; nothing is measured with it"
STANDING = f"approved though not usable, accepted by C. Reader: {REASON}"


def set_not_usable(**declared: object) -> CoefficientSet:
    """Return a set with one finding that its stated uncertainties do not hold."""
    plain = solved_package()
    beyond = Finding("cubic", "said of cubic.", True, 0.001, is_held=False)
    axes = {**plain.axes, "x": replace(plain.axes["x"], findings=(beyond,))}
    entry = build_set(replace(plain, axes=axes), provenance(**{**RELEASED, **declared}))  # type: ignore[arg-type]
    assert entry.document["verdict"] == NOT_USABLE
    return entry


def set_usable(**declared: object) -> CoefficientSet:
    """Return the same without the finding."""
    return build_set(solved_package(), provenance(**{**RELEASED, **declared}))  # type: ignore[arg-type]


def accept_findings(url: str, moment: datetime) -> None:
    """Prepare the set of SN1047, accept its finding and review it: all but the verdict."""
    sign(url, "SN1047", "prepared", "A. Operator", moment)
    accept(url, "SN1047", FINDING, "C. Reader", moment, "a tenth of the limit")
    sign(url, "SN1047", "reviewed", "C. Reader", moment)


def approve_not_usable(url: str, moment: datetime) -> None:
    """Accept finding and verdict, and approve."""
    accept_findings(url, moment)
    accept(url, "SN1047", NOT_USABLE, "C. Reader", moment, REASON)
    sign(url, "SN1047", "approved", "B. Chief", moment)
