"""Outputs of a pitch-roll package by explicit rotation matrices, TP (110) to (116): independent of the solvers."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

TRUTH = {
    "x": (0.005, 2.5, 0.5, 35.0),
    "y": (-0.003, 2.48, 0.3, -110.0),
    "z": (0.008, -2.52, 0.4, 160.0),
}
"""Sensor axis to offset (V), sensitivity (V/g), coning (°) and azimuth (°)."""
ATTITUDES = [(-35.0, -20.0), (5.0, 60.0), (90.0, 10.0)]
"""Pitch and roll in degrees, one of them singular."""


def pitch_matrix(angle: float) -> np.ndarray:
    """TP (110)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def roll_matrix(angle: float) -> np.ndarray:
    """TP (111)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


def yaw_matrix(angle: float) -> np.ndarray:
    """TP (112)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


MISALIGNMENT = {"x": (yaw_matrix, roll_matrix), "y": (roll_matrix, pitch_matrix), "z": (pitch_matrix, yaw_matrix)}


def output_v(axis: str, truth: Sequence[float], pitch_deg: float, roll_deg: float) -> float:
    """TP (114) to (116): gravity turned into sensor coordinates, its component along the sensor's own axis."""
    offset, sensitivity, coning, azimuth = truth[0], truth[1], np.deg2rad(truth[2]), np.deg2rad(truth[3])
    gravity = roll_matrix(np.deg2rad(roll_deg)) @ pitch_matrix(np.deg2rad(pitch_deg)) @ np.array([0.0, 0.0, -1.0])
    by_coning, by_azimuth = MISALIGNMENT[axis]
    return float(offset + sensitivity * (by_coning(coning) @ by_azimuth(azimuth) @ gravity)["xyz".index(axis)])


def write_observations(
    path: Path,
    pitch_deg: Sequence[float],
    roll_deg: Sequence[float],
    replications: int,
    noise_v: float = 0.0,
    seed: int = 1,
    truth: Mapping[str, Sequence[float]] = TRUTH,
) -> Path:
    """A CSV of DESIGN's form: replication, point, pitch_deg, roll_deg, s<axis>_v."""
    chance = np.random.default_rng(seed)
    attitudes = [(pitch, roll) for pitch in pitch_deg for roll in roll_deg]
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["replication", "point", "pitch_deg", "roll_deg", *(f"s{axis}_v" for axis in truth)])
        for replication in range(1, replications + 1):
            for point, (pitch, roll) in enumerate(attitudes, start=1):
                outputs = [output_v(axis, truth[axis], pitch, roll) + noise_v * chance.normal() for axis in truth]
                rows.writerow([replication, point, pitch, roll, *map(repr, outputs)])
    return path
