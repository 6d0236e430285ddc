"""Second step of CR: the model package calibrated against the sting package instead of against the table's angles.

The sting's outputs give gravity in sting axes, roll turns it into model axes; so a tunnel that knows only its roll can
calibrate the model package. Pitch and yaw stand for that direction of gravity; at level, where yaw has no meaning, any
yaw does. What the sting's own calibration leaves uncertain is common to all rows and is not in the result: it is said.
Source: CR IV-A.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ams.attitude.two_package import angles_from_gravity
from ams.errors import OutsideValidity
from ams.inference.inference import Package
from ams.inputs.csv_table import PLAIN, CsvForm
from ams.inputs.observations_csv import read_csv
from ams.observations import Observations

WARNING = (
    "gravity is that of the sting package: the uncertainty of its calibration is not in these uncertainties; calibrate "
    "against the table's angles where they are known"
)


def read_with_sting(path: str | Path, axes: Mapping[str, str], sting: Package, form: CsvForm = PLAIN) -> Observations:
    """Read observations whose pitch and yaw come from the sting's columns; the file states roll.

    Raises: ObservationsError as :func:`ams.inputs.observations_csv.read_csv`; OutsideValidity where the set is no
    sting's.
    """
    if not sting.is_of_sting or len(sting.columns) != 3:
        raise OutsideValidity(
            f"{sting.coefficients.sensor}: got model {sting.model} with {len(sting.columns)} axes, needed "
            "pitch-yaw-roll-sting with three; nothing was solved; give the set of the sting package"
        )
    named = {f"sting {axis}": column for axis, column in sting.columns.items()}
    rows = read_csv(path, {**axes, **named}, ("roll",), form=form)
    readings = {column: rows.outputs[f"sting {axis}"] for axis, column in sting.columns.items()}
    if rows.temperature_degc is not None:
        readings["temperature_degc"] = rows.temperature_degc
    sensors = sting.sensors(readings, None)
    k = np.stack([sensor.k_v_per_g for sensor in sensors])
    volts = sting.outputs_v(sensors, readings) - np.array([sensor.offset_v for sensor in sensors])
    gravity = -np.linalg.solve(k, volts.T).T
    angles = angles_from_gravity(gravity, gravity)
    outputs = {axis: rows.outputs[axis] for axis in axes}
    yaw = np.where(np.isnan(angles.yaw_rad), 0.0, angles.yaw_rad)
    size = np.arctan2(np.hypot(gravity[:, 0], gravity[:, 1]), gravity[:, 2])
    sideways = np.isnan(angles.pitch_rad)
    return replace(
        rows,
        pitch_rad=np.where(sideways, size, angles.pitch_rad),
        yaw_rad=np.where(sideways, np.sign(gravity[:, 1]) * 0.5 * np.pi, yaw),
        outputs=outputs,
    )
