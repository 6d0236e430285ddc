"""A gimbal of which any axis is beyond its declared limit is named, whatever its curve; one within it is not."""

from collections.abc import Iterator
from functools import partial

import numpy as np
import pytest
from gimbal_campaign import GIMBAL_AXES, Curve, GimbalDesign, Terms, gimbal_limits, on_a_gimbal
from physics_scenes.rotations import ARCSEC
from physics_scenes.tables import eight_harmonics, once_per_turn, white_teeth

from ams.analysis.diagnostics.beliefs import TABLE_LIMIT
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest

TWICE = partial(once_per_turn, times=2)
CURVES = (once_per_turn, TWICE, white_teeth)


def _solved(axes: str | tuple[str, ...], curve, size_arcsec: float, count: int, package: str = "model", seed: int = 1,
            terms: Terms | None = None) -> Iterator[Calibration]:  # fmt: skip
    """``count`` campaigns in which each of the ``axes`` has a curve of its own that is nowhere more than the size."""
    for index in range(count):
        chance = np.random.default_rng([seed, index])
        curves: dict[str, Curve] = {axis: curve(size_arcsec * ARCSEC, 1, chance) for axis in axes}
        rows = on_a_gimbal(chance, GimbalDesign(), curves, terms, is_on_sting=package == "sting")
        yield calibrate(rows, CalibrationRequest(model=f"pitch-yaw-roll-{package}", table=gimbal_limits()))


def _of_table(solved: Calibration) -> list[Finding]:
    """What is told for sure of the table's limit."""
    findings = (finding for axis in solved.axes.values() for finding in axis.findings)
    return [each for each in findings if each.details.get("test") == TABLE_LIMIT and each.is_significant]


def _named(found: Iterator[Calibration]) -> list[str]:
    """Of each campaign that names the table, the axis of the largest error."""
    told = [findings[0].details for solved in found if (findings := _of_table(solved))]
    return [max(GIMBAL_AXES, key=lambda axis, of=of: float(of.get(f"{axis}_arcsec") or 0.0)) for of in told]


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("axis", GIMBAL_AXES)
def test_a_curve_of_five_times_the_limit_is_the_table_s_and_its_axis_is_told(axis: str, curve) -> None:
    named = _named(_solved([axis], curve, 5.0, 8))
    assert len(named) >= 7
    assert set(named) == {axis}


@pytest.mark.parametrize(("axis", "curve"), [("pitch", TWICE), ("pitch", white_teeth), ("yaw", white_teeth)])
def test_it_is_told_by_a_package_that_roll_does_not_reach_and_nothing_of_roll_is(axis: str, curve) -> None:
    found = list(_solved([axis], curve, 6.0, 8, "sting"))
    named = _named(iter(found))
    assert len(named) >= 6
    assert set(named) == {axis}
    assert all("roll_arcsec" not in finding.details for solved in found for finding in _of_table(solved))
    assert not _named(_solved(["roll"], white_teeth, 20.0, 8, "sting"))


@pytest.mark.parametrize("package", ["model", "sting"])
@pytest.mark.parametrize("curve", [*CURVES, eight_harmonics])
def test_curves_of_all_axes_that_reach_their_limit_are_not_named(curve, package: str) -> None:
    assert len(_named(_solved(GIMBAL_AXES, curve, 1.0, 12, package))) <= 1


def test_what_the_table_does_is_not_said_of_the_sensor_as_well() -> None:
    (solved,) = _solved(["yaw"], TWICE, 5.0, 1, seed=3)
    assert solved.verdict != "sound"
    for axis in solved.axes.values():
        (finding,) = [each for each in axis.findings if each.is_significant]
        assert finding.details["test"] == TABLE_LIMIT
        assert "the table is off by more than is declared: its index errors in yaw by " in finding.text
        assert 2.0 < float(finding.details["yaw_arcsec"]) < 8.0  # type: ignore[arg-type]
        assert not any("indices beyond" in remark for remark in axis.remarks)


def _bent(force: np.ndarray) -> np.ndarray:
    """y with a square of 30 µg along itself, z with a cross coupling of 30 µg."""
    zero = np.zeros(len(force))
    return 3e-5 * np.stack([zero, force[:, 1] ** 2, force[:, 0] * force[:, 2]], axis=1)


@pytest.mark.parametrize("package", ["model", "sting"])
def test_a_sensor_is_not_blamed_on_the_gimbal(package: str) -> None:
    found = list(_solved([], once_per_turn, 0.0, 8, package, terms=_bent))
    assert not any(_of_table(solved) for solved in found)
    kinds = {finding.kind for solved in found for finding in solved.axes["y"].findings if finding.is_significant}
    assert "quadratic" in kinds
