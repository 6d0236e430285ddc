"""Whether what was found is in the stated uncertainties: the words of findings and pages."""

from collections.abc import Collection, Iterable, Iterator
from typing import Final

from ams.analysis.diagnostics.beliefs import LACK_OF_FIT, MEMORIES, OF_THE_ORDER
from ams.analysis.diagnostics.declared.declared_signs import fits_other_angles
from ams.analysis.diagnostics.declared.differing_replications import DIFFERING
from ams.analysis.diagnostics.declared.gravity_on_gyros import GRAVITY
from ams.analysis.diagnostics.facts import CONTAINED, as_the_order_has_it
from ams.findings import Finding, Said

BESIDE_MEMORY: Final = (
    "what the memory of the output does is in the stated uncertainties only if a limit of it is declared"
)
_OF_DIFFERING: Final = "replications differ by more than the stated uncertainties may hold"
_OF_GRAVITY: Final = "what gravity does to the zero is part of it, and that is not in the stated uncertainties"
_OF_ORDER: Final = "what the order of the points does to it is not in the stated uncertainties"
_OF_ANGLES: Final = "other signs or another order of the angles explain it, and the stated uncertainties do not hold it"
_AS_INDEPENDENT: Final = (
    "it is in the stated uncertainties as errors that differ from attitude to attitude; an index of the table that is "
    "wrong, or a smooth error of it, is alike at many attitudes and is not, and nothing is declared of this table"
)
_AS_INDEPENDENT_LEVELS: Final = (
    "it is in the stated uncertainties as errors that differ from level to level; what goes smoothly over the levels, "
    "of the sensor or of what they were set by, is alike at many of them and is not"
)
_ALIKE: Final = (
    "the stated uncertainties take it for errors that differ from attitude to attitude, and it goes alike over the "
    "attitudes of"
)
TURNS: Final = "turns"
"""In place of axes of a table: the points of a gyro that turned about one axis."""
_ALIKE_TURNS: Final = Said(
    "the stated uncertainties take it for errors that differ from point to point, and it goes alike over all points "
    "that turned about one axis, so that the offset holds more of it than is stated: what is not in the rows changed "
    "as the package was laid another way, such as the Earth's rate that it sees, or gravity on the zero",
    "put the Earth's rate into the rates of the rows, and look at the residuals by the axis that turned",
)
_TOO_LARGE: Final = Said(
    "that is more than 1 % of the sensitivity and than what is declared of table and sensor: points, angles or model "
    "are not those of the readings, and the stated uncertainties do not hold it",
    "look at the residuals by attitude",
)
_FAR_FROM_LINE: Final = Said(
    "that is more than 1 % of half of what the line spans, and than what is declared of the sensor: levels or readings "
    "are wrong, or the sensor is not straight, and the stated uncertainties do not hold it",
    "look at the residuals by level",
)


def drift_words(order: Iterable[Finding], *, is_remembering: bool, is_differing: bool) -> str:
    """Return whether a drift is in the stated uncertainties; ``order``: what is said of the order of the points.

    ``is_differing``: whether replications differ by more than a scatter that is stated may be.
    """
    if is_differing:
        return _OF_DIFFERING
    return BESIDE_MEMORY if is_remembering else as_the_order_has_it(order)


def lack_words(
    *,
    other_angles: bool,
    is_large: bool,
    follows_gravity: bool,
    is_remembering: bool,
    is_of_order: bool,
    alike_over: Collection[str],
    has_table: bool,
    is_of_levels: bool,
) -> Said:
    """Return whether a lack of fit is in the stated uncertainties, what explains it first.

    ``alike_over``: axes of the table over whose indices it goes alike, or :data:`TURNS`. ``has_table``: whether index
    errors of a table are declared. ``is_of_levels``: whether known levels, not attitudes, are what points differ by.
    """
    if other_angles:
        return Said(_OF_ANGLES)
    if is_large:
        return _too_large(is_of_levels=is_of_levels)
    if follows_gravity:
        return Said(_OF_GRAVITY)
    if is_remembering or is_of_order:
        return Said(BESIDE_MEMORY if is_remembering else _OF_ORDER)
    if alike_over:
        return _alike(alike_over)
    if is_of_levels:
        return Said(_AS_INDEPENDENT_LEVELS)
    return Said(CONTAINED if has_table else _AS_INDEPENDENT)


def _too_large(*, is_of_levels: bool) -> Said:
    return _FAR_FROM_LINE if is_of_levels else _TOO_LARGE


def _alike_axes(findings: Collection[Finding]) -> list[str]:
    """Return the axes of the table that findings name so."""
    after = [finding.text.split(_ALIKE)[1] for finding in findings if _ALIKE in finding.text]
    axes = [axis for axis in ("pitch", "roll") if any(f"of {axis}" in text for text in after)]
    return [TURNS] if any(_ALIKE_TURNS.fact in finding.text for finding in findings) else axes


def _alike(axes: Collection[str]) -> Said:
    if TURNS in axes:
        return _ALIKE_TURNS
    fact = (
        f"{_ALIKE} one index of {' and of '.join(axes)}, so that offset and sensitivities hold more of it than is "
        "stated"
    )
    what_to_do = (
        "look at the residuals by index: an error of the table is one to declare, a term of the sensor to take in"
    )
    return Said(fact, what_to_do)


def untested_scatter(scatter: float, words: str, largest_lack: float, *, is_of_levels: bool) -> Iterator[Finding]:
    """Yield a finding where residuals that no replication tells from noise are larger than any lack of fit may be.

    ``scatter``: standard deviation of a dwell about the fit, in the output's unit; ``words``: the same to be read.
    """
    if not scatter > largest_lack:
        return
    too_large = _too_large(is_of_levels=is_of_levels)
    fact = (
        f"the residuals scatter by {words} (standard deviation of a dwell), and no replication tells lack of fit from "
        f"noise; {too_large.fact}"
    )
    what_to_do = too_large.what_to_do
    yield Finding("lack-of-fit", fact, True, None, details={"size": scatter}, is_held=False, what_to_do=what_to_do)


def held_words(findings: Iterable[Finding], *, is_drift: bool) -> str:
    """Return whether lack of fit, or a drift, is in the stated uncertainties: the words that the findings have."""
    found = list(findings)
    significant = [finding for finding in found if finding.is_significant]
    tests = {finding.details.get("test") for finding in significant}
    is_remembering = not tests.isdisjoint(MEMORIES)
    if is_drift:
        return drift_words(found, is_remembering=is_remembering, is_differing=DIFFERING in tests)
    alike_over = _alike_axes(significant)
    lacks = [finding.text for finding in significant if finding.details.get("test") == LACK_OF_FIT]
    lack_is = lack_words(
        other_angles=any(map(fits_other_angles, significant)),
        is_large=any(_TOO_LARGE.fact in text or _FAR_FROM_LINE.fact in text for text in lacks),
        follows_gravity=GRAVITY in tests,
        is_remembering=is_remembering,
        is_of_order=not tests.isdisjoint(OF_THE_ORDER),
        alike_over=alike_over,
        has_table=not any(_AS_INDEPENDENT in finding.text for finding in found),
        is_of_levels=any(_AS_INDEPENDENT_LEVELS in text or _FAR_FROM_LINE.fact in text for text in lacks),
    )
    return lack_is.fact
