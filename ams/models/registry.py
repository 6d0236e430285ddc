"""Which model a name in a file stands for."""

from ams.errors import DesignError
from ams.models.model import Model
from ams.models.sensor_model import SensorModel
from ams.registry import Registry

MODELS: Registry[SensorModel] = Registry("calrig.models", SensorModel, DesignError)
FAMILIES = ("pitch-yaw-roll", "linear")
"""Names that stand for several models: CR's two packages, and straight lines of whatever a sensor measures."""


def names_by_option() -> tuple[str, ...]:
    """Return the names that a file or the command may ask for: registered models and families of them."""
    return (*(name for name, model in MODELS.items() if model.is_offered), *FAMILIES)


def built_in_models_at_rest() -> tuple[str, ...]:
    """Return the models of other distributions that are told by attitudes alone."""
    return tuple(name for name in MODELS.foreign() if MODELS[name].is_offered and not MODELS[name].needs_rates)


def model_named(name: str, nominal_axis: str) -> Model:
    """Return the model of one sensor axis.

    Raises:
        DesignError: there is no such model or no such axis.
    """
    if nominal_axis not in ("x", "y", "z"):
        raise DesignError(f"model {name}: nominal axis: got {nominal_axis!r}, allowed x, y or z; nothing was solved")
    if name not in MODELS:
        raise DesignError(f"model: got {name!r}, allowed {', '.join(MODELS)}; nothing was solved; name one of these")
    return MODELS[name].make(nominal_axis)
