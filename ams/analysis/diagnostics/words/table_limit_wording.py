"""What is said of a table against its declared limit: that it is off, and what else it may be."""

from collections.abc import Mapping

import numpy as np

from ams.analysis.diagnostics.beliefs import BeliefTest
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.findings import Finding, Said
from ams.rounding import significant
from ams.units import ARCSEC_PER_DEG


def of_table_limit(test: BeliefTest, limit: TableLimit, *, is_significant: bool) -> Finding:
    """Return the finding on the table: it names the axes of the table whose index errors are beyond the limit."""
    sizes = {axis: np.rad2deg(size) * ARCSEC_PER_DEG for axis, size in limit.largest_rad.items()}
    limits = {axis: np.rad2deg(size) * ARCSEC_PER_DEG for axis, size in limit.limit_rad.items()}
    details: dict[str, float | str | None] = {"test": test.name}
    details |= {f"{axis}_arcsec": float(size) for axis, size in sizes.items()}
    details |= {f"{axis}_limit_arcsec": float(size) for axis, size in limits.items()}
    said = (
        _beyond_the_table(sizes, limits, limit) if is_significant else Said(f"{test.name}: {_within_the_table(limit)}")
    )
    return Finding(
        test.kind,
        said.fact,
        is_significant,
        test.p_value,
        details=details,
        is_held=test.is_held,
        what_to_do=said.what_to_do,
    )


def _within_the_table(limit: TableLimit) -> str:
    if limit.is_of_single_output:
        return "index errors within it explain all outputs but one, which departs alone: that is none of the table"
    return "index errors within it explain the points"


def _beyond_the_table(sizes: Mapping[str, float], limits: Mapping[str, float], limit: TableLimit) -> Said:
    beyond = [axis for axis, size in sizes.items() if size > limits[axis]]
    shown = " and ".join(
        f"{axis} by {significant(sizes[axis])}″ (declared ±{significant(limits[axis])}″)" for axis in beyond
    )
    declared = " and ".join(f"±{significant(size)}″ in {axis}" for axis, size in limits.items())
    index_errors = f"its index errors in {shown}, as far as the attitudes show them"
    chance = f"{limit.p_value:.2g}".replace("-", "−")
    compared = f"no index errors within the declared {declared} explain the points as larger ones do (p = {chance})"
    unheld = "offset and sensitivities hold part of it that the stated uncertainties do not"
    what_to_do = (
        "look at the table, its coupling and its last certificate, and declare the limit, or the errors at angles, "
        "that it has"
    )
    if limit.outputs == 1 or limit.is_departing:
        either = (
            f"either the table is off by more than is declared, {index_errors},"
            if beyond
            else (f"{compared}: either the table has larger ones,")
        )
        parted = (
            "the other outputs of the package are explained within the limit, and one that sees the most of a table's "
            f"axis does not tell the two apart; {unheld}"
            if limit.is_departing
            else f"one output alone does not tell the two apart; {unheld}"
        )
        second = "" if limit.is_departing else ", or measure a second output on the same table"
        fact = f"{either} or the sensor has a nonlinearity of its own of higher order: {parted}"
        return Said(fact, f"{what_to_do}{second}")
    first = f"the table is off by more than is declared: {index_errors}" if beyond else f"the table: {compared}"
    return Said(f"{first}, alike for every output of this package; {unheld}", what_to_do)
