"""A remount leaves offsets, sensitivities and angles between axes alone, and is found as the rotation that it was."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from solved_sets import gyro_set, package_set, tp_set

from ams.surveillance.characteristics import PackageNumbers, characteristics_of, numbers_of, rotations_rad
from ams.surveillance.history_points import pack, unpack

CHANCE = np.random.default_rng(4)


def turned(numbers: PackageNumbers, rotation: Rotation) -> PackageNumbers:
    """Every sensitive axis turned alike, as a remount does."""
    primary = numbers.primary.copy()
    primary[0, :, 1:] = rotation.apply(primary[0, :, 1:])
    return replace(numbers, primary=primary)


@pytest.mark.parametrize("axes", ["x", "z", "xy", "xyz"])
def test_characteristics_do_not_see_a_remount_and_the_rotation_is_the_remount(axes: str) -> None:
    numbers = numbers_of(tp_set(axes))
    vector = np.radians([0.3, -0.2, 0.5])
    after = turned(numbers, Rotation.from_rotvec(vector))
    before_value, after_value = characteristics_of(numbers).value, characteristics_of(after).value
    assert np.abs(after_value - before_value).max() < 1e-11
    found = rotations_rad(after.directions, numbers.directions[0])[0]
    if len(axes) > 1:
        assert np.abs(found - vector).max() < 1e-12
    else:  # twist about a single axis does not show: what is found turns the axis all the same
        alike = Rotation.from_rotvec(found).apply(numbers.directions[0])
        assert np.abs(alike - after.directions[0]).max() < 1e-10


def test_names_say_axis_and_unit_and_a_package_has_nine() -> None:
    assert characteristics_of(numbers_of(tp_set())).names == (
        "offset_v.x", "offset_v.y", "offset_v.z",
        "sensitivity_v_per_g.x", "sensitivity_v_per_g.y", "sensitivity_v_per_g.z",
        "angle_deg.xy", "angle_deg.xz", "angle_deg.yz",
    )  # fmt: skip
    assert "sensitivity_v_per_dps.x" in characteristics_of(numbers_of(gyro_set())).names
    assert len(characteristics_of(numbers_of(tp_set("x"))).names) == 2


def test_uncertainties_are_those_of_simulated_calibrations() -> None:
    numbers = numbers_of(tp_set("xyz"))
    root = CHANCE.normal(size=(3, 4, 4)) * 1e-5
    covariance = (root @ np.swapaxes(root, 1, 2))[None]
    numbers = replace(numbers, covariance=covariance, scatter=covariance)
    count = 4000
    noise = np.einsum("aij,naj->nai", root, CHANCE.normal(size=(count, 3, 4)))
    many = np.broadcast_to(covariance, (count, 3, 4, 4))
    simulated = replace(numbers, primary=numbers.primary + noise, covariance=many, scatter=many)
    spread = characteristics_of(simulated).value.std(axis=0)
    assert characteristics_of(numbers).standard_uncertainty[0] == pytest.approx(spread, rel=0.05)


def test_what_every_run_repeats_is_no_scatter_between_runs() -> None:
    numbers = numbers_of(tp_set("xyz", 1e-5, CHANCE))
    assert np.all(np.diagonal(numbers.scatter, axis1=2, axis2=3) <= np.diagonal(numbers.covariance, axis1=2, axis2=3))


@pytest.mark.parametrize("package", ["sting", "model"])
def test_cr_packages_and_packing_keep_every_number(package: str) -> None:
    numbers = numbers_of(package_set(package))
    back = unpack(numbers.axes, [pack(numbers), pack(numbers)], numbers.sensitivity_name)
    for name in ("primary", "covariance", "scatter"):
        assert np.array_equal(getattr(back, name)[1], getattr(numbers, name)[0])
