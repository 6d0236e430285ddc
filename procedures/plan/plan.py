"""The plan: everything a run will do, as one frozen value that can be printed, hashed, stored and read back.

It names devices and holds none. The journal keeps it as JSON with its SHA-256; resuming, reporting and solving read
the plan of the journal and never make it again.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cache

from pydantic import JsonValue, TypeAdapter, ValidationError

from procedures.description.dwell_settings import DwellSettings
from procedures.description.procedure_file import CheckPlan, EnvironmentPlan, KindTable, Order, Solve
from procedures.errors import PlanError
from procedures.plan.designs import Design
from procedures.plan.learned_times import PartTime
from procedures.plan.steps import Dwell, Rest, Soak, Step
from rig.description.rig_file import AttitudeReference, Sensor

PLAN_VERSION = 1


@dataclass(frozen=True)
class Expectation:
    """How long the steps should take."""

    p50_s: float
    p90_s: float
    parts: Mapping[str, PartTime] = field(default_factory=dict)
    """By what is done, all steps together; empty in plans of before."""
    learned_from: int = 0
    """So many past runs of the rig taught it; 0: the files alone."""


@dataclass(frozen=True)
class SequentialStop:
    """The rule of ``[stop] half_width_deg``: after which replication the run has measured enough."""

    half_width_deg: float
    least_replications: int
    usage_pitch_deg: tuple[float, float]
    usage_noise_arcsec: float | None


@dataclass(frozen=True)
class Plan:
    """What :func:`procedures.kinds.planner.make_plan` makes of a rig and a procedure."""

    version: int
    title: str
    kind: str
    """A name of :data:`procedures.kinds.registry.KINDS`."""
    axes: tuple[str, ...]
    """In the order in which they move."""
    sensors: dict[str, Sensor]
    """Serial to what is calibrated."""
    channels: tuple[str, ...]
    """Every channel that a dwell reads, ``readout.channel``, in the order read."""
    settle_channel: str
    """The channel that decides when the package is at rest."""
    design: Design
    """One point a visit: with forward-reverse twice as many as attitudes."""
    order: Order
    seed: int | None
    """Of the shuffled orders."""
    replications: int
    """Replication labels run from 1 to this, over all plateaus."""
    usage_pitch_deg: tuple[float, float] | None
    dwell: DwellSettings
    environment: EnvironmentPlan | None
    """With its name filled in."""
    reference: CheckPlan | None
    solve: Solve
    export_formats: tuple[str, ...]
    max_duration_s: float | None
    expected: Expectation
    steps: tuple[Step, ...]
    attitude_reference: AttitudeReference | None = None
    """Of the rig, where it tells the attitude better than the axes do."""
    kind_settings: Mapping[str, Mapping[str, JsonValue]] = field(default_factory=dict)
    """The kind's own table of the procedure by its name; empty where the kind has none. Read by :meth:`kind_table`."""
    most_samples: int = 0
    """Of one streamed channel in the longest dwell; 0 where ``[dwell]`` says it."""
    sequential: SequentialStop | None = None
    """None: every replication is measured."""
    moving_together: tuple[str, ...] = ()
    """Axes that go to an attitude at the same time; the others one after the other."""
    reading_together: tuple[str, ...] = ()
    """Readouts that read at the same time, each its channels in their order; the others one after the other."""
    counts_earth: bool = False
    """The Earth's rotation is taken off calibrations of gyros, or budgeted; a run stored before keeps its numbers."""

    counts_temperature: bool = False
    """What a recorded temperature that no model has may have done is budgeted; a run stored before is as it was."""

    def kind_table(self, name: str, form: type[KindTable]) -> KindTable | None:
        """Return the kind's own table ``[name]``; None where the plan is of a kind that has another, or none.

        Of runs stored before plans kept every kind's table, only ``levels`` and ``static`` are there.
        """
        values = self.kind_settings.get(name)
        return None if values is None else form.model_validate_json(json.dumps(values))

    @property
    def is_at_rest(self) -> bool:
        """Accelerometers at attitudes: what a package reads follows from where the axes stand."""
        return all(dwell.motion is None for dwell in self.dwells)

    @property
    def dwells(self) -> tuple[Dwell, ...]:
        """Every dwell: check set, design and references."""
        return tuple(step for step in self.steps if isinstance(step, Dwell))

    @property
    def design_dwells(self) -> tuple[Dwell, ...]:
        """The dwells that enter the solution."""
        return tuple(dwell for dwell in self.dwells if dwell.purpose == "design")

    @property
    def is_single_rest(self) -> bool:
        """One attitude, recorded at rest for long: beside its dwells is none of another point."""
        dwells = self.design_dwells
        return len({dwell.point for dwell in dwells}) == 1 and all(isinstance(dwell.motion, Rest) for dwell in dwells)

    @property
    def check_set(self) -> tuple[Dwell, ...]:
        """The check attitudes, measured at the start and again after every restart."""
        return tuple(dwell for dwell in self.dwells if dwell.purpose == "check")

    @property
    def soaks(self) -> tuple[Soak, ...]:
        return tuple(step for step in self.steps if isinstance(step, Soak))

    @property
    def sha256(self) -> str:
        """Of :meth:`to_json`, hexadecimal."""
        return hashlib.sha256(self.to_json().encode("utf-8")).hexdigest()

    def to_json(self) -> str:
        """Return the plan as one line of JSON: the same plan is the same text everywhere.

        Key order is kept: axes move in it.
        """
        document = _adapter().dump_python(self, mode="json")
        return json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))

    @staticmethod
    def from_json(text: str, source: str = "plan") -> "Plan":
        """Read a plan back. Raises: PlanError when it is of another version or is no plan."""
        try:
            plan = _adapter().validate_json(text, strict=True)
        except ValidationError as error:
            _require_version(text, source)
            first = error.errors(include_url=False)[0]
            where = ".".join(str(part) for part in first["loc"])
            raise PlanError(f"{source}: {where}: {first['msg']}; this is not a plan that calrig wrote") from None
        if plan.version != PLAN_VERSION:
            raise _other_version(plan.version, source)
        return plan if plan.kind_settings else replace(plan, kind_settings=_tables_before(text))


def _require_version(text: str, source: str) -> None:
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise PlanError(f"{source}: not JSON: {error}; the plan was not read") from None
    found = document.get("version") if isinstance(document, dict) else None
    if found != PLAN_VERSION:
        raise _other_version(found, source)


def _other_version(found: object, source: str) -> PlanError:
    return PlanError(f"{source}: plan version: got {found!r}, allowed {PLAN_VERSION}; use the calrig that wrote it")


@dataclass(frozen=True)
class _TablesBefore:
    """The tables that a plan held under names of their own before it had ``kind_settings``."""

    levels: dict[str, JsonValue] | None = None
    static: dict[str, JsonValue] | None = None


def _tables_before(text: str) -> dict[str, dict[str, JsonValue]]:
    """Return what a stored plan holds in place of ``kind_settings``; nothing of one whose kind has no table."""
    found = asdict(_adapter_before().validate_json(text))
    return {name: values for name, values in found.items() if values is not None}


@cache
def _adapter_before() -> TypeAdapter[_TablesBefore]:
    return TypeAdapter(_TablesBefore)


@cache
def _adapter() -> TypeAdapter[Plan]:
    """Reader and writer of the plan's JSON. Building it takes longer than reading a plan, so it is built once."""
    return TypeAdapter(Plan)
