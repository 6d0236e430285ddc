"""What the sensors of each model sense, as the registered models say: specific force, gravity, angular velocity.

Every equation of a set is v = b + k·h with h this field in package axes, or a function of it that the model brings; so
a set needs no more than the name of its model to be evaluated.
"""

from collections.abc import Iterator, Mapping

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.frames import Attitude
from ams.models.registry import MODELS
from ams.models.sensor_model import PER_G as PER_G
from ams.models.sensor_model import SetForm

RATE_INPUTS = ("pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps")


class _Forms(Mapping[str, SetForm]):
    """Name to form of every registered model that a set can have."""

    def __getitem__(self, name: str) -> SetForm:
        form = MODELS[name].set_form
        if form is None:
            raise KeyError(name)
        return form

    def __iter__(self) -> Iterator[str]:
        return (name for name, model in MODELS.items() if model.set_form is not None)

    def __len__(self) -> int:
        return sum(1 for _ in self)


FIELDS: Mapping[str, SetForm] = _Forms()


def field_at(model: str, attitude: Attitude) -> FloatArray:
    """Return the (…, 3) field in package axes: local g, or °/s for gyros.

    Raises: OutsideValidity where the model needs a yaw or rates that are not given.
    """
    form = FIELDS[model]
    if "yaw_deg" in form.inputs and attitude.yaw_rad is None:
        raise OutsideValidity(f"model {model}: yaw is missing: the set knows yaw; nothing was computed; give yaw_rad")
    if form.senses_rates and attitude.euler_rate_rad_s is None:
        raise OutsideValidity(
            f"model {model}: the rates are missing: gyros sense the rates of pitch, yaw and roll; nothing was "
            "computed; give euler_rate_rad_s"
        )
    return form.field(attitude)
