"""Limits of ``[acceptance]`` that a plan would leave without a judgement: nothing declared is silently dropped."""

from collections.abc import Iterator, Mapping

from ams.surveillance.attitude_errors import angles_judged
from procedures.description.procedure_file import ProcedureDescription, Solve
from procedures.errors import PlanError
from rig.description.rig_file import RigDescription, Sensor

_WHO_IS_JUDGED = (
    "errors of pitch and roll are told of packages of accelerometers in pitch and roll, of one axis those of pitch"
)


def limits_of_nobody(
    rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor]
) -> Iterator[PlanError]:
    """Tell of limits that no sensor of the plan can be held to."""
    for key, holding in _judged_by(rig, procedure.solve, sensors).items():
        if not holding:
            yield procedure.error(
                ("solve", "model"),
                f'no sensor of this run can be held to {key} of the rig file with the model "{procedure.solve.model}" '
                f"({', '.join(sensors)}): {_WHO_IS_JUDGED}; the limit would not be judged; remove it from "
                "the rig file of this run, or solve with a model that tells the angle",
            )


def limits_of_some(rig: RigDescription, solve: Solve, sensors: Mapping[str, Sensor]) -> Iterator[str]:
    """Yield limits that some sensors of the plan are held to and others cannot be."""
    for key, judged in _judged_by(rig, solve, sensors).items():
        without = [serial for serial in sensors if serial not in judged]
        if judged and without:
            yield f"{key} is judged of {', '.join(judged)}, and not of {', '.join(without)}: {_WHO_IS_JUDGED}"


def limits_in_words(rig: RigDescription) -> tuple[str, ...]:
    """Return the limits that a rig file declares, each by its key and value."""
    return tuple(key for key, _ in _limits(rig))


def _judged_by(rig: RigDescription, solve: Solve, sensors: Mapping[str, Sensor]) -> dict[str, list[str]]:
    """Return each limit that is declared, in words, to the sensors that are judged by it."""
    judged = {
        serial: angles_judged(solve.model_of(serial, rolls=sensor.rolls), len(sensor.channels))
        for serial, sensor in sensors.items()
    }
    return {key: [serial for serial, angles in judged.items() if angle in angles] for key, angle in _limits(rig)}


def _limits(rig: RigDescription) -> Iterator[tuple[str, str]]:
    """Yield every limit that is declared, in words, and its angle."""
    declared = {"pitch": rig.acceptance.pitch_limit_deg, "roll": rig.acceptance.roll_limit_deg}
    for angle, limit_deg in declared.items():
        if limit_deg is not None:
            yield f"acceptance.{angle}_limit_deg = {limit_deg:g}", angle
