"""Play of an axis of the table that all outputs of a package show: what it does to each of them, and its finding."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import BACKLASH, AxisTests, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.settling import Estimate
from ams.analysis.diagnostics.sensed_force import along_force, is_rolled, turned_by
from ams.analysis.diagnostics.size_words import within
from ams.analysis.diagnostics.step_patterns import What
from ams.analysis.diagnostics.steps.approach import axes_with_play, turned_by_play
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import FloatArray
from ams.findings import Finding
from ams.inputs.table_uncertainty import TableUncertainty
from ams.rounding import significant
from ams.statistics.intervals import t_quantile
from ams.units import in_arcsec

_SEES: Final = 10.0
"""Times the uncertainty of all: an output that tells a play less well than that hardly sees it."""
_HYSTERESIS: Final = "the sensor has a hysteresis of its own"
_UNHELD: Final = "offset and sensitivities hold part of it that the stated uncertainties do not"


@dataclass(frozen=True)
class Play:
    """Of one axis of the table."""

    axis: What
    size_rad: float
    """From one side to the other; positive where the axis goes on beyond what it shows."""
    standard_uncertainty_rad: float
    dof: float
    p_value: float
    of_outputs: tuple[tuple[str, Estimate], ...]
    """Nominal axis of each output to the play that it shows by itself, radians."""
    ways_before: tuple[float, ...] = ()
    """What stands for the sense of the last move of each axis where it is not known; empty: it counts as neither."""

    @property
    def is_of_lone_output(self) -> bool:
        """Whether no other output shows or denies it."""
        return len(self.of_outputs) == 1

    @property
    def square(self) -> float:
        """What it explains, over the variance of readings."""
        return (self.size_rad / self.standard_uncertainty_rad) ** 2


def test_of(play: Play, table: TableUncertainty | None) -> BeliefTest:
    """Return the test of a play as one of every output that shows it."""
    return BeliefTest(
        BACKLASH[play.axis],
        "table-rotation",
        play.p_value,
        play.size_rad,
        play.standard_uncertainty_rad,
        "rad",
        play.dof,
        is_held=_is_within(play, table),
        axes=len(play.of_outputs),
    )


def taken_by(plays: Iterable[Play], evidence: Evidence, output: int) -> FloatArray:
    """Return (N,) what the play of axes does to an output, in its unit."""
    rows, taken = evidence.rows, np.zeros(evidence.layout.rows)
    base = accelerometer_base(evidence.models[output])
    assert base is not None, "no other sensor shows play"
    angles, k = turned_by(base, rows), along_force(base, evidence.primary[output])
    axes = axes_with_play(angles[2], is_rolled=is_rolled(base))
    for play in plays:
        by_row = turned_by_play(axes, *angles, evidence.time_order, rows.step, frozenset(), play.ways_before)
        at = 3 * axes.index(play.axis)
        taken += play.size_rad * (by_row[:, at : at + 3] @ k)
    return taken


def backlash_findings(plays: Iterable[Play], tests: AxisTests, table: TableUncertainty | None) -> Iterator[Finding]:
    """Yield what is said of each play that the tests of an output were decided with."""
    for play in plays:
        if tests.is_significant.get(BACKLASH[play.axis]):
            yield backlash_finding(play, table)


def backlash_finding(play: Play, table: TableUncertainty | None) -> Finding:
    """Return what is said of a play: which axis of the table, by how much, and whether its declared limit holds it."""
    test, limit = test_of(play, table), _limit_rad(play, table)
    least = _SEES * play.standard_uncertainty_rad
    seeing = [(name, estimate) for name, estimate in play.of_outputs if estimate.uncertainty <= least]
    each = ", ".join(f"{name} {_sized(estimate.size, estimate.uncertainty, estimate.dof)}" for name, estimate in seeing)
    size = _sized(abs(play.size_rad), play.standard_uncertainty_rad, play.dof)
    where = "beyond" if play.size_rad > 0.0 else "short of"
    comes = (
        f"the table comes to rest {size} apart about {play.axis} by the direction that it came from, half of that "
        f"{where} what the axis shows"
    )
    held = _held_words(limit, is_held=test.is_held)
    if play.is_of_lone_output:
        fact = f"either {comes} (backlash), or {_HYSTERESIS}: one output alone does not tell the two apart; {held}"
    else:
        fact = f"{comes}: backlash; the outputs turn together by it, and no sensor does that ({each}); {held}"
    approach = f"let the axis come from one side always (approach_deg of axes.{play.axis} in the rig file)"
    way_out = (
        f"{approach} where less is asked for"
        if test.is_held
        else f"{approach} and measure again, or have the play taken out of its drive, or declare a limit of its index "
        "errors that holds half of it"
    )
    details: dict[str, float | str | None] = {
        "test": test.name,
        "axis_of_table": play.axis,
        "backlash_arcsec": in_arcsec(abs(play.size_rad)),
        "standard_uncertainty_arcsec": in_arcsec(play.standard_uncertainty_rad),
        **({"confounded_with": "sensor-change"} if play.is_of_lone_output else {}),
        **({} if limit is None else {f"{play.axis}_limit_arcsec": in_arcsec(limit)}),
    }
    return Finding(test.kind, fact, True, play.p_value, (), details, is_held=test.is_held, what_to_do=way_out)


def _held_words(limit_rad: float | None, *, is_held: bool) -> str:
    if limit_rad is None:
        return _UNHELD
    declared = f"the ±{significant(in_arcsec(limit_rad))}″ that are declared of its index errors"
    return (
        f"half of it is within {declared}, and in the stated uncertainties"
        if is_held
        else f"half of it is beyond {declared}, and {_UNHELD}"
    )


def _is_within(play: Play, table: TableUncertainty | None) -> bool:
    """Return whether the declared limit of the index errors holds what the axis stands off by on either side."""
    limit = _limit_rad(play, table)
    return limit is not None and 0.5 * abs(play.size_rad) <= limit


def _limit_rad(play: Play, table: TableUncertainty | None) -> float | None:
    """Return the declared limit of an axis; None where none is, or where errors at angles are, which are smaller."""
    if table is None or table.declared(play.axis).known is not None:
        return None
    return table.limit_rad(play.axis)


def _sized(size_rad: float, uncertainty_rad: float, dof: float) -> str:
    return f"{within(in_arcsec(size_rad), float(t_quantile(0.95, dof)) * in_arcsec(uncertainty_rad))}″"
