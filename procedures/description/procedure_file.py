"""``procedure.toml`` as one frozen value: what is to be done, on any rig that can do it.

Checked here, table by table, before the rig is looked at; what only both files together can tell is the planner's.
"""

from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Discriminator, Field, PrivateAttr, Tag, field_validator, model_validator

from procedures.description.motion import Levels, Profile, Rates, Static
from procedures.errors import PlanError
from rig.description.device_settings import NotNegative, Positive
from rig.errors import DescriptionError
from rig.toml_file import StrictTable, TomlFile, as_tuple, read_toml

Order = Literal["there-and-back", "forward-reverse", "serpentine", "raster", "blocks", "random", "seeded"]
Angle = Annotated[float, Field(ge=-360.0, le=360.0)]
MAX_POINTS_PER_AXIS = 3601


class Procedure(StrictTable):
    """``[procedure]``: the title and what kind of work it is."""

    title: Annotated[str, Field(min_length=1, max_length=200)]
    kind: Literal["grid", "tumble", "rates", "profile", "two-level", "static"]
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
            raise ValueError(f"from {self.start} to {self.stop} is not a whole number of steps of {self.step}")
        if self.count == 1 and self.start != self.stop:
            raise ValueError("one point cannot stand at both ends; give count = 2 or more")
        if len(self.values()) > MAX_POINTS_PER_AXIS:
            raise ValueError(f"{len(self.values())} points, at most {MAX_POINTS_PER_AXIS} are allowed")
        return self

    def values(self) -> tuple[float, ...]:
        """The points in degrees, exact in decimals: −90 to 90 by 0.1 holds 0.3 and not 0.30000000000000004."""
        first, span = _decimal(self.start), _decimal(self.stop) - _decimal(self.start)
        if self.step is not None:
            return tuple(
                float(first + _decimal(self.step) * place) for place in range(int(span / _decimal(self.step)) + 1)
            )
        assert self.count is not None
        return tuple(float(first + span * place / max(self.count - 1, 1)) for place in range(self.count))


def _range_or_list(value: object) -> str:
    return "range" if isinstance(value, dict | Range) else "list"


AngleSet = Annotated[
    Annotated[Range, Tag("range")] | Annotated[tuple[Angle, ...], BeforeValidator(as_tuple), Tag("list")],
    Discriminator(_range_or_list),
]


class Design(StrictTable):
    """``[design]``: which attitudes, in which order."""

    kind: Literal["D", "D0", "D1", "T", "up-down", "fractional", "optimal", "file"]
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
    order: Order = "there-and-back"
    seed: Annotated[int, Field(ge=0)] = 0

    @field_validator("fractional", "usage_pitch_deg", mode="before")
    @classmethod
    def _lists_are_tuples(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _what_the_kind_needs(self) -> Self:
        if self.kind == "file" and self.file is None:
            raise ValueError('kind = "file" needs file = "points.csv"')
        if self.kind == "fractional" and self.fractional is None:
            raise ValueError('kind = "fractional" needs fractional = [K_pitch, K_roll]')
        for key, owner in (("file", "file"), ("fractional", "fractional")):
            if self.kind != owner and getattr(self, key) is not None:
                raise ValueError(f'{key} belongs to kind = "{owner}", not to kind = "{self.kind}"')
        if self.kind not in ("file", "T", "up-down") and self.pitch_deg is None:
            raise ValueError(f'kind = "{self.kind}" needs pitch_deg')
        return self


class Settle(StrictTable):
    """Window statistics on one channel decide when the package is at rest."""

    window_s: Positive = 1.5
    windows: Annotated[int, Field(ge=2, le=20)] = 2
    min_s: NotNegative = 2.0
    max_s: Positive = 60.0

    @model_validator(mode="after")
    def _time_enough(self) -> Self:
        if self.max_s < max(self.min_s, self.window_s * self.windows):
            raise ValueError(
                f"max_s = {self.max_s} is shorter than min_s or than {self.windows} windows of {self.window_s} s"
            )
        return self


class DwellSettings(StrictTable):
    """``[dwell]``: how one dwell is taken and judged."""

    settle: Settle = Settle()
    settle_nplc: Annotated[float, Field(gt=0.0, le=100.0)] = 1.0
    samples: Annotated[int, Field(ge=2, le=100_000)] = 20
    max_noise_factor: Annotated[float, Field(gt=1.0)] = 3.0
    retries: Annotated[int, Field(ge=0, le=20)] = 2


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
    """``[check]``: returns to a reference attitude."""

    reference_every: Annotated[int, Field(ge=1)]
    pitch_deg: Angle = 0.0
    roll_deg: Angle = 0.0


class StopRule(StrictTable):
    """``[stop]``: when the run ends by itself before its last step."""

    max_duration_s: Positive


class KnownTemperature(StrictTable):
    """Coefficients that are applied, not estimated."""

    offset_tc_v_per_degc: float
    sensitivity_tc_per_degc: float
    reference_temperature_degc: float


class Solve(StrictTable):
    """``[solve]``: which model, and what is done about temperature."""

    model: Literal["pitch-roll", "pitch-only", "pitch-yaw-roll", "linear", "gyro"] = "pitch-roll"
    packages: dict[str, Literal["sting", "model"]] = {}
    """For pitch-yaw-roll: sensor to CR's package; one that is not named is a model package."""
    temperature: Literal["none", "apply", "estimate"] = "none"
    known_temperature: dict[str, KnownTemperature] = {}
    """``"SENSOR.AXIS"`` to its coefficients, for ``temperature = "apply"``."""
    extended: Literal["no", "test", "yes"] = "yes"
    expected_noise_arcsec: Positive = 0.5
    """Standard deviation of a dwell, for the uncertainty expected beforehand."""
    time_term: Literal["none", "linear"] = "none"
    """``linear``: a drift of the offset with time through the run is estimated beside the parameters."""

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


ExportFormat = Literal["json", "csv", "mat", "hdf5", "parquet", "c", "c-fixed", "epics", "dcc", "linear"]


class Export(StrictTable):
    """``[export]``: which files are written for the tunnel systems."""

    formats: tuple[ExportFormat, ...] = ("json",)

    @field_validator("formats", mode="before")
    @classmethod
    def _lists_are_tuples(cls, value: object) -> object:
        return as_tuple(value)


class ProcedureDescription(StrictTable):
    """The whole file."""

    procedure: Procedure
    design: Design = Design(kind="up-down")
    """Of attitudes; only grids and tumbles have one of their own."""
    rates: Rates | None = None
    profile: Profile | None = None
    levels: Levels | None = None
    static: Static | None = None
    dwell: DwellSettings = DwellSettings()
    environment: EnvironmentPlan | None = None
    check: CheckPlan | None = None
    stop: StopRule | None = None
    solve: Solve = Solve()
    export: Export = Export()
    _file: TomlFile = PrivateAttr()

    @property
    def moves(self) -> bool:
        """Whether it is of a kind with motion, applied fields or long rests."""
        return self.procedure.kind not in ("grid", "tumble")

    @property
    def path(self) -> Path:
        """Where it was read from; relative paths in it are relative to its folder."""
        return self._file.path

    def error(self, key: Sequence[object], text: str) -> PlanError:
        """A mistake that only the plan can see, named by file, line and key."""
        return PlanError(self._file.complaint(key, text))


def read_procedure(path: Path) -> ProcedureDescription:
    """Read and check a procedure file. Raises: rig.errors.DescriptionError naming every mistake."""
    file = read_toml(path)
    description = file.validate(ProcedureDescription)
    complaints = [file.complaint(key, text) for key, text in disagreements(description)]
    if complaints:
        raise DescriptionError("\n".join(complaints))
    description._file = file
    return description


def disagreements(description: ProcedureDescription) -> Iterator[tuple[tuple[str, ...], str]]:
    """Tables that do not go together: key and what is wrong."""
    kind = description.procedure.kind
    is_tumble = description.design.kind in ("T", "up-down")
    if kind == "tumble" and not is_tumble:
        yield ("design", "kind"), 'kind = "tumble" goes with a design of kind "T", and only with it (or "up-down")'
    if kind == "grid" and is_tumble:
        yield ("design", "kind"), 'kind = "tumble" goes with a design of kind "T", and only with it (or "up-down")'
    own = {"rates": "rates", "profile": "profile", "two-level": "levels", "static": "static"}
    for owner, table in own.items():
        if (getattr(description, table) is not None) != (kind == owner):
            told = "is missing" if kind == owner else f"belongs to procedure.kind = {owner!r}"
            yield (table,), f"{told}; this is a procedure of kind {kind!r}"
    if kind in own and "design" in description.model_fields_set:
        yield ("design",), f"has no meaning for a procedure of kind {kind!r}, which has its own attitudes; remove it"
    models = {"rates": ("gyro", "linear"), "two-level": ("linear",), "static": ("linear",)}
    if kind == "profile" and description.solve.model not in ("gyro", "pitch-yaw-roll", "pitch-roll"):
        yield ("solve", "model"), 'a profile is solved with "gyro", "pitch-yaw-roll" or "pitch-roll"'
    if kind in models and description.solve.model not in models[kind]:
        allowed = " or ".join(f'"{model}"' for model in models[kind])
        yield ("solve", "model"), f"got {description.solve.model!r}, allowed for kind {kind!r}: {allowed}"
    if kind in ("grid", "tumble") and description.solve.model == "gyro":
        yield ("solve", "model"), 'the model "gyro" needs rates: procedure.kind = "rates" or "profile"'


def _decimal(value: float) -> Decimal:
    return Decimal(repr(value))
