"""What a planned run's solution will be reserved about, whatever is measured: the solver is asked with simulated rows.

The rows are those of the plan in the order of their visits, the outputs those of a sensor without errors and the noise
that is believed. What a test finds in such outputs is chance and left out; what stays is said of the design, the order,
the temperatures and the number of replications, in the words that the report will use.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ams.calibration.mountings import calibrate_mountings
from ams.calibration_result import AxisCalibration
from ams.findings import significant_texts
from procedures.description.procedure_file import Solve
from procedures.plan.channels import temperature_source
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.expected import Believed, PlannedRows, assumed_degc, at_use, planned_observations
from procedures.solution.request import request_of
from procedures.solution.temperature_of_use import beyond_measured, calibrated_degc, use_warnings
from rig.description.rig_file import RigDescription, Sensor

FACTS = ("time-confounded", "axis-undetermined")
"""Kinds of findings that need no test."""
TEMPERATURE = "temperature-residual"
_LEAST_NOISE = 1e-9
"""Of the sensitivity: outputs that do not scatter leave the tests nothing to divide by."""


def foreseen_warnings(
    rig: RigDescription, solve: Solve, serial: str, sensor: Sensor, rows: PlannedRows, believed: Believed
) -> tuple[str, ...]:
    """Return the warnings of one sensor, each once. Raises: ams.errors.AmsError where the rows cannot be solved."""
    tempered, model = at_use(rig, solve, sensor, rows), solve.model_of(serial, rolls=sensor.rolls)
    planned = planned_observations(model, tempered, believed.axes, rolls=sensor.rolls)
    plain = with_scanned_volts(planned, rig, sensor)
    chance = np.random.default_rng(0)
    outputs = {
        axis: values
        + max(believed.noise_v(axis), _LEAST_NOISE * float(np.linalg.norm(believed.axes[axis].k_v_per_g)))
        * chance.standard_normal(values.size)
        for axis, values in plain.outputs.items()
    }
    observations = replace(plain, outputs=outputs)
    solved = calibrate_mountings(observations, request_of(serial, rig, sensor, solve, observations))
    is_recorded = temperature_source(rig, sensor) is not None
    degc = calibrated_degc(solve.temperature, observations.temperature_degc)
    used = (
        *use_warnings(sensor, degc, is_recorded=is_recorded),
        *beyond_measured(sensor, solve.temperature, observations.temperature_degc),
    )
    return tuple(dict.fromkeys([*solved.warnings, *_of_axes(solved.axes), *used]))


def use_remarks(rig: RigDescription, solve: Solve, sensors: Mapping[str, Sensor]) -> Iterator[str]:
    """Yield what is taken for the temperature of a calibration that nothing sets, sensors that are alike together."""
    said: dict[str, list[str]] = {}
    for serial, sensor in sensors.items():
        degc, used = assumed_degc(rig, solve, sensor), sensor.use_temperature_degc
        if degc is None or used is None or use_warnings(sensor, degc):
            continue
        text = (
            f"nothing sets the temperature of the calibration; the temperature of use counts as if it were {degc:.4g} "
            f"°C, the middle of {used[0]:g} to {used[1]:g} °C, which is the least: calibrated at {used[0]:g} or "
            f"{used[1]:g} °C it would count twice as much, outside that range more"
        )
        said.setdefault(text, []).append(serial)
    yield from (text if len(whose) == len(sensors) else f"{', '.join(whose)}: {text}" for text, whose in said.items())


def _of_axes(axes: Mapping[str, AxisCalibration]) -> Iterator[str]:
    for axis in axes.values():
        facts = [
            finding
            for finding in axis.findings
            if (finding.kind in FACTS and finding.p_value is None)
            or (finding.kind == TEMPERATURE and finding.details.get("test") == "temperature with attitude")
        ]
        tested = significant_texts([finding for finding in axis.findings if finding not in facts])
        yield from (text for text in axis.warnings if text not in tested)
