"""The mathematics of the angular measurement system: models, solvers, uncertainty, attitude and coefficient sets.

No device and no clock is known here. The names below load what they need when they are first used, so that importing
the package costs next to nothing; ``from ams.calibrate import calibrate`` solves, ``ams.apply`` evaluates a set.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ams.document import to_document as to_document
    from ams.observations import Observations as Observations
    from ams.observations_csv import read_csv as read_csv
    from ams.request import CalibrationRequest as CalibrationRequest
    from ams.sets.apply import apply as apply
    from ams.uncertainty.design_variance import evaluate_design as evaluate_design
    from ams.uncertainty.table import TableUncertainty as TableUncertainty

_HOME = {
    "CalibrationRequest": "ams.request",
    "Observations": "ams.observations",
    "TableUncertainty": "ams.uncertainty.table",
    "apply": "ams.sets.apply",
    "evaluate_design": "ams.uncertainty.design_variance",
    "read_csv": "ams.observations_csv",
    "to_document": "ams.document",
}

__all__ = [
    "CalibrationRequest",
    "Observations",
    "TableUncertainty",
    "apply",
    "evaluate_design",
    "read_csv",
    "to_document",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
