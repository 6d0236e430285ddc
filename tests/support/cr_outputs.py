"""Outputs of CR's packages by explicit rotation matrices, CR (III-B.2) to (III-B.12): independent of the solvers."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from package_outputs import pitch_matrix, roll_matrix, yaw_matrix

# CR table 3, specified: B in V, S in V/g, A in deg, C in deg.
TABLE_3_STING = {"x": (1.25, 0.51, 0.05, 0.06), "y": (1.27, 0.47, 0.12, 0.15), "z": (1.19, 0.54, 0.11, 0.11)}
TABLE_3_MODEL = {"x": (1.26, 0.52, 0.08, 0.08), "y": (1.28, 0.49, 0.10, 0.09), "z": (1.20, 0.53, 0.09, 0.12)}
# CR table 4, specified: B in V, S in V/(deg/s), A in deg, C in deg.
TABLE_4 = {"x": (0.051, 1.25, 0.14, 0.11), "y": (0.052, 1.26, 0.15, 0.12), "z": (0.053, 1.27, 0.16, 0.13)}

MISALIGNMENT = {
    "x": lambda azimuth, coning: (pitch_matrix(coning) @ roll_matrix(azimuth))[0],
    "y": lambda azimuth, coning: (yaw_matrix(coning) @ pitch_matrix(azimuth))[1],
    "z": lambda azimuth, coning: (roll_matrix(coning) @ yaw_matrix(azimuth))[2],
}


def to_package(pitch_rad: float, yaw_rad: float, roll_rad: float) -> np.ndarray:
    """From tunnel axes to package axes; the first half turn is CR's."""
    return roll_matrix(roll_rad) @ yaw_matrix(yaw_rad) @ pitch_matrix(pitch_rad) @ pitch_matrix(np.pi)


def accelerometer_v(axis: str, truth: Sequence[float], euler_deg: Sequence[float], package: str) -> float:
    """One output: gravity (0, 0, −1) g in tunnel axes, turned into the sensor's own; roll stays out of the sting."""
    pitch, yaw, roll = np.deg2rad(euler_deg)
    gravity = to_package(pitch, yaw, roll if package == "model" else 0.0) @ np.array([0.0, 0.0, -1.0])
    return float(truth[0] + truth[1] * MISALIGNMENT[axis](*np.deg2rad(truth[2:])) @ gravity)


def gyro_v(axis: str, truth: Sequence[float], euler_deg: Sequence[float], rate_dps: Sequence[float]) -> float:
    """One output: the angular velocity from the derivative of the rotation matrix, by a complex step."""
    euler, rate = np.deg2rad(euler_deg), np.asarray(rate_dps)
    step = 1e-30
    derivative = to_package(*(euler + 1j * step * rate)).imag / step
    cross = -derivative @ to_package(*euler).T
    velocity_dps = np.array([cross[2, 1], cross[0, 2], cross[1, 0]])
    return float(truth[0] + truth[1] * MISALIGNMENT[axis](*np.deg2rad(truth[2:])) @ velocity_dps)


def write_package(
    path: Path,
    package: str,
    truth: Mapping[str, Sequence[float]],
    eulers_deg: Sequence[Sequence[float]],
    replications: int = 1,
    noise_v: float = 0.0,
    seed: int = 1,
) -> Path:
    """replication, point, pitch_deg, yaw_deg, roll_deg, <axis>_v."""
    chance = np.random.default_rng(seed)
    clean = [[accelerometer_v(axis, truth[axis], euler, package) for axis in truth] for euler in eulers_deg]
    rows = [
        [replication, point, *euler, *(value + noise_v * chance.normal() for value in values)]
        for replication in range(1, replications + 1)
        for point, (euler, values) in enumerate(zip(eulers_deg, clean, strict=True), start=1)
    ]
    return write_rows(path, ["pitch_deg", "yaw_deg", "roll_deg", *(f"{axis}_v" for axis in truth)], rows)


def write_gyros(
    path: Path, eulers_deg: np.ndarray, rates_dps: np.ndarray, replications: int = 1, noise_v: float = 0.0
) -> Path:
    """replication, point, yaw_deg, roll_deg, the three rates, <axis>_v, of CR's table 4."""
    chance = np.random.default_rng(2)
    motion = list(zip(eulers_deg, rates_dps, strict=True))
    clean = [[gyro_v(axis, TABLE_4[axis], euler, rate) for axis in TABLE_4] for euler, rate in motion]
    rows = [
        [replication, point, euler[1], euler[2], *rate, *(value + noise_v * chance.normal() for value in values)]
        for replication in range(1, replications + 1)
        for point, ((euler, rate), values) in enumerate(zip(motion, clean, strict=True), start=1)
    ]
    names = ["yaw_deg", "roll_deg", "pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps", "x_v", "y_v", "z_v"]
    return write_rows(path, names, rows)


def write_second_step(path: Path) -> Path:
    """replication, point, roll_deg, sting_<axis>_v, <axis>_v along the ramp of CR's table 3: of both packages."""
    rows = [
        [1, point, euler[2]]
        + [accelerometer_v(axis, TABLE_3_STING[axis], euler, "sting") for axis in "xyz"]
        + [accelerometer_v(axis, TABLE_3_MODEL[axis], euler, "model") for axis in "xyz"]
        for point, euler in enumerate(table_3_profile())
    ]
    return write_rows(
        path, ["roll_deg", *(f"sting_{axis}_v" for axis in "xyz"), *(f"{axis}_v" for axis in "xyz")], rows
    )


def write_rows(path: Path, names: Sequence[str], rows: Sequence[Sequence[object]]) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["replication", "point", *names])
        writer.writerows([[repr(float(v)) if isinstance(v, float) else v for v in row] for row in rows])
    return path


def table_3_profile() -> list[tuple[float, float, float]]:
    """Θ = Ψ = Φ from 0 to 10 degrees in 10 s, 1 001 samples (CR IV-A)."""
    return [(angle, angle, angle) for angle in np.linspace(0.0, 10.0, 1001)]


def table_4_profile() -> tuple[np.ndarray, np.ndarray]:
    """Θ, Ψ, Φ = 10 sin 2πft degrees, f = 0.125, 0.0625, 0.25 Hz, 10 s by 0.01 s (CR IV-C), and their rates."""
    omega = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = np.linspace(0.0, 10.0, 1001)[:, None] * omega
    return 10 * np.sin(phase), 10 * omega * np.cos(phase)
