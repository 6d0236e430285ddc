"""Three lines of a magnetometer against the one field that they were solved in."""

from collections.abc import Mapping

import numpy as np
import pytest
from physics_scenes import FieldReadings, campaigns

from ams.analysis.diagnostics.declared.declared_field import FieldAxis, FieldTest, field_finding, judge_field
from ams.arrays import FloatArray
from ams.solve.layout import Layout

COIL = np.array([0.0, 0.0, 1.0])
EARTH_UT = np.array([22.0, -9.0, 40.0])
LEVEL = 0.05


def _layout(replications: int, points: int) -> Layout:
    replication, point = np.repeat(np.arange(replications), points), np.tile(np.arange(points), replications)
    return Layout(replication, point, tuple(range(replications)), tuple(range(points)))


def _judged(
    drawn: FieldReadings,
    index: int,
    *,
    declared_ut: FloatArray | None = None,
    errors_ut: FloatArray | None = None,
    is_declared: bool = True,
    added: Mapping[str, FloatArray] | None = None,
) -> FieldTest:
    """Return what the axes of a campaign say of a field that is declared; ``errors_ut`` (3, q) of what stands there."""
    replications, positions, levels, _ = drawn.counts.shape[1:]
    turned = np.tile(np.repeat(drawn.to_package, levels, axis=0), (replications, 1, 1))
    applied = np.tile(drawn.nominal_coil_ut[:, 2], replications * positions)
    beside = drawn.nominal_earth_ut if declared_ut is None else declared_ut
    readings = drawn.counts[index].reshape(-1, 3)
    axes = {
        axis: FieldAxis(
            readings[:, which] + (0.0 if added is None else added.get(axis, 0.0)),
            beside,
            {} if errors_ut is None else {"surroundings": turned[:, which] @ errors_ut},
        )
        for which, axis in enumerate("xyz")
    }
    found = judge_field(turned, COIL, applied, axes, _layout(replications, positions * levels), is_declared=is_declared)
    assert found is not None
    return found


def _drawn(name: str, size: float, count: int, **design: object) -> FieldReadings:
    return campaigns(name, size, np.random.default_rng(3), count, **design)


def test_what_stands_there_beyond_the_declaration_is_found_in_its_own_direction() -> None:
    drawn = _drawn("field-undeclared", 0.0, 1, noise_counts=1e-6)
    iron_ut = np.array([0.4, -0.2, 0.3])
    found = _judged(drawn, 0, declared_ut=drawn.nominal_earth_ut - iron_ut)
    assert found.p_value < 1e-12
    np.testing.assert_allclose(found.beside, iron_ut, atol=0.01)
    assert np.degrees(found.coil_rad) < 0.01


def test_a_coil_that_stands_off_its_direction_is_found_by_its_angle() -> None:
    drawn = _drawn("field-coil-direction", 0.5, 20, noise_counts=1e-6)
    found = [_judged(drawn, index) for index in range(20)]
    assert max(test.p_value for test in found) < 1e-12
    np.testing.assert_allclose(np.degrees([test.coil_rad for test in found]), 0.5, rtol=0.03)


@pytest.mark.parametrize("is_declared", [True, False])
def test_axes_that_agree_ring_at_the_level_and_no_more(is_declared: bool) -> None:
    drawn = _drawn("field-undeclared", 0.0, 400)
    p_values = np.array([_judged(drawn, index, is_declared=is_declared).p_value for index in range(400)])
    assert 0.01 < np.mean(p_values < LEVEL) < 0.09  # 0.05 less what the larger of two scatters takes; ± 0.03
    assert np.mean(p_values < 0.5) == pytest.approx(0.5, abs=0.12)


def test_what_the_declaration_allows_is_no_contradiction() -> None:
    drawn = _drawn("field-undeclared", 1.0, 50)
    bare = [_judged(drawn, index).p_value for index in range(50)]
    allowed = [_judged(drawn, index, errors_ut=0.5 * np.eye(3)).p_value for index in range(50)]
    assert max(bare) < 1e-6
    assert min(allowed) > LEVEL


def test_a_field_that_one_axis_alone_saw_is_told_by_that_axis_where_the_surroundings_are_solved() -> None:
    """A lift stood above the laboratory while z was up and down: 0.5 µT more along the coil by z than by x and y."""
    drawn = _drawn("field-undeclared", 0.0, 1)
    replications, _, levels, _ = drawn.counts.shape[1:]
    along = np.tile(np.repeat(drawn.to_package[:, 2, 2], levels), replications)
    quiet = _judged(drawn, 0, is_declared=False)
    found = _judged(drawn, 0, is_declared=False, added={"z": 0.5 * drawn.matrix_counts_per_ut[0, 2, 2] * along})
    assert quiet.p_value > LEVEL
    assert found.p_value < 1e-6
    by = dict(found.along)
    assert by["z"] - 0.5 * (by["x"] + by["y"]) == pytest.approx(0.5, abs=0.05)
    told = field_finding(found, LEVEL, "µT")
    assert told.is_significant
    assert told.kind == "field-contradicted"
    assert "by z" in told.text


def test_two_readings_of_each_axis_are_too_few_to_judge() -> None:
    turned, applied = np.stack([np.eye(3)] * 4), np.array([0.0, 40.0, 0.0, 40.0])
    axes = {axis: FieldAxis(np.arange(4.0), EARTH_UT, {}) for axis in "xyz"}
    assert judge_field(turned, COIL, applied, axes, _layout(2, 2), is_declared=True) is None
