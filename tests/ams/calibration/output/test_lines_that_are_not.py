"""A line whose readings stand at a rail, or that is not straight, is not usable; coarse counts are neither."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.models.straight_line import StraightLine
from ams.observations import Observations

SPAN_UT, COUNTS_PER_UT, NOISE_COUNTS = 100.0, 10.0, 0.3


def read_levels(levels: int, replications: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the levels of every row, and what a straight sensor reads there."""
    chance = np.random.default_rng(seed)
    level = np.tile(np.linspace(-SPAN_UT, SPAN_UT, levels), replications)
    return level, 12.0 + COUNTS_PER_UT * level + NOISE_COUNTS * chance.standard_normal(level.size)


def solved(level: np.ndarray, read: np.ndarray) -> Calibration:
    _, point = np.unique(level, return_inverse=True)
    replications = level.size // (int(point.max()) + 1)
    rows = Observations(
        replication=np.repeat(np.arange(1, replications + 1), level.size // replications),
        point=point + 1,
        pitch_rad=np.zeros(level.size),
        roll_rad=np.zeros(level.size),
        outputs={"x": read},
        reference_level=level,
        step=np.arange(1, level.size + 1),
        units={"x": "counts"},
    )
    return calibrate(rows, CalibrationRequest(models={"x": StraightLine("x", "ut", "counts")}, tested_axes=1))


def found(calibration: Calibration, kind: str) -> list[Finding]:
    return [one for one in calibration.axes["x"].findings if one.kind == kind and one.is_significant]


@pytest.mark.parametrize("levels", [3, 5, 9])
@pytest.mark.parametrize("replications", [3, 4])
@pytest.mark.parametrize("share", [0.002, 0.1])
@pytest.mark.parametrize("sides", [1, 2])
def test_a_rail_at_the_outer_levels_is_told(levels: int, replications: int, share: float, sides: int) -> None:
    level, read = read_levels(levels, replications, 3)
    high = read[level == SPAN_UT].min() - share * COUNTS_PER_UT * SPAN_UT
    low = -high if sides == 2 else -np.inf
    is_cut = (read >= high) | (read <= low)
    calibration = solved(level, np.clip(read, low, high))
    (clipped,) = found(calibration, "output-clipped")
    assert set(clipped.steps) == set((np.flatnonzero(is_cut) + 1).tolist())
    assert f"level {SPAN_UT:g}" in clipped.text
    assert "pitch" not in clipped.text
    assert calibration.verdict == "not usable"


@pytest.mark.parametrize("step_counts", [0.0, 0.1, 0.5, 1.0, 5.0])
@pytest.mark.parametrize("levels", [3, 5])
def test_neither_noise_nor_coarse_counts_are_a_rail_or_no_line(levels: int, step_counts: float) -> None:
    for seed in range(15):
        level, read = read_levels(levels, 4, seed)
        calibration = solved(level, np.rint(read / step_counts) * step_counts if step_counts else read)
        assert not found(calibration, "output-clipped")
        assert all(lack.is_held for lack in found(calibration, "lack-of-fit"))


@pytest.mark.parametrize(("part", "is_held"), [(0.003, True), (0.05, False)])
@pytest.mark.parametrize("replications", [1, 4])
def test_a_sensor_that_bends_is_no_straight_line(part: float, replications: int, *, is_held: bool) -> None:
    """Its reading departs at the outer levels by a part of what it reads there, with the cube of the level."""
    level, read = read_levels(7, replications, 5)
    bent = solved(level, read + part * COUNTS_PER_UT * SPAN_UT * (level / SPAN_UT) ** 3)
    lacks = found(bent, "lack-of-fit")
    assert all(lack.is_held is is_held for lack in lacks)
    if replications > 1 or not is_held:
        assert lacks
    assert not any("table" in lack.text for lack in lacks)
    assert (bent.verdict == "not usable") is not is_held


def test_a_level_that_was_written_down_wrongly_leaves_no_line_to_use() -> None:
    level, read = read_levels(5, 4, 6)
    assert solved(np.where(level == SPAN_UT / 2.0, SPAN_UT / 20.0, level), read).verdict == "not usable"
