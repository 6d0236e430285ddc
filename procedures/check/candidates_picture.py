"""The picture of a comparison: hours against U95, the candidates that no other beats, and the chosen one."""

from pathlib import Path
from typing import TYPE_CHECKING

from ams.units import ARCSEC_PER_DEG
from procedures.check.candidate import Candidate, Comparison
from procedures.check.design_map import FORMATS, write_picture
from procedures.errors import RequestError
from procedures.report import canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


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
    every, front = comparison.candidates, [comparison.candidates[place] for place in comparison.front]
    chosen = comparison.candidates[comparison.chosen]
    sound, confounded = ([one for one in every if one.is_confounded is wanted] for wanted in (False, True))
    panel.plot(*_places(confounded), "x", color=canvas.GRID, markersize=2.5, label="a drift would pass for a parameter")
    panel.plot(*_places(sound), ".", color=canvas.FAINT, markersize=3.0, label=f"{len(sound)} calibrations")
    panel.plot(*_places(front), "o-", color=canvas.BLUE, markersize=4.0, label="no other is quicker and better")
    panel.plot(*_places([chosen]), "s", color=canvas.RED, markersize=8.0, fillstyle="none", label="chosen")
    panel.annotate(
        f"{chosen.points} × {chosen.replications} × {chosen.samples}",
        (chosen.hours, chosen.half_width_deg * ARCSEC_PER_DEG),
        xytext=(8, 8), textcoords="offset points", color=canvas.RED,
    )  # fmt: skip
    panel.set_xscale("log")
    panel.set_xlabel("hours (p50)")
    panel.set_ylabel("U95 of an angle at use (″)")
    panel.set_title("Points × replications × readings: what an hour is worth")
    panel.grid(color=canvas.GRID, linewidth=0.5, which="both")
    panel.legend(loc="upper right")
    return figure


def _places(candidates: "list[Candidate] | tuple[Candidate, ...]") -> tuple[list[float], list[float]]:
    return [one.hours for one in candidates], [one.half_width_deg * ARCSEC_PER_DEG for one in candidates]
