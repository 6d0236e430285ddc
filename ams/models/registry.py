"""Which model a name in a file stands for."""

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

from ams.errors import DesignError
from ams.models.accelerometer import PitchOnly, PitchRoll
from ams.models.gyro import Gyro
from ams.models.level_line import LevelLine
from ams.models.model import Model
from ams.models.pitch_yaw_roll import PitchYawRoll

MODELS: Mapping[str, Callable[[str], Model]] = MappingProxyType(
    {
        "pitch-roll": PitchRoll,
        "pitch-only": PitchOnly,
        "pitch-yaw-roll-sting": partial(PitchYawRoll, package="sting"),
        "pitch-yaw-roll-model": partial(PitchYawRoll, package="model"),
        "gyro": Gyro,
        "linear-accelerometer": LevelLine,
    }
)
"""Name to the constructor from a nominal axis: every model names itself as it stands here."""


def model_named(name: str, nominal_axis: str) -> Model:
    """The model of one sensor axis.

    Raises:
        DesignError: there is no such model or no such axis.
    """
    if nominal_axis not in ("x", "y", "z"):
        raise DesignError(f"model {name}: nominal axis: got {nominal_axis!r}, allowed x, y or z; nothing was solved")
    if name not in MODELS:
        raise DesignError(f"model: got {name!r}, allowed {', '.join(MODELS)}; nothing was solved; name one of these")
    return MODELS[name](nominal_axis)
