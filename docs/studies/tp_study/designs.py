"""TP's figures 1 to 5 and table 1: the variance function and the figures of merit of the planner's designs.

Source: TP 5.3. M = 64 roll values, N pitch values; roll is repeated at 180° in figure 5 only.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from tp_study.printed import TABLE_1

from ams.analysis.design_variance import AngleBox, evaluate_design, variance_function
from ams.analysis.design_without_roll import variance_without_roll
from procedures.plan.designs import Design, full_grid, tumble, uniform_circle_deg, uniform_roll, uniform_symmetric

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

RANGES_DEG = (30.0, 45.0, 90.0, 180.0)
M, N = 64, 33
N_WITHOUT_ROLL = 65
N_FAMILY = (5, 9, 17, 33, 65)
CENTRE_DEG = (*range(11), 12, 14, 18, 22, 26, 30)
BORDER_DEG = (0, 4, 8, 12, 16, 18, *range(20, 31))
"""Pitch of figure 3, both signs. The text gives all but ±12° and ±18°; these make N = 33 and table 1's values."""


def pitch_deg(limit_deg: float, count: int) -> FloatArray:
    return np.linspace(-limit_deg, limit_deg, count)


def both_signs(half_deg: Sequence[float]) -> list[float]:
    """Each value and its negative, zero once."""
    return sorted({sign * float(value) for value in half_deg for sign in (1.0, -1.0)})


def points_rad(design: Design) -> tuple[FloatArray, FloatArray]:
    return (
        np.deg2rad([point.pitch_deg for point in design.points]),
        np.deg2rad([point.roll_deg for point in design.points]),
    )


def table_1_designs() -> dict[str, tuple[Design, float, float | None]]:
    """Figure to design, half its calibration range and half its usage range, degrees."""
    roll = uniform_circle_deg(M)
    usage = {"2(b)": 30.0, "2(c)": 30.0, "2(d)": 30.0}
    found: dict[str, tuple[Design, float, float | None]] = {}
    for name, limit in zip(("2(a)", "2(b)", "2(c)", "2(d)"), RANGES_DEG, strict=True):
        found[name] = (uniform_symmetric(pitch_deg(limit, N).tolist(), roll), limit, usage.get(name))
    found["3, top"] = (uniform_roll(both_signs(CENTRE_DEG), roll), 30.0, 10.0)
    found["3, bottom"] = (uniform_roll(both_signs(BORDER_DEG), roll), 30.0, 10.0)
    found["4"] = (full_grid([-30.0] * 16 + [0.0] + [30.0] * 16, roll), 30.0, 10.0)
    found["5"] = (uniform_symmetric(pitch_deg(30.0, N).tolist(), uniform_circle_deg(M, repeat=True)), 30.0, None)
    return found


def table_1() -> list[tuple[str, float, float, float | None, float | None]]:
    """Figure, V^½ printed and here, V_R^½ printed and here."""
    rows = []
    for name, (design, limit, usage) in table_1_designs().items():
        merits = [None if half is None else _merit(design, half) for half in (limit, usage)]
        printed = TABLE_1[name]
        assert merits[0] is not None
        rows.append((name, printed[0], merits[0], printed[1], merits[1]))
    return rows


def _merit(design: Design, half_deg: float) -> float:
    half = float(np.deg2rad(half_deg))
    return evaluate_design(*points_rad(design), AngleBox((-half, half))).figure_of_merit_sqrt


def normalised(design: Design, at_deg: FloatArray, roll_deg: float = 0.0) -> FloatArray:
    """√(K φᵀP⁻¹φ), what TP's figures 2 to 5 have on the ordinate."""
    at = np.deg2rad(at_deg)
    return np.sqrt(
        len(design.points) * variance_function(*points_rad(design), at, np.full(at.shape, np.deg2rad(roll_deg)))
    )


def draw_figure_1(figure: "Figure") -> None:
    axes = figure.subplots(2, 2, sharey=True)
    for panel, limit, letter in zip(axes.flat, RANGES_DEG, "abcd", strict=True):
        at = np.linspace(-limit, limit, 181)
        curve = np.sqrt(
            N_WITHOUT_ROLL * variance_without_roll(np.deg2rad(pitch_deg(limit, N_WITHOUT_ROLL)), np.deg2rad(at))
        )
        four, _ = points_rad(tumble(with_roll=False))
        panel.plot(at, curve, label=f"D₁, N = {N_WITHOUT_ROLL}")
        panel.plot(at, np.sqrt(4 * variance_without_roll(four, np.deg2rad(at))), ":", label="four-point tumble")
        _dress(panel, f"1({letter}): ±{limit:g}°")
    axes[0, 0].legend()


def draw_figure_2(figure: "Figure") -> None:
    axes = figure.subplots(2, 2, sharey=True)
    for panel, limit, letter in zip(axes.flat, RANGES_DEG, "abcd", strict=True):
        at = np.linspace(-limit, limit, 181)
        for count in N_FAMILY:
            design = uniform_symmetric(pitch_deg(limit, count).tolist(), uniform_circle_deg(M))
            panel.plot(at, normalised(design, at), label=f"N = {count}")
        panel.plot(at, normalised(tumble(with_roll=True), at), ":", color="black", label="six-point tumble")
        _dress(panel, f"2({letter}): ±{limit:g}°")
    axes[0, 0].legend(ncols=2)


def draw_figures_3_to_5(figure: "Figure") -> None:
    axes = figure.subplots(2, 2, sharey=True)
    at = np.linspace(-30.0, 30.0, 181)
    designs = table_1_designs()
    for panel, name in zip(axes.flat, ("3, top", "3, bottom", "4", "5"), strict=True):
        design = designs[name][0]
        for roll in np.linspace(-180.0, 180.0, 13) if name == "5" else (0.0,):
            panel.plot(at, normalised(design, at, float(roll)), color="#0072b2", linewidth=0.8)
        here = np.array(design.pitch_values_deg)
        panel.plot(here, normalised(design, here), "o", markersize=2.5, color="#1a1a1a")
        _dress(panel, name)


def _dress(panel: "Axes", title: str) -> None:
    panel.set_title(title, loc="left")
    panel.set_xlabel("pitch (°)")
    panel.set_ylabel("√(K σ_v²/σ_E²)")
    panel.grid(visible=True, color="#e3e3e3", linewidth=0.5)


def curve_facts() -> dict[str, float]:
    """The numbers that TP 5.3 puts into words."""
    zero = np.zeros(1)
    without = {limit: np.deg2rad(pitch_deg(limit, N_WITHOUT_ROLL)) for limit in RANGES_DEG}

    def centre(limit: float) -> float:
        return float(np.sqrt(N_WITHOUT_ROLL * variance_without_roll(without[limit], zero))[0])

    with_roll = table_1_designs()
    ends = {
        name: normalised(with_roll[name][0], np.array([0.0, with_roll[name][1], 90.0])) for name in ("2(b)", "2(c)")
    }
    repeated = [normalised(with_roll["5"][0], np.array([30.0]), r)[0] for r in np.linspace(-180.0, 180.0, 13)]
    return {
        "centre_180_over_90": centre(180.0) / centre(90.0),
        "centre_180_over_30": centre(180.0) / centre(30.0),
        "2b_centre": float(ends["2(b)"][0]),
        "2b_border": float(ends["2(b)"][1]),
        "2c_centre": float(ends["2(c)"][0]),
        "2c_border": float(ends["2(c)"][2]),
        "5_spread": float(np.ptp(repeated) / np.mean(repeated)),
    }
