"""Figures as bytes: one style, one size, the same SVG for the same input on every run.

Matplotlib's object-oriented interface alone: no pyplot, no figure that lives on. Colours are those of Okabe and Ito,
told apart by colour-blind readers and, with the symbols, in a black and white print.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING, Any

from ams.arrays import FloatArray
from procedures.report.compact_svg import compact_svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.lines import Line2D
    from matplotlib.text import Text

WIDTH_IN = 7.3
INK, FAINT, GRID = "#1a1a1a", "#767676", "#e3e3e3"
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, BROWN = (
    "#0072b2", "#e69f00", "#009e73", "#d55e00", "#aa4499", "#56b4e9", "#7f5f2a",
)  # fmt: skip
SERIES = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY, BROWN, INK)
SYMBOLS = ("o", "s", "^", "D", "v", "P", "X", "*")
SYMBOL_SIZES = {"s": 0.9, "D": 0.85, "^": 1.15, "v": 1.15, "P": 1.15, "X": 1.1, "*": 1.4}
"""Relative sizes at which the symbols look alike."""
RASTERISE_FROM = 400
"""A panel of more points than this is embedded as a picture: the page stays small."""
TICK_STEPS_DEG = (0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0)
MOST_COLUMNS = 6
"""Of a legend above its axes."""
LEGEND_ROW, BESIDE_LABEL, LEGEND_MARGIN = 1.7, 5.0, 1.3
"""Of such a legend, in heights of its letters: a row, symbol and gap beside a label, what stays free around it."""
DPI = 200
"""Dots per inch of such a picture."""

STYLE: Any = {
    "svg.hashsalt": "calrig",
    "svg.fonttype": "path",
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.0,
    "axes.titley": 1.0,  # where it stands anyway: to look for ticks above it takes a sixth of the drawing
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.6,
    "axes.labelcolor": INK,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "lines.linewidth": 1.0,
    "figure.facecolor": "white",
    "text.color": INK,
}


@dataclass(frozen=True)
class Figure:
    """One finished picture."""

    name: str
    """Of letters, digits and hyphens: its file name and its anchor on the page."""
    title: str
    caption: str
    svg: bytes


def canvas(height_in: float) -> "Canvas":
    """Make an empty figure as wide as the page. Call inside :func:`style`."""
    from matplotlib.figure import Figure as Canvas

    return Canvas(figsize=(WIDTH_IN, height_in))


def style() -> Any:
    """Return the context in which figures are made and saved."""
    import matplotlib

    return matplotlib.rc_context(STYLE)


def to_svg(figure: "Canvas") -> bytes:
    """Return the figure's bytes, without date and without the version of the program that drew it."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    buffer = BytesIO()
    figure.set_dpi(DPI)
    # print_figure draws everything once more to learn a layout that these figures have fixed; the bytes are the same
    FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None, "Creator": None})  # type: ignore[no-untyped-call]
    return compact_svg(buffer.getvalue())


def plain_axes(axes: "Axes", *, zero_line: bool = False) -> None:
    """Thin grid, no box on the right and above."""
    axes.grid(visible=True, color=GRID, linewidth=0.5)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(length=2.5, width=0.6)
    if zero_line:
        axes.axhline(0.0, color=FAINT, linewidth=0.6)


def pitch_ticks(axes: "Axes", angles_deg: FloatArray, most: float = 8.0) -> None:
    """Angles up the ordinate."""
    ticks, limits = _angle_scale(angles_deg, most)
    axes.set_yticks(ticks)
    axes.set_ylim(*limits)


def angle_ticks(axes: "Axes", angles_deg: FloatArray, most: float = 12.5) -> None:
    """Angles along the abscissa, at most so many steps."""
    ticks, limits = _angle_scale(angles_deg, most)
    axes.set_xticks(ticks)
    axes.set_xlim(*limits)


def _angle_scale(angles_deg: FloatArray, most: float) -> tuple[list[float], tuple[float, float]]:
    """Return the ticks at whole steps that a reader of attitudes expects, and limits with a margin."""
    lowest, highest = float(angles_deg.min()), float(angles_deg.max())
    span = highest - lowest
    step = next((step for step in TICK_STEPS_DEG if span / step <= most), 90.0)
    first = -(-(lowest - 1e-6) // step) * step
    count = int((highest - first) / step + 1e-6) + 1
    margin = 0.035 * span if span > 0.0 else 0.5
    return [first + step * index for index in range(count)], (lowest - margin, highest + margin)


def date_axis(axes: "Axes") -> None:
    """Write dates along the abscissa, few and short."""
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

    locator = AutoDateLocator(minticks=3, maxticks=5)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator, show_offset=False))  # type: ignore[no-untyped-call]
    axes.tick_params(labelbottom=True)


def legend_entry(**properties: Any) -> "Line2D":
    """Return a line that stands in a legend alone; the properties are matplotlib's."""
    from matplotlib.lines import Line2D

    return Line2D([], [], **properties)


def series_style(index: int, count: int) -> tuple[Any, str]:
    """Return colour and symbol of one replication among ``count``; beyond eight the colours run from dark to light."""
    if count <= len(SERIES):
        return SERIES[index], SYMBOLS[index]
    import matplotlib

    return matplotlib.colormaps["cividis"](0.9 * index / (count - 1)), SYMBOLS[index % len(SYMBOLS)]


def legend_above(figure: "Canvas", axes: "Axes") -> None:
    """Put the legend above the axes, in as many columns as their width holds; the figure grows by its rows."""
    legend = axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    labels = list(legend.get_texts())
    width_in, letter_in = figure.get_figwidth() * axes.get_position().width, float(labels[0].get_fontsize()) / 72.0
    columns = max(1, min(MOST_COLUMNS, int(width_in / (widest_in(labels) + BESIDE_LABEL * letter_in))))
    rows = -(-len(labels) // columns)
    below_in = figure.subplotpars.bottom * figure.get_figheight()
    height_in = figure.get_figheight() + LEGEND_ROW * letter_in * (rows - 1)
    figure.set_figheight(height_in)
    above_in = (LEGEND_MARGIN + LEGEND_ROW * rows) * letter_in
    figure.subplots_adjust(top=1.0 - above_in / height_in, bottom=below_in / height_in)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.0)


def widest_in(labels: "Iterable[Text]") -> float:
    """Return the width of the widest label as it is drawn, in inches: outlines are not hinted to pixels."""
    from matplotlib.textpath import TextPath

    paths = (
        TextPath((0, 0), label.get_text(), float(label.get_fontsize()), prop=label.get_fontproperties())
        for label in labels
    )
    return max((float(path.get_extents().width) for path in paths), default=0.0) / 72.0
