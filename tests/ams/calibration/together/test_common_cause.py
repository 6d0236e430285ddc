"""What the outputs of a package have in common by its cause is told together where no axis tells it alone."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from physics_scenes import Campaign, campaigns
from solved_campaigns import rows_of, rows_of_package

from ams.analysis.diagnostics.beliefs import AFTER_MOVES, CURVATURE, LEVEL, AxisTests, BeliefTest
from ams.analysis.diagnostics.size_words import Scale
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration.together.common_cause import AxisShown, judge_common_cause
from ams.calibration_result import AxisCalibration
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

NOTHING_MORE: Mapping[str, FloatArray] = MappingProxyType({})
TOGETHER = "told by the axes of the package together"


def _packages(drawn: Campaign, more_v: Mapping[str, FloatArray] = NOTHING_MORE) -> list[list[AxisCalibration]]:
    """Return by axis what every campaign tells of it, its three axes solved as one package."""
    every = [calibrate(rows, CalibrationRequest()).axes for rows in _read(drawn, more_v)]
    return [[package[axis] for package in every] for axis in drawn.setup.axes]


def _alone(drawn: Campaign, more_v: Mapping[str, FloatArray] = NOTHING_MORE) -> list[list[AxisCalibration]]:
    """Return the same, each axis solved by itself at its share of the level."""
    requests = {axis: CalibrationRequest(nominal_axes={axis: axis}, tested_axes=3) for axis in drawn.setup.axes}
    return [
        [calibrate(rows, request).axes[axis] for rows in _read(drawn, more_v)] for axis, request in requests.items()
    ]


def _read(drawn: Campaign, more_v: Mapping[str, FloatArray]) -> Iterator[Observations]:
    for index in range(drawn.campaigns):
        rows = rows_of_package(drawn, index)
        yield replace(rows, outputs={axis: read_v + more_v.get(axis, 0.0) for axis, read_v in rows.outputs.items()})


def _kinds(found: AxisCalibration) -> set[str]:
    return {finding.kind for finding in found.findings if finding.is_significant}


def _told(found: AxisCalibration) -> list[Finding]:
    return [finding for finding in found.findings if finding.is_significant and TOGETHER in finding.fact]


def _naming(of_axes: list[list[AxisCalibration]], kinds: set[str]) -> np.ndarray:
    """Return (axes, campaigns) whether an axis names the cause."""
    return np.array([[bool(_kinds(found) & kinds) for found in axis] for axis in of_axes])


def _named(of_axes: list[list[AxisCalibration]], kinds: set[str]) -> float:
    """Share of the campaigns in which some axis names the cause."""
    return float(np.any(_naming(of_axes, kinds), axis=0).mean())


@pytest.mark.parametrize(
    ("scene", "size", "kinds", "design"),
    [
        ("after-pitch-moves", 3.0, {"drift"}, {}),
        ("k0-asymmetry", 3.0, {"asymmetry", "cubic"}, {"pitch_limit_deg": 30.0}),
    ],
)
def test_three_axes_name_a_common_cause_more_often_than_the_best_of_them(scene, size, kinds, design) -> None:
    """Simulated in 400 and 200 campaigns: 0.39 and 0.62 of them, 0.49 and 0.73."""
    drawn = campaigns(scene, size, np.random.default_rng(3), 40, **design)
    alone, together = _alone(drawn), _packages(drawn)
    assert _named(together, kinds) >= _named(alone, kinds) + 0.1
    for of_axis, singly in zip(together, alone, strict=True):
        for found, by_itself in zip(of_axis, singly, strict=True):
            assert _kinds(by_itself) <= _kinds(found) | {"lack-of-fit"}
            assert all(finding.kind in kinds for finding in _told(found))


def test_what_is_told_together_has_the_size_of_every_axis_and_which_show_it() -> None:
    drawn = campaigns("after-pitch-moves", 3.0, np.random.default_rng(3), 40)
    told = [
        {axis: finding for axis, found in zip("xyz", package, strict=True) for finding in _told(found)}
        for package in zip(*_packages(drawn), strict=True)
    ]
    told = [of_package for of_package in told if of_package]
    assert len(told) >= 5
    for of_package in told:
        (words,) = {finding.fact.split(f"{TOGETHER}: ")[1] for finding in of_package.values()}
        shown, _, others = words.partition("; not shown by ")
        sizes = {size.split()[0]: size for size in f"{shown}, {others}".split(", ") if size}
        assert set(sizes) == set("xyz")
        assert set(of_package) == {size.split()[0] for size in shown.split(", ")}
        assert all(" ± " in size and size.endswith("″") for size in sizes.values())
        for finding in of_package.values():
            assert not finding.is_held  # offset and sensitivities hold it, by itself or together
            assert abs(float(finding.details["size"])) > 1.9 * float(finding.details["standard_uncertainty"])


def test_a_cause_of_one_axis_alone_is_told_of_it_as_often_and_not_of_the_others() -> None:
    drawn = campaigns("clean", 0.0, np.random.default_rng(8), 30)
    rows = rows_of(drawn)
    force = specific_force(rows.pitch_rad, rows.roll_rad)[:, 0]
    asymmetry = {"x": 0.5 * 2.5 * 6e-6 * np.sign(np.round(force, 9))}
    kinds = {"asymmetry", "cubic"}
    alone, together = _alone(drawn, asymmetry), _packages(drawn, asymmetry)
    singly, jointly = _naming(alone, kinds), _naming(together, kinds)
    assert 0.3 < singly[0].mean() < 0.95
    assert np.all(singly[0] <= jointly[0])
    assert np.mean(jointly[1:] & ~singly[1:]) <= 0.025


def _shown(p_values: dict[str, float], *, significant: bool = False, level: float = LEVEL / 3.0) -> AxisShown:
    tests = {
        name: BeliefTest(name, "drift", p_value, 1.0, 0.3, dof=100.0) for name, p_value in p_values.items()
    }  # fmt: skip
    flags = {name: significant and name == AFTER_MOVES for name in tests}
    return AxisShown("x", AxisTests(tests, flags, level=level), Scale("V", None))


def test_chances_that_mean_nothing_ring_together_as_seldom_as_a_test_does() -> None:
    """χ² of three independent chances, each even between 0 and 1: 38 tests share the level of three axes."""
    chance, runs = np.random.default_rng(1), 6_000
    rings = 0
    for p_values in chance.random((runs, 3)):
        rings += any(judge_common_cause([_shown({AFTER_MOVES: p_value}, level=4.0 * LEVEL) for p_value in p_values]))
    bound = 3.0 * 4.0 * LEVEL / 38.0
    assert rings / runs == pytest.approx(bound, abs=4.0 * np.sqrt(bound / runs))


def test_two_numbers_of_each_axis_are_joined_as_two() -> None:
    """Fisher's −2 Σ ln p: 2 × 11.5 of four degrees of freedom is a chance of 1.3e-4."""
    shown = judge_common_cause([_shown({CURVATURE: 10.0**-2.5})] * 2)
    assert shown[0] is not None
    assert shown[0].p_value == pytest.approx(1e-5 * (1.0 + 5.0 * np.log(10.0)), rel=1e-6)


@pytest.mark.parametrize(
    ("more", "is_significant"),
    [({}, True), ({"drift of offset": 1e-9}, False), ({"autocorrelation": 1e-9}, False), ({"K2": 1e-12}, False)],
)
def test_nothing_is_joined_that_one_axis_tells_or_that_unsteady_dwells_may_be(more, is_significant: bool) -> None:
    """Nor what another of the columns that the points are tested for explains better."""
    p_values = {AFTER_MOVES: 1e-3, "K2": 0.5}
    package = [_shown(p_values), _shown(p_values), _shown(p_values | more, significant=is_significant)]
    assert not any(judge_common_cause(package))
    assert all(judge_common_cause([_shown(p_values)] * 3))


def test_one_axis_alone_has_nothing_in_common() -> None:
    assert judge_common_cause([_shown({AFTER_MOVES: 1e-3})]) == [None]


def test_a_solved_run_says_what_its_axes_show_together() -> None:
    drawn = campaigns("after-pitch-moves", 3.0, np.random.default_rng(1), 20)
    said = 0
    for index in range(20):
        solution = calibrate(rows_of_package(drawn, index), CalibrationRequest())
        said += any(TOGETHER in warning for axis in solution.axes.values() for warning in axis.warnings)
    assert said >= 2
