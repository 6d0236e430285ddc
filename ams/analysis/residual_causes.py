"""What usually makes a Fourier term of the residuals: the table, its seat, or a soft mount inside the package.

Each mechanism turns the specific force a little, or bends it quadratically; which terms that leaves in the output of a
sensor along x, y or z follows from the small turns of :mod:`ams.solve.table_errors` and from fᵀQf, and is checked
against explicit rotations in the tests. What lies in the model itself (a roll zero turns the package) leaves nothing.
Source: TP 9.2, figures 37 to 41, for the soft mount.
"""

from collections.abc import Mapping
from types import MappingProxyType

_SOFT_MOUNT = frozenset(
    {"cos 2α", "sin 2α·sin R", "sin 2α·cos R", "cos 2R", "sin 2R", "cos 2α·cos 2R", "cos 2α·sin 2R"}
)
_ROLL_AXIS = frozenset({"cos α", "cos α·cos 2R", "cos α·sin 2R"})

MECHANISMS: Mapping[str, Mapping[str, frozenset[str]]] = MappingProxyType(
    {
        "the table's pitch axis (an error once a turn)": {
            "x": frozenset({"sin 2α"}),
            "y": frozenset({"sin R", "cos 2α·sin R"}),
            "z": frozenset({"cos R", "cos 2α·cos R"}),
        },
        "the zero of the pitch axis or the level of the base along it": {
            "x": frozenset({"cos α"}),
            "y": frozenset({"sin α·sin R"}),
            "z": frozenset({"sin α·cos R"}),
        },
        "the level of the base across the pitch axis": {"y": frozenset({"cos R"}), "z": frozenset({"sin R"})},
        "a roll axis that is not square to the pitch axis": {
            "y": frozenset({"sin α·cos R"}),
            "z": frozenset({"sin α·sin R"}),
        },
        "droop of the table": {
            "x": frozenset({"cos 2α"}),
            "y": frozenset({"sin 2α·sin R"}),
            "z": frozenset({"sin 2α·cos R"}),
        },
        "the table's roll axis (an error once a turn)": {"y": _ROLL_AXIS, "z": _ROLL_AXIS},
        "a soft mount inside the package": dict.fromkeys("xyz", _SOFT_MOUNT),
    }
)
"""Words for a mechanism to the terms that it leaves in the output of a sensor along each nominal axis."""
SHARES = frozenset({"sin α", "cos α·sin R", "cos α·cos R"})
"""Of gravity along the package's axes: what a straight line along one of them leaves of the others."""
MISALIGNED = "a misalignment of the sensor, which a straight line has no term for"
UNUSUAL = "no usual cause: look for something that moves with the table, such as cables or a magnetic field"


def usual_cause(term: str, nominal_axis: str) -> str:
    """Return what usually causes a Fourier term of the residuals, in words; several causes joined by 'or'."""
    words = [words for words, left in MECHANISMS.items() if term in left.get(nominal_axis, frozenset())]
    return " or ".join(words) if words else UNUSUAL
