"""The study's pictures, one for each group of TP's figures."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from tp_study.designs import draw_figure_1, draw_figure_2, draw_figures_3_to_5
from tp_study.evidence import Evidence
from tp_study.judged import residuals
from tp_study.pictures import curve_panel, inferred_panel, residual_panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Draw = Callable[["Figure"], None]

DOWN_FROM_180 = tuple(float(angle) for angle in range(180, -1, -30))
PITCHES_30 = tuple(float(angle) for angle in range(-30, 31, 10))


def pictures(evidence: Evidence) -> Mapping[str, tuple[float, Draw]]:
    """File name to height (inches) and what draws it."""
    return {
        "figure-01.png": (5.0, draw_figure_1),
        "figure-02.png": (5.0, draw_figure_2),
        "figures-03-to-05.png": (5.0, draw_figures_3_to_5),
        "figures-22-to-27.png": (7.2, lambda figure: without_roll(figure, evidence)),
        "figures-28-to-30.png": (5.0, lambda figure: narrow_over_pitch(figure, evidence)),
        "figures-31-to-33.png": (5.0, lambda figure: narrow_over_roll(figure, evidence)),
        "figures-34-to-36.png": (7.0, lambda figure: second_and_fraction(figure, evidence)),
        "figures-37-to-41.png": (7.2, lambda figure: soft_mount(figure, evidence)),
        "figures-42-and-43.png": (2.6, lambda figure: second_sensor(figure, evidence)),
        "figures-44-to-46.png": (7.2, lambda figure: package(figure, evidence, "44", "45", "46")),
        "figures-47-to-49.png": (7.2, lambda figure: package(figure, evidence, "47", "48", "49")),
        "figures-50-and-51.png": (7.2, lambda figure: tumble(figure, evidence)),
        "figures-52-to-54.png": (7.2, lambda figure: reduced_against_full(figure, evidence)),
        "extended-model.png": (5.0, lambda figure: extended(figure, evidence)),
    }


def without_roll(figure: "Figure", evidence: Evidence) -> None:
    grid = figure.subplots(3, 2)
    limits = (None, 30.0, 60.0)
    for (left, right), name, limit in zip(grid, ("22", "24", "26"), limits, strict=True):
        solved = evidence.solved[name]
        residual_panel(left, name, solved.x, solved.observations)
        inferred_panel(right, str(int(name) + 1), evidence.pitch[name], solved.observations, limit=limit)


def narrow_over_pitch(figure: "Figure", evidence: Evidence) -> None:
    grid = figure.subplots(2, 2)
    for panel, name in zip(grid[0], ("28(a)", "28(b)"), strict=True):
        residual_panel(panel, name, evidence.solved[name].x, evidence.solved[name].observations)
    found, rows = evidence.pitch["28(b)"], evidence.solved["28(b)"].observations
    inferred_panel(grid[1, 0], "29", found, rows)
    curve_panel(grid[1, 1], "30: by roll", found.error, rows, "pitch", DOWN_FROM_180)


def narrow_over_roll(figure: "Figure", evidence: Evidence) -> None:
    grid = figure.subplots(2, 2)
    solved, found = evidence.solved["28(b)"], evidence.pitch["28(b)"]
    residual_panel(grid[0, 0], "31", solved.x, solved.observations, "roll")
    inferred_panel(grid[0, 1], "32", found, solved.observations, "roll")
    curve_panel(grid[1, 0], "33: by pitch", found.error, solved.observations, "roll", PITCHES_30)
    grid[1, 1].axis("off")


def second_and_fraction(figure: "Figure", evidence: Evidence) -> None:
    panels = figure.subplots(3, 1)
    for panel, name in zip(panels[:2], ("34", "35"), strict=True):
        residual_panel(panel, name, evidence.solved[name].x, evidence.solved[name].observations)
    residual_panel(panels[2], "36", evidence.held["36"].x, evidence.held["36"].observations)


def soft_mount(figure: "Figure", evidence: Evidence) -> None:
    grid = figure.subplots(3, 2)
    solved = evidence.solved["37"]
    left, rows = residuals(solved.x), solved.observations
    residual_panel(grid[0, 0], "37", solved.x, rows)
    inferred_panel(grid[0, 1], "38", evidence.pitch["37"], rows, limit=30.0)
    curve_panel(grid[1, 0], "39: by roll", left, rows, "pitch", DOWN_FROM_180[::-1])
    residual_panel(grid[1, 1], "40", solved.x, rows, "roll")
    curve_panel(grid[2, 0], "41: by pitch", left, rows, "roll", DOWN_FROM_180[::-1])
    grid[2, 1].axis("off")


def second_sensor(figure: "Figure", evidence: Evidence) -> None:
    left, right = figure.subplots(1, 2)
    solved = evidence.solved["42"]
    residual_panel(left, "42", solved.x, solved.observations)
    inferred_panel(right, "43", evidence.pitch["42"], solved.observations, limit=80.0)


def package(figure: "Figure", evidence: Evidence, name: str, pitch: str, roll: str) -> None:
    grid = figure.subplots(3, 2)
    solved = evidence.solved[name]
    for panel, axis, letter in zip(grid[:, 0], "xyz", "abc", strict=True):
        residual_panel(panel, f"{name}({letter}): {axis}", solved.axes[axis], solved.observations)
    first = int(solved.observations.replication.min())
    inferred_panel(grid[0, 1], pitch, evidence.pitch[name], solved.observations, replication=first)
    inferred_panel(grid[1, 1], roll, evidence.roll[name], solved.observations, replication=first)
    inferred_panel(grid[2, 1], f"{pitch}, over roll", evidence.pitch[name], solved.observations, "roll", first)


def tumble(figure: "Figure", evidence: Evidence) -> None:
    grid = figure.subplots(3, 2)
    solved = evidence.solved["50"]
    for panel, axis in zip(grid[:, 0], "xyz", strict=True):
        residual_panel(panel, f"50: {axis}", solved.axes[axis], solved.observations)
    inferred_panel(grid[0, 1], "51: pitch", evidence.pitch["50"], solved.observations)
    inferred_panel(grid[1, 1], "51: roll", evidence.roll["50"], solved.observations)
    grid[2, 1].axis("off")


def reduced_against_full(figure: "Figure", evidence: Evidence) -> None:
    grid = figure.subplots(3, 2)
    for panel, axis, letter in zip(grid[:, 0], "xyz", "abc", strict=True):
        residual_panel(panel, f"52({letter}): {axis}", evidence.held["52"].axes[axis], evidence.held["52"].observations)
    residual_panel(grid[0, 1], "53: x", evidence.solved["53"].x, evidence.solved["53"].observations)
    residual_panel(grid[1, 1], "54: x", evidence.held["54"].x, evidence.held["54"].observations)
    grid[2, 1].axis("off")


def extended(figure: "Figure", evidence: Evidence) -> None:
    grid = figure.subplots(2, 2, sharey=True)
    for row, name, title in zip(grid, ("37", "37 extended"), ("pitch-roll", "extended"), strict=True):
        solved = evidence.solved[name]
        residual_panel(row[0], title, solved.x, solved.observations)
        residual_panel(row[1], title, solved.x, solved.observations, "roll")
    height = float(np.max(np.abs(residuals(evidence.solved["37"].x)))) * 1.1
    grid[0, 0].set_ylim(-height, height)
