"""Index errors of a table as columns: their covariance written out, and what a zero and a list of errors change."""

import numpy as np
import pytest

from ams.errors import ObservationsError
from ams.inputs.table_uncertainty import (
    IndexErrors,
    TableUncertainty,
    corrected,
    index_columns,
    known_errors,
    shown_rad,
)
from ams.observations import Observations

ARCSEC = np.pi / 180.0 / 3600.0
ANGLES = np.deg2rad([-180.0, -90.0, -33.0, 0.0, 10.0, 90.0, 170.0, 180.0])


def covariance(errors: IndexErrors, angle_rad=ANGLES, limit: float = 1.0) -> np.ndarray:
    table = TableUncertainty(limit, 0.0, "limit", errors={"pitch": errors})
    columns = table.index_errors("pitch", angle_rad).scaled_rad
    return columns @ columns.T


def written_out(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """MATH: 0.81 (0.30 δ + 0.35 cos(a − a′) + 0.35 cos 2(a − a′)) for a limit of one."""
    apart = a[:, None] - b
    same = np.abs(np.sin(apart / 2.0)) < 1e-9
    return 0.81 * (0.30 * same + 0.35 * np.cos(apart) + 0.35 * np.cos(2.0 * apart))


def test_a_limit_is_rectangular_and_an_expanded_uncertainty_is_divided_by_its_factor() -> None:
    """A limit of 1″ is a standard uncertainty of 0.577″."""
    assert TableUncertainty(1.0, 2.0, "limit").standard_rad() == pytest.approx(
        {"pitch": 0.57735, "roll": 1.1547, "yaw": 0.0}, rel=1e-5
    )
    assert TableUncertainty(1.0, 1.5, "expanded", 3.0).standard_rad() == pytest.approx(
        {"pitch": 1 / 3, "roll": 0.5, "yaw": 0.0}
    )


def test_independent_indices_share_one_error_each_and_half_turns_are_one_index() -> None:
    pitch, roll = np.deg2rad([0.0, 0.0, 10.0, 10.0]), np.deg2rad([-180.0, 90.0, 180.0, 90.0])
    slopes = {"pitch": np.array([1.0, 2.0, 3.0, 4.0]), "roll": np.array([5.0, 6.0, 7.0, 8.0])}
    independent = dict.fromkeys(("pitch", "roll"), IndexErrors("independent"))
    columns = index_columns(TableUncertainty(0.1, 0.2, errors=independent), {"pitch": pitch, "roll": roll}, slopes)
    expected = 0.01 * np.outer(slopes["pitch"], slopes["pitch"]) * np.equal.outer([0, 0, 1, 1], [0, 0, 1, 1])
    expected = expected + 0.04 * np.outer(slopes["roll"], slopes["roll"]) * np.equal.outer([0, 1, 0, 1], [0, 1, 0, 1])
    np.testing.assert_allclose(columns @ columns.T, expected, rtol=1e-12, atol=1e-15)


def test_an_undeclared_shape_has_teeth_and_waves_once_and_twice_a_turn() -> None:
    np.testing.assert_allclose(covariance(IndexErrors()), written_out(ANGLES, ANGLES), atol=1e-12)


def test_an_axis_set_to_zero_has_the_differences_and_the_uncertainty_of_setting() -> None:
    """Var(E(a) − E(a₀) + z) from the covariance written out, at an index in use and at one that is not."""
    for zero_deg in (0.0, 5.0):
        zero = np.deg2rad([zero_deg])
        expected = (
            written_out(ANGLES, ANGLES)
            - written_out(ANGLES, zero)
            - written_out(zero, ANGLES)
            + written_out(zero, zero)
        )
        found = covariance(IndexErrors(zero_rad=float(zero[0]), zero_standard_uncertainty_rad=0.2))
        np.testing.assert_allclose(found, expected + 0.04, atol=1e-12)


def test_a_smooth_curve_has_no_error_of_a_tooth_alone() -> None:
    near = covariance(IndexErrors("smooth"), np.deg2rad([20.0, 20.1]))
    assert near[0, 1] / near[0, 0] > 0.999
    assert near[0, 0] == pytest.approx(0.81)


LIST = known_errors(np.arange(-180.0, 180.0, 30.0), np.sin(np.deg2rad(np.arange(-180.0, 180.0, 30.0))), [0.1] * 12)


def test_a_listed_error_is_put_on_the_angles_by_interpolation_round_the_turn() -> None:
    """At 165° half-way between the rows of 150° (0.5″) and −180° (0″)."""
    table = TableUncertainty(ARCSEC, ARCSEC, "limit", errors={"pitch": IndexErrors(known=LIST)})
    shown = np.deg2rad([30.0, 165.0, -180.0, 180.0, 10.0])
    rows = Observations(np.zeros(5, dtype=int), np.arange(5), shown, shown, {})
    moved = corrected(rows, table)
    expected = ARCSEC * np.array([0.5, 0.25, 0.0, 0.0, 0.5 / 3.0])
    np.testing.assert_allclose(moved.pitch_rad - shown, expected, atol=1e-15)
    np.testing.assert_array_equal(moved.roll_rad, shown)
    np.testing.assert_allclose(shown_rad(table, {"pitch": moved.pitch_rad})["pitch"], shown, atol=1e-10)
    zeroed = TableUncertainty(ARCSEC, 0.0, "limit", errors={"pitch": IndexErrors(zero_rad=np.deg2rad(30), known=LIST)})
    np.testing.assert_allclose(corrected(rows, zeroed).pitch_rad - shown, expected - 0.5 * ARCSEC, atol=1e-15)


def test_at_a_listed_angle_only_the_list_is_uncertain_and_between_them_the_curve_as_well() -> None:
    """At a row of the list 0.9 √3 × its standard uncertainty; half-way the teeth of three indices come back."""
    found = np.diag(covariance(IndexErrors(known=LIST), np.deg2rad([30.0, 45.0]), limit=ARCSEC)) / ARCSEC**2
    assert found[0] == pytest.approx(0.81 * 3.0 * 0.1**2, rel=1e-9)
    assert found[1] > 0.81 * 0.30 * 1.5


def test_between_the_angles_of_a_list_a_smooth_curve_leaves_little() -> None:
    """Eight times a turn bends by 1 − cos 40° = 0.23 of itself between angles that are 10° apart."""
    every_ten = known_errors(np.arange(-180.0, 180.0, 10.0), np.zeros(36), np.zeros(36))
    found = np.diag(covariance(IndexErrors("smooth", known=every_ten), np.deg2rad([45.0]), limit=1.0))
    assert found[0] < 0.81 * 0.05 * 4 * 0.23**2


def test_an_axis_without_uncertainty_has_no_columns() -> None:
    angle = {"pitch": np.zeros(3), "roll": np.zeros(3)}
    assert index_columns(TableUncertainty(0.0, 0.0), angle, angle).shape == (3, 0)


def test_a_shape_that_is_none_is_refused_in_words() -> None:
    with pytest.raises(
        ObservationsError, match=r"index errors of pitch: got 'rough', allowed unknown, independent, sm"
    ):
        TableUncertainty(1.0, 1.0, errors={"pitch": IndexErrors("rough")})  # type: ignore[arg-type]
