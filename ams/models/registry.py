"""Which model a name in a file stands for."""

from ams.errors import DesignError
from ams.models.model import Model
from ams.models.sensor_model import SensorModel
from ams.registry import Registry

MODELS: Registry[SensorModel] = Registry("calrig.models", SensorModel, DesignError)


def names_by_option() -> tuple[str, ...]:
    """Return the names that a file or the command may ask for: each stands for one registered model or several."""
    return tuple(dict.fromkeys(model.name_in_files for model in MODELS.values() if model.is_offered))


def models_of_name(name: str) -> tuple[SensorModel, ...]:
    """Return the models that a name in a file or of the command stands for; none where nothing has it."""
    return tuple(model for model in MODELS.values() if model.is_offered and model.name_in_files == name)


def names_at_rest() -> tuple[str, ...]:
    """Return of :func:`names_by_option` those of models that attitudes at rest determine."""
    return tuple(name for name in names_by_option() if not senses_rates(name))


def names_of_rates() -> tuple[str, ...]:
    """Return of :func:`names_by_option` those of models that sense rates."""
    return tuple(filter(senses_rates, names_by_option()))


def senses_rates(name: str) -> bool:
    """Return whether what a name asks for needs the rates of the axes."""
    return any(model.needs_rates for model in models_of_name(name))


def knows_roll(name: str) -> bool:
    """Return whether observations for what a name asks for must state roll."""
    return any("roll" in model.columns for model in models_of_name(name))


def takes_levels(name: str) -> bool:
    """Return whether a name asks for straight lines, where levels of the quantity itself are known."""
    return any(model.takes_levels for model in models_of_name(name))


def is_solved_from_levels(model: str) -> bool:
    """Return whether the model of a solution takes levels of the quantity itself; False where nothing registers it."""
    return model in MODELS and MODELS[model].takes_levels


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
