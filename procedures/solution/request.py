"""What is asked of the solver: from plan and rig to requests, and the solved sensor as a value."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from ams.analysis.calibration_budget import AxisBudget, axis_budget
from ams.calibration.jointly import with_level
from ams.calibration_result import Calibration
from ams.inputs.declared_direction import NOTHING_DECLARED, DeclaredDirection
from ams.inputs.known_of_run import NOTHING_KNOWN, KnownOfRun
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import OF_THE_BASE, SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.thermal import TemperatureCoefficients
from ams.observations import Observations
from ams.solve.table_errors import TablePriors
from ams.statistics.noise_terms import NoiseTerm
from ams.surveillance.reference_attitude import LEVEL, TABLE, ReferenceAttitude, ReferenceInWords, parts_of
from ams.units import RAD_PER_ARCSEC
from procedures.description.procedure_file import Solve
from procedures.plan.channels import environment_of
from procedures.plan.plan import Plan
from procedures.records.declared_gaps import level_remarks
from procedures.records.declared_supply import at_declared, correcting
from procedures.records.dwells import DwellRecord
from procedures.solution.declared_directions import declared_directions
from procedures.solution.temperature_of_use import calibrated_degc
from procedures.solution.type_b import (
    gravity_of,
    shared_errors,
    table_in_words,
    table_uncertainty,
)
from rig.description.rig_file import RigDescription, Sensor


@dataclass(frozen=True)
class SolvedSensor:
    """One package of a run: its rows, and its calibration or why there is none."""

    name: str
    observations: Observations
    calibration: Calibration | None
    failure: str | None
    budgets: Mapping[str, AxisBudget] = field(default_factory=dict)
    """Axis to its uncertainty budget."""
    static: "Mapping[str, StaticAxis]" = field(default_factory=dict)
    """Axis to what a long rest showed; there is no calibration then."""
    reference: ReferenceAttitude | None = None
    """What the attitudes of its rows are wrong by; None where they are no attitudes of a rig."""
    traceback: str = ""
    """Of the defect that kept it from being solved; empty where none did."""

    @property
    def why_not_usable(self) -> str | None:
        """Why there is no result to use: it was not solved, or an axis is unusable; None where there is one."""
        if self.failure is not None or self.calibration is None:
            return self.failure
        found = [f"axis {label}: {text}" for label, text in self.calibration.unusable_axes.items()]
        return "; ".join(found) or None


@dataclass(frozen=True)
class SensorRows:
    """One sensor of a run and its accepted dwells of the design, in the order of the plan."""

    name: str
    sensor: Sensor
    dwells: tuple[DwellRecord, ...]
    rig: RigDescription
    plan: Plan
    source: str
    """Where the dwells come from, for messages."""
    known_of_run: KnownOfRun = NOTHING_KNOWN
    """What all sensors of the run have shown of the table."""
    run: str = ""
    """Name of the run, as commands take it; empty where nobody said it."""

    @property
    def channels(self) -> dict[str, str]:
        """Axis of the sensor to its channel."""
        return {str(axis): channel for axis, channel in self.sensor.channels.items()}

    @property
    def tested_axes(self) -> int:
        """How many axes the sensors of the run have together: the tests of all of them are one family."""
        return sum(len(sensor.channels) for sensor in self.plan.sensors.values())

    def at_declared(self) -> list[DwellRecord]:
        """Return the dwells with samples at the declared supply and load resistor."""
        return [at_declared(row, correcting(self.rig.chain)) for row in self.dwells]


@dataclass(frozen=True)
class StaticAxis:
    """What one axis showed during a long rest, in the unit of its reading."""

    unit: str
    mean: float
    mean_uncertainty: float | None
    """Standard, from the Allan deviation at the longest averaging time: the mean wanders."""
    tau_s: tuple[float, ...]
    allan_deviation: tuple[float, ...]
    random_walk_per_sqrt_s: float
    bias_instability: float
    is_bottom_reached: bool
    use_s: float
    allowed_deg: float
    drift_deg: float | None
    """Expanded (k = 2) error of the angle at the end of the use, zeroed over as long before; None without a scale."""
    verdict: str
    noise_terms: tuple[NoiseTerm, ...] = ()
    """The five terms of the Allan variance; none where the rest was too short for them."""
    part: str = ""
    """The part that the sensor is said to be, with the table that has it."""
    beside_table: tuple[str, ...] = ()
    """What that table states, what the axis showed, and how they lie; none where it states nothing of it."""

    @property
    def holds(self) -> bool | None:
        return None if self.drift_deg is None else self.drift_deg <= self.allowed_deg


def request_for(
    sensor_name: str,
    channels: Iterable[str],
    solve: Solve,
    table: TableUncertainty | None,
    shared: Mapping[str, tuple[SharedError, ...]] = MappingProxyType({}),
    *,
    rolls: bool = True,
    declared: Mapping[str, DeclaredDirection] = NOTHING_DECLARED,
) -> CalibrationRequest:
    """Return what a procedure's ``[solve]`` asks of one sensor, under the certificates of its rig."""
    axes = tuple(channels)
    known = {
        axis: solve.known_temperature[key]
        for axis in axes
        if (key := f"{sensor_name}.{axis}") in solve.known_temperature
    }
    reference_degc = next(
        (item.reference_temperature_degc for item in known.values()), solve.reference_temperature_degc
    )
    return CalibrationRequest(
        model=solve.model_of(sensor_name, rolls=rolls),
        nominal_axes={axis: axis for axis in axes},
        declared=declared,
        temperature=solve.temperature,
        temperature_order=solve.temperature_order if solve.temperature == "estimate" else 1,
        known_temperature={
            axis: TemperatureCoefficients(
                item.offset_tc_v_per_degc,
                item.sensitivity_tc_per_degc,
                item.offset_tc_uncertainty_v_per_degc,
                item.sensitivity_tc_uncertainty_per_degc,
                offset_tc2_v_per_degc2=item.offset_tc2_v_per_degc2,
                sensitivity_tc2_per_degc2=item.sensitivity_tc2_per_degc2,
            )
            for axis, item in known.items()
        },
        reference_temperature_degc=reference_degc,
        extended=solve.extended,
        time_term=solve.time_term == "linear",
        table=table,
        shared_errors=shared,
    )


def joint_priors(rig: RigDescription, solve: Solve) -> TablePriors:
    """Return what rig file and procedure state of the table, as the joint fit takes it."""
    given = {f"{name}_rad": value * RAD_PER_ARCSEC for name, value in solve.joint_priors_arcsec.items()}
    return TablePriors(table=table_uncertainty(rig), **given)


def reference_of(rig: RigDescription, solve: Solve, shared: Mapping[str, tuple[SharedError, ...]]) -> ReferenceAttitude:
    """Return what the attitudes of a run are wrong by, as its rig declares it, with the words for it.

    ``shared``: sensor axis to the errors that its calibration was solved with.
    """
    stated = joint_priors(rig, solve) if solve.joint else TablePriors(table=table_uncertainty(rig))
    priors = with_level(stated, shared)
    of_level = dict.fromkeys(
        f"{error.name} ({error.stated.removeprefix('level: ')})"
        for errors in shared.values()
        for error in errors
        if error.effect in OF_THE_BASE
    )
    of_table = "" if priors.table is None else f"table: {table_in_words(rig)}"
    of_whole = joint_priors_in_words(solve.joint_priors_arcsec.items()) if solve.joint else ""
    unlevelled = bool(level_remarks(rig)) and priors.pitch_zero_rad == priors.base_tilt_rad == 0.0
    in_words = ReferenceInWords(
        "; ".join(words for words in (of_table, *of_level, of_whole) if words),
        " and ".join([*_undeclared_indices(rig, priors), *([LEVEL] if unlevelled else [])]),
    )
    return ReferenceAttitude(priors, in_words, parts_of(shared))


def _undeclared_indices(rig: RigDescription, priors: TablePriors) -> list[str]:
    """Return what of the index errors nobody declared."""
    if priors.table is None:
        return [TABLE]
    standard_rad = priors.table.standard_rad()
    return [f"the index errors of {name}" for name in ("pitch", "roll") if name in rig.axes and not standard_rad[name]]


def joint_priors_in_words(priors_arcsec: Iterable[tuple[str, float]]) -> str:
    """Name the whole-table errors, with their u, that procedure or command declares; empty where it declares none."""
    return ", ".join(f"{re.sub('[-_]', ' ', name)} u {u:g}″" for name, u in priors_arcsec)


def budgets_of(
    calibration: Calibration,
    request: CalibrationRequest,
    rig: RigDescription | None,
    trials: int = 0,
    priors_in_words: str = "",
) -> dict[str, AxisBudget]:
    """Return axis to its budget under what was asked for; ``trials`` of a Monte Carlo check, 0: none.

    ``priors_in_words``: what else was declared of the table.
    """
    gravity = None if rig is None else gravity_of(rig)
    of_table = [] if rig is None else [words for words in (table_in_words(rig), priors_in_words) if words]
    stated = {} if rig is None else {"table": "; ".join(of_table)}
    return {
        label: axis_budget(axis, request.shared_errors.get(label, ()), gravity, stated=stated, trials=trials)
        for label, axis in calibration.axes.items()
    }


def request_of(
    name: str, rig: RigDescription, sensor: Sensor, solve: Solve, observations: Observations
) -> CalibrationRequest:
    """Return what is asked of one sensor of a run."""
    errors = shared_errors(
        rig,
        sensor,
        environment_of(rig, sensor),
        calibrated_degc(solve.temperature, observations.temperature_degc),
        counts_earth=observations.from_level is not None,
    )
    declared = declared_directions(sensor, observations.units)
    return request_for(
        name, sensor.channels, solve, table_uncertainty(rig), errors, rolls=sensor.rolls, declared=declared
    )
