"""A row has the same flag, and the same angles, whether its 95 % intervals are asked for or not."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pytest
from foreign_sets import bending
from scipy.spatial.transform import Rotation
from solved_sets import bent_set, gyro_set, package_set, tp_set

from ams.attitude import flag_codes
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.monitored import MonitoredAngles
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.inference import Package, inference
from ams.inference.package.alignment import Alignment
from ams.inference.rows.angle_stream import AngleStream
from ams.inference.rows.averaged import AveragedAngles
from ams.inference.rows.low_passed import LowPassedAngles, LowPassWish
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import predicted_v

ROWS = 400
ASKEW = Alignment("TP1", Rotation.from_rotvec([0.01, -0.02, 0.03]).as_matrix(), 1e-6 * np.eye(3), 9, 0.01)


@dataclass(frozen=True)
class Asked:
    """One way of asking."""

    coefficients: CoefficientSet
    axes: str = "xyz"
    site_gravity_mps2: float | None = None
    alignment: Alignment | None = None
    model_set: CoefficientSet | None = None
    upright: bool = True
    right_wing_down: bool = True

    def package(self) -> Package:
        columns = {axis: f"{axis}_v" for axis in self.axes}
        return Package(self.coefficients, columns, self.site_gravity_mps2, self.alignment)


ASKED = {
    "three axes": Asked(tp_set()),
    "three axes of a noisy calibration": Asked(tp_set(noise_v=3e-4, chance=np.random.default_rng(3))),
    "at another g": Asked(tp_set(), site_gravity_mps2=9.81),
    "aligned": Asked(tp_set(), alignment=ASKEW),
    "bent": Asked(bent_set()),
    "by temperature": Asked(bending()),
    "x and y": Asked(tp_set(), "xy"),
    "x and y beyond ±90°": Asked(tp_set(), "xy", upright=False),
    "x and z": Asked(tp_set(), "xz"),
    "x and z on the other side": Asked(tp_set(), "xz", right_wing_down=False),
    "x alone": Asked(tp_set(), "x"),
    "sting alone": Asked(package_set("sting")),
    "two packages": Asked(package_set("sting"), model_set=package_set("model")),
}


def spoilt(own: Asked) -> dict[str, np.ndarray]:
    """Return outputs of directions all round, half of them with an output that is wrong in one way or another."""
    chance = np.random.default_rng(14)
    force = chance.normal(size=(ROWS, 3))
    force[: ROWS // 8, 1:] *= 0.003  # towards the vertical
    force /= np.linalg.norm(force, axis=1, keepdims=True)
    readings = {"temperature_degc": np.linspace(15.0, 30.0, ROWS), "roll_deg": chance.uniform(-180.0, 180.0, ROWS)}
    for prefix, coefficients in (("", own.coefficients), ("model_", own.model_set)):
        for axis, one in ({} if coefficients is None else coefficients.axes).items():
            warm = readings["temperature_degc"] if own.coefficients.needs_temperature else None
            sensed = -force if one.form.is_gravity else force
            clean = predicted_v(one, sensed, warm)
            wrong = chance.integers(0, 12, ROWS)
            offset = float(one.primary["offset_v"])
            by_kind = [np.full(ROWS, offset), np.full(ROWS, 10.0), clean + 0.2, offset + 0.7 * (clean - offset)]
            values = np.select([wrong == kind for kind in range(4)], by_kind, clean)
            values[wrong == 5] = np.nan
            readings[f"{prefix}{axis}_v"] = values + 1e-5 * chance.normal(size=ROWS)
    return readings


def answered(found: AngleStream, readings: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    first, last = found.answer(readings), found.finish()
    columns = {name: np.concatenate([first.columns[name], last.columns[name]]) for name in first.columns}
    return columns, (*first.flags, *last.flags)


@pytest.mark.parametrize("name", ASKED)
@pytest.mark.parametrize("around", ["alone", "low-passed", "averaged", "monitored"])
def test_a_row_has_the_same_flag_with_and_without_intervals(name: str, around: str) -> None:
    own, told = ASKED[name], []
    for intervals in (False, True):
        second = None
        if own.model_set is not None:
            second = Package(own.model_set, {axis: f"model_{axis}_v" for axis in "xyz"})
        found: AngleStream = inference(
            own.package(), second, 1e-5, upright=own.upright, right_wing_down=own.right_wing_down, intervals=intervals
        )
        readings = spoilt(own)
        if around == "monitored":
            gyros = GyroPackage(gyro_set(), {axis: f"gyro_{axis}_v" for axis in "xyz"})
            for axis, one in gyros.coefficients.axes.items():
                readings[f"gyro_{axis}_v"] = np.full(ROWS, float(one.primary[one.form.offset]))
            found = MonitoredAngles(found, GyroAngles(gyros, Motion(rate_hz=100.0)), 0.1)
        elif around == "low-passed":
            found = LowPassedAngles(found, LowPassWish(5.0), 100.0)
        elif around == "averaged":
            found = AveragedAngles(found, 0.05, 100.0)
        told.append(answered(found, readings))
    (plain, flags), (more, flags_with) = told
    assert flags_with == flags
    for column, values in plain.items():
        np.testing.assert_allclose(more[column], values, rtol=1e-6, atol=1e-9, err_msg=column)
    assert any(column.endswith("_half_95_deg") for column in more)
    assert any(flags)


def test_the_axis_is_named_in_both_ways() -> None:
    for name in ("three axes", "at another g", "aligned", "bent", "by temperature"):
        found = inference(ASKED[name].package(), None, 1e-5, intervals=True).answer(spoilt(ASKED[name]))
        assert sum("suspect" in flag for flag in found.flags) > 10, name
        assert np.any(found.codes & flag_codes.REDUNDANCY), name
