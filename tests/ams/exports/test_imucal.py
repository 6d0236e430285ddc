"""A set as a calibration of imucal: the fields and the arithmetic of imucal 2.6 give the force and the rate."""

import json
import re
from collections.abc import Callable

import numpy as np
import pytest
from foreign_sets import warm
from solved_sets import bent_set, gyro_set, package_set, tp_set

from ams.errors import SetError, VectorsDisagree
from ams.exports.checksum_inside import CHECKSUM_SLOT, MARK, with_checksum_inside
from ams.exports.imucal import from_imucal, to_imucal
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import predicted_v

FIELDS = {"acc_unit", "gyr_unit", "from_acc_unit", "from_gyr_unit", "comment", "K_a", "R_a", "b_a", "K_g", "R_g",
          "K_ga", "b_g"}  # fmt: skip
"""Of FerrarisCalibrationInfo: any other key is refused by its constructor."""
GRAVITY_MPS2 = 9.79826
VECTORS = np.random.default_rng(5).normal(size=(40, 3))
FORCES = VECTORS / np.linalg.norm(VECTORS, axis=1, keepdims=True)


def calibrate(cal: dict, acc: np.ndarray, gyr: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what ``FerrarisCalibrationInfo.calibrate`` does, line by line."""
    own = {name: np.array(cal[name]) for name in ("K_a", "R_a", "b_a", "K_g", "R_g", "K_ga", "b_g")}
    acc_mat = np.linalg.inv(own["R_a"]) @ np.linalg.inv(own["K_a"])
    acc_out = (acc_mat @ (acc - own["b_a"]).T).T
    gyro_mat = np.matmul(np.linalg.inv(own["R_g"]), np.linalg.inv(own["K_g"]))
    offsets = (own["K_ga"] @ acc_out.T).T + own["b_g"]
    return acc_out, (gyro_mat @ (gyr - offsets).T).T


def read(coefficients: CoefficientSet) -> dict:
    cal = json.loads(to_imucal(coefficients))
    assert cal.pop("_format_version") == "2.0.0"
    assert cal.pop("cal_type") == "Turntable"
    assert set(cal) == FIELDS
    assert (cal["acc_unit"], cal["gyr_unit"]) == ("m/s^2", "deg/s")
    return cal


@pytest.mark.parametrize("make", [tp_set, lambda: package_set("sting"), lambda: package_set("model")])
def test_imucal_makes_the_specific_force_of_our_outputs_and_lets_rates_through(
    make: Callable[[], CoefficientSet],
) -> None:
    coefficients = make()
    sense = -1.0 if coefficients.convention == "CR" else 1.0  # CR's equations are of gravity
    outputs = np.stack([predicted_v(coefficients.axes[axis], sense * FORCES, None) for axis in "xyz"], axis=-1)
    cal = read(coefficients)
    acceleration, rates = calibrate(cal, outputs, VECTORS)
    assert acceleration == pytest.approx(GRAVITY_MPS2 * FORCES, abs=1e-12)
    assert rates == pytest.approx(VECTORS, abs=1e-15)
    assert (cal["from_acc_unit"], cal["from_gyr_unit"]) == ("V", "deg/s")


def test_imucal_makes_the_rate_of_our_gyros_and_lets_acceleration_through() -> None:
    coefficients = gyro_set()
    outputs = np.stack([one.primary[one.form.offset] + VECTORS @ one.direction for one in coefficients.axes.values()],
                       axis=-1)  # fmt: skip
    cal = read(coefficients)
    acceleration, rates = calibrate(cal, FORCES, outputs)
    assert rates == pytest.approx(VECTORS, abs=1e-12)
    assert acceleration == pytest.approx(FORCES, abs=1e-15)
    assert (cal["from_acc_unit"], cal["from_gyr_unit"]) == ("m/s^2", "V")


def test_scales_are_positive_and_rows_of_the_rotation_are_of_length_one() -> None:
    cal = read(tp_set())
    scale, rows = np.array(cal["K_a"]), np.array(cal["R_a"])
    assert np.array_equal(scale, np.diag(np.diag(scale)))
    assert np.all(np.diag(scale) > 0.0)
    assert np.linalg.norm(rows, axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize("make", [bent_set, warm])
def test_what_has_no_place_is_bounded_in_the_comment(make: Callable[[], CoefficientSet]) -> None:
    coefficients = make()
    cal = read(coefficients)
    told = re.findall(r"Neglected in ([xyz]): at most (\S+) g", cal["comment"])
    bounds = {axis: float(bound) for axis, bound in told}
    limits = coefficients.validity.temperature_degc or (20.0, 20.0)
    for temperature in limits:
        degrees = np.full(len(FORCES), temperature) if coefficients.needs_temperature else None
        outputs = np.stack([predicted_v(coefficients.axes[axis], FORCES, degrees) for axis in "xyz"], axis=-1)
        rows = np.array(cal["K_a"]) @ np.array(cal["R_a"])
        off = np.abs(outputs - np.array(cal["b_a"]) - GRAVITY_MPS2 * FORCES @ rows.T).max(axis=0)
        lengths = GRAVITY_MPS2 * np.diag(np.array(cal["K_a"]))
        assert all(off[place] / lengths[place] <= bounds[axis] * 1.01 for place, axis in enumerate("xyz"))
    assert min(bounds.values()) > 0.0


@pytest.mark.parametrize("axes", ["x", "xy"])
def test_fewer_than_three_axes_are_refused_with_what_to_do(axes: str) -> None:
    with pytest.raises(SetError, match=r"needed are three accelerometers or three gyros x, y, z.*export c or json"):
        to_imucal(tp_set(axes))


def test_another_number_in_the_file_is_no_longer_the_set() -> None:
    content = to_imucal(tp_set())
    offset = repr(json.loads(content)["b_a"][0]).encode()
    place = content.rindex(MARK)
    plain = content[:place] + CHECKSUM_SLOT + content[place + len(CHECKSUM_SLOT) :]
    forged = with_checksum_inside(plain.replace(b"        " + offset, b"        0.25", 1))
    with pytest.raises(VectorsDisagree, match="file: numbers"):
        from_imucal(forged, "file")
