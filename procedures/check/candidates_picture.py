"""The picture of a comparison: hours against what the target is about; the best candidates and the chosen one."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ams.parameter_words import words_of
from ams.units import ARCSEC_PER_DEG, small_unit
from procedures.check.candidate import Candidate, Comparison, Target
from procedures.check.design_map import FORMATS, write_picture
from procedures.errors import RequestError
from procedures.report import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

_HOURS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0)
"""Where the axis of hours has figures."""


def plot_comparison(comparison: Comparison, path: Path) -> None:
    """Draw into an SVG, PNG or PDF file.

    Raises: RequestError for another ending, WriteFailed where it cannot be written.
    """
    if path.suffix.lower() not in FORMATS:
        raise RequestError(f"plan: --plot: got {path.name!r}, allowed are names that end in {', '.join(FORMATS)}")
    with canvas.style():
        write_picture(_figure(comparison), path)


def _figure(comparison: Comparison) -> "Canvas":
    figure = canvas.canvas(3.6)
    panel = figure.subplots(1, 1)
    figure.subplots_adjust(left=0.085, right=0.985, top=0.93, bottom=0.13)
    every, front = comparison.candidates, [comparison.candidates[index] for index in comparison.front]
    chosen = comparison.candidates[comparison.chosen]
    sound, confounded = (
        [candidate for candidate in every if candidate.is_confounded is wanted] for wanted in (False, True)
    )
    what, factor = _height(comparison.request.target)

    def points_of(some: Sequence[Candidate]) -> tuple[list[float], list[float]]:
        return [candidate.hours for candidate in some], [
            candidate.value(comparison.request.target) * factor for candidate in some
        ]

    panel.plot(
        *points_of(confounded), "x", color=canvas.GRID, markersize=2.5, label="a drift would pass for a parameter"
    )
    panel.plot(*points_of(sound), ".", color=canvas.FAINT, markersize=3.0, label=f"{len(sound)} calibrations")
    panel.plot(*points_of(front), "o-", color=canvas.BLUE, markersize=4.0, label="no other is quicker and better")
    panel.plot(*points_of([chosen]), "s", color=canvas.RED, markersize=8.0, fillstyle="none", label="chosen")
    panel.annotate(
        f"{chosen.points} × {chosen.replications} × {chosen.samples}",
        (chosen.hours, chosen.value(comparison.request.target) * factor),
        xytext=(-8, -8), textcoords="offset points", color=canvas.RED, ha="right", va="top",
    )  # fmt: skip
    panel.set_xscale("log")
    panel.set_xticks([hours for hours in _HOURS if every[0].hours <= hours <= every[-1].hours], minor=False)
    panel.xaxis.set_major_formatter(lambda hours, _: f"{hours:g}")
    panel.xaxis.set_minor_formatter(lambda *_: "")
    panel.set_xlabel("hours (p50)")
    panel.set_ylabel(what)
    panel.set_title("Points × replications × readings: what an hour is worth")
    panel.grid(color=canvas.GRID, linewidth=0.5, which="both")
    panel.legend(loc="upper right")
    return figure


def _height(target: Target) -> tuple[str, float]:
    """Return what stands over the hours, and its factor: an angle, or the parameter that the target names."""
    if target.parameter is None:
        return "U95 of an angle at use (″)", ARCSEC_PER_DEG
    words = words_of(target.parameter[0])
    unit, factor = small_unit(words.unit)
    return f"95 % half-width of {words.label} ({unit})", factor
