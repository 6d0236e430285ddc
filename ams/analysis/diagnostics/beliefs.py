"""The tests by name, and what each says of one sensor axis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Final, NamedTuple

from ams.analysis.diagnostics.locations import Location
from ams.analysis.diagnostics.low_order import OF_GYROS, PPM, TERMS
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.finding_kinds import FindingKind
from ams.frames import AXES


def _dwells(count: float) -> str:
    return f"{count:g} dwell{'' if count == 1.0 else 's'}"


LEVEL: Final = 0.05
"""Of all tests of a run: where nothing is wrong some test rings in 4.2 to 6 % of the runs, with one axis, three or nine
(756 to 9 000 simulated)."""
WRONG_DWELL: Final = "wrong dwell"
LACK_OF_FIT: Final = "lack of fit"
DRIFT_OF: Final = "drift of "
OVER_TIME: Final = "drift with time"
AUTOCORRELATION: Final = "autocorrelation"
ROBUST: Final = "robust fit"
BY_THE_DWELL_BEFORE: Final = "what a dwell knows of the one before it"
BY_ANOTHER_MEMORY: Final = "a memory of another length"
BY_A_DRIFT: Final = "a drift"
BY_TEMPERATURE: Final = "temperature"
BY_THE_ENDS: Final = "what every dwell at an end of its range reads alike"
BY_TERMS: Final = "terms of second and third order"
"""What explains a test that rings by itself."""
UNTOLD: Final = 0.01
"""Chance of one test, of many, from which on nothing is told of it: what is more to look at is not looked at."""
UNEVEN: Final = "noise of the replications"
TURNED_FROM: Final = "previous attitude"
TURNED_FROM_ALIKE: Final = "previous attitude, alike in every replication"
MEMORY_DWELLS: Final = (1.0, 3.0, 10.0)
"""Time constants of a memory that are tried, in dwells."""
MEMORIES: Final = tuple(f"memory of about {_dwells(dwells)}" for dwells in MEMORY_DWELLS)
HELD_ACROSS: Final = tuple(f"force along {axis} at the dwell before" for axis in AXES)
"""Across the nominal axis: what a channel keeps of the one that was read before it."""
BY_POINT: Final = "temperature, point by point"
BY_POINT_GAIN: Final = "temperature, point by point, on the sensitivity"
BY_REPLICATION: Final = "temperature, replication by replication"
LAG: Final = "temperature lag"
CURVATURE: Final = "temperature curvature"
TERMS_OVER_TEMPERATURE: Final = "terms of low order over temperature"
AXIS_OVER_TEMPERATURE: Final = "sensitive axis over temperature"
TABLE_LIMIT: Final = "table's declared limit"
BACKLASH: Final[Mapping[str, str]] = {axis: f"backlash of the table about {axis}" for axis in ("pitch", "roll", "yaw")}
"""Axis of the table to the test of its play."""
ATTITUDE_TURN: Final = "turn of the package with its attitude"
IN_STEP: Final = "disturbance in step with the replications"
SQUARENESS: Final = "squareness of the table's axes"
AT_A_LOCATION: Final = "one index or attitude"
SLIP: Final = "slip of the table in mid-run"
STEP: Final = "step of the output in mid-run"
SETTLING: Final = "settling at the start of every replication"
AFTER_MOVES: Final = "settling after every move of the slower axis"


@dataclass(frozen=True)
class Column:
    """What the means of the points are tested for, one column each."""

    name: str
    kind: FindingKind
    unit: str
    is_held: bool = True
    """As of a test."""


COLUMNS: Final = (
    *(Column(name, kind, unit) for name, kind, _, unit in TERMS),
    Column(SQUARENESS, "lack-of-fit", "rad"),
    Column(TURNED_FROM_ALIKE, "autocorrelation", ""),
    *(Column(name, "autocorrelation", "V/g", is_held=False) for name in MEMORIES),
    Column(SETTLING, "drift", "", is_held=False),
    *(Column(name, "autocorrelation", "V/g", is_held=False) for name in HELD_ACROSS),
    Column(AFTER_MOVES, "drift", "", is_held=False),
    Column(BY_POINT, "temperature-residual", "per °C", is_held=False),
    Column(BY_POINT_GAIN, "temperature-residual", "per °C", is_held=False),
)
RECORDED: Final = (BY_POINT, BY_POINT_GAIN)
"""Of the recorded temperature, alike in every replication."""
TESTS: Final = (
    *(
        WRONG_DWELL,
        LACK_OF_FIT,
        AT_A_LOCATION,
        OVER_TIME,
        AUTOCORRELATION,
        ROBUST,
        UNEVEN,
        TURNED_FROM,
        TABLE_LIMIT,
        BY_REPLICATION,
    ),
    *(LAG, CURVATURE, TERMS_OVER_TEMPERATURE, AXIS_OVER_TEMPERATURE, ATTITUDE_TURN, IN_STEP, SLIP, STEP),
    *BACKLASH.values(),
    *(column.name for column in COLUMNS),
)
"""Every test of an axis by name, but for those of a drift of each quantity. What is not here has no words."""
OF_THE_ORDER: Final = (*HELD_ACROSS, AFTER_MOVES)
"""What an order that is always the same leaves at the points, beside a memory along the axis and the settling."""
LIKE_A_MEMORY: Final = frozenset({AUTOCORRELATION, TURNED_FROM, *(column.name for column in COLUMNS)})
"""Tests that ring for a memory of the attitudes before, or that one rings for."""
COLUMNS_OF_GYROS: Final = tuple(replace(column, unit=PPM) if column.name in OF_GYROS else column for column in COLUMNS)


@dataclass(frozen=True)
class TermChange:
    """How one term of low order changes with temperature."""

    name: str
    unit: str
    """Of the term's coefficient."""
    per_degc: float
    standard_uncertainty: float


class BeliefTest(NamedTuple):
    """One belief, tested."""

    name: str
    kind: FindingKind
    p_value: float
    """NaN where the data do not allow the test."""
    size: float = float("nan")
    """In the output's unit, or as ``unit`` says."""
    uncertainty: float = float("nan")
    unit: str = ""
    dof: float = float("inf")
    """Degrees of freedom of the uncertainty, where others are to be joined to it."""
    explained_by: str = ""
    """What another finding tells that explains it, in words; empty where nothing does."""
    is_held: bool = True
    """False where no scatter between replications holds what it finds: it is alike in every replication, passes for a
    sensitivity, or reads to one side."""
    fit_as_well: tuple[str, ...] = ()
    """Names of tests that nothing tells from this one."""
    changes: tuple[TermChange, ...] = ()
    """Of the terms that change with temperature, the plainest first."""
    in_package: str = ""
    """How large it is of each axis of the package, in words, where their tests are joined; empty: by itself."""
    replications: tuple[str, ...] = ()
    """Labels of those that it is about."""
    axes: int = 1
    """How many axes of a family have this same test: it can ring falsely once only, so it has the share of all of them.
    """

    @property
    def numbers(self) -> dict[str, float | str | None]:
        """Size, uncertainty and unit as the details of a finding; nothing where there is no size."""
        if not isfinite(self.size):
            return {}
        found: dict[str, float | str | None] = {"size": self.size}
        if isfinite(self.uncertainty):
            found["time_constant_h" if self.name == LAG else "standard_uncertainty"] = self.uncertainty
        if self.unit:
            found["unit"] = self.unit
        return found


@dataclass(frozen=True)
class AxisTests:
    """Of one sensor axis."""

    tests: Mapping[str, BeliefTest]
    """By name, those that could be made."""
    is_significant: Mapping[str, bool] = field(default_factory=dict)
    grid: GridResiduals | None = None
    """What every dwell says beside the others and beside what is known; None where nothing was tested."""
    dwells: GridResiduals | None = None
    """What single dwells are judged by."""
    memories: Sequence[BeliefTest] = ()
    """Of each time constant, beside no other memory."""
    locations: Sequence[Location] = ()
    """At which alone what repeats is off, the plainest first."""
    level: float = LEVEL
    """Of all tests of this axis together."""

    @property
    def is_remembering(self) -> bool:
        """Whether the output remembers attitudes before."""
        return any(self.is_significant.get(name) for name in MEMORIES)

    @property
    def is_of_order(self) -> bool:
        """Whether the order of the points leaves something else that is alike in every replication."""
        return any(self.is_significant.get(name) for name in OF_THE_ORDER)

    @property
    def conviction_level(self) -> float:
        """The level at which the first of several tests is significant whatever the others say."""
        return self.level / max(len(self.tests), 1)
