"""How it is said what nobody declared of a result and what is not tested of it, and how its verdict goes on then."""

from collections.abc import Iterable, Sequence
from types import MappingProxyType
from typing import Final

NO_LEVEL: Final = "the level of the base is not declared"
"""How the remark on an unread level begins."""
NO_TABLE: Final = "no uncertainty of the table's indices is declared"
"""How it is said of axes that turn and of whose indices nothing is known: in remark, verdict and gap."""
NO_METER: Final = "no uncertainty of the meter is declared"
"""How it is said of a meter without a standard that states volts: in remark, verdict and gap."""
NO_CROSSTALK: Final = "no crosstalk of the scanner is declared"
"""How it is said of a scanner of whose channels nobody declared how far they leak into each other."""
NO_STANDARD_OF_RATES: Final = "no standard of the rates is declared"
"""How it is said of gyros that turned about an axis without a standard: in remark, verdict and gap."""
NO_DIRECTIONS: Final = "no uncertainty of the directions of the table's axes is declared"
"""How it is said of gyros that turned about axes of whose squareness nothing is known: in remark, verdict and gap."""
NO_THERMOMETER: Final = "no uncertainty of the thermometer is declared"
"""How it is said of temperatures without a standard that states degrees, where a result is stated over them."""
NO_TEMPERATURE: Final = "no temperature was recorded with the readings"
"""How it is said of a sensor whose own temperature nobody knows."""
NO_COEFFICIENTS_U: Final = "no uncertainty of the known temperature coefficients is declared"
"""How it is said of coefficients that are applied as if they were exact."""
NO_GRAVITY: Final = "no uncertainty of local gravity is declared"
"""How it is said of a gravity that is stated alone: in remark, verdict and gap."""
NO_FIELD: Final = "no uncertainty of the field is declared"
"""How the remark on what magnetometers were held against begins."""
NO_TIMES: Final = "no times are given"
"""How it is said of rows of which nobody knows when they were measured, and whose order lets a drift pass."""
TERMS_NOT_DETERMINED: Final = "terms of second and third order are not determined by these points"
"""How it is said of points at which these terms pass for offset and sensitivities, such as six of a tumble."""
RATE_TERMS_NOT_DETERMINED: Final = "nonlinearity and asymmetry of the scale factor are not determined by these rates"
"""How it is said of gyros of few rates."""
THREE_RATES: Final = "what the scale factor does between three rates is not told by them"
"""How the remark on gyros of three rates begins."""
REFERENCE_NOT_MEASURED: Final = "nothing was measured near the reference temperature"
"""How a reservation begins where offset and sensitivities are stated at a temperature that nothing holds them at."""
CURVATURE_UNDETERMINED: Final = "curvature over temperature is not told"
"""How a reservation begins where temperature coefficients rest on two temperatures, the reference one of them."""
CUBIC_BEND_UNDETERMINED: Final = "a bend of third order over temperature is not told by three temperatures"
"""How the remark on three of them begins."""
TERMS_NOT_TESTED: Final = (
    "terms of second and third order, memories of the attitudes before and slips of the table are not tested for this "
    "model: what they do passes for a drift, for a lack of fit or for a sensitivity"
)
DIRECTIONS_NOT_MEASURED: Final = (
    "how the sensitive axes lie to one another is not told by lines along the nominal axes: what several of them "
    "measure together, such as an angle, is off by as much as they lie off, which is in no uncertainty; solve them as "
    "one package, from attitudes or rates that turn all of them"
)
"""How it is said of straight lines, each along its nominal axis."""
NOT_BUDGETED: Final = (
    "not tested and not budgeted beyond the limits that are declared of the item: what vibration does to its zero "
    "(rectification), and what its supply does that changes with load or temperature"
)
"""How it is said of every accelerometer: at rest on one supply nothing shows either."""
_WITHOUT: Final = MappingProxyType(
    {
        NO_LEVEL: "the level of the base",
        NO_TABLE: "the uncertainty of the table's indices",
        NO_METER: "the uncertainty of the meter",
        NO_CROSSTALK: "the crosstalk of the scanner",
        NO_STANDARD_OF_RATES: "a standard of the rates",
        NO_DIRECTIONS: "the directions of the table's axes",
        NO_THERMOMETER: "the uncertainty of the thermometer",
        NO_COEFFICIENTS_U: "the uncertainty of the temperature coefficients",
        NO_GRAVITY: "the uncertainty of local gravity",
        NO_FIELD: "the uncertainty of the field",
    }
)
"""How a remark begins, and what the verdict then says that the result is without."""
_UNTESTED: Final = MappingProxyType(
    {
        TERMS_NOT_DETERMINED: "terms of second and third order, which these points do not determine",
        RATE_TERMS_NOT_DETERMINED: (
            "nonlinearity and asymmetry of the scale factor, which these rates do not determine"
        ),
        THREE_RATES: "a bend of third order of the scale factor between the three rates",
        TERMS_NOT_TESTED: "terms of second and third order, memories and slips of the table",
        DIRECTIONS_NOT_MEASURED: "how the sensitive axes lie to one another",
        CUBIC_BEND_UNDETERMINED: "a bend of third order between the three temperatures",
        NO_TIMES: "a drift inside the replications, of which no times are given",
    }
)
"""A remark, and what the verdict then says that nobody looked for."""
_SAID_BY: Final = MappingProxyType({TERMS_NOT_DETERMINED: TERMS_NOT_TESTED})
"""A remark, and the one whose words in the verdict hold those of the first."""

BEGINNINGS: Final = (*_WITHOUT, *_UNTESTED)
"""How every remark begins that a verdict goes on with."""


def verdict_conditions(remarks: Iterable[str]) -> str:
    """Return without what a result is, as its verdict goes on: what nobody declared, and what is not tested.

    Such as ``, without …, which is not declared; not tested for …``; empty where nothing lacks.
    """
    texts = tuple(remarks)
    stated = {begins for begins in BEGINNINGS if any(text.startswith(begins) for text in texts)}
    stated -= {begins for begins, other in _SAID_BY.items() if other in stated}
    undeclared, untested = (
        [what for begins, what in known.items() if begins in stated] for known in (_WITHOUT, _UNTESTED)
    )
    said = ""
    if undeclared:
        said += f", without {_in_a_row(undeclared)}, which {'is' if len(undeclared) == 1 else 'are'} not declared"
    if untested:
        said += f"; not tested for {'; '.join(untested)}"
    return said


def _in_a_row(words: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))
