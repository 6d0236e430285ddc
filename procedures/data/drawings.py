"""Pictures for a notebook: matplotlib figures that show themselves, in the style of the report."""

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ams.arrays import FloatArray
from ams.models.registry import is_solved_from_levels
from procedures.report.canvas import BLUE, FAINT, WIDTH_IN, plain_axes, style, to_svg
from procedures.solution.request import SolvedSensor

_PANEL_IN = 1.9
_MICROVOLTS = 1e6


class Drawing(Figure):
    """A figure that a notebook shows without pyplot."""

    def _repr_svg_(self) -> str:
        with style():
            return to_svg(self).decode("utf-8")


def means_against_pitch(dwells: pd.DataFrame, readings: pd.DataFrame, channel: str | None) -> Drawing:
    """Draw the mean reading of every accepted dwell of the design, a panel a channel of a sensor, or of one channel."""
    rows = readings.join(dwells[["accepted", "purpose", "pitch_deg"]])
    rows = rows[rows["accepted"] & (rows["purpose"] == "design")]
    rows = rows[rows["sensor"] != ""] if channel is None else rows[rows["channel"] == channel]
    return _panels(
        (f"{name} ({group['unit'].iloc[0]})", group["pitch_deg"].to_numpy(), group["mean"].to_numpy())
        for name, group in rows.groupby("channel", sort=False)
    )


def attitudes_by_step(steps: pd.DataFrame) -> Drawing:
    """Draw where every axis stands, step by step, a panel an axis; the steps are those of a plan."""
    axes = [name for name in steps.columns if name.endswith("_deg")]
    indices = steps.index.to_numpy()
    return _panels(
        ((f"{name.removesuffix('_deg')} (°)", indices, steps[name].to_numpy()) for name in axes), across="step"
    )


def residuals_of(sensors: Mapping[str, SolvedSensor]) -> Drawing:
    """Draw observed less fitted output of every row of the solution that is a dwell, a panel an axis.

    Straight lines have levels in place of attitudes, each axis its own: theirs stand in the order of the rows.
    """
    solved = [(name, sensor.calibration) for name, sensor in sensors.items() if sensor.calibration is not None]
    if solved and all(is_solved_from_levels(calibration.model) for _, calibration in solved):
        return _panels(
            (
                (f"{name} {label} ({sensors[name].observations.unit_of(label)})", np.arange(1.0, rows.size + 1.0), rows)
                for name, calibration in solved
                for label, rows in ((label, axis.residuals_v) for label, axis in calibration.axes.items())
            ),
            across="row",
        )
    return _panels(
        (f"{name} {axis} (µV)", np.rad2deg(sensor.observations.pitch_rad), solved.residuals_v * _MICROVOLTS)
        for name, sensor in sensors.items()
        if sensor.calibration is not None
        for axis, solved in sensor.calibration.axes.items()
        if solved.residuals_v.size == sensor.observations.rows
    )


def _panels(panels: Iterable[tuple[str, FloatArray, FloatArray]], across: str = "pitch (°)") -> Drawing:
    drawn = list(panels)
    with style():
        figure = Drawing(figsize=(WIDTH_IN, 0.6 + _PANEL_IN * max(1, len(drawn))), layout="constrained")
        for index, (label, stations, values) in enumerate(drawn):
            axes = figure.add_subplot(len(drawn), 1, index + 1)
            plain_axes(axes)
            axes.axhline(0.0, color=FAINT, linewidth=0.6)
            axes.plot(stations, values, "o", color=BLUE, markersize=2.5)
            axes.set_ylabel(label)
            axes.set_xlabel(across if index == len(drawn) - 1 else "")
        return figure
