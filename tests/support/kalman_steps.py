"""The filter's steps one by one, from an estimate to the next: what streams do to their state."""

from dataclasses import dataclass

import numpy as np

from ams.attitude.kalman import Estimate, GyroNoise, State, carry, known_direction, state_of, weigh


@dataclass(frozen=True)
class Correction:
    """What a measured direction did to the estimate."""

    estimate: Estimate
    normalised_innovation: float


def start_estimate(quaternion: np.ndarray, turn_sd_rad: float, bias_sd_rad_s: float) -> Estimate:
    """Return an estimate to start from; all three turns and all three biases equally uncertain, and no bias."""
    covariance = np.diag([turn_sd_rad**2] * 3 + [bias_sd_rad_s**2] * 3)
    return Estimate(quaternion / np.linalg.norm(quaternion), np.zeros(3), covariance)


def propagate(estimate: Estimate, gyro_rad_s: np.ndarray, interval_s: float, noise: GyroNoise) -> Estimate:
    """Return the estimate one interval later."""
    state = state_of(estimate)
    carry(state, tuple(gyro_rad_s.tolist()), interval_s, noise)
    return _estimate(state)


def correct(
    estimate: Estimate, measured: np.ndarray, reference: np.ndarray, sd: float, gate: float | None = None
) -> Correction:
    """Take a (3,) vector measured in body axes; with ``gate`` the state says itself whether it was left out."""
    state = state_of(estimate)
    innovation = weigh(state, tuple(measured.tolist()), known_direction(reference, sd), gate).normalised
    return Correction(_estimate(state), innovation)


def _estimate(state: State) -> Estimate:
    return Estimate(np.array(state.quaternion), np.array(state.bias_rad_s), state.covariance)
