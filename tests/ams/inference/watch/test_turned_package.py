"""A model package that sits turned on its mount is told by all rows together, long before half of them disagree.

Both packages are calibrated on one gimbal whose axes have smooth errors within what is declared of them, then carried
by one model: explicit rotations of gravity, each reading with noise of its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache

import numpy as np
import pytest
from physics_scenes.gimbal_scenes import GimbalSetup, coned_axis, gravity_in_packages
from physics_scenes.rotations import ARCSEC, turn_matrix

from ams.attitude import flag_codes
from ams.calibration.calibrate import calibrate
from ams.inference.inference import Inference, Package, inference
from ams.inference.watch.doubts import doubts_of
from ams.inference.watch.turned_package import turn_of
from ams.inference.watch.watched_axes import WatchedAxes, answered_at_once, watched_axes
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.sets.provenance import Provenance

FloatArray = np.ndarray
SAID = np.uint64(flag_codes.REDUNDANCY | flag_codes.FAULTY)
NOISE_ARCSEC, V_PER_G, LIMIT_ARCSEC = 1.65, 2.5, 1.0
ROWS, SETS = 200, 8
PROVENANCE = Provenance(
    sensor="SN", gravity_mps2=9.80665, gravity_source="declared", pitch_range_deg=(-90.0, 90.0),
    roll_range_deg=(-180.0, 180.0), yaw_range_deg=(-90.0, 90.0), created_utc=datetime(2026, 1, 1, tzinfo=UTC),
    software_version="0", rig="", procedure="", simulated=True,
)  # fmt: skip


@dataclass(frozen=True)
class Truth:
    offset_v: FloatArray
    """(2, 3)"""
    vector_v_per_g: FloatArray
    """(2, 3, 3)"""

    def read(self, gravity: FloatArray, chance: np.random.Generator) -> FloatArray:
        """(N, 2, 3) volts from gravity in both packages."""
        clean = self.offset_v + np.einsum("npc,pac->npa", gravity, self.vector_v_per_g)
        return clean + NOISE_ARCSEC * ARCSEC * V_PER_G * chance.standard_normal(clean.shape)


def smooth(chance: np.random.Generator) -> FloatArray:
    """Errors of an axis over whole degrees, −180 to 180, that reach nine tenths of an arc second; degrees."""
    turn = np.deg2rad(np.arange(-180.0, 181.0))
    waves = sum(chance.standard_normal() * np.sin(k * turn + chance.uniform(0.0, 2.0 * np.pi)) for k in (1, 2, 3))
    return 0.9 / 3600.0 * waves / np.abs(waves).max()


@cache
def calibrated(seed: int, replications: int = 4, *, is_short: bool = False) -> tuple[Inference, Truth]:
    """``is_short``: at a quarter of the points, on a gimbal without errors."""
    chance, setup = np.random.default_rng([1, seed]), GimbalSetup(replications=replications)
    limit_arcsec = 0.0 if is_short else LIMIT_ARCSEC
    if is_short:
        setup = GimbalSetup(replications=replications, pitch_count=3, roll_count=4)
    volts = V_PER_G * (1.0 + 0.01 * chance.uniform(-1.0, 1.0, (2, 3)))
    coning, azimuth = np.deg2rad(chance.uniform(0.05, 1.0, (2, 3))), chance.uniform(-np.pi, np.pi, (2, 3))
    units = np.stack([coned_axis(axis, coning[:, i], azimuth[:, i]) for i, axis in enumerate("xyz")], axis=-2)
    truth = Truth(0.01 * chance.standard_normal((2, 3)), volts[..., None] * units)
    shown = setup.calibration_euler_deg()
    curves = [limit_arcsec * smooth(chance) for _ in range(3)]
    errors = [np.interp(shown[:, axis], np.arange(-180.0, 181.0), curve) for axis, curve in enumerate(curves)]
    gravity, points = gravity_in_packages(shown + np.stack(errors, axis=1)), len(shown)
    read = np.stack([truth.read(gravity, chance) for _ in range(replications)])
    pitch, yaw, roll = (np.tile(angle, replications) for angle in np.deg2rad(shown).T)
    limit = limit_arcsec * ARCSEC
    packages = []
    for which, name in enumerate(("sting", "model")):
        rows = Observations(
            np.repeat(np.arange(replications), points), np.tile(np.arange(points), replications), pitch, roll,
            {axis: read[:, :, which, i].ravel() for i, axis in enumerate("xyz")}, yaw_rad=yaw,
        )  # fmt: skip
        table = TableUncertainty(limit, limit, "limit", yaw_rad=limit)
        found = calibrate(rows, CalibrationRequest(model=f"pitch-yaw-roll-{name}", table=table))
        packages.append(Package(build_set(found, PROVENANCE), {axis: f"{name}_{axis}_v" for axis in "xyz"}))
    return inference(*packages, reading_sd_v=NOISE_ARCSEC * ARCSEC * V_PER_G), truth


def flown(truth: Truth, seed: int, turn_arcsec: FloatArray, rows: int = ROWS) -> Mapping[str, FloatArray]:
    """Rows of a flight with the model package turned by (3,) angles about its own axes."""
    chance = np.random.default_rng([2, seed])
    gravity = gravity_in_packages(chance.uniform(-1.0, 1.0, (rows, 3)) * np.array([30.0, 20.0, 180.0]))
    size = np.linalg.norm(turn_arcsec)
    if size:
        components = turn_matrix((turn_arcsec * ARCSEC)[None])[0]
        gravity[:, 1] = gravity[:, 1] @ components.T
    read = truth.read(gravity, chance)
    return {
        f"{name}_{axis}_v": read[:, p, i] for p, name in enumerate(("sting", "model")) for i, axis in enumerate("xyz")
    }


def about_yz(size_arcsec: float, seed: int) -> FloatArray:
    angle = np.random.default_rng([3, seed]).uniform(0.0, 2.0 * np.pi)
    return size_arcsec * np.array([0.0, np.cos(angle), np.sin(angle)])


def flagged_share(size_arcsec: float, sets: int = SETS, replications: int = 4) -> float:
    shares = []
    for seed in range(sets):
        angles, truth = calibrated(seed, replications)
        codes = answered_at_once(angles, flown(truth, seed, about_yz(size_arcsec, seed))).codes
        shares.append(np.mean((codes.astype(np.uint64) & SAID) != 0))
    return float(np.mean(shares))


def test_good_packages_have_hardly_a_row_flagged() -> None:
    assert flagged_share(0.0) < 0.005


def test_ten_arc_seconds_are_flagged_in_every_row() -> None:
    assert flagged_share(10.0) > 0.99


@pytest.mark.soak
@pytest.mark.parametrize("replications", [2, 3, 4])
def test_one_or_two_rows_in_a_thousand_are_flagged_over_many_sets(replications: int) -> None:
    assert flagged_share(0.0, 400, replications) < 0.002


def test_the_turn_is_told_with_its_size_and_sense() -> None:
    for seed in range(SETS):
        angles, truth = calibrated(seed)
        turn = about_yz(10.0, seed)
        found = turn_of(angles, flown(truth, seed, turn))
        assert found is not None
        assert found.is_proven
        off = found.about_yz_rad - turn[1:] * ARCSEC
        assert np.all(np.abs(off) < 4.0 * np.sqrt(np.diag(found.covariance)))


def test_what_both_calibrations_are_wrong_by_is_no_turn_however_many_the_rows() -> None:
    """The noise of 2 000 rows leaves a turn of a twentieth of an arc second, short calibrations some tenths."""
    for seed in range(SETS):
        angles, truth = calibrated(seed, replications=2, is_short=True)
        found = turn_of(angles, flown(truth, seed, np.zeros(3), rows=2000))
        assert found is not None
        assert found.about_yz_rad @ np.linalg.solve(found.covariance, found.about_yz_rad) < 13.8, "once in a thousand"


def test_a_turn_about_x_is_a_roll() -> None:
    angles, truth = calibrated(0)
    found = turn_of(angles, flown(truth, 0, np.array([600.0, 0.0, 0.0])))
    assert found is not None
    assert not found.is_proven


def test_what_is_no_turn_is_not_told_as_one() -> None:
    """One axis of the model package has lost a hundredth of its signal."""
    angles, truth = calibrated(0)
    readings = dict(flown(truth, 0, np.zeros(3)))
    readings["model_y_v"] = truth.offset_v[1, 1] + 0.99 * (readings["model_y_v"] - truth.offset_v[1, 1])
    found = turn_of(angles, readings)
    assert found is not None
    assert not found.is_proven


def test_rows_that_come_in_pieces_are_told_of_with_the_turn_and_those_before_it_was_known() -> None:
    angles, truth = calibrated(0)
    readings = flown(truth, 0, about_yz(10.0, 0))
    watched = watched_axes(angles)
    assert isinstance(watched, WatchedAxes)
    pieces = np.array_split(np.arange(ROWS), 20)
    codes = [watched.answer({name: values[piece] for name, values in readings.items()}).codes for piece in pieces]
    watched.finish()
    assert np.all(codes[-1].astype(np.uint64) & SAID)
    turned, before = doubts_of(watched, is_flagged_throughout=False)
    assert "SN, model package: all rows together hold it turned against SN, the sting package, by" in turned
    assert "were answered before that was proven" in before
