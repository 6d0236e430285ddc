"""Copies are refused; readings that repeat because a meter is coarse, or nothing scatters, are not."""

from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.errors import ObservationsError
from ams.inputs import copied_replications
from ams.inputs.copied_replications import refuse_copies
from ams.observations import Observations

ARCSEC = np.pi / 648_000


def _rows(noise_arcsec: float = 1.65, seed: int = 2, **design: float) -> Observations:
    drawn = campaigns("use-good", 0.0, np.random.default_rng(seed), 1, noise_arcsec=noise_arcsec, **design).calibration
    return replace(rows_of(drawn), outputs={axis: columns_of(drawn, axis)[:, 0] for axis in "xyz"})


def _copied(rows: Observations, onto: tuple[int, ...], of: int = 1, kept: int = 0) -> Observations:
    """Return the rows with some replications overwritten by another, but for the first points of each."""
    first, *_ = labels = np.unique(rows.replication)
    source = labels[of - 1] if of > 1 else first
    outputs = {axis: values.copy() for axis, values in rows.outputs.items()}
    for label in onto:
        for values in outputs.values():
            where = np.flatnonzero(rows.replication == labels[label - 1])[kept:]
            values[where] = values[np.flatnonzero(rows.replication == source)[kept:]]
    return replace(rows, outputs=outputs)


@pytest.mark.parametrize(("onto", "of"), [((2,), 1), ((2, 3, 4, 5, 6), 1), ((5,), 3)])
def test_copies_are_refused_by_name(onto: tuple[int, ...], of: int) -> None:
    rows = _rows()
    labels = np.unique(rows.replication)
    with pytest.raises(ObservationsError) as refused:
        refuse_copies(_copied(rows, onto, of))
    assert f"{', '.join(str(labels[label - 1]) for label in onto)} " in str(refused.value)
    assert f"of replication {labels[of - 1]}:" in str(refused.value)
    assert "156 of 156 points" in str(refused.value)


def test_only_pairs_that_repeat_are_looked_at_closely(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a hundred replications there are 4 950 pairs; one in which nothing repeats is no copy."""
    closely: list[int] = []
    copied = copied_replications._copied

    def look(observations: Observations, first: int, here: np.ndarray, there: np.ndarray) -> object:
        closely.append(first)
        return copied(observations, first, here, there)

    monkeypatch.setattr(copied_replications, "_copied", look)
    rows = _rows(replications=100)
    refuse_copies(rows)
    assert closely == []
    with pytest.raises(ObservationsError, match="replication 6 is a copy of replication 2"):
        refuse_copies(_copied(rows, (7,), 3))
    assert len(closely) == 1


def test_a_copy_of_which_a_few_points_were_measured_again_is_refused() -> None:
    with pytest.raises(ObservationsError, match="146 of 156 points"):
        refuse_copies(_copied(_rows(), (4,), kept=10))


@pytest.mark.parametrize("step_v", [0.0, 1e-5, 2e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("noise_arcsec", [0.0, 0.02, 0.2, 1.65])
def test_measured_replications_are_none(step_v: float, noise_arcsec: float) -> None:
    for limit in (30.0, 90.0):
        rows = _rows(noise_arcsec, pitch_limit_deg=limit)
        if step_v:
            rows = replace(rows, outputs={a: np.rint(v / step_v) * step_v for a, v in rows.outputs.items()})
        refuse_copies(rows)


@pytest.mark.parametrize("digits", [6, 9, 12])
def test_exact_outputs_of_a_file_with_few_digits_are_none(digits: int) -> None:
    rows = _rows(0.0)
    refuse_copies(replace(rows, outputs={axis: values.round(digits) for axis, values in rows.outputs.items()}))


def test_an_axis_that_stands_still_makes_no_copies() -> None:
    rows = _rows()
    refuse_copies(replace(rows, outputs={**rows.outputs, "z": np.full(rows.rows, 0.3)}))


@pytest.mark.parametrize("points", [16, 78, 130])
def test_a_part_of_a_replication_that_is_copied_is_refused(points: int) -> None:
    with pytest.raises(ObservationsError, match=f"1 is a copy in part of replication 0: {points} of 156 points"):
        refuse_copies(_copied(_rows(), (2,), kept=156 - points))


def test_one_output_that_is_copied_is_refused_by_name() -> None:
    rows = _rows()
    copied = _copied(rows, (2,)).outputs["x"]
    with pytest.raises(ObservationsError, match="156 of 156 points have the same output x "):
        refuse_copies(replace(rows, outputs={**rows.outputs, "x": copied}))


@pytest.mark.parametrize("step_in_noise", [0.05, 0.2, 0.4, 0.6, 2.0])
@pytest.mark.parametrize("seed", range(6))
def test_readings_that_repeat_by_the_step_of_a_meter_are_no_copies(step_in_noise: float, seed: int) -> None:
    rows = _rows(seed=seed)
    step_v = step_in_noise * 1.65 * ARCSEC * 2.5
    refuse_copies(replace(rows, outputs={a: np.rint(v / step_v) * step_v for a, v in rows.outputs.items()}))


def test_an_output_that_hangs_in_two_replications_is_not_called_a_copy() -> None:
    rows = _rows()
    first, second, *_ = np.unique(rows.replication)
    outputs = {axis: values.copy() for axis, values in rows.outputs.items()}
    for label in (first, second):
        for values in outputs.values():
            values[np.flatnonzero(rows.replication == label)[:100]] = 0.3
    refuse_copies(replace(rows, outputs=outputs))


def _sting(noise_v: float, step_v: float, copied_points: int = 0) -> Observations:
    """Three replications of a package that pitches and yaws, by the definition of gravity forward, right and down."""
    grid = np.deg2rad([(pitch, yaw) for pitch in range(-30, 31, 5) for yaw in range(-20, 21, 5)])
    pitch, yaw = np.tile(grid, (3, 1)).T
    gravity = np.stack([-np.sin(pitch) * np.cos(yaw), np.sin(pitch) * np.sin(yaw), np.cos(pitch)], axis=-1)
    sensitivities = np.array([[2.5, 0.02, -0.01], [-0.015, 2.48, 0.02], [0.01, -0.02, 2.51]])
    read = 0.01 + gravity @ sensitivities.T + noise_v * np.random.default_rng(1).standard_normal(gravity.shape)
    read = np.rint(read / step_v) * step_v
    read[len(grid) : len(grid) + copied_points] = read[:copied_points]
    points = np.tile(np.arange(len(grid)), 3)
    return Observations(
        np.repeat([1, 2, 3], len(grid)), points, pitch, np.zeros_like(pitch),
        dict(zip("xyz", read.T, strict=True)), yaw_rad=yaw,
    )  # fmt: skip


@pytest.mark.parametrize(("noise_v", "step_v"), [(0.0, 1e-9), (0.0, 1e-4), (2e-6, 1e-4), (2e-5, 1e-4), (2e-5, 1e-9)])
def test_a_quiet_package_that_yaws_on_a_coarse_meter_is_no_copy(noise_v: float, step_v: float) -> None:
    """Gravity without yaw does not explain its outputs: what was left passed for scatter, and the rows were refused."""
    refuse_copies(_sting(noise_v, step_v))


def test_a_part_that_is_copied_is_refused_of_a_package_that_yaws() -> None:
    with pytest.raises(ObservationsError, match="2 is a copy in part of replication 1: 50 of 117 points"):
        refuse_copies(_sting(2e-5, 1e-9, copied_points=50))


SIX = np.deg2rad([(0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, -90.0), (90.0, 0.0), (-90.0, 0.0)])
TWELVE = np.deg2rad([(p, r) for p in (-45.0, 0.0, 45.0) for r in (-180.0, -90.0, 0.0, 90.0)])


def _few(
    points: np.ndarray, seed: int = 1, *, step_v: float = 1e-12, bend: float = 2e-5, noise_v: float = 2e-5
) -> Observations:
    """Four replications of a sensor that bends a little, read by a meter with a step."""
    pitch, roll = np.tile(points, (4, 1)).T
    force = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=-1)
    read = 0.01 + 2.5 * force + bend * force**2 + noise_v * np.random.default_rng(seed).standard_normal(force.shape)
    read = np.rint(read / step_v) * step_v
    numbers = np.tile(np.arange(len(points)), 4)
    outputs = dict(zip("xyz", read.T, strict=True))
    return Observations(np.repeat([1, 2, 3, 4], len(points)), numbers, pitch, roll, outputs)


@pytest.mark.parametrize("points", [SIX, TWELVE], ids=["six points", "twelve points"])
@pytest.mark.parametrize("copies", [(3,), (2, 3, 4)])
def test_copies_of_few_points_are_refused(points: np.ndarray, copies: tuple[int, ...]) -> None:
    rows = _few(points)
    outputs = {axis: values.copy() for axis, values in rows.outputs.items()}
    for values in outputs.values():
        for label in copies:
            values[rows.replication == label] = values[rows.replication == 1]
    with pytest.raises(ObservationsError, match=f"of replication 1: {len(points)} of {len(points)} points"):
        refuse_copies(replace(rows, outputs=outputs))


@pytest.mark.parametrize("points", [SIX, TWELVE], ids=["six points", "twelve points"])
@pytest.mark.parametrize(("step_v", "noise_v"), [(1e-12, 2e-5), (1e-5, 2e-5), (1e-4, 2e-5), (1e-4, 1e-6), (1e-6, 1e-8)])
def test_few_points_that_were_measured_are_no_copies(points: np.ndarray, step_v: float, noise_v: float) -> None:
    """A quiet sensor that bends by ten steps of its meter repeats every reading, and tells so by the steps."""
    for seed in range(20):
        refuse_copies(_few(points, seed, step_v=step_v, noise_v=noise_v))


def test_few_points_that_were_computed_without_noise_are_no_copies() -> None:
    refuse_copies(_few(SIX, bend=0.0, noise_v=0.0))


def _in_two_ranges(rows: Observations, step_v: float, above_v: float = 1.2) -> Observations:
    """Return the rows as a meter reads them that has steps of 0.1 µV, and coarser ones in its higher range."""
    read = {
        axis: np.where(np.abs(v) > above_v, np.rint(v / step_v) * step_v, np.rint(v / 1e-7) * 1e-7)
        for axis, v in rows.outputs.items()
    }
    return replace(rows, outputs=read)


@pytest.mark.parametrize("step_v", [1e-4, 3e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("seed", range(6))
def test_readings_that_repeat_in_the_coarse_range_of_a_meter_are_no_copies(step_v: float, seed: int) -> None:
    """A range is chosen by the size of a reading: all three outputs are high at some attitudes, and repeat there."""
    refuse_copies(_in_two_ranges(_rows(seed=seed), step_v))
    refuse_copies(_in_two_ranges(_tilted(seed), step_v))


def _tilted(seed: int) -> Observations:
    """Four replications of three axes that lie by half a degree beside those of the package, none like another."""
    chance = np.random.default_rng(seed)
    grid = np.deg2rad([(p, r) for p in range(-60, 61, 20) for r in range(-180, 180, 45)])
    pitch, roll = np.tile(grid, (4, 1)).T
    force = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=-1)
    sensitivities = np.diag(chance.uniform(2.3, 2.7, 3)) + chance.normal(0.0, 0.015, (3, 3))
    read = chance.normal(0.0, 0.01, 3) + force @ sensitivities.T + chance.normal(0.0, 2e-5, force.shape)
    points, outputs = np.tile(np.arange(len(grid)), 4), dict(zip("xyz", read.T, strict=True))
    return Observations(np.repeat([1, 2, 3, 4], len(grid)), points, pitch, roll, outputs)


@pytest.mark.parametrize("step_v", [1e-4, 1e-3])
def test_copies_are_refused_of_a_meter_with_two_ranges(step_v: float) -> None:
    rows = _in_two_ranges(_rows(), step_v)
    with pytest.raises(ObservationsError, match="156 of 156 points"):
        refuse_copies(_copied(rows, (2,)))
    with pytest.raises(ObservationsError, match="a copy in part"):
        refuse_copies(_copied(rows, (2,), kept=60))


def _renumbered(rows: Observations, chosen: np.ndarray, replication: np.ndarray | None = None) -> Observations:
    """Return the rows with some of them once more, under numbers of points that no other has."""
    new = rows.point.max() + 1 + np.arange(chosen.size) % np.unique(rows.point[chosen]).size
    given = rows.replication[chosen] if replication is None else replication
    return replace(
        rows, replication=np.concatenate([rows.replication, given]), point=np.concatenate([rows.point, new]),
        pitch_rad=np.concatenate([rows.pitch_rad, rows.pitch_rad[chosen]]),
        roll_rad=np.concatenate([rows.roll_rad, rows.roll_rad[chosen]]),
        outputs={axis: np.concatenate([values, values[chosen]]) for axis, values in rows.outputs.items()},
        time_s=None, temperature_degc=None, step=None, yaw_rad=None,
    )  # fmt: skip


@pytest.mark.parametrize("share", [1.0, 0.25])
def test_rows_that_stand_twice_under_new_numbers_of_points_are_refused(share: float) -> None:
    """All rows once more, or a block of each replication: a design of more points, of which the noise is half told."""
    rows = _rows()
    points = np.unique(rows.point)
    block = points[: int(share * points.size)]
    twice = _renumbered(rows, np.flatnonzero(np.isin(rows.point, block)))
    with pytest.raises(ObservationsError, match="rows stand twice, under new numbers of points") as refused:
        refuse_copies(twice)
    assert f"{block.size} rows of replication" in str(refused.value)
    assert f"points {twice.point.max() - block.size + 1} to {twice.point.max()}" in str(refused.value)


def test_attitudes_that_were_measured_twice_in_a_replication_are_no_copies() -> None:
    """Points of one attitude, there and back, read twice: they scatter, and repeat only by a meter's coarse step."""
    rows = _rows(replications=12)
    labels = np.unique(rows.replication)
    is_back = np.isin(rows.replication, labels[1::2])
    point = np.where(is_back, rows.point + rows.point.max() + 1, rows.point)
    twice = replace(rows, point=point, replication=np.searchsorted(labels, rows.replication) // 2)
    for step_v in (1e-9, 1e-5, 1e-4, 1e-3):
        refuse_copies(replace(twice, outputs={a: np.rint(v / step_v) * step_v for a, v in rows.outputs.items()}))
    back = {
        axis: np.where(is_back, np.roll(values, np.sum(~is_back) // 6), values) for axis, values in rows.outputs.items()
    }
    with pytest.raises(ObservationsError, match="rows stand twice"):
        refuse_copies(replace(twice, outputs=back))


def test_rows_that_were_computed_may_stand_twice() -> None:
    rows = _rows(noise_arcsec=0.0)
    refuse_copies(_renumbered(rows, np.arange(rows.rows)))
