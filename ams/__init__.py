"""The mathematics of the angular measurement system: models, solvers, uncertainty, attitude and coefficient sets.

No device and no clock is known here. The names below load what they need when they are first used, so that importing
the package costs next to nothing; ``from ams.calibration.calibrate import calibrate`` solves, ``ams.apply`` evaluates
a set, ``ams.load`` makes angles of its readings.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ams.analysis.design_variance import evaluate_design as evaluate_design
    from ams.calibration.document import to_document as to_document
    from ams.exports.formats import export_set as export_set
    from ams.exports.formats import load_set as load_set
    from ams.exports.verify import verify as verify
    from ams.in_use import Attitude as Attitude
    from ams.in_use import GyroStream as GyroStream
    from ams.in_use import PackageInUse as PackageInUse
    from ams.in_use import PackageStream as PackageStream
    from ams.in_use import load as load
    from ams.in_use import load_gyros as load_gyros
    from ams.inference.gyros.aided_rates import Aiding as Aiding
    from ams.inference.gyros.rates import Motion as Motion
    from ams.inputs.observations_csv import read_csv as read_csv
    from ams.inputs.request import CalibrationRequest as CalibrationRequest
    from ams.inputs.table_uncertainty import TableUncertainty as TableUncertainty
    from ams.observations import Observations as Observations
    from ams.sets.apply import apply as apply
    from ams.sets.apply import sensed_level as sensed_level
    from ams.sets.coefficients import build_set as build_set
    from ams.sets.provenance import Provenance as Provenance

_HOME = {
    "Aiding": "ams.inference.gyros.aided_rates",
    "Attitude": "ams.in_use",
    "CalibrationRequest": "ams.inputs.request",
    "GyroStream": "ams.in_use",
    "Motion": "ams.inference.gyros.rates",
    "Observations": "ams.observations",
    "PackageInUse": "ams.in_use",
    "PackageStream": "ams.in_use",
    "Provenance": "ams.sets.provenance",
    "TableUncertainty": "ams.inputs.table_uncertainty",
    "apply": "ams.sets.apply",
    "build_set": "ams.sets.coefficients",
    "evaluate_design": "ams.analysis.design_variance",
    "export_set": "ams.exports.formats",
    "load": "ams.in_use",
    "load_gyros": "ams.in_use",
    "load_set": "ams.exports.formats",
    "read_csv": "ams.inputs.observations_csv",
    "sensed_level": "ams.sets.apply",
    "to_document": "ams.calibration.document",
    "verify": "ams.exports.verify",
}

__all__ = [
    "Aiding",
    "Attitude",
    "CalibrationRequest",
    "GyroStream",
    "Motion",
    "Observations",
    "PackageInUse",
    "PackageStream",
    "Provenance",
    "TableUncertainty",
    "apply",
    "build_set",
    "evaluate_design",
    "export_set",
    "load",
    "load_gyros",
    "load_set",
    "read_csv",
    "sensed_level",
    "to_document",
    "verify",
]


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
