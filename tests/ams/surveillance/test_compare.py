"""Compared sets: the remount is taken out as the rotation it was, and what an axis really changed is what is left."""

import numpy as np
import pytest
from changed_sets import changed
from scipy.spatial.transform import Rotation
from solved_sets import package_set, tp_set

from ams.errors import SetError
from ams.sets.coefficients import CoefficientSet, from_document
from ams.surveillance.compare import compare

ARCSEC = np.pi / 180.0 / 3600.0
NOISE_V = 2e-5


def moved(coefficients: CoefficientSet, rotation: Rotation, gain: float = 1.0, offset_v: float = 0.0) -> CoefficientSet:
    """The package remounted; its x axis with another gain and offset. Test vectors are not touched: none is used."""

    def change(document: dict) -> None:
        for name, section in document["axes"].items():
            values = section["primary"]["values"]
            k = rotation.apply([values[f"k_{axis}_v_per_g"] for axis in "xyz"])
            own = gain if name == "x" else 1.0
            values.update({f"k_{axis}_v_per_g": float(part) * own for axis, part in zip("xyz", k, strict=True)})
            values["offset_v"] += offset_v if name == "x" else 0.0

    return from_document(changed(coefficients, change), "moved")


def test_a_remount_is_a_rotation_and_nothing_else() -> None:
    old = tp_set("xyz", NOISE_V, np.random.default_rng(1))
    vector_deg = [0.02, -0.05, 0.03]
    found = compare(old, moved(old, Rotation.from_rotvec(vector_deg, degrees=True)))
    assert [found.rotation_deg[axis].value for axis in "xyz"] == pytest.approx(vector_deg, abs=1e-10)
    for axis in found.axes.values():
        assert abs(axis.sensitivity_relative.value) < 1e-12
        assert axis.offset_v.value == 0.0
        assert all(abs(entry.value) < 1e-6 for entry in axis.direction_arcsec.values())
    assert found.direction_dof == 3


def test_what_an_axis_changed_is_told_of_that_axis() -> None:
    old = tp_set("xyz", NOISE_V, np.random.default_rng(2))
    found = compare(old, moved(old, Rotation.from_rotvec([0.0, 0.1, 0.0], degrees=True), 1.0 + 2e-4, 3e-4))
    assert found.axes["x"].sensitivity_relative.value == pytest.approx(2e-4, rel=1e-9)
    assert found.axes["x"].offset_v.value == pytest.approx(3e-4, rel=1e-9)
    assert found.axes["x"].sensitivity_relative.in_uncertainties > 10.0
    assert abs(found.axes["y"].sensitivity_relative.value) < 1e-12


def test_one_axis_cannot_tell_its_direction_from_a_remount() -> None:
    old = tp_set("x", NOISE_V, np.random.default_rng(3))
    found = compare(old, moved(old, Rotation.from_rotvec([0.0, 0.1, 0.2], degrees=True)))
    assert found.direction_dof == 0
    assert found.direction_p_value is None
    assert found.rotation_deg["x"] is None
    assert found.rotation_deg["z"] is not None
    assert all(abs(entry.value) < 1e-3 for entry in found.axes["x"].direction_arcsec.values())


def test_without_a_change_the_directions_exceed_their_limit_as_often_as_stated() -> None:
    chance = np.random.default_rng(5)
    found = [compare(tp_set("xyz", NOISE_V, chance), tp_set("xyz", NOISE_V, chance)) for _ in range(40)]
    below = sum(entry.direction_p_value < 0.2 for entry in found if entry.direction_p_value is not None)
    assert 1 <= below <= 17, below  # binomial, 40 at 0.2: 0.2 % either side
    ratios = [axis.sensitivity_relative.in_uncertainties for entry in found for axis in entry.axes.values()]
    assert 0.75 < np.sqrt(np.mean(np.square(ratios))) < 1.35
    left = [
        entry.in_uncertainties
        for pair in found
        for axis in pair.axes.values()
        for entry in axis.direction_arcsec.values()
    ]
    assert 0.82 < np.sqrt(np.mean(np.square(left))) < 1.22


def test_another_g_is_no_change_of_the_sensor() -> None:
    old = tp_set("xyz")

    def elsewhere(document: dict) -> None:
        ratio = 9.81 / document["acceleration_unit"]["value_mps2"]
        document["acceleration_unit"]["value_mps2"] = 9.81
        for section in document["axes"].values():
            values = section["primary"]["values"]
            values.update({name: value * ratio for name, value in values.items() if name.startswith("k_")})

    found = compare(old, from_document(changed(old, elsewhere), "elsewhere"))
    assert abs(found.axes["x"].sensitivity_relative.value) < 1e-12
    assert "9.81 m/s²" in found.notes[-1]


def test_sets_of_other_axes_or_conventions_are_refused() -> None:
    with pytest.raises(SetError, match="axes: cannot be compared: got x, the older set has x, y, z; nothing was"):
        compare(tp_set("xyz"), tp_set("x"))
    with pytest.raises(SetError, match="convention: cannot be compared: got CR, the older set has TP"):
        compare(tp_set("xyz"), package_set("sting"))
