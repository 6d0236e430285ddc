"""The numbers of the page: what the redrawn figures say where the reports say something."""

import numpy as np
from attitude_study import singular
from attitude_study.motions import by_hand, construction, flight
from attitude_study.tp_figures import ROLL_DEG, by_three, by_two, furthest_from_roll_90, one_axis, rank_of_figure_12


def facts() -> dict[str, object]:
    """Return every number that the template names."""
    return _of_one_and_two() | _of_three() | _of_cr() | _of_sr() | singular.facts()


def _of_one_and_two() -> dict[str, object]:
    at_30, at_0, at_89 = one_axis(1.0, np.array([30.0, 0.0, 89.0]), np.zeros(3))
    roll = ROLL_DEG
    over = {ratio: one_axis(ratio, np.zeros(roll.size), roll) for ratio in (1.0, 10.0, 100.0)}
    spread = {ratio: float(np.nanmax(spreads) / np.nanmin(spreads)) for ratio, spreads in over.items()}
    clear = np.abs(np.abs(roll) - 90.0) > 5.0
    equal, coarse, wide = (
        np.concatenate([by_two("xy", coning, (90.0, 0.0), ratio, pitch)[0][clear] * np.cos(np.deg2rad(pitch))
                        for pitch in (0.0, 20.0, 40.0)])
        for coning, ratio in ((0.1, 1.0), (0.1, 10.0), (1.0, 10.0))
    )  # fmt: skip
    beside = by_two("xy", 0.1, (0.0, 0.0), 10.0, 40.0)[0] * np.cos(np.deg2rad(40.0))
    minimum = np.abs(roll[np.nanargmin(by_two("xy", 0.1, (90.0, 0.0), 1.0, 0.0)[1])])
    return {
        "one_at_30": 100.0 * (at_30 / at_0 - 1.0), "one_at_89": at_89,
        "roll_1": spread[1.0], "roll_10": spread[10.0], "roll_100": spread[100.0],
        "locus_0": furthest_from_roll_90(0.0), "locus_90": furthest_from_roll_90(90.0),
        "two_equal": np.nanmax(equal), "two_coarse": np.nanmax(coarse), "two_wide": np.nanmax(wide),
        "two_beside": np.nanmax(beside), "two_minimum": min(minimum, 180.0 - minimum),
    }  # fmt: skip


def _of_three() -> dict[str, object]:
    pitch = np.array([0.0, 30.0, 60.0])
    worst = {}
    for coning, ratio in ((0.1, 10.0), (1.0, 10.0), (1.0, 1.0), (5.0, 10.0)):
        alpha = np.deg2rad(pitch)
        free = 1.0 / np.sqrt(np.cos(alpha) ** 2 + np.sin(alpha) ** 2 / ratio**2)
        worst[coning, ratio] = max(
            float(np.max(np.abs(by_three(coning, ratio, pitch, np.full(3, roll))[0] / free - 1.0)))
            for roll in (0.0, 30.0, 60.0, 90.0)
        )
    aside, level = (by_three(5.0, 10.0, np.zeros(1), np.array([roll]))[0][0] for roll in (90.0, 0.0))
    determinant, least = rank_of_figure_12()
    return {
        "three_01": 100.0 * worst[0.1, 10.0], "three_1": 100.0 * worst[1.0, 10.0],
        "three_even": 100.0 * worst[1.0, 1.0],
        "three_5": 100.0 * (aside / level - 1.0), "determinant": determinant, "least": least,
        "ols_30": np.hypot(np.cos(np.pi / 6), 10.0 * np.sin(np.pi / 6)),
        "wls_30": 1.0 / np.sqrt(0.75 + 0.25 / 100.0),
    }  # fmt: skip


def _of_cr() -> dict[str, object]:
    moved, resting = by_hand(True), by_hand(False)
    held = (moved.time_s > 9.0) & (moved.time_s < 10.0)
    return {
        "cubic": construction(1000.0).worst_deg, "butcher": construction(1000.0, "cubic", "butcher").worst_deg,
        "hold_100": construction(100.0, "hold").worst_deg, "linear_100": construction(100.0, "linear").worst_deg,
        "hold_1000": construction(1000.0, "hold").worst_deg,
        "held": float(np.mean(moved.accelerometer_deg[held])),
        "rest_sd": float(np.std(resting.accelerometer_deg)),
        "rest_inside": 100.0 * float(np.mean(np.abs(resting.accelerometer_deg) < 0.1)),
        "rest_smoothed": float(np.std(resting.accelerometer_deg[: 100 * 17].reshape(-1, 20).mean(axis=1))),
        "gyro_end": float(moved.gyro_deg[-1]), "gyro_rest": float(resting.gyro_deg[-1]),
    }  # fmt: skip


def _of_sr() -> dict[str, object]:
    flown = flight()
    gyro, filtered = flown.off_deg(flown.by_gyro), flown.off_deg(flown.by_filter)
    found = np.rad2deg(flown.filtered.bias_rad_s[:, -1])
    return {
        "flight_gyro": float(gyro.max()), "flight_filter": float(filtered[600:].max()),
        "flight_rms": float(np.sqrt(np.mean(filtered[600:] ** 2))),
        "flight_norm": float(np.abs(np.linalg.norm(flown.quaternion_by_gyro, axis=0) - 1.0).max()),
        "bias": ", ".join(f"{value:+.3f}" for value in found),
    }  # fmt: skip
