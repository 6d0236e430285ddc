"""Which sensor of a rig file the columns of a file were read from, and what the rig file declares of its readings."""

from collections.abc import Iterable

from ams.inputs.shared_errors import SharedError
from procedures.errors import RequestError
from procedures.plan.channels import environment_of
from procedures.solution.type_b import shared_errors
from rig.description.rig_file import RigDescription, Sensor


def require_sensor(rig: RigDescription | None, name: str | None, source: str) -> None:
    """Check that a sensor that is named stands in the rig file ``source``. Raises: RequestError where it does not."""
    if rig is not None and name is not None and name not in rig.sensors:
        raise RequestError(
            f"sensor {name!r}: {source} has no [sensors.{name}] (allowed: {', '.join(sorted(rig.sensors))}); nothing "
            "was solved; name one of these, or add it to the rig file"
        )


def named_sensor(rig: RigDescription | None, name: str | None, columns: Iterable[str]) -> str | None:
    """Return the sensor that is named; of several in a rig file the one whose name all columns begin with.

    ``columns``: of the file, such as ``SN1047_x_v``. None where nothing names one.
    """
    if rig is None or name is not None or len(rig.sensors) < 2:
        return name
    written = tuple(columns)
    matching = [sensor for sensor in rig.sensors if all(_begins_with(column, sensor) for column in written)]
    return matching[0] if len(matching) == 1 else None


def _begins_with(column: str, sensor: str) -> bool:
    return column.startswith(sensor) and not column[len(sensor) : len(sensor) + 1].isalnum()


def sensor_of(rig: RigDescription, name: str | None) -> Sensor | None:
    """Return the sensor whose channels stand in the rig file.

    The one named, else the only one; None where that is open.
    """
    if name is not None and name in rig.sensors:
        return rig.sensors[name]
    return next(iter(rig.sensors.values())) if len(rig.sensors) == 1 else None


def errors_of_file(rig: RigDescription, name: str | None) -> dict[str, tuple[SharedError, ...]]:
    """Return what the rig file declares of the readings of a file; the sensor as :func:`sensor_of` takes it."""
    sensor = sensor_of(rig, name)
    return shared_errors(rig, sensor, None if sensor is None else environment_of(rig, sensor))
