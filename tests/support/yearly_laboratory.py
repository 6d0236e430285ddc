"""A laboratory that calibrates its packages once a year: its sensors scatter, age and drop, its meter changes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import timedelta

import numpy as np
from scipy.spatial.transform import Rotation

from ams.archive.synthetic import AXES, RIG, START
from ams.arrays import FloatArray
from ams.surveillance.characteristics import PackageNumbers
from ams.surveillance.series import PointLabel, Population
from ams.units import RAD_PER_ARCSEC

NOISE_ARCSEC, DAY_ARCSEC, REMOUNT_ARCSEC = 0.5, 2.0, 30.0


@dataclass(frozen=True)
class Laboratory:
    """Packages on one table read by one meter, once a year; the last run's meter and table may be others."""

    sensors: int = 8
    runs: int = 8
    checks: int = 1
    """So many of them stay mounted."""
    gain_arcsec: float = 0.0
    moved: int | None = None
    """So many of them, the first ones, are read with that gain, as by one of two meters; None for all."""
    offset_arcsec: float = 0.0
    """Of a package of 2.5 V/g."""
    tilt_arcsec: float = 0.0
    drop_arcsec: float = 0.0
    """Of the last package alone, from run ``drop_run`` on."""
    drop_run: int = -1
    wander_arcsec: float = 0.0
    """Of the meter's gain, every year anew."""
    sensitivity: tuple[float, float] = (2.5, 2.5)
    is_reversed: bool = False
    """Whether the y axis of every package is mounted the other way."""


def measured(laboratory: Laboratory, seed: int) -> Population:
    chance = np.random.default_rng(seed)
    rows: list[tuple[PointLabel, FloatArray]] = []
    names = [f"CHECK-{index}" if index < laboratory.checks else f"SN{index}" for index in range(laboratory.sensors)]
    levels = {
        name: (chance.normal(0.0, 0.005, (3, 1)), np.eye(3) + chance.normal(0.0, 0.003, (3, 3)), scale)
        for name, scale in zip(names, chance.uniform(*laboratory.sensitivity, len(names)), strict=True)
    }
    signs = np.array([[1.0], [-1.0 if laboratory.is_reversed else 1.0], [1.0]])
    for run in range(laboratory.runs):
        is_last = run == laboratory.runs - 1
        wander = laboratory.wander_arcsec * chance.standard_normal()
        for index, name in enumerate(names):
            is_moved = is_last and (laboratory.moved is None or index < laboratory.moved)
            gain = wander + laboratory.gain_arcsec * is_moved
            offset, k, scale = levels[name]
            stays = name.startswith("CHECK")
            turn = [0.0, laboratory.tilt_arcsec * is_last, 0.0] if stays else chance.normal(0.0, REMOUNT_ARCSEC, 3)
            day = chance.normal([0.0, gain], DAY_ARCSEC, (3, 2))
            is_dropped = run >= laboratory.drop_run % laboratory.runs
            day[:, 1] += laboratory.drop_arcsec * (is_dropped and name == names[-1])
            primary = np.hstack(
                [
                    offset
                    + scale * RAD_PER_ARCSEC * day[:, :1]
                    + 2.5 * RAD_PER_ARCSEC * laboratory.offset_arcsec * is_last,
                    signs * Rotation.from_rotvec(RAD_PER_ARCSEC * np.array(turn)).apply(k) * scale
                    * (1.0 + RAD_PER_ARCSEC * day[:, 1:]),
                ]
            )  # fmt: skip
            primary += scale * NOISE_ARCSEC * RAD_PER_ARCSEC * chance.standard_normal((3, 4))
            when = START + timedelta(days=365 * run)
            rows.append((PointLabel(f"{name}{run}", name, f"run-{run:02d}", when, RIG, stays, 9.8), primary))
    rows.sort(key=lambda row: (row[0].sensor, row[0].created_utc))
    spread = np.eye(4) * (2.5 * NOISE_ARCSEC * RAD_PER_ARCSEC) ** 2
    covariance = np.broadcast_to(spread, (len(rows), 3, 4, 4)).copy()
    numbers = PackageNumbers(AXES, np.stack([primary for _, primary in rows]), covariance, covariance)
    return Population([label for label, _ in rows], numbers)


def read_otherwise(population: Population, gain_arcsec: Callable[[str, int], float]) -> Population:
    """Multiply the sensitivities of a sensor in a run, from 0."""
    primary = population.numbers.primary.copy()
    for row, label in enumerate(population.labels):
        assert label.run_id is not None
        primary[row, :, 1:] *= 1.0 + RAD_PER_ARCSEC * gain_arcsec(label.sensor, int(label.run_id[-2:]))
    return replace(population, numbers=replace(population.numbers, primary=primary))
