"""The pictures of :mod:`procedures.kinds.section`, drawn in the report's one style."""

from collections.abc import Iterator

from procedures.kinds.section import Plot, SensorPage
from procedures.report.canvas import SERIES, SYMBOLS, Figure, canvas, plain_axes, to_svg

HEIGHT_IN = 2.8


def section_figures(section: SensorPage, slug: str) -> Iterator[Figure]:
    """Call inside :func:`procedures.report.canvas.style`."""
    for plot in section.plots:
        yield Figure(f"{slug}-{plot.name.rpartition('-')[2]}", plot.title, plot.caption, _drawn(plot))


def _drawn(plot: Plot) -> bytes:
    figure = canvas(HEIGHT_IN)
    axes = figure.subplots()
    plain_axes(axes, zero_line=not plot.is_logarithmic)
    for index, curve in enumerate(plot.curves):
        colour, symbol = SERIES[index % len(SERIES)], SYMBOLS[index % len(SYMBOLS)]
        line = "-" if plot.is_logarithmic else "none"
        axes.plot(curve.x, curve.y, marker=symbol, markersize=3.0, color=colour, label=curve.label, linestyle=line)
    if plot.is_logarithmic:
        axes.set_xscale("log")
        axes.set_yscale("log")
    axes.set_xlabel(plot.x_label)
    axes.set_ylabel(plot.y_label)
    axes.legend(loc="best", ncols=3)
    figure.tight_layout()
    return to_svg(figure)
