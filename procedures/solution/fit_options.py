"""What ``calrig fit`` and ``calrig.fit`` are told in the same words: model, stated errors, day of the readings."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime, time, timedelta
from math import inf
from types import MappingProxyType
from typing import Final, Literal

from ams.calibration.linear_levels import scale_error, zero_error
from ams.frames import ANGLES
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.shared_errors import SharedError
from ams.models.registry import names_by_option, senses_rates, takes_levels
from procedures.errors import RequestError
from procedures.solution.declared_directions import declared_directions
from procedures.solution.earth_turn import earth_of_any_direction
from procedures.solution.sensor_of_file import sensor_of
from procedures.solution.type_b import direction_error, g_sensitivity_error
from rig.description.rig_file import RigDescription

Option = Callable[[str], str]
"""From the name of an option, such as ``calibrated_on``, to how the caller is told of it."""
OF_TWO_PACKAGES: Final = "pitch-yaw-roll"


@dataclass(frozen=True)
class StatedError:
    """What one option of a fit states."""

    largest: float
    unit: str
    errors_of: Callable[[float], tuple[SharedError, ...]]
    is_of: Callable[[str], bool]
    """Whether a name of a model takes the option."""


def _rate_error(uncertainty_ppm: float) -> SharedError:
    """Return the one error of all rates of a table, as a relative standard uncertainty states it."""
    return SharedError("rate of the table", "rate", 1e-6 * uncertainty_ppm, stated=f"u {uncertainty_ppm:g} ppm")


def _direction_errors(u_arcsec: float) -> tuple[SharedError, ...]:
    """Return how far the axes of a table lean, each by itself, as one standard uncertainty of all of them states it."""
    return tuple(direction_error(axis, u_arcsec, f"u {u_arcsec:g}″ to either side") for axis in ANGLES)


STATED: Final[Mapping[str, StatedError]] = MappingProxyType(
    {
        "rate_uncertainty_ppm": StatedError(1e5, "ppm", lambda u: (_rate_error(u),), senses_rates),
        "direction_uncertainty_arcsec": StatedError(3.6e4, "″", _direction_errors, senses_rates),
        "largest_g_sensitivity_dps_per_g": StatedError(
            10.0, "°/s per g", lambda limit: (g_sensitivity_error(limit),), senses_rates
        ),
        "reference_uncertainty_ppm": StatedError(1e5, "ppm", lambda u: (scale_error(u),), takes_levels),
        "reference_zero_uncertainty": StatedError(
            inf, "in the unit of the known levels", lambda u: (zero_error(u),), takes_levels
        ),
    }
)
"""Every option by which a fit is told what its reference is wrong by, or its sensor at most."""


SIGNS: Final[Mapping[str, Literal[1, -1]]] = MappingProxyType({"+": 1, "-": -1})
"""How a polarity is written."""
INCLUDED_BY: Final = "--rates-include-earth of calrig fit says that the rates include it"


def on_command_line(name: str) -> str:
    """Return ``--calibrated-on`` of ``calibrated_on``."""
    return f"--{name.replace('_', '-')}"


def in_python(name: str) -> str:
    """Return ``fit: calibrated_on`` of ``calibrated_on``."""
    return f"fit: {name}"


def model_named(model: str, package: str | None, option: Option) -> str:
    """Return the name of a model in the mathematics, where CR's two packages are two models. Raises: RequestError."""
    if model not in names_by_option():
        allowed = ", ".join(names_by_option())
        raise RequestError(f"{option('model')}: got {model!r}, allowed are {allowed}; nothing was solved")
    if model != OF_TWO_PACKAGES:
        if package is not None:
            raise RequestError(
                f"{option('package')} {package}: belongs to {option('model')} {OF_TWO_PACKAGES}, not to {model}; "
                "nothing was solved"
            )
        return model
    if package not in ("sting", "model"):
        found = "is missing" if package is None else f"got {package!r}"
        raise RequestError(
            f"{option('package')} {found}: {OF_TWO_PACKAGES} needs the package, sting or model; nothing was solved"
        )
    return f"{model}-{package}"


def refuse_reference_temperature(reference_degc: float | None, temperature: str, option: Option) -> None:
    """Refuse a temperature at which coefficients are to hold that have no temperature in them. Raises: RequestError."""
    if reference_degc is not None and temperature == "none":
        given = option("temperature")
        raise RequestError(
            f"{option('reference_temperature_degc')}: belongs to {given} apply or estimate, not to {given} none; "
            "nothing was solved"
        )


def errors_of_options(
    stated: Sequence[float | None], model: str, option: Option, *, rates_include_earth: bool
) -> Mapping[str, tuple[SharedError, ...]]:
    """Return what the options of a fit state of the rates, of gravity's doing and of the known levels, for every axis.

    ``stated``: the value of each option of :data:`STATED`, in its order. ``rates_include_earth``: whether the rates are
    stated to include the Earth's, which is an error of gyros else.

    Raises: RequestError for one that is of another model, or beyond what is allowed.
    """
    found: list[SharedError] = []
    if senses_rates(model) and not rates_include_earth:
        found.append(earth_of_any_direction(INCLUDED_BY))
    if rates_include_earth:
        _require_model(model, senses_rates, "rates_include_earth", option)
    for (name, of), value in zip(STATED.items(), stated, strict=True):
        if value is None:
            continue
        _require_model(model, of.is_of, name, option)
        if not 0.0 < value < of.largest:
            below = "" if of.largest == inf else f" and below {of.largest:g}"
            raise RequestError(f"{option(name)}: got {value:g}, allowed above 0{below} {of.unit}")
        found += of.errors_of(value)
    return dict.fromkeys("xyz", tuple(found)) if found else {}


def directions_of(
    polarity: Mapping[str, str],
    axes: Collection[str],
    model: str,
    described: tuple[RigDescription | None, str | None],
    option: Option,
) -> Mapping[str, DeclaredDirection]:
    """Return what is declared of the axes' directions: by the rig file and its sensor in it, and of signs by an option.

    ``polarity``: axis to ``+`` or ``-``, the sign of its sensitivity. ``axes``: those that are solved.

    Raises: RequestError for a sign of no axis, another word than a sign, and one that the rig file declares already.
    """
    rig, sensor = described
    found = {} if rig is None else dict(declared_directions(sensor_of(rig, sensor)))
    if polarity:
        _require_model(model, lambda name: not takes_levels(name), "polarity", option)
    for axis, sign in polarity.items():
        what = f"{option('polarity')} {axis}={sign}"
        if axis not in axes:
            raise RequestError(f"{what}: no column is that axis; it has {', '.join(axes)}; nothing was solved")
        if sign not in SIGNS:
            raise RequestError(f"{what}: allowed are {axis}=+ and {axis}=-; nothing was solved")
        direction = found.get(axis, DeclaredDirection(axis))
        if direction.polarity is not None:
            raise RequestError(
                f"{what}: the rig file declares it already, by the sign of the sensor's nominal sensitivity; nothing "
                "was solved; correct the one that is wrong and leave out the option"
            )
        found[axis] = replace(direction, polarity=SIGNS[sign])
    return found


def _require_model(model: str, is_of: Callable[[str], bool], name: str, option: Option) -> None:
    """Check that an option belongs to the model. Raises: RequestError where it does not."""
    if model not in (names := tuple(filter(is_of, names_by_option()))):
        given = option("model")
        raise RequestError(f"{option(name)}: belongs to {given} {' or '.join(names)}, not to {given} {model}")


REHEARSED_AHEAD = timedelta(days=31)
"""The clock of a rehearsal runs ahead: so far the readings of one may be to come."""


def measured_utc(last_utc: datetime | None, stated: str | date | None, today: date, option: Option) -> datetime | None:
    """Return when the readings were taken: as the file tells, or on the day that is stated; None where nothing says it.

    Raises: RequestError for what is no day, one to come (in the file by more than :data:`REHEARSED_AHEAD`), or a day
    beside those of the file.
    """
    name = option("calibrated_on")
    if last_utc is not None and last_utc.date() > today + REHEARSED_AHEAD:
        raise RequestError(
            f"column started_utc: the last reading is of {last_utc:%Y-%m-%d}, which is to come (today is {today}); "
            "nothing was solved; correct the column: a set that is dated in the future is due for calibration too late"
        )
    if stated is None:
        return last_utc
    if last_utc is not None:
        raise RequestError(
            f"{name}: the file tells it already (column started_utc, last {last_utc:%Y-%m-%d}); nothing was solved; "
            "give one of the two"
        )
    try:
        day = date.fromisoformat(stated) if isinstance(stated, str) else stated
    except ValueError:
        raise RequestError(f"{name}: got {stated!r}, allowed is a day such as 2026-03-01; nothing was solved") from None
    if day > today:
        raise RequestError(f"{name}: got {day}, which is to come (today is {today}); nothing was solved; correct it")
    return datetime.combine(day, time(12), UTC)
