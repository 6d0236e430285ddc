"""What is asked of the observations, and what is refused before anything is solved."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.errors import DesignError, ObservationsError
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.known_of_run import NOTHING_KNOWN, KnownOfRun
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.model import Model
from ams.models.possible_temperature import POSSIBLE, impossible_temperatures, likely_unit
from ams.models.registry import MODELS
from ams.models.thermal import Order, TemperatureCoefficients
from ams.observations import Observations

_NO_YAW_RAD = 1e-9


@dataclass(frozen=True)
class CalibrationRequest:
    """One calibration of a package."""

    model: str = "pitch-roll"
    """A name of ``ams.models.registry.MODELS``, such as ``pitch-roll``, ``pitch-yaw-roll-sting`` or ``gyro``."""
    nominal_axes: Mapping[str, str] = field(default_factory=dict)
    """Sensor axis label to the package axis it nominally lies along. Empty: every output is its own (``x``,
    ``y``, ``z``)."""
    declared: Mapping[str, DeclaredDirection] = field(default_factory=dict)
    """Sensor axis label to where it is declared to lie and with which polarity, in the axes of the model. An axis that
    is not named is declared along its nominal one, of either polarity."""
    temperature: Literal["none", "apply", "estimate"] = "none"
    temperature_order: Order = 1
    """Of the terms that ``estimate`` solves for; what is known has the order that it has."""
    known_temperature: Mapping[str, TemperatureCoefficients] = field(default_factory=dict)
    """Sensor axis label to its coefficients, for ``apply``."""
    reference_temperature_degc: float | None = None
    """None: the mean of the measured temperatures rounded to 1 °C."""
    extended: Literal["no", "test", "yes"] = "yes"
    """Terms of second and third order beside pitch-roll: ``yes`` wherever the points determine them, ``test`` where an
    F-test asks for them."""
    time_term: bool = False
    """A drift of the offset, linear in time within the run, as a parameter ``offset_drift_v_per_h``."""
    table: TableUncertainty | None = None
    """Index errors of the table, carried in U_Y."""
    shared_errors: Mapping[str, tuple[SharedError, ...]] = field(default_factory=dict)
    """Sensor axis label to the errors that all its rows share (meter, level, thermometer), carried in U_Y."""
    residual_curvature: bool = False
    """H_E of TP appendix B at the solution, among the notes of every axis: what the residuals' own curvature would do
    to the uncertainties. Zero for a model that is linear in its primary parameters."""
    weights: FloatArray | None = None
    """(N,) relative weights of the rows, inversely proportional to their variances. None: equal."""
    models: Mapping[str, Model] = field(default_factory=dict)
    """Sensor axis label to a model of the caller's own, used instead of the one that ``model`` names."""

    counts_temperature: bool = True
    """What a recorded temperature that no model has may have done is part of the uncertainty."""
    counts_tilts: bool = True
    """A tilt of the base that the replications of a package show is part of the uncertainty."""
    tested_axes: int | None = None
    """How many sensor axes the run has: the tests of all of them are one family. None: those that are solved here."""

    single_approach: frozenset[str] = frozenset()
    """Axes of the table (``pitch``, ``roll``) that the machine lets come from one side always: their play cannot show.
    """

    known_of_run: KnownOfRun = NOTHING_KNOWN
    """What runs and other packages have shown of the table, so that no axis is blamed for it."""

    def axes_of(self, observations: Observations) -> Mapping[str, str]:
        """Return the nominal axis of every sensor axis to solve, by label."""
        return self.nominal_axes or {label: label for label in observations.outputs}

    def with_error(self, error: SharedError) -> "CalibrationRequest":
        """Return the same with one more error that all rows of every axis share."""
        errors = {axis: (*self.shared_errors.get(axis, ()), error) for axis in self.nominal_axes}
        return replace(self, shared_errors=errors)

    def declared_of(self, label: str, nominal_axis: str) -> DeclaredDirection:
        """Return what is declared of the direction of a sensor axis."""
        return self.declared.get(label, DeclaredDirection(nominal_axis))


def refuse_unusable(observations: Observations, request: CalibrationRequest) -> None:
    """Refuse arrays of several lengths, numbers that are not finite, unknown axes and weights.

    Raises:
        ObservationsError: what is wrong, and in which column.
        DesignError: a combination that is asked for does not exist.
    """
    if request.temperature not in ("none", "apply", "estimate"):
        raise DesignError(
            f"temperature: got {request.temperature!r}, allowed none, apply, estimate; nothing was solved"
        )
    if request.temperature_order not in (1, 2):
        raise DesignError(f"temperature_order: got {request.temperature_order!r}, allowed 1, 2; nothing was solved")
    if request.temperature_order != 1 and request.temperature != "estimate":
        raise DesignError(
            f"temperature_order: got {request.temperature_order} with temperature {request.temperature!r}: it belongs "
            "to temperature estimate; nothing was solved"
        )
    if request.extended not in ("no", "test", "yes"):
        raise DesignError(f"extended: got {request.extended!r}, allowed no, test, yes; nothing was solved")
    for label in request.axes_of(observations):
        if label not in observations.outputs:
            raise ObservationsError(
                f"{observations.source}: axis {label}: no outputs; there are "
                f"{', '.join(observations.outputs) or 'none'}; "
                "nothing was solved; name an axis that was measured"
            )
    for name, values in _columns(observations, request).items():
        _refuse_column(observations, name, values)
    _refuse_impossible_temperatures(observations)
    _refuse_ignored_yaw(observations, request)


def _refuse_impossible_temperatures(observations: Observations) -> None:
    """Refuse what no sensor stands, of runs and tables; readers of files name the line."""
    read = observations.temperature_degc
    if read is None or not (beyond := impossible_temperatures(read)).any():
        return
    row = int(np.flatnonzero(beyond)[0])
    raise ObservationsError(
        f"{observations.source}: temperature_degc: {int(beyond.sum())} of {read.size} rows are impossible, the first "
        f"in replication {observations.replication[row]}, point {observations.point[row]}: got {read[row]:g} °C, "
        f"allowed {POSSIBLE}; nothing was solved; {likely_unit(read)}, or leave out the row"
    )


def _refuse_ignored_yaw(observations: Observations, request: CalibrationRequest) -> None:
    yaw = observations.yaw_rad
    registered = MODELS.get(request.model)
    if yaw is None or registered is None or registered.follows_yaw or request.models:
        return
    if np.abs(yaw).max() > _NO_YAW_RAD:
        row = int(np.argmax(np.abs(yaw)))
        raise ObservationsError(
            f"{observations.source}: yaw_deg: got {np.rad2deg(yaw[row]):g}° in replication "
            f"{observations.replication[row]}, point {observations.point[row]}: the model {request.model} has no yaw, "
            "allowed 0°; nothing was solved; use the model pitch-yaw-roll"
        )


def _columns(observations: Observations, request: CalibrationRequest) -> Mapping[str, FloatArray]:
    columns: dict[str, FloatArray | None] = {
        "pitch": observations.pitch_rad,
        "roll": observations.roll_rad,
        "yaw": observations.yaw_rad,
        "temperature": observations.temperature_degc,
        "time": observations.time_s,
        "reference level": observations.reference_level,
        **_rates(observations),
        "weights": request.weights,
    }
    outputs = {f"output {label}": observations.outputs[label] for label in request.axes_of(observations)}
    return {name: values for name, values in columns.items() if values is not None} | outputs


def _rates(observations: Observations) -> Mapping[str, FloatArray]:
    rates = observations.euler_rate_rad_s
    return {} if rates is None else dict(zip(("pitch rate", "yaw rate", "roll rate"), rates.T, strict=True))


def _refuse_column(observations: Observations, name: str, values: FloatArray) -> None:
    if values.shape != (observations.rows,):
        raise ObservationsError(
            f"{observations.source}: {name}: got an array of shape {values.shape}, allowed ({observations.rows},), "
            "one value a row; nothing was solved"
        )
    allowed = np.isfinite(values) & (values > 0.0) if name == "weights" else np.isfinite(values)
    if not allowed.all():
        row = int(np.flatnonzero(~allowed)[0])
        raise ObservationsError(
            f"{observations.source}: {name}: row {row + 1} (replication {observations.replication[row]}, point "
            f"{observations.point[row]}): got {values[row]}, allowed a "
            f"finite{' positive' if name == 'weights' else ''} number; "
            "nothing was solved; correct or leave out the row"
        )


def select_rows(observations: Observations, kept: BoolArray) -> Observations:
    """Return the rows where ``kept`` is true."""
    return replace(
        observations,
        replication=observations.replication[kept],
        point=observations.point[kept],
        pitch_rad=observations.pitch_rad[kept],
        roll_rad=observations.roll_rad[kept],
        outputs={label: values[kept] for label, values in observations.outputs.items()},
        yaw_rad=None if observations.yaw_rad is None else observations.yaw_rad[kept],
        temperature_degc=None if observations.temperature_degc is None else observations.temperature_degc[kept],
        time_s=None if observations.time_s is None else observations.time_s[kept],
        euler_rate_rad_s=None if observations.euler_rate_rad_s is None else observations.euler_rate_rad_s[kept],
        reference_level=None if observations.reference_level is None else observations.reference_level[kept],
        level_errors=None if observations.level_errors is None else observations.level_errors[kept],
        scanned_v=None if observations.scanned_v is None else observations.scanned_v[kept],
        gravity_errors_rad=None if observations.gravity_errors_rad is None else observations.gravity_errors_rad[kept],
        mounting=None if observations.mounting is None else observations.mounting[kept],
        step=None if observations.step is None else observations.step[kept],
        from_level=None if observations.from_level is None else observations.from_level[kept],
    )
