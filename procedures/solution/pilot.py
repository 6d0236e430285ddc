"""What a run that was made says of the next one on the same rig: noise, lack of fit and drift as it showed them."""

from collections.abc import Mapping, Sequence
from dataclasses import astuple
from math import sqrt

import numpy as np

from ams.calibration_result import AxisCalibration
from ams.sets.sensed_quantity import form_by_names
from procedures.errors import RequestError
from procedures.solution.beliefs import Pilot, Shown
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from rig.description.rig_file import RigDescription


def pilot_of(record: RunRecord, sensors: Mapping[str, SolvedSensor], rig: RigDescription) -> Pilot:
    """Return what a solved run showed. Raises: RequestError where it is of another rig or shows nothing."""
    if record.rig.rig.name != rig.rig.name:
        raise RequestError(
            f"pilot {record.run_id}: it is of the rig {record.rig.rig.name!r}, this one is {rig.rig.name!r}; what one "
            "rig shows says nothing of another; give a run of this rig"
        )
    if record.is_simulated and not rig.is_simulated:
        raise RequestError(
            f"pilot {record.run_id}: it was simulated and teaches nothing about real devices; give a run that was "
            "measured"
        )
    shown = shown_in(record, sensors)
    if not shown:
        raise RequestError(
            f"pilot {record.run_id}: it has no solved sensor with two replications or more, which alone tell noise, "
            "lack of fit and drift apart; give another run"
        )
    of_type: dict[tuple[str, str], Shown] = {}
    for (name, label), found in shown.items():
        key = (record.plan.sensors[name].model, label)
        before = astuple(of_type.get(key, found))
        of_type[key] = Shown(*(max(pair) for pair in zip(before, astuple(found), strict=True)))
    return Pilot(f"run {record.run_id}", shown, of_type)


def shown_in(record: RunRecord, sensors: Mapping[str, SolvedSensor]) -> dict[tuple[str, str], Shown]:
    """Return what every axis of a solved run showed, by sensor and axis; those that were not replicated are missing."""
    return {
        (name, label): found
        for name, solved in sensors.items()
        if solved.calibration is not None
        for label, axis in solved.calibration.axes.items()
        if (found := _shown(axis, *_readings(record, name, label))) is not None
    }


def mean_of_shown(found: Sequence[Shown]) -> Shown:
    """Return the root mean square of what several runs showed: variances are what adds up."""
    return Shown(*np.sqrt(np.mean(np.square([astuple(shown) for shown in found]), axis=0)).tolist())


def _readings(record: RunRecord, name: str, label: str) -> tuple[float, float]:
    """Return the scatter of the readings inside the dwells, volts, and how many a dwell had (harmonic mean)."""
    channel = {str(axis): channel for axis, channel in record.plan.sensors[name].channels.items()}[label]
    readings = [
        dwell.readings[channel]
        for dwell in record.dwells
        if dwell.accepted and dwell.purpose == "design" and channel in dwell.readings
    ]
    if not readings:
        return 0.0, record.plan.dwell.samples
    squares = [reading.standard_deviation**2 for reading in readings]
    return sqrt(float(np.mean(squares))), 1.0 / float(np.mean([1.0 / reading.samples.size for reading in readings]))


def _shown(axis: AxisCalibration, reading_v: float, samples: float) -> Shown | None:
    """Return what an axis showed; None where nothing was replicated, or it is no accelerometer.

    Drift is what the spread between the replications has beyond what precision gives it.
    """
    replication, form = axis.replication, form_by_names(axis.model, axis.primary_names)
    spread = next((part.covariance for part in axis.variance_components if part.name == "replications"), None)
    if replication is None or spread is None or form is None or form.unit != "g":
        return None
    along, offset = np.zeros(axis.primary.size), np.zeros(axis.primary.size)
    terms = [axis.primary_names.index(name) for name in form.directions if name in axis.primary_names]
    per_g = float(np.linalg.norm(axis.primary[terms]))
    if per_g == 0.0:
        return None
    along[terms] = axis.primary[terms] / per_g
    offset[axis.primary_names.index(form.offset)] = 1.0
    n, precision = replication.replications, replication.precision_v**2
    expected = precision * axis.tp_primary_covariance / axis.standard_error_v**2
    drifts = [sqrt(max(0.0, n * float(way @ (spread - expected) @ way))) for way in (offset, along)]
    dwell = sqrt(max(0.0, precision - reading_v**2 / samples))
    parts = (reading_v, dwell, replication.lack_of_fit_v, *drifts)
    return Shown(*(part / per_g for part in parts))
