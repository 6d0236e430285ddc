"""What a registered sensor model is: how it is made for the solvers, what a file must state, and how a set has it.

A model is one file with a class that the solvers take (:mod:`ams.models.model`), one :class:`SensorModel` and one entry
point ``calrig.models``. With a :class:`SetForm` it goes into coefficient sets, exports and their application as well.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ams.arrays import FloatArray
from ams.frames import Exposure
from ams.models.model import Model

PER_G = ("k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g")
RATE_INPUTS = ("pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps")
"""Of the angles, in the order in which attitudes have them; columns of observations and inputs of a set."""
ACCELEROMETER_TEXT = "output = offset_v + k_x_v_per_g*f_x + k_y_v_per_g*f_y + k_z_v_per_g*f_z"
SYMBOLS_TEXT = "; alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, "


@dataclass(frozen=True)
class Equation:
    """What a set prints about the equation of one axis, temperature apart."""

    source: str
    primary: str
    derived: str


@dataclass(frozen=True, kw_only=True)
class LowOrder:
    """Terms that may stand in an equation beside v = b + k·h, each without its best linear approximation.

    A set has as many of them, from the first, as its ``centring`` has rows.
    """

    names: tuple[str, ...]
    """Of their coefficients among the primary parameters."""
    basis: Callable[[FloatArray, str], FloatArray]
    """(…, t) what each coefficient multiplies, from the (…, 3) field and the nominal axis, nothing taken off."""
    c: Callable[[str], tuple[str, ...]]
    """The same as expressions in C, of ``f[0]`` to ``f[2]``."""


@dataclass(frozen=True, kw_only=True)
class ModelOutput:
    """The output of a model whose equation is not v = b + k·f (+ fᵀQf), as a function of the field."""

    primary_names: tuple[str, ...]
    value_v: Callable[[Mapping[str, float], FloatArray], FloatArray]
    """From the primary parameters and the (…, 3) field."""
    c: str | None = None
    """The same as an expression in C: ``f[0]`` to ``f[2]``, and each primary parameter by its name in braces."""
    pitch_rad: Callable[[Mapping[str, float], FloatArray], FloatArray] | None = None
    """The inverse, from (N,) outputs at no roll; NaN where there is no such pitch. None: attitude is not inferred."""


@dataclass(frozen=True, kw_only=True)
class SetForm:
    """How a coefficient set has a model: the field that it senses, the names of its numbers, its text and its C.

    The field h is (…, 3) in package axes; the equation is v = b + k·h unless ``output`` says otherwise.
    """

    convention: str
    """``TP``, ``CR`` or ``SR``."""
    symbol: str
    """Of the field in the printed equations."""
    inputs: tuple[str, ...]
    """What the equation takes, as named in test vectors, temperature apart."""
    field: Callable[[Exposure], FloatArray]
    """Asked for only with the yaw and the rates that ``inputs`` name."""
    equation: Callable[[str], Equation | None]
    """Of a nominal axis; None where the model has none for it."""
    centred_equation: Callable[[str, int], Equation | None] | None = None
    """The same with so many terms taken without their best linear approximation; None: the model has no such terms."""
    directions: tuple[str, str, str] = PER_G
    """Names of k among the primary parameters."""
    quadratic: tuple[str, ...] = ()
    """Names of Q among the primary parameters."""
    low_order: LowOrder | None = None
    """None: nothing stands beside v = b + k·h."""
    angles: tuple[str, ...] = ("coning_deg", "azimuth_deg")
    """The derived parameters that tell the direction of k."""
    along: Callable[[str, FloatArray], FloatArray] | None = None
    """(3,) unit vector of k from the nominal axis and those angles in radians; None: k is not derived from angles."""
    c_field: str | None = None
    """The field as statements in C that fill ``f[3]``, angles in radians by the names of the inputs; None: no C."""
    is_gravity: bool = False
    """Whether k is per g of gravity, which points the other way than the specific force."""
    senses_roll: bool = True
    senses_rates: bool = False
    output: ModelOutput | None = None
    offset: str = "offset_v"
    """Name of b among the primary parameters."""
    measured_unit: str = "v"
    """Of the outputs, as it is written in a key."""
    unit: str = "g"
    """Of the field that is sensed, as it is written in a key."""
    in_units: Callable[[str, str], "SetForm"] | None = None
    """The same form for another unit of the outputs and of the field; None: its names have their units."""
    gain: str | None = None
    """The derived parameter 1/k along the nominal axis, of straight lines turned round."""
    site_prefixes: tuple[str, ...] = ()
    """How primary parameters begin that tell of the place and not of the sensor: a set's equation is without them."""

    @property
    def senses_level(self) -> bool:
        """Whether the inputs are the field itself along the package's axes, and no attitude."""
        return self.inputs[0].startswith("level_")

    @property
    def sensitivity(self) -> str:
        return self.directions[0].replace("k_x", "sensitivity")


@dataclass(frozen=True, kw_only=True)
class SensorModel:
    """One model by its name in files, registered under ``calrig.models``."""

    name: str
    make: Callable[[str], Model]
    """From a nominal axis. Raises: DesignError where there is no such sensor."""
    columns: tuple[str, ...] = ("pitch", "roll")
    """Angles that observations must state."""
    needs_rates: bool = False
    has_misalignment: bool = True
    """Whether it has terms for a misalignment; without, one shows in the residuals."""
    set_form: SetForm | None = None
    """None: no coefficient set has it."""
    family: str | None = None
    """What files and ``calrig fit --model`` call it by, where one name stands for several models."""
    is_offered: bool = True
    """Whether they may ask for it."""
    takes_levels: bool = False
    """Whether it is solved from levels of the quantity itself, as straight lines, and not from attitudes."""

    @property
    def name_in_files(self) -> str:
        """Return the name by which files and the command ask for it."""
        return self.family or self.name

    @property
    def follows_yaw(self) -> bool:
        """Whether yaw may be other than 0: the observations state it, or the levels follow from it."""
        return "yaw" in self.columns or (self.set_form is not None and self.set_form.senses_level)

    @property
    def is_of_sting(self) -> bool:
        """Whether it is CR's package on the sting, which roll does not reach: it tells pitch and yaw."""
        return "yaw" in self.columns and "roll" not in self.columns

    @property
    def follows_sting(self) -> bool:
        """Whether it is CR's package in the model: it tells roll where the sting's tells pitch and yaw."""
        return {"yaw", "roll"} <= set(self.columns) and not self.needs_rates
