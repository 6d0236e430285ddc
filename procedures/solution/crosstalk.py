"""What leaks from the other channels of a scanner into a reading, as the rig file limits it (type B).

A channel whose relay is open passes a part of its volts all the same: through insulation, and by what the meter's input
keeps of the channel before. Each other channel leaks by a part of its own, of unknown sign within the declared limit
and the same from the first dwell to the last, so that a reading has Σ εⱼ·vⱼ too much. Sensors that are turned together
then have a wrong offset, a wrong sensitivity and a sensitive axis that lies askew, and no residual shows it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import sqrt

import numpy as np

from ams.arrays import FloatArray
from ams.frames import AXES, specific_force
from ams.inputs.shared_errors import SharedError
from ams.observations import Observations
from procedures.records.dwells import DwellRecord
from rig.description.device_settings import ScannedReadoutSettings
from rig.description.rig_file import RigDescription, Sensor

CROSSTALK = "crosstalk of the scanner"


def crosstalk_errors(rig: RigDescription, sensor: Sensor, channel: str) -> Iterator[SharedError]:
    """Yield what may leak into ``channel``, of each other channel of its scanner by a part of its own."""
    readout = channel.partition(".")[0]
    scanner, read = rig.scanners_behind(sensor).get(readout), leaking_channels(rig, sensor)
    if scanner is None or scanner.crosstalk_ratio is None:
        return
    columns = tuple(column for column, other in enumerate(read) if other.partition(".")[0] == readout)
    axis_of = {name: str(axis) for axis, name in sensor.channels.items()}
    others = len(columns) - 1
    yield SharedError(
        CROSSTALK,
        "crosstalk",
        scanner.crosstalk_ratio / sqrt(3.0),
        "limit" if others == 1 else "standard",  # the sum of several rectangular ones is nearly normal
        f"readouts.{readout}: limit {scanner.crosstalk_ratio:g} of the volts of each of {others} other channels",
        columns=columns,
        axes=tuple(axis_of.get(read[column], "") for column in columns),
        is_of_one_channel=True,
    )


def leaking_channels(rig: RigDescription, sensor: Sensor) -> tuple[str, ...]:
    """Return the channels of the scanners that read a sensor and leak, its own among them: the columns of the rows."""
    return tuple(
        f"{name}.{channel}"
        for name, scanner in rig.scanners_behind(sensor).items()
        if scanner.crosstalk_ratio is not None
        for channel in scanner.channel_names()
    )


def with_scanned_volts(
    rows: Observations, rig: RigDescription, sensor: Sensor | None, dwells: Sequence[DwellRecord] = ()
) -> Observations:
    """Return the rows with the volts on all channels of the scanners that leak; as they are where none does.

    ``dwells``: the accepted ones that the rows are of, in their order; without them a channel of another sensor has
    what is declared of it, as if it were mounted alike, and one of which nothing is declared has all of its range.
    """
    channels = () if sensor is None else leaking_channels(rig, sensor)
    if sensor is None or not channels:
        return rows
    of_sensor = {channel: str(axis) for axis, channel in sensor.channels.items()}
    columns = []
    for channel in channels:
        read = np.array([row.readings[channel].mean if channel in row.readings else np.nan for row in dwells])
        if dwells and np.isfinite(read).all():
            columns.append(read)
        elif of_sensor.get(channel) in rows.outputs:
            columns.append(rows.outputs[of_sensor[channel]])
        else:
            columns.append(_declared_v(rows, rig, channel))
    return replace(rows, scanned_v=np.stack(columns, axis=1))


def _declared_v(rows: Observations, rig: RigDescription, channel: str) -> FloatArray:
    """Return (N,) volts by declaration: of an accelerometer, of a supply, else the range of the channel."""
    for sensor in rig.sensors.values():
        for axis, name in sensor.channels.items():
            if name == channel and sensor.nominal_v_per_g(axis):
                force_g = specific_force(rows.pitch_rad, rows.roll_rad, rows.yaw_rad)
                return np.asarray(sensor.nominal_v_per_g(axis) * force_g[:, AXES.index(axis)])
    supplies_v = [chain.reference_supply_v for chain in rig.chain.values() if chain.supply_channel == channel]
    readout, _, name = channel.partition(".")
    scanner = rig.readouts[readout]
    assert isinstance(scanner, ScannedReadoutSettings), "leaking_channels names those of scanners alone"
    range_v = scanner.range_of_channel_v(name)
    return np.full(rows.rows, next((volts for volts in supplies_v if volts is not None), range_v))
