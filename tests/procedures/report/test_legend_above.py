"""A legend stays on its figure, however long the names are that a laboratory gives its sensors."""

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from procedures.report.canvas import canvas, legend_above


@pytest.mark.parametrize("count", [1, 3, 8])
@pytest.mark.parametrize("label", ["x", "SN1047.x", "SN1047 x at pitch −30°, roll 180°", "a" * 60])
def test_every_label_lies_on_the_figure_and_none_on_the_axes(count: int, label: str) -> None:
    """Three channels of one sensor at two attitudes ran off the left edge."""
    figure = canvas(2.5)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.085, right=0.985, bottom=0.18)
    for index in range(count):
        axes.plot([0.0, 1.0], [0.0, index], marker="o", markersize=3, label=f"{label} {index}")
    legend_above(figure, axes)
    drawn = FigureCanvasAgg(figure)
    drawn.draw()
    legend = axes.get_legend()
    assert legend is not None
    box, whole = legend.get_window_extent(drawn.get_renderer()), figure.bbox
    assert box.x0 >= whole.x0
    assert box.x1 <= whole.x1
    assert box.y1 <= whole.y1
    assert box.y0 >= axes.get_window_extent(drawn.get_renderer()).y1 - 1.0
