"""Intervals hold whatever a table's index errors look like inside their limit: scenes by somebody else, fixed seeds."""

from dataclasses import replace

import numpy as np
import pytest
from case_shares import rest_to_thorough
from physics_scenes import campaigns
from solved_campaigns import ARCSEC, Coverage, coverage, solved, table_of

from ams.inputs.table_uncertainty import IndexErrors, TableUncertainty, known_errors

CURVES = ("once", "twice", "harmonics", "teeth")


def covered(scene: str, pitch_limit_deg: float, table: TableUncertainty, count: int, seed: int = 1) -> Coverage:
    drawn = campaigns(scene, 1.0, np.random.default_rng(seed), count, pitch_limit_deg=pitch_limit_deg, replications=4)
    return coverage(drawn, solved(drawn, table, extended=False), np.random.default_rng(seed + 1))


@pytest.mark.parametrize(("curve", "pitch_limit_deg"), rest_to_thorough(CURVES, [10.0, 90.0], every=3))
def test_an_undeclared_shape_covers_every_curve_at_its_limit(curve: str, pitch_limit_deg: float) -> None:
    """300 axes: 0.93 less the scatter of a share of 0.95, 1.3 %."""
    assert covered(f"table-{curve}", pitch_limit_deg, table_of(), 100).least >= 0.92


@pytest.mark.parametrize("curve", ["once", "teeth"])
def test_an_axis_set_to_zero_is_covered_too(curve: str) -> None:
    assert covered(f"table-{curve}-zeroed", 30.0, table_of(zero_rad=0.0), 100).least >= 0.92


def test_a_smooth_table_declared_as_teeth_is_not_covered() -> None:
    """What the declaration says is believed: the reason why teeth are no default."""
    assert covered("table-once", 30.0, table_of(shape="independent"), 60).prediction < 0.8


@pytest.mark.soak
@pytest.mark.parametrize("pitch_limit_deg", [10.0, 30.0, 60.0, 90.0])
@pytest.mark.parametrize("is_zeroed", [False, True])
@pytest.mark.parametrize("curve", [*CURVES, "worm", "smooth-and-teeth"])
def test_every_curve_is_covered_in_a_long_run(curve: str, is_zeroed: bool, pitch_limit_deg: float) -> None:
    scene = f"table-{curve}" + ("-zeroed" if is_zeroed else "")
    found = covered(scene, pitch_limit_deg, table_of(zero_rad=0.0 if is_zeroed else None), 1000)
    assert found.least >= 0.93


@pytest.mark.soak
@pytest.mark.parametrize("pitch_limit_deg", [10.0, 30.0, 60.0, 90.0])
@pytest.mark.parametrize("curve", ["once", "twice", "harmonics"])
def test_a_smooth_curve_declared_smooth_is_covered(curve: str, pitch_limit_deg: float) -> None:
    assert covered(f"table-{curve}", pitch_limit_deg, table_of(shape="smooth"), 1000).least >= 0.93


@pytest.mark.parametrize("pitch_limit_deg", [10.0, 30.0, 60.0, 90.0])
@pytest.mark.parametrize(("zero_rad", "most"), [(None, 1.5), (0.0, 2.1)])
def test_intervals_are_not_wide_against_those_of_a_curve_once_a_turn(
    pitch_limit_deg: float, zero_rad: float | None, most: float
) -> None:
    """Against the covariance (limit/√2)² cos(a − a′) alone, by generalised least squares written out with one noise."""
    pitch, roll = np.meshgrid(
        np.deg2rad(np.linspace(-pitch_limit_deg, pitch_limit_deg, 13)), np.deg2rad(np.arange(-180.0, 180.0, 30.0))
    )
    pitch, roll = pitch.ravel(), roll.ravel()
    declared, once = (half_width_arcsec(pitch, roll, kind, zero_rad) for kind in ("unknown", "once"))
    assert declared <= most * once


def half_width_arcsec(pitch: np.ndarray, roll: np.ndarray, kind: str, zero_rad: float | None) -> float:
    """Mean half-width of an x axis' predictions over the range: 1.65″ a dwell, six replications."""
    basis = with_one(pitch, roll)
    slopes = {"pitch": np.cos(pitch), "roll": np.zeros_like(pitch)}
    columns = []
    for name, angle in (("pitch", pitch), ("roll", roll)):
        if kind == "unknown":
            part = table_of(zero_rad=zero_rad).index_errors(name, angle).scaled_rad / ARCSEC
        else:
            waves = [np.cos(angle), np.sin(angle)]
            part = np.stack(waves, axis=1) / np.sqrt(2.0)
            part = part - (0.0 if zero_rad is None else np.array([1.0, 0.0]) / np.sqrt(2.0))
        columns.append(slopes[name][:, None] * part)
    joined = np.hstack(columns)
    whole = np.eye(pitch.size) * 1.65**2 / 6.0 + joined @ joined.T
    covariance = np.linalg.inv(basis.T @ np.linalg.solve(whole, basis))
    chance = np.random.default_rng(3)
    limit = np.abs(pitch).max()
    there = with_one(chance.uniform(-limit, limit, 400), chance.uniform(-np.pi, np.pi, 400))
    return float(np.mean(1.96 * np.sqrt(np.einsum("ni,ij,nj->n", there, covariance, there))))


def with_one(pitch: np.ndarray, roll: np.ndarray) -> np.ndarray:
    level = np.cos(pitch)
    return np.stack([np.ones_like(pitch), np.sin(pitch), -level * np.sin(roll), -level * np.cos(roll)], axis=1)


def test_a_listed_curve_is_taken_out_of_the_attitudes() -> None:
    """A table of 20″ once a turn, listed every 10° to 0.1″: what is left is far below the curve, and is covered."""
    chance = np.random.default_rng(5)
    angle_deg = np.arange(-180.0, 180.0, 10.0)
    listed = known_errors(angle_deg, 20.0 * np.sin(np.deg2rad(angle_deg) + 0.7), np.full(36, 0.1 / np.sqrt(3.0)))
    errors = dict.fromkeys(("pitch", "roll"), IndexErrors("smooth", known=listed))
    table = TableUncertainty(ARCSEC, ARCSEC, "limit", errors=errors)
    drawn = campaigns("clean", 0.0, chance, 100, pitch_limit_deg=60.0, replications=4)
    pitch, roll = (np.deg2rad(drawn.schedule.pitch_deg), np.deg2rad(drawn.schedule.roll_deg))
    true = [angle + 20.0 * ARCSEC * np.sin(angle + 0.7) for angle in (pitch, roll)]
    moved_v = drawn.true_output_v(*np.rad2deg(true)) - drawn.true_output_v(*np.rad2deg([pitch, roll]))
    drawn = replace(drawn, output_v=drawn.output_v + moved_v)
    assert coverage(drawn, solved(drawn, table, extended=False), chance).least >= 0.93
    alone = TableUncertainty(ARCSEC, ARCSEC, "limit")
    assert coverage(drawn, solved(drawn, alone, extended=False), chance).prediction < 0.3
