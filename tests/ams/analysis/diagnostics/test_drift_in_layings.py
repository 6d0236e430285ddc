"""A zero that goes with every laying and is back at the next passes for sensitivity where the rates ascend in each."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.frames import body_rates_rad_s
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FloatArray = NDArray[np.float64]
Order = Callable[[int, np.random.Generator], Sequence[float]]
"""Number of a replication to the rates about each axis, as they follow one another."""
NOISE_V, VOLTS_PER_DPS, REPLICATIONS = 2e-5, 0.02, 4
UP = (-100.0, -60.0, -30.0, 0.0, 30.0, 60.0, 100.0)
OWN = (10.0, -10.0, 40.0, -40.0)


def _always(*rates: float) -> Order:
    return lambda _replication, _chance: rates


TOLD: dict[str, Order] = {
    "up": _always(*UP),
    "down": _always(*UP[::-1]),
    "up from rest": _always(0.0, 10.0, 30.0, 60.0, 100.0),
    "one pair": _always(-100.0, 100.0),
}
NOT_TOLD: dict[str, Order] = {
    "rates of this program": _always(*OWN),
    "up, and down in the next replication": lambda replication, _: UP if replication % 2 else UP[::-1],
    "there and back": _always(*UP[::2], *UP[1::2][::-1]),
    "by chance": lambda _, chance: chance.permutation(UP).tolist(),
}


def _gyros(order: Order, seed: int, saw_sd: float = 0.0) -> Observations:
    """Turn about roll, pitch and yaw after each other; zeros go by ``saw_sd`` of a dwell in each, and go back."""
    chance = np.random.default_rng(seed)
    laid = [
        (replication, point, axis, rate, turn / (len(rates) - 1) - 0.5)
        for replication in range(REPLICATIONS)
        for axis in (2, 0, 1)
        for rates in [order(replication, chance)]
        for point, (turn, rate) in zip(np.argsort(np.argsort(rates)), enumerate(rates), strict=True)
    ]
    replication, point, axis, rate_dps, place = np.array(laid).T
    euler_rate = np.deg2rad(rate_dps)[:, None] * np.eye(3)[axis.astype(int)]
    nothing = np.zeros(rate_dps.size)
    sensed = VOLTS_PER_DPS * np.rad2deg(body_rates_rad_s(np.zeros_like(euler_rate), euler_rate))
    outputs = sensed + NOISE_V * (saw_sd * place[:, None] + chance.standard_normal(sensed.shape))
    return Observations(
        replication.astype(int), (100 * axis + point).astype(int), nothing, nothing,
        dict(zip("xyz", outputs.T, strict=True)), yaw_rad=nothing, time_s=120.0 * np.arange(nothing.size),
        euler_rate_rad_s=euler_rate,
    )  # fmt: skip


def _solved(rows: Observations, *, time_term: bool = False) -> Calibration:
    return calibrate(rows, CalibrationRequest(model="gyro", nominal_axes={a: a for a in "xyz"}, time_term=time_term))


def _told(solved: Calibration) -> list[Finding]:
    """Return what is told of the order, of each axis."""
    return [
        finding
        for axis in solved.axes.values()
        for finding in axis.findings
        if finding.kind == "time-confounded" and finding.is_significant
    ]


@pytest.mark.parametrize("name", TOLD)
@pytest.mark.parametrize("time_term", [False, True])
def test_an_order_that_lets_a_zero_of_every_laying_into_the_scale_factor_is_told(name: str, time_term: bool) -> None:
    """Drifting or not; an even drift over the run in the solution takes nothing of what comes back."""
    for seed in range(4):
        solved = _solved(_gyros(TOLD[name], seed), time_term=time_term)
        said = _told(solved)
        assert len(said) == 3
        assert all("go together while it turns about one axis" in found.text for found in said)
        assert all("there and back" in found.what_to_do and "time_term" not in found.what_to_do for found in said)
        assert solved.verdict == "usable"


@pytest.mark.parametrize("name", NOT_TOLD)
def test_an_order_that_tells_time_and_rate_apart_in_every_laying_is_not_told(name: str) -> None:
    for seed in range(20):
        assert not _told(_solved(_gyros(NOT_TOLD[name], seed)))


def test_what_is_told_is_what_moves_the_scale_factor_and_what_is_not_told_does_not() -> None:
    """A zero that warms by ten standard deviations of a dwell in each laying, in 60 scale factors each."""
    held: dict[str, list[bool]] = {"up": [], "up, and down in the next replication": [], "there and back": []}
    for name, of_name in held.items():
        for seed in range(20):
            for axis in _solved(_gyros({**TOLD, **NOT_TOLD}[name], seed, saw_sd=10.0)).axes.values():
                interval = next(p.interval_95 for p in axis.parameters if p.name == "sensitivity_v_per_dps")
                assert interval is not None
                of_name.append(interval[0] <= VOLTS_PER_DPS <= interval[1])
    assert np.mean(held.pop("up")) < 0.1
    assert all(np.mean(of_name) >= 0.9 for of_name in held.values()), held


def test_an_axis_alone_and_rows_in_any_order_say_it_and_rows_without_times_remark_it() -> None:
    rows = _gyros(TOLD["up"], 1)
    mixed = np.random.default_rng(3).permutation(rows.rows)
    alone = {"x": rows.outputs["x"]}
    (said,) = _told(calibrate(replace(rows, outputs=alone), CalibrationRequest(model="gyro", nominal_axes={"x": "x"})))
    assert rows.time_s is not None
    assert rows.euler_rate_rad_s is not None
    shuffled = replace(
        rows, replication=rows.replication[mixed], point=rows.point[mixed], time_s=rows.time_s[mixed],
        euler_rate_rad_s=rows.euler_rate_rad_s[mixed], outputs={a: v[mixed] for a, v in rows.outputs.items()},
    )  # fmt: skip
    assert [found.text for found in _told(_solved(shuffled))] == [said.text] * 3
    untimed = _solved(replace(rows, time_s=None))
    assert not _told(untimed)
    assert any("while it turns about one axis" in text for text in untimed.axes["x"].remarks)


@pytest.mark.parametrize("is_to_and_fro", [False, True])
def test_pitch_that_ascends_at_every_roll_is_told_and_to_and_fro_is_not(is_to_and_fro: bool) -> None:
    pitches, rolls = np.arange(-75.0, 76.0, 25.0), np.arange(-180.0, 180.0, 45.0)
    grid = [(p, r) for row, r in enumerate(rolls) for p in (pitches[::-1] if row % 2 and is_to_and_fro else pitches)]
    pitch, roll = np.tile(np.deg2rad(grid), (REPLICATIONS, 1)).T
    replication, point = np.divmod(np.arange(pitch.size), len(grid))
    force = {"x": np.sin(pitch), "y": -np.cos(pitch) * np.sin(roll), "z": -np.cos(pitch) * np.cos(roll)}
    for seed in range(4):
        chance = np.random.default_rng(seed)
        outputs = {axis: 2.5 * along + 2e-5 * chance.standard_normal(along.size) for axis, along in force.items()}
        rows = Observations(replication, point, pitch, roll, outputs, time_s=30.0 * np.arange(pitch.size))
        said = _told(calibrate(rows, CalibrationRequest(nominal_axes={axis: axis for axis in "xyz"})))
        assert len(said) == (0 if is_to_and_fro else 3)
        assert all("from one move of the slower axis to the next" in found.text for found in said)
