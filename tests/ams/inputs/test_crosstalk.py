"""Channels of a scanner that leak into each other: scenes from physics, and what the declared limit holds of them.

A package, another one mounted askew beside it and a supply of 5 V are read through one scanner. Every reading has a
part of its own of every other channel's volts too much, drawn once a campaign.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
import pytest
from simulated_campaign import OFFSET_V, VECTOR_V_PER_G, Campaign
from solved import provenance

from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration.jointly import calibrate_jointly
from ams.calibration_result import Calibration
from ams.errors import ObservationsError
from ams.frames import specific_force
from ams.inference.inference import Package, inference
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.solve.table_errors import TablePriors
from ams.statistics.intervals import t_quantile

AXES = ("x", "y", "z")
ASKEW = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
"""(3, 3) how the other package is mounted."""
SUPPLY_V, NOISE_V = 5.0, 5e-6
CHANNELS = 7
TABLE = TableUncertainty(2e-7, 2e-7, kind="standard")


def crosstalk(ratio: float) -> tuple[SharedError, ...]:
    columns, axes = tuple(range(CHANNELS)), (*AXES, "", "", "", "")
    u = ratio / sqrt(3.0)
    return (SharedError("crosstalk", "crosstalk", u, columns=columns, axes=axes, is_of_one_channel=True),)


def truly(force_g: FloatArray) -> FloatArray:
    """Return (N, 7) volts on the channels."""
    beside = 0.15 + force_g @ ASKEW.T * 2.5
    own = np.stack([OFFSET_V[axis] + force_g @ VECTOR_V_PER_G[axis] for axis in AXES], axis=1)
    return np.hstack([own, beside, np.full((len(force_g), 1), SUPPLY_V)])


def measured(rows: Observations, ratio: float, chance: np.random.Generator) -> Observations:
    """Return the rows as a meter behind a scanner reads them whose channels leak by up to ``ratio``."""
    leaks = chance.uniform(-ratio, ratio, (CHANNELS, CHANNELS))
    np.fill_diagonal(leaks, 0.0)
    volts = truly(specific_force(rows.pitch_rad, rows.roll_rad))
    read = volts + volts @ leaks.T + NOISE_V * chance.standard_normal(volts.shape)
    return replace(rows, outputs=dict(zip(AXES, read.T[:3], strict=True)), scanned_v=read)


def solved(rows: Observations, ratio: float, *, joint: bool = False) -> Calibration:
    shared = {axis: crosstalk(ratio) if ratio else () for axis in AXES}
    request = CalibrationRequest(shared_errors=shared, extended="no")
    return calibrate_jointly(rows, request, TablePriors(table=TABLE)) if joint else calibrate(rows, request)


@dataclass(frozen=True)
class Kept:
    """Over campaigns: share of 95 % intervals of b and k that held, of angles too, and rms error over stated u."""

    coefficients: float
    angles: float
    error_over_u: Mapping[str, float]


def kept(ratio: float, declared: float, campaigns: int, *, joint: bool = False) -> Kept:
    chance = np.random.default_rng(5)
    rows = Campaign(replications=3).observe(chance)
    pitch_deg, roll_deg = chance.uniform(-70.0, 70.0, 40), chance.uniform(-180.0, 180.0, 40)
    used_v = truly(specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg)))[:, :3]
    held, angles = [], []
    errors: dict[str, list[tuple[float, float]]] = {"b": [], "k": []}
    for _ in range(campaigns):
        calibration = solved(measured(rows, ratio, chance), declared, joint=joint)
        for axis, found in calibration.axes.items():
            off = found.primary - np.concatenate([[OFFSET_V[axis]], VECTOR_V_PER_G[axis]])
            u = np.sqrt(np.diag(found.primary_covariance))
            held.append(np.abs(off) <= t_quantile(0.95, found.primary_dof) * u)
            errors["b"].append((off[0] ** 2, u[0] ** 2))
            errors["k"] += zip(off[1:] ** 2, u[1:] ** 2, strict=True)
        package = Package(build_set(calibration, provenance()), {axis: f"{axis}_v" for axis in AXES})
        answer = replace(inference(package, reading_sd_v=1e-9), intervals=True).infer(
            {f"{axis}_v": used_v[:, at] for at, axis in enumerate(AXES)}
        )
        for name, truth in (("pitch", pitch_deg), ("roll", roll_deg)):
            away_deg = np.abs((answer[f"{name}_deg"] - truth + 180.0) % 360.0 - 180.0)
            angles.append(away_deg <= answer[f"{name}_half_95_deg"])
    over = {name: float(np.sqrt(np.divide(*np.sum(pairs, axis=0)))) for name, pairs in errors.items()}
    return Kept(float(np.mean(held)), float(np.mean(angles)), over)


@pytest.mark.parametrize("ratio", [1e-7, 1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("campaigns", [30, pytest.param(300, marks=pytest.mark.thorough)])
def test_a_declared_crosstalk_holds_b_k_and_angles_from_nothing_to_obvious(ratio: float, campaigns: int) -> None:
    found = kept(ratio, ratio, campaigns)
    assert found.coefficients > 0.93
    assert found.angles > 0.93
    slack = 0.25 if campaigns < 100 else 0.1
    assert max(found.error_over_u.values()) < 1.0 + slack, found
    is_of_crosstalk = ratio > 1e-6  # below, three replications state their noise on the safe side
    assert not is_of_crosstalk or min(found.error_over_u.values()) > 1.0 - slack, found


def test_one_that_nobody_declared_is_held_by_nothing() -> None:
    """What the declaration is for: no residual shows it, and intervals without it are far too narrow."""
    found = kept(1e-5, 0.0, 15)
    assert found.coefficients < 0.5
    assert min(found.error_over_u.values()) > 3.0


def test_the_joint_fit_counts_the_same() -> None:
    rows = measured(Campaign(replications=3).observe(np.random.default_rng(1)), 1e-4, np.random.default_rng(2))
    alone, joint = solved(rows, 1e-4), solved(rows, 1e-4, joint=True)
    for axis in AXES:
        parts = [
            next(part.covariance for part in found.axes[axis].variance_components if part.name == "crosstalk")
            for found in (alone, joint)
        ]
        np.testing.assert_allclose(np.diag(parts[1]), np.diag(parts[0]), rtol=0.05)


def test_the_part_is_the_sum_over_the_other_channels_and_none_leaks_into_itself() -> None:
    """An axis has E²/3 · Σ θθᵀ of offset and sensitivities by it, over the θ of all channels but its own."""
    ratio, chance = 1e-4, np.random.default_rng(1)
    found = solved(measured(Campaign(replications=3).observe(chance), ratio, chance), ratio)
    beside = [np.concatenate([[0.15], 2.5 * row]) for row in ASKEW]
    every = {axis: np.concatenate([[OFFSET_V[axis]], VECTOR_V_PER_G[axis]]) for axis in AXES}
    for axis in AXES:
        others = [*(every[other] for other in AXES if other != axis), *beside, np.array([SUPPLY_V, 0.0, 0.0, 0.0])]
        expected = ratio**2 / 3.0 * sum(np.outer(theta, theta) for theta in others)
        parts = found.axes[axis].variance_components
        (part,) = (part.covariance for part in parts if part.name == "crosstalk")
        np.testing.assert_allclose(part, expected, rtol=0.02, atol=0.002 * np.diag(expected)[1:].max())


def test_axes_have_no_part_of_it_in_common() -> None:
    """What leaks from y into x is not what leaks from x into y."""
    rows = measured(Campaign(replications=3).observe(np.random.default_rng(1)), 1e-4, np.random.default_rng(2))
    package = solved(rows, 1e-4).package
    assert package is not None
    part = next(part.covariance for part in package.components if part.name == "crosstalk")
    assert np.diag(part).min() > 0.0
    assert not part[:4, 4:].any()


def test_rows_that_do_not_know_the_other_channels_are_refused() -> None:
    rows = replace(Campaign(replications=3).observe(np.random.default_rng(1)), scanned_v=None)
    with pytest.raises(ObservationsError, match="volts of the other channels; nothing was solved"):
        solved(rows, 1e-5)
