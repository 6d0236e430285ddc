"""Angles from outputs and rates: rows and steps a second on one processor, beside numpy's own limit and peers.

The limit is what numpy takes for the least that the answer needs: for angles one matrix product and two arctangents of
a block, for gyros the quaternions of the turns. scipy's integrator and rotations stand for the peers that go step by
step, and where the package ahrs is installed (``pip install ahrs``; calrig does not ask for it) so do its integration
and its Kalman filter. Processor time is taken, so that what else the machine does counts little.
"""

import resource
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from threadpoolctl import threadpool_limits

from ams.attitude.attitude_filter import AttitudeFilter, FilterSettings
from ams.attitude.few_axes import OneAxis, TwoAxes
from ams.attitude.force_covariance import ParameterErrors
from ams.attitude.gyro import cr_angles_rad, path_by_butcher
from ams.attitude.kalman import Estimate, GyroNoise
from ams.attitude.rate_scan import Path, RateScan, quaternions, turns_of_rates
from ams.attitude.static import redundancy_limit
from ams.attitude.three_axes import BLOCK_ROWS, three_axes
from ams.frames import body_rates_rad_s, specific_force
from bench.figure import Effort, Figure

FloatArray = NDArray[np.float64]
K = np.array([[2.5, 0.02, -0.03], [0.01, -2.4, 0.04], [-0.02, 0.03, 2.6]])
OFFSET_V = np.array([0.01, -0.02, 0.03])
READING_V = np.array([1e-5, 3e-5, 2e-5])


def figures(effort: Effort) -> Iterator[Figure]:
    """Rates, times and ratios."""
    yield from _angles(effort.amount(1_000_000, 10_000))
    yield from _gyro(effort.amount(1_000_000, 10_000), effort.amount(5_000, 50))
    yield from _kalman(effort.amount(5_000, 50))


def _angles(rows: int) -> Iterator[Figure]:
    rng = np.random.default_rng(1)
    pitch, roll = rng.uniform(-1.2, 1.2, rows), rng.uniform(-3.0, 3.0, rows)
    outputs = OFFSET_V[:, None] + K @ specific_force(pitch, roll).T + READING_V[:, None] * rng.normal(size=(3, rows))
    parts = np.stack([np.diag(rng.uniform(1e-12, 4e-12, 12)) for _ in range(2)])
    errors = ParameterErrors(parts, np.array([5.0, 60.0]), READING_V**2)
    three = three_axes(K, OFFSET_V, errors, redundancy_limit)
    limit_s = _limit_s(outputs)
    whole_s, plain_s = best_s(lambda: three.attitude(outputs)), best_s(lambda: three.angles(outputs))
    yield Figure(
        "three axes, sd and redundancy", rows / whole_s / 1e6, "M/s", 5.0, at_most=False,
        note=f"{whole_s / limit_s:.1f} × numpy's product and arctangents",
    )  # fmt: skip
    yield Figure(
        "three axes, angles alone", rows / plain_s / 1e6, "M/s", 15.0, at_most=False, note=f"{plain_s / limit_s:.1f} ×"
    )
    pair = TwoAxes(K[:2], OFFSET_V[:2], ParameterErrors(parts[:, :8, :8], errors.dof, READING_V[:2] ** 2))
    single = OneAxis(K[0], OFFSET_V[0], ParameterErrors(parts[:, :4, :4], errors.dof, READING_V[:1] ** 2))
    two_s = best_s(lambda: pair.attitude(outputs[:2]))
    single_s = best_s(lambda: single.attitude(outputs[0], roll, 1e-4))
    yield Figure("two axes, sd and flags", rows / two_s / 1e6, "M/s", 3.0, at_most=False)
    yield Figure("one axis with known roll, sd and flags", rows / single_s / 1e6, "M/s", 5.0, at_most=False)


def _limit_s(outputs: FloatArray) -> float:
    inverse = np.linalg.inv(K)

    def work() -> None:
        for start in range(0, outputs.shape[1], BLOCK_ROWS):
            force = inverse @ outputs[:, start : start + BLOCK_ROWS]
            np.arctan2(force[0], np.sqrt(force[1] * force[1] + force[2] * force[2]))
            np.arctan2(force[1], force[2])

    return best_s(work)


def _gyro(all_steps: int, steps: int) -> Iterator[Figure]:
    """CR's profile at 1 kHz: pitch, yaw and roll of 10° at 0.125, 0.0625 and 0.25 Hz."""
    time_s = np.arange(all_steps + 1) * 1e-3
    omega = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = time_s[:, None] * omega
    euler = np.deg2rad(10.0) * np.sin(phase)
    rates = body_rates_rad_s(euler, np.deg2rad(10.0) * omega * np.cos(phase))
    by_channel, start = np.ascontiguousarray(rates.T), Rotation.from_euler("YZX", euler[0]).as_quat()
    scan_s = best_s(lambda: _integrated(by_channel, start), repeats=3)
    limit_s = best_s(lambda: quaternions(turns_of_rates(by_channel, 1e-3, "cubic")), repeats=3)
    yield Figure(
        "gyro, 10⁶ steps to quaternions", scan_s, "s", 0.5, at_most=True, note=f"{scan_s / limit_s:.1f} × turns alone"
    )
    found = cr_angles_rad(_integrated(by_channel, start), euler[0]).T
    angles_s = best_s(lambda: cr_angles_rad(_integrated(by_channel, start), euler[0]), repeats=3)
    yield Figure("gyro, 10⁶ steps to pitch, yaw, roll", angles_s, "s", 0.8, at_most=True)
    yield Figure(
        "  off the closed form", float(np.rad2deg(np.max(np.abs(found - euler)))) * 1e9, "n°", 1.0, at_most=True
    )
    butcher_s = best_s(lambda: _integrated(by_channel[:, :steps], start, path_by_butcher), repeats=1)
    loop_s = best_s(lambda: _step_by_step(rates[:steps]), repeats=1)
    scipy_s = best_s(lambda: _by_solve_ivp(time_s[:steps], rates[:steps], start), repeats=1)
    peers = [("Butcher's method", butcher_s), ("scipy's rotations", loop_s), ("solve_ivp", scipy_s)]
    if find_spec("ahrs") is not None:
        peers.append(("ahrs AngularRate", best_s(lambda: _by_ahrs(rates[:steps], start), repeats=1)))
    for name, their_s in peers:
        yield Figure(f"  {name} / ours", their_s / steps * all_steps / scan_s, "×", 10.0, at_most=False, is_gated=True)


def _integrated(rates: FloatArray, start: FloatArray, path: Path | None = None) -> FloatArray:
    """Return the (4, N) attitudes at all of (3, N) samples, as a stream gives them."""
    scan = RateScan(start, 1e-3, path=path)
    return np.concatenate([scan.feed(rates).quaternion, scan.finish().quaternion], axis=1)


def _by_ahrs(rates: FloatArray, start: FloatArray) -> Any:
    scalar_first = np.roll(start, 1)
    return import_module("ahrs.filters").AngularRate(gyr=rates, q0=scalar_first, frequency=1e3, method="series").Q


def _step_by_step(rates: FloatArray) -> Rotation:
    attitude = Rotation.identity()
    for turn in (rates[1:] + rates[:-1]) * 0.5e-3:
        attitude = attitude * Rotation.from_rotvec(turn)
    return attitude


def _by_solve_ivp(time_s: NDArray[np.floating], rates: FloatArray, start: FloatArray) -> FloatArray:
    def slope(now_s: float, q: FloatArray) -> list[float]:
        a, b, c = (float(np.interp(now_s, time_s, column)) / 2.0 for column in rates.T)
        x, y, z, w = q.tolist()
        return [w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a, -x * a - y * b - z * c]

    return np.asarray(solve_ivp(slope, (0.0, float(time_s[-1])), start, rtol=1e-9, atol=1e-12, max_step=1e-2).y)


def _kalman(steps: int) -> Iterator[Figure]:
    rng = np.random.default_rng(2)
    gyro = rng.normal(0.0, 0.01, (3, steps))
    force = np.array([[0.0], [0.0], [-1.0]]) + rng.normal(0.0, 0.01, (3, steps))
    magnetic = np.array([[22.0], [3.0], [42.0]]) + rng.normal(0.0, 0.5, (3, steps))
    start = Estimate(np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.diag([0.1**2] * 3 + [0.01**2] * 3))
    plain = FilterSettings(0.01, GyroNoise(1e-3, 1e-5), 0.01)
    aided = FilterSettings(
        0.01, GyroNoise(1e-3, 1e-5), 0.01, field_reference_ut=(22.0, 3.0, 42.0), field_sd_ut=0.5
    )  # fmt: skip
    gravity_s = best_s(lambda: AttitudeFilter(plain, start).run(gyro, force))
    both_s = best_s(lambda: AttitudeFilter(aided, start).run(gyro, force, magnetic))
    yield Figure("Kalman step, gyro and gravity", gravity_s / steps * 1e6, "µs", 40.0, at_most=True)
    yield Figure("Kalman step, with a field", both_s / steps * 1e6, "µs", 40.0, at_most=True)
    if find_spec("ahrs") is not None:
        upwards = np.ascontiguousarray(-9.80665 * force.T)
        theirs_s = best_s(lambda: _by_ahrs_filter(np.ascontiguousarray(gyro.T), upwards), repeats=1)
        yield Figure("  ahrs EKF / ours", theirs_s / gravity_s, "×", 1.5, at_most=False, is_gated=True)


def _by_ahrs_filter(gyro: FloatArray, upwards_mps2: FloatArray) -> Any:
    return import_module("ahrs.filters").EKF(gyr=gyro, acc=upwards_mps2, frequency=100.0).Q


def best_s(work: Callable[[], object], repeats: int = 5) -> float:
    """Processor seconds of one call, the best of several, with one thread of linear algebra as ``calrig attitude``."""
    taken = []
    with threadpool_limits(limits=1, user_api="blas"):
        for _ in range(repeats):
            start_s = processor_s()
            work()
            taken.append(processor_s() - start_s)
    return min(taken)


def processor_s() -> float:
    """Return what this process has taken of the processors until now."""
    if sys.platform != "win32":
        used = resource.getrusage(resource.RUSAGE_SELF)
        return used.ru_utime + used.ru_stime
    raise OSError("Windows has no getrusage")
