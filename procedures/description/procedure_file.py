"""``procedure.toml`` as one frozen value: what is to be done, on any rig that can do it.

Checked here, table by table, before the rig is looked at; what only both files together can tell is the planner's.
The file is read by :mod:`procedures.kinds.read`, which adds the table that each kind of run has of its own.
"""

from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    Tag,
    field_validator,
    model_validator,
)

from ams.exports.formats import FORMATS
from ams.models.registry import names_by_option
from procedures.description.described_designs import DESCRIBED_DESIGNS
from procedures.description.dwell_settings import DwellSettings
from procedures.errors import PlanError
from rig.description.device_settings import NotNegative, Positive
from rig.toml_file import StrictTable, TomlFile, as_tuple

Order = Literal[
    "there-and-back", "forward-reverse", "serpentine", "raster", "as-listed", "neighbours", "blocks", "random", "seeded"
]  # fmt: skip
Angle = Annotated[float, Field(ge=-360.0, le=360.0)]
MAX_POINTS_PER_AXIS = 3601
Angles = Annotated[
    Annotated[Angle, Tag("one")] | Annotated[tuple[Angle, ...], BeforeValidator(as_tuple), Tag("list")],
    Discriminator(lambda value: "list" if isinstance(value, list | tuple) else "one"),
]
"""One angle or several."""
KindTable = TypeVar("KindTable", bound=StrictTable)


class Procedure(StrictTable):
    """``[procedure]``: the title and what kind of work it is."""

    title: Annotated[str, Field(min_length=1, max_length=200)]
    kind: str
    """A name of the registry of kinds, which gives the form of the file its allowed values."""
    replications: Annotated[int, Field(ge=1, le=1000)] = 1


class Range(StrictTable):
    """``{ from = -90.0, to = 90.0, step = 10.0 }`` or ``{ from, to, count }``: both ends are points."""

    start: Angle = Field(alias="from")
    stop: Angle = Field(alias="to")
    step: Positive | None = None
    count: Annotated[int, Field(ge=1, le=MAX_POINTS_PER_AXIS)] | None = None

    @model_validator(mode="after")
    def _step_or_count(self) -> Self:
        if (self.step is None) == (self.count is None):
            raise ValueError("give either step or count")
        if self.start > self.stop:
            raise ValueError(f"from must not exceed to, got from {self.start} to {self.stop}")
        if self.step is not None and (_decimal(self.stop) - _decimal(self.start)) % _decimal(self.step):
            raise ValueError(
                f"from {self.start} to {self.stop} is not a whole number of steps of {self.step}; correct an end or "
                "the step"
            )
        if self.count == 1 and self.start != self.stop:
            raise ValueError("one point cannot stand at both ends; give count = 2 or more")
        if len(self.values()) > MAX_POINTS_PER_AXIS:
            raise ValueError(f"{len(self.values())} points, at most {MAX_POINTS_PER_AXIS} are allowed")
        return self

    def values(self) -> tuple[float, ...]:
        """Return the points in degrees, exact in decimals: −90 to 90 by 0.1 holds 0.3 and not 0.30000000000000004."""
        first, span = _decimal(self.start), _decimal(self.stop) - _decimal(self.start)
        if self.step is not None:
            return tuple(
                float(first + _decimal(self.step) * index) for index in range(int(span / _decimal(self.step)) + 1)
            )
        assert self.count is not None
        return tuple(float(first + span * index / max(self.count - 1, 1)) for index in range(self.count))


def _range_or_list(value: object) -> str:
    return "range" if isinstance(value, dict | Range) else "list"


AngleSet = Annotated[
    Annotated[Range, Tag("range")] | Annotated[tuple[Angle, ...], BeforeValidator(as_tuple), Tag("list")],
    Discriminator(_range_or_list),
]


def _registered_design(name: str) -> str:
    if name not in DESCRIBED_DESIGNS:
        raise ValueError(f"allowed are {', '.join(DESCRIBED_DESIGNS)}")
    return name


class Design(StrictTable):
    """``[design]``: which attitudes, in which order. A kind that adds keys of its own has a subclass as its table."""

    names_files: ClassVar[tuple[str, ...]] = ("file",)
    kind: Annotated[str, AfterValidator(_registered_design)]
    pitch_deg: AngleSet | None = None
    roll_deg: AngleSet | None = None
    yaw_deg: AngleSet | None = None
    """Of a gimbal; every attitude of the design at every yaw."""
    fractional: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = None
    """Column and row decimation (K_α, K_R) of TP 7; the borders are kept."""
    file: str | None = None
    """CSV with pitch_deg and roll_deg, for ``kind = "file"``; relative to this file."""
    repeat_roll: bool = False
    """Adds +180° where the roll set ends before it."""
    usage_pitch_deg: tuple[Angle, Angle] | None = None
    usage_noise_arcsec: Positive | None = None
    """Standard deviation of one reading where the sensors are used; by default that of one dwell of the calibration."""
    order: Order = "there-and-back"
    seed: Annotated[int, Field(ge=0)] = 0

    @field_validator("fractional", "usage_pitch_deg", mode="before")
    @classmethod
    def _lists_are_tuples(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _what_the_kind_needs(self) -> Self:
        kind = DESCRIBED_DESIGNS[self.kind]
        for key, example in kind.needs.items():
            if getattr(self, key) is None:
                raise ValueError(f'kind = "{self.kind}" needs {key}{example and f" = {example}"}')
        for key in ("file", "fractional"):
            if key not in kind.takes and getattr(self, key) is not None:
                owners = " or ".join(f'"{owner.name}"' for owner in DESCRIBED_DESIGNS.values() if key in owner.takes)
                raise ValueError(f'{key} belongs to kind = {owners}, not to kind = "{self.kind}"')
        return self

    @model_validator(mode="wrap")
    @classmethod
    def _in_the_table_of_its_kind(cls, value: Any, validate: ModelWrapValidatorHandler[Self]) -> Self:
        """Read a kind with keys of its own by the table that has them."""
        name = value.get("kind") if isinstance(value, dict) else None
        table = DESCRIBED_DESIGNS[name].table if isinstance(name, str) and name in DESCRIBED_DESIGNS else None
        if table is None or not issubclass(table, cls) or table is cls:
            return validate(value)
        return table.model_validate(value)


class EnvironmentPlan(StrictTable):
    """``[environment]``: temperature plateaus, each a whole plot."""

    name: str | None = None
    """Which of the rig's environments; by default its only one."""
    plateaus_degc: tuple[float, ...] = Field(min_length=1)
    band_degc: Positive = 1.0
    soak_s: NotNegative = 1800.0
    end_degc: float | None = None
    """Where the chamber goes when the run gives the rig up, however it ends; by default it keeps its setpoint."""

    @field_validator("plateaus_degc", mode="before")
    @classmethod
    def _lists_are_tuples(cls, value: object) -> object:
        return as_tuple(value)


class CheckPlan(StrictTable):
    """``[check]``: returns to the reference attitude, or to several, one after the other."""

    reference_every: Annotated[int, Field(ge=1)]
    pitch_deg: Angles = 0.0
    roll_deg: Angles = 0.0

    @model_validator(mode="after")
    def _as_many_of_each(self) -> Self:
        counts = {len(angles) for angles in (self.pitch_deg, self.roll_deg) if isinstance(angles, tuple)}
        if len(counts) > 1 or 0 in counts:
            raise ValueError(
                "pitch_deg and roll_deg name the reference attitudes together: give one number, or two lists of the "
                "same length"
            )
        return self

    @property
    def attitudes_deg(self) -> tuple[tuple[float, float], ...]:
        """Pitch and roll of every reference attitude, in the order of a visit."""
        given = (self.pitch_deg, self.roll_deg)
        count = max(len(angles) if isinstance(angles, tuple) else 1 for angles in given)
        pitch, roll = (angles if isinstance(angles, tuple) else (angles,) * count for angles in given)
        return tuple(zip(pitch, roll, strict=True))

    @property
    def tells_slip_from_tilt(self) -> bool:
        """Whether two of the attitudes differ in pitch and in roll."""
        return any(
            attitude[0] != other[0] and attitude[1] != other[1]
            for attitude in self.attitudes_deg
            for other in self.attitudes_deg
        )


class StopRule(StrictTable):
    """``[stop]``: when the run ends by itself before its last step."""

    max_duration_s: Positive | None = None
    half_width_deg: Positive | None = None
    """Replications are measured until U95 of every angle at use is at most so much."""
    least_replications: Annotated[int, Field(ge=2, le=1000)] | None = None
    most_replications: Annotated[int, Field(ge=2, le=1000)] | None = None

    @model_validator(mode="after")
    def _a_rule_and_its_bounds(self) -> Self:
        if self.max_duration_s is None and self.half_width_deg is None:
            raise ValueError("give max_duration_s, or half_width_deg with least_replications and most_replications")
        bounds = (self.least_replications, self.most_replications)
        if (self.half_width_deg is None) is not (bounds == (None, None)) or bounds.count(None) == 1:
            raise ValueError("half_width_deg, least_replications and most_replications go together: give all or none")
        if self.least_replications is not None and self.least_replications > (self.most_replications or 0):
            raise ValueError("least_replications must not exceed most_replications")
        return self


class KnownTemperature(StrictTable):
    """Coefficients that are applied, not estimated."""

    offset_tc_v_per_degc: float
    sensitivity_tc_per_degc: float
    offset_tc2_v_per_degc2: float = 0.0
    sensitivity_tc2_per_degc2: float = 0.0
    offset_tc_uncertainty_v_per_degc: Annotated[float, Field(ge=0.0)] = 0.0
    sensitivity_tc_uncertainty_per_degc: Annotated[float, Field(ge=0.0)] = 0.0
    """Standard uncertainties; 0: not declared."""
    reference_temperature_degc: float


def _is_a_model(name: str) -> str:
    if name not in names_by_option():
        raise ValueError(f"allowed are {', '.join(names_by_option())}")
    return name


class Solve(StrictTable):
    """``[solve]``: which model, and what is done about temperature."""

    model: Annotated[str, AfterValidator(_is_a_model)] = "pitch-roll"
    packages: dict[str, Literal["sting", "model"]] = {}
    """For pitch-yaw-roll: sensor to CR's package; one that is not named is a model package."""
    temperature: Literal["none", "apply", "estimate"] = "none"
    temperature_order: Literal[1, 2] = 1
    """2: offset and sensitivity may bend with temperature; for ``temperature = "estimate"``."""
    known_temperature: dict[str, KnownTemperature] = {}
    """``"SENSOR.AXIS"`` to its coefficients, for ``temperature = "apply"``."""
    reference_temperature_degc: float | None = None
    """Where what ``temperature = "estimate"`` solves for is to hold; None: the mean temperature, to 1 °C."""
    extended: Literal["no", "test", "yes"] = "yes"
    expected_noise_arcsec: Positive = 0.5
    """Standard deviation of a dwell, for the uncertainty expected beforehand."""
    joint: bool = False
    """The package and the table in one fit, the table's errors as unknowns under what the rig file declares of them."""
    joint_priors_arcsec: dict[Literal["pitch_zero", "roll_zero", "base_tilt", "squareness", "droop"], Positive] = {}
    """Standard uncertainties of errors of the whole table, for ``joint``."""
    time_term: Literal["none", "linear"] = "none"
    """``linear``: a drift of the offset with time through the run is estimated beside the parameters."""

    def model_of(self, sensor: str, *, rolls: bool = True) -> str:
        """Return what the mathematics calls the model of one sensor: CR's two packages are two models.

        ``rolls``: whether roll carries the sensor, which tells the package where the procedure does not.
        """
        if self.model == "pitch-yaw-roll":
            return f"pitch-yaw-roll-{self.packages.get(sensor, 'model' if rolls else 'sting')}"
        return "linear-accelerometer" if self.model == "linear" else self.model

    @model_validator(mode="after")
    def _packages_are_of_cr(self) -> Self:
        if self.packages and self.model != "pitch-yaw-roll":
            raise ValueError(f'packages belongs to model = "pitch-yaw-roll", not to model = "{self.model}"')
        return self

    @model_validator(mode="after")
    def _apply_needs_coefficients(self) -> Self:
        if self.temperature == "apply" and not self.known_temperature:
            raise ValueError('temperature = "apply" needs known_temperature."SENSOR.AXIS" = { … }')
        return self

    @model_validator(mode="after")
    def _axes_agree_in_the_reference(self) -> Self:
        if self.reference_temperature_degc is not None and self.temperature != "estimate":
            raise ValueError(
                f'reference_temperature_degc belongs to temperature = "estimate", not to "{self.temperature}"; known '
                "coefficients each have their own, in known_temperature"
            )
        references: dict[str, set[float]] = {}
        for name, known in self.known_temperature.items():
            references.setdefault(name.rpartition(".")[0], set()).add(known.reference_temperature_degc)
        for sensor, found in references.items():
            if len(found) > 1:
                raise ValueError(
                    f"known_temperature: the axes of {sensor} have reference_temperature_degc "
                    f"{' and '.join(f'{degc:g}' for degc in sorted(found))}; the coefficients of one sensor hold at "
                    "one temperature: bring those of all its axes to the same"
                )
        return self

    @model_validator(mode="after")
    def _joint_goes_with(self) -> Self:
        if self.joint_priors_arcsec and not self.joint:
            raise ValueError("joint_priors_arcsec belongs to joint = true, which is missing")
        is_plain = self.model == "pitch-roll" and self.temperature == "none" and self.time_term == "none"
        if self.joint and (not is_plain or self.extended == "test"):
            raise ValueError(
                'joint = true goes with model = "pitch-roll", temperature = "none", time_term = "none" and extended = '
                '"yes" or "no" (it has no test that lets terms of second order in)'
            )
        return self

    @model_validator(mode="after")
    def _order_is_of_an_estimate(self) -> Self:
        if self.temperature_order != 1 and self.temperature != "estimate":
            raise ValueError(
                f'temperature_order = {self.temperature_order} belongs to temperature = "estimate"; known coefficients '
                "of second order are given as offset_tc2_v_per_degc2 and sensitivity_tc2_per_degc2"
            )
        return self


def _registered_format(name: str) -> str:
    if name not in FORMATS:
        raise ValueError(f"allowed are {', '.join(FORMATS)}")
    return name


ExportFormat = Annotated[str, AfterValidator(_registered_format)]
"""The name of a format that is registered (:mod:`ams.exports.formats`)."""


class Export(StrictTable):
    """``[export]``: which files are written for the tunnel systems."""

    formats: tuple[ExportFormat, ...] = ("json",)

    @field_validator("formats", mode="before")
    @classmethod
    def _lists_are_tuples(cls, value: object) -> object:
        return as_tuple(value)


class ProcedureDescription(StrictTable):
    """The whole file, but for the tables that the kinds add (:mod:`procedures.kinds.read`)."""

    procedure: Procedure
    design: Design = Design(kind="up-down")
    """Of attitudes; kinds with a table of their own have none."""
    dwell: DwellSettings = DwellSettings()
    environment: EnvironmentPlan | None = None
    check: CheckPlan | None = None
    stop: StopRule | None = None
    solve: Solve = Solve()
    export: Export = Export()
    _file: TomlFile = PrivateAttr()

    def table_of(self, table: type[KindTable]) -> KindTable | None:
        """Return the kind's own table of that form; None where this procedure has none."""
        tables = (getattr(self, name) for name in type(self).model_fields)
        return next((found for found in tables if isinstance(found, table)), None)

    @property
    def replications(self) -> int:
        """How many replications are laid out, of every plateau: the most, where a rule may end them."""
        most = None if self.stop is None else self.stop.most_replications
        return self.procedure.replications if most is None else most

    @property
    def path(self) -> Path:
        """Where it was read from; relative paths in it are relative to its folder."""
        return self._file.path

    def error(self, key: Sequence[object], text: str) -> PlanError:
        """Return a mistake that only the plan can see, named by file, line and key."""
        return PlanError(self._file.complaint(key, text))


def _decimal(value: float) -> Decimal:
    return Decimal(repr(value))
