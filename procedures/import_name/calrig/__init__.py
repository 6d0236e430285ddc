"""calrig for scripts and notebooks: fit observations, plan and run procedures, read runs and coefficient sets.

Paths may be texts. What a function needs is loaded when it is first used, so that importing this costs next to nothing.
docs/python.md shows each of them at work.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ams.exports.formats import load_set as load_set
    from procedures.data.run_data import RunData as RunData
    from procedures.data.run_data import read_run as read_run
    from procedures.data.solved import Solved as Solved
    from procedures.facade.fitting import fit as fit
    from procedures.facade.planning import PlannedRun as PlannedRun
    from procedures.facade.planning import plan as plan
    from procedures.facade.rigs import run as run
    from procedures.facade.rigs import simulate as simulate

    __version__: str

_HOME = {
    "PlannedRun": "procedures.facade.planning",
    "RunData": "procedures.data.run_data",
    "Solved": "procedures.data.solved",
    "fit": "procedures.facade.fitting",
    "load_set": "ams.exports.formats",
    "plan": "procedures.facade.planning",
    "read_run": "procedures.data.run_data",
    "run": "procedures.facade.rigs",
    "simulate": "procedures.facade.rigs",
}

__all__ = ["PlannedRun", "RunData", "Solved", "__version__", "fit", "load_set", "plan", "read_run", "run", "simulate"]


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> object:
    if name == "__version__":
        return import_module("importlib.metadata").version("calrig")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
