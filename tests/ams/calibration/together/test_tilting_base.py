"""A base that tilts while it is measured, and comes back before its level is read again, is told and counted.

Readings are made here from gravity that is turned in the laboratory and seen from a package on a table of pitch and
roll: three axes at 2.5 V/g, 1.65″ a dwell, thirteen pitch angles by twelve roll angles, there and back, 30 s a dwell.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from ams.analysis.calibration_budget import axis_budget
from ams.analysis.diagnostics.beliefs import LEVEL
from ams.analysis.diagnostics.facts import CONTAINED
from ams.calibration.calibrate import calibrate
from ams.calibration.together.tilting_base import BASE_TILT
from ams.calibration_result import AxisCalibration, Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.observations import Observations
from ams.statistics.intervals import t_quantile

FloatArray = NDArray[np.float64]
ARCSEC = np.pi / 180.0 / 3600.0
V_PER_G, OFFSET_V = 2.5, 0.005
REPLICATIONS = 6
ROLLS = np.arange(-180.0, 180.0, 30.0)
PITCHES = (*range(-90, 91, 30), *range(75, -90, -30))
GRID = np.deg2rad([(p, r) for i, p in enumerate(PITCHES) for r in (ROLLS if i % 2 == 0 else ROLLS[::-1])])
TUMBLE_DEG = np.array([(90.0, 0.0), (-90.0, 0.0), *((0.0, roll) for roll in range(0, 360, 45))])
ALONG, ACROSS = 0.0, np.pi / 2.0
LEVEL_OF_BASE = (
    SharedError("level of the base about pitch", "pitch", 0.1 * ARCSEC / 3.0**0.5, "limit"),
    SharedError("level of the base about roll", "base-tilt", 0.1 * ARCSEC / 3.0**0.5, "limit"),
)
Tilt = Callable[[FloatArray], FloatArray]
"""(N,) parts of the run that are over to (N, 2) tilts about the pitch and the forward axis, arc seconds."""


def still(part: FloatArray) -> FloatArray:
    return np.zeros((part.size, 2))


def there_and_back(arcsec: float, heading: float) -> Tilt:
    """Return a tilt that is nothing at the beginning and at the end."""
    return lambda part: np.outer(arcsec * np.sin(np.pi * part), [np.cos(heading), np.sin(heading)])


def felt(pitch: FloatArray, roll: FloatArray, tilt_rad: FloatArray) -> FloatArray:
    """Return (N, 3) the specific force in package axes: that of the laboratory, pitched and rolled."""
    up = np.column_stack([tilt_rad, -np.ones(pitch.size)])
    x, y, z = (up / np.linalg.norm(up, axis=1)[:, None]).T
    forward, down = np.cos(pitch) * x - np.sin(pitch) * z, np.sin(pitch) * x + np.cos(pitch) * z
    return np.stack([forward, np.cos(roll) * y + np.sin(roll) * down, np.cos(roll) * down - np.sin(roll) * y], axis=1)


def observed(
    tilt: Tilt,
    seed: int,
    mount: FloatArray | None = None,
    drift: FloatArray | None = None,
    outputs: str = "xyz",
    points: FloatArray = GRID,
) -> Observations:
    """``mount``: (n, 3) small turns of the package on its mount; ``drift``: (3,) volts at the middle of the run.

    ``points``: (K, 2) pitch and roll.
    """
    chance, point = np.random.default_rng(seed), np.tile(np.arange(len(points)), REPLICATIONS)
    pitch, roll = points[point].T
    part, replication = np.linspace(0.0, 1.0, point.size), np.repeat(np.arange(REPLICATIONS), len(points))
    force = felt(pitch, roll, tilt(part) * ARCSEC)
    if mount is not None:
        force = force - np.cross(mount[replication], force)
    k = V_PER_G * (np.eye(3) + 0.005 * chance.standard_normal((3, 3)))
    read = force @ k.T + OFFSET_V + 1.65 * ARCSEC * V_PER_G * chance.standard_normal(force.shape)
    if drift is not None:
        read += np.outer(np.sin(np.pi * part), drift)
    columns = {name: read[:, "xyz".index(name)] for name in outputs}
    return Observations(replication + 1, point + 1, pitch, roll, columns, time_s=30.0 * np.arange(point.size))


def solved(rows: Observations, *, counts_tilts: bool = True) -> Calibration:
    shared = dict.fromkeys(rows.outputs, LEVEL_OF_BASE)
    return calibrate(rows, CalibrationRequest(shared_errors=shared, counts_tilts=counts_tilts))


def tilts_told(found: Calibration) -> list[Finding]:
    return [
        finding
        for axis in found.axes.values()
        for finding in axis.findings
        if finding.is_significant and finding.details.get("test") == BASE_TILT
    ]


def parts_counted(axis: AxisCalibration) -> list[str]:
    return [part.name for part in axis.variance_components if part.name.startswith(BASE_TILT)]


def is_held(axis: AxisCalibration) -> bool:
    u, dof = float(np.sqrt(axis.primary_covariance[0, 0])), float(axis.primary_dof[0])
    return abs(float(axis.primary[0]) - OFFSET_V) <= float(t_quantile(0.95, dof)) * u


@pytest.mark.parametrize("heading", [ALONG, ACROSS, 0.7])
def test_a_base_that_comes_back_before_its_level_is_read_is_told_by_all_outputs(heading: float) -> None:
    found = solved(observed(there_and_back(3.5, heading), 1))
    findings = tilts_told(found)
    assert len(findings) == 3
    assert {finding.kind for finding in findings} == {"table-rotation"}
    assert all(finding.is_held for finding in findings)
    for axis in found.axes.values():
        assert parts_counted(axis)
        assert is_held(axis)
    turned = [float(findings[0].details[f"about_{axis}_arcsec"] or 0.0) for axis in ("pitch", "forward_axis")]
    mean_of_first, mean_of_third = 0.256, 0.955  # of a half sine, over a sixth of it each
    expected = 3.5 * (mean_of_third - mean_of_first) * np.abs([np.cos(heading), np.sin(heading)])
    np.testing.assert_allclose(turned, expected, atol=1.0)


def test_the_budget_says_of_a_tilt_what_was_counted_and_by_whom() -> None:
    """And the Monte Carlo check draws it as the limit that it is: a rectangle beside which Student's t is wide."""
    found = solved(observed(there_and_back(6.0, ALONG), 1))
    axis = found.axes["x"]
    lines = {line.source: line for line in axis_budget(axis, LEVEL_OF_BASE).lines if line.source.startswith(BASE_TILT)}
    (finding, *_) = tilts_told(found)
    about = {"about pitch": "about_pitch_arcsec", "about roll": "about_forward_axis_arcsec"}
    assert {name.removeprefix(f"{BASE_TILT}, ") for name in lines} <= set(about)
    assert lines
    for name, line in lines.items():
        size = float(finding.details[about[name.removeprefix(f"{BASE_TILT}, ")]] or 0.0)
        assert line.stated.startswith(f"limit {size:.3g}″, shown by the calibration's own rows")
    part = next(part for part in axis.variance_components if part.name.startswith(BASE_TILT))
    alone = replace(axis, variance_components=(part,))
    checked = axis_budget(alone, LEVEL_OF_BASE, trials=20_000, seed=1).monte_carlo
    assert checked is not None
    offset = checked.parameters["offset_v"]
    half = 0.5 * (offset.interval_95[1] - offset.interval_95[0])
    assert half == pytest.approx(0.95 * 3.0**0.5 * offset.standard_uncertainty, rel=0.02)


def test_of_a_tilt_one_story_is_told() -> None:
    """Offset and angles that change with the tilt are not said to be contained, where of the tilt not all is."""
    found = solved(observed(there_and_back(3.5, 0.7), 1))
    changes = [
        finding.text for axis in found.axes.values() for finding in axis.findings
        if finding.is_significant and "changed from replication to replication" in finding.fact
    ]  # fmt: skip
    assert changes
    assert all(text.endswith("what of it the stated uncertainties hold is said of the tilt") for text in changes)
    still_base = solved(observed(still, 1, drift=np.array([20e-6, 0.0, 0.0])))
    of_offset = [finding for finding in still_base.axes["x"].findings if finding.fact.startswith("offset changed")]
    assert of_offset
    assert CONTAINED in of_offset[0].text


def test_offsets_hold_a_tilt_whatever_its_size() -> None:
    """Without the tilt counted, x misses in half of them: its mean passes for cos α, hence for an offset."""
    sizes, seeds = (2.0, 3.0, 6.0), range(4)
    every = [solved(observed(there_and_back(size, ALONG), seed)) for size in sizes for seed in seeds]
    held = [is_held(found.axes["x"]) or found.verdict == "not usable" for found in every]
    assert sum(held) >= len(held) - 1


def test_a_tilt_beyond_three_arc_seconds_leaves_nothing_usable() -> None:
    found = solved(observed(there_and_back(10.0, 0.7), 2))
    assert tilts_told(found)
    assert found.verdict == "not usable"


def test_a_tilt_that_nothing_counts_is_beyond_the_stated_uncertainties() -> None:
    found = solved(observed(there_and_back(3.0, ALONG), 1), counts_tilts=False)
    finding = tilts_told(found)[0]
    assert not finding.is_held
    assert "not in the stated uncertainties" in finding.fact
    assert not parts_counted(found.axes["x"])
    assert found.verdict == "not usable"


@pytest.mark.parametrize("campaigns", [12, pytest.param(600, marks=pytest.mark.thorough)])
def test_a_base_that_stands_still_is_told_as_rarely_as_any_test_allows(campaigns: int) -> None:
    every = [solved(observed(still, seed)) for seed in range(campaigns)]
    counted = sum(bool(parts_counted(found.axes["x"])) for found in every)
    assert sum(bool(tilts_told(found)) for found in every) <= 1 + LEVEL * campaigns / 10
    assert counted <= 2 + 0.13 * campaigns


def test_a_package_that_is_mounted_anew_for_every_replication_is_no_tilt_of_the_base() -> None:
    for seed in range(4):
        mount = 20.0 * ARCSEC * np.random.default_rng(seed).standard_normal((REPLICATIONS, 3))
        found = solved(observed(still, seed, mount=mount))
        assert not tilts_told(found)


@pytest.mark.parametrize("drift", [(20.0, 0.0, 0.0), (0.0, -20.0, 0.0), (5.0, 12.0, -20.0)])
def test_sensors_that_drift_each_for_itself_are_no_tilt_of_the_base(drift: Sequence[float]) -> None:
    for seed in range(3):
        found = solved(observed(still, seed, drift=np.array(drift) * ARCSEC * V_PER_G))
        assert not tilts_told(found)


@pytest.mark.parametrize("output", ["y", "z"])
def test_one_output_that_reads_as_if_it_were_tilted_proves_no_tilt(output: str) -> None:
    rows, tilted = observed(still, 6), observed(there_and_back(6.0, 0.7), 6)
    mixed = {name: (tilted if name == output else rows).outputs[name] for name in "xyz"}
    found = solved(Observations(rows.replication, rows.point, rows.pitch_rad, rows.roll_rad, mixed, time_s=rows.time_s))
    assert not tilts_told(found)
    assert not parts_counted(found.axes["x"])


def test_two_axes_show_it_and_one_alone_cannot() -> None:
    two = solved(observed(there_and_back(6.0, 0.7), 3, outputs="yz"))
    assert tilts_told(two)
    for name in "xyz":
        lone = solved(observed(there_and_back(6.0, 0.7), 3, outputs=name))
        assert not tilts_told(lone)
        assert not parts_counted(lone.axes[name])


def test_a_tilt_that_two_outputs_absorb_is_not_read_off_the_scatter_of_the_attitudes() -> None:
    """Two outputs of a tumble see no tilt about pitch: 0.02° of scatter of its attitudes made 1000″ of their noise."""
    for seed in range(40):
        stood = np.deg2rad(TUMBLE_DEG + 0.02 * np.random.default_rng(seed).standard_normal(TUMBLE_DEG.shape))
        found = solved(observed(still, 100 + seed, outputs="yz", points=stood))
        assert not parts_counted(found.axes["y"])
        assert not parts_counted(found.axes["z"])


def test_rows_that_are_missing_or_far_off_hide_no_tilt() -> None:
    rows = observed(there_and_back(6.0, ALONG), 4)
    kept = np.random.default_rng(5).random(rows.rows) > 0.03
    outputs = {name: values.copy() for name, values in rows.outputs.items()}
    outputs["y"][300] += 0.01
    fewer = Observations(
        rows.replication[kept], rows.point[kept], rows.pitch_rad[kept], rows.roll_rad[kept],
        {name: values[kept] for name, values in outputs.items()}, time_s=30.0 * np.flatnonzero(kept),
    )  # fmt: skip
    assert tilts_told(solved(fewer))
