"""What the sensors of each model sense, as the registered models say: specific force, gravity, angular velocity.

Every equation of a set is v = b + k·h with h this field in package axes, or a function of it that the model brings; so
a set needs no more than the name of its model to be evaluated.
"""

import re
from collections.abc import Iterator, Mapping, Sequence

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.frames import Exposure
from ams.models.registry import MODELS
from ams.models.sensor_model import PER_G as PER_G
from ams.models.sensor_model import SetForm

_K_NAME = re.compile(r"k_[xyz]_(?P<measured>.+)_per_(?P<unit>.+)")


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


Units = tuple[str, str]
"""Of the output and of what is sensed, as they are written in keys."""


def form_of(model: str, units: Units | None) -> SetForm:
    """Return the form of a model, in the units given where its names depend on them."""
    form = FIELDS[model]
    return form if units is None or form.in_units is None else form.in_units(*units)


def units_in(model: str, primary_names: Sequence[str]) -> Units | None:
    """Return the units that the names of the primary parameters end in; None where the model fixes them."""
    if model not in FIELDS or FIELDS[model].in_units is None:
        return None
    found = next((match for name in primary_names if (match := _K_NAME.fullmatch(name))), None)
    return None if found is None else (found["measured"], found["unit"])


def form_by_names(model: str, primary_names: Sequence[str]) -> SetForm | None:
    """Return the form of a solved axis, in the units that the names of its primary parameters end in.

    None where no coefficient set has the model.
    """
    return form_of(model, units_in(model, primary_names)) if model in FIELDS else None


def field_at(model: str, units: Units | None, attitude: Exposure) -> FloatArray:
    """Return the (…, 3) field in package axes: local g, °/s for gyros, the unit of straight lines.

    Raises: OutsideValidity where the model needs a yaw, rates or levels that are not given.
    """
    form = form_of(model, units)
    if form.senses_level and attitude.package_level is None:
        raise OutsideValidity(
            f"model {model}: the level is missing: straight lines take the quantity itself along the package's axes; "
            f"nothing was computed; give level, (…, 3) in {form.unit}"
        )
    if "yaw_deg" in form.inputs and attitude.yaw_rad is None:
        raise OutsideValidity(f"model {model}: yaw is missing: the set knows yaw; nothing was computed; give yaw_rad")
    if form.senses_rates and attitude.euler_rate_rad_s is None:
        raise OutsideValidity(
            f"model {model}: the rates are missing: gyros sense the rates of pitch, yaw and roll; nothing was "
            "computed; give euler_rate_rad_s"
        )
    return form.field(attitude)
