"""The attitude that a chosen coefficient set makes of the channels' means, beside what the table says."""

from pathlib import Path

import numpy as np

from ams.errors import AmsError
from ams.exports.formats import load_set
from ams.frames import ANGLES
from ams.inference.inference import Inference, Package, inference
from procedures.errors import RequestError
from procedures.jog_screen.values import AttitudeView
from rig.description.rig_file import RigDescription, Sensor


class InferredAttitude:
    """A set, and where its sensor's outputs are read on this rig."""

    def __init__(self, found: Inference, sensor: str, wiring: Sensor) -> None:
        self._found = found
        self._sensor = sensor
        self._wiring = wiring

    def view(self, means_v: dict[str, float], air_degc: float | None, roll_deg: float | None) -> AttitudeView:
        """``roll_deg`` is the table's: a single axis needs to be told."""
        volts = {axis: means_v.get(channel, np.nan) for axis, channel in self._wiring.channels.items()}
        if any(np.isnan(value) for value in volts.values()):
            return AttitudeView(self._sensor, flag="waiting for readings of every axis")
        columns = {f"{axis}_v": np.array([value]) for axis, value in volts.items()}
        degc = self._sensor_degc(means_v, air_degc)
        if degc is not None:
            columns["temperature_degc"] = np.array([degc])
        if roll_deg is not None:
            columns["roll_deg"] = np.array([roll_deg])
        missing = [name for name in self._found.needed if name not in columns]
        if missing:
            return AttitudeView(self._sensor, flag=f"the set needs {missing[0]}, which this rig does not tell")
        try:
            answer = self._found.infer(columns)
        except AmsError as error:
            return AttitudeView(self._sensor, flag=str(error))
        angles = tuple(
            (name, float(answer[f"{name}_deg"][0]), float(answer[f"{name}_sd_deg"][0]))
            for name in ANGLES
            if f"{name}_deg" in answer
        )
        return AttitudeView(self._sensor, angles, str(answer["flag"][0]))

    def _sensor_degc(self, means_v: dict[str, float], air_degc: float | None) -> float | None:
        channel = self._wiring.temperature
        if channel is None or np.isnan(means_v.get(channel.channel, np.nan)):
            return air_degc
        return channel.offset_degc + channel.slope_degc_per_v * means_v[channel.channel]


def inferred_attitude(path: Path, description: RigDescription) -> InferredAttitude:
    """Return the set of a file with the rig's own wiring. Raises: SetError, RequestError, OutsideValidity."""
    coefficients = load_set(path)
    coefficients.check_vectors(str(path))
    sensors = description.sensors
    name = coefficients.sensor if coefficients.sensor in sensors else next(iter(sensors))
    if name != coefficients.sensor and len(sensors) > 1:
        raise RequestError(
            f"--set {path}: is of the sensor {coefficients.sensor}, allowed are the rig's: {', '.join(sensors)};"
            " nothing was opened"
        )
    wiring = sensors[name]
    strange = [axis for axis in coefficients.axes if axis not in wiring.channels]
    if strange:
        raise RequestError(
            f"--set {path}: has the axis {strange[0]}, which {name} on this rig has not; nothing was opened"
        )
    columns = {axis: f"{axis}_v" for axis in coefficients.axes}
    return InferredAttitude(inference(Package(coefficients, columns)), coefficients.sensor, wiring)
