"""Which model a name in a file stands for."""

from ams.errors import DesignError
from ams.models.model import Model
from ams.models.sensor_model import SensorModel
from ams.registry import Registry

MODELS: Registry[SensorModel] = Registry("calrig.models", SensorModel, DesignError)


def model_named(name: str, nominal_axis: str) -> Model:
    """The model of one sensor axis.

    Raises:
        DesignError: there is no such model or no such axis.
    """
    if nominal_axis not in ("x", "y", "z"):
        raise DesignError(f"model {name}: nominal axis: got {nominal_axis!r}, allowed x, y or z; nothing was solved")
    if name not in MODELS:
        raise DesignError(f"model: got {name!r}, allowed {', '.join(MODELS)}; nothing was solved; name one of these")
    return MODELS[name].make(nominal_axis)
