"""The set of a file with the columns that its axes are read from."""

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from ams.exports.formats import load_set
from ams.inference.inference import Package
from ams.sets.coefficients import CoefficientSet
from procedures.errors import RequestError


class Wiring(Protocol):
    """What knows the channels of a stream; readings of a file have none."""

    def pairs(self, coefficients: CoefficientSet, option: str) -> list[str]:
        """Return AXIS=CHANNEL of the set's sensor. Raises: RequestError."""
        ...

    def check(self, columns: Mapping[str, str], unit: str, option: str) -> None:
        """Refuse channels that are not there, or in another unit than the set's. Raises: RequestError."""
        ...


def package_of(
    path: Path,
    pairs: list[str] | None,
    option: str,
    prefix: str,
    gravity_mps2: float | None = None,
    wiring: Wiring | None = None,
) -> Package:
    """Return the set of a file with the columns of its axes; with a stream of a rig its channels.

    Raises: RequestError for a pair that is none; SetError.
    """
    coefficients = load_set(path)
    coefficients.check_vectors(str(path))
    columns: dict[str, str] = {}
    unit = next(iter(coefficients.axes.values())).form.measured_unit
    if not pairs:
        named = [f"{axis}={prefix}{axis}_{unit}" for axis in coefficients.axes]
        pairs = named if wiring is None else wiring.pairs(coefficients, option)
    for pair in pairs:
        name, _, column = pair.partition("=")
        if name not in coefficients.axes or not column or name in columns:
            raise RequestError(
                f"{option} {pair}: allowed is AXIS=COLUMN, each of {', '.join(coefficients.axes)} at most once"
            )
        if column in columns.values():
            raise RequestError(
                f"{option} {pair}: {column} is read for another axis already; every axis has a column of its own"
            )
        columns[name] = column
    if wiring is not None:
        wiring.check(columns, unit, option)
    # Flags name axes in the set's order, in whatever order the options did.
    ordered = {axis: columns[axis] for axis in coefficients.axes if axis in columns}
    return Package(coefficients, ordered, gravity_mps2)
