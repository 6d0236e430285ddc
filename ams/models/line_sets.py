"""SR's straight lines in a coefficient set: measured = b + k·h, h the quantity itself along the package's axes.

A line along one direction has one component of k, a magnetometer that was turned in a known field all three; three axes
together are a 3 × 3 matrix of sensitivities with offset, as IMUs have it. The units are those of the reading and of
the quantity, so every name of such a set ends in them. SR's own form, real = A·measured + B, stands beside it: A = 1/k
along the nominal axis, B = −b/k. Source: SR 4.1.
"""

from dataclasses import replace
from functools import cache

from ams.arrays import FloatArray
from ams.frames import AXES, Exposure
from ams.models.level_line import LevelLine
from ams.models.sensor_model import Equation, SensorModel, SetForm
from ams.models.straight_line import StraightLine

_C_LEVELS = """
    f[0] = level_x_{unit};
    f[1] = level_y_{unit};
    f[2] = level_z_{unit};
"""


@cache
def _form(measured_unit: str, unit: str) -> SetForm:
    """Return the form of lines whose outputs and quantity have these units."""
    x, y, z = (f"k_{axis}_{measured_unit}_per_{unit}" for axis in AXES)
    lowest = f"zero_level_{measured_unit}"
    gain, offset = f"gain_{unit}_per_{measured_unit}", f"offset_{unit}"

    def equation(nominal_axis: str) -> Equation | None:
        if nominal_axis not in AXES:
            return None
        k = f"k_{nominal_axis}_{measured_unit}_per_{unit}"
        return Equation(
            "SR 4.1",
            f"output = {lowest} + {x}*level_x_{unit} + {y}*level_y_{unit} + {z}*level_z_{unit}; a k that is not given "
            "is 0",
            f"along the axis: level_{nominal_axis}_{unit} = A*output + B; A = {gain} = 1/{k}, B = {offset} = "
            f"-{lowest}/{k}",
        )

    return SetForm(
        convention="SR",
        symbol="h",
        inputs=tuple(f"level_{axis}_{unit}" for axis in AXES),
        field=_level,
        equation=equation,
        directions=(x, y, z),
        angles=(),
        c_field=_C_LEVELS.format(unit=unit),
        offset=lowest,
        measured_unit=measured_unit,
        unit=unit,
        in_units=_form,
        gain=gain,
        site_prefixes=("surroundings_",),
    )


@cache
def _accelerometer_form(measured_unit: str, unit: str) -> SetForm:
    """Return the form of accelerometers at known attitudes, whose zero is called offset_v."""
    plain = _form(measured_unit, unit)

    def equation(nominal_axis: str) -> Equation | None:
        printed = plain.equation(nominal_axis)
        if printed is None:
            return None
        primary, derived = (text.replace(plain.offset, "offset_v") for text in (printed.primary, printed.derived))
        return Equation(printed.source, primary, derived)

    return replace(plain, equation=equation, offset="offset_v", in_units=_accelerometer_form)


def _level(attitude: Exposure) -> FloatArray:
    assert attitude.package_level is not None, "the inputs of the model say so"
    return attitude.package_level


LINEAR = SensorModel(
    name="linear",
    make=lambda nominal_axis: StraightLine(nominal_axis, "g", "v"),
    has_misalignment=False,
    set_form=_form("v", "g"),
    family="linear",
    takes_levels=True,
)
"""Whoever knows the units makes the line itself."""

LINEAR_ACCELEROMETER = SensorModel(
    name="linear-accelerometer",
    make=LevelLine,
    has_misalignment=False,
    set_form=_accelerometer_form("v", "g"),
    family="linear",
)
