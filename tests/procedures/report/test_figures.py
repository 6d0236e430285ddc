import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from report_scene import Scene, run_view

from procedures.report.canvas import style
from procedures.report.figures import Figures, draw_figures, write_figures
from procedures.report.run_figures import MOST_LINES, drift_figure, reference_figures

SCENES = {
    "three axes, replicated": Scene(),
    "one axis, one replication, no azimuth": Scene(axes=("x",), replications=1, null_azimuth=True, simulated=False),
    "two sensors, ten replications": Scene(
        sensors=("A.1", "A 1"), axes=("x",), replications=10, pitch_deg=(-60, 0, 60)
    ),
    "one axis, replicated": Scene(axes=("x",)),
    "interrupted": Scene(axes=("y", "z"), interruptions=2, rejected=1),
}


@cache
def drawn(name: str) -> Figures:
    return draw_figures(run_view(SCENES[name]))


SHORT = "one axis, one replication, no azimuth"


@pytest.mark.parametrize(
    "name", [name if name == SHORT else pytest.param(name, marks=pytest.mark.thorough) for name in SCENES]
)
def test_every_figure_shows_data(name: str) -> None:
    figures = drawn(name).all()
    assert len(figures) >= 7
    for figure in figures:
        marks = len(re.findall(rb"<use x=\"|<image |<path d=\"M[^\"]*[lhvLHV][^\"]*\"", figure.svg))
        assert marks > 5, figure.name
        assert figure.svg.startswith(b"<?xml")
        assert figure.caption.endswith(".")


@pytest.mark.thorough
def test_the_same_view_gives_the_same_bytes() -> None:
    view = run_view(Scene(axes=("x",), pitch_deg=tuple(range(-90, 91, 10)), replications=4))
    first, second = draw_figures(view), draw_figures(view)
    assert first == second
    assert all(b"<dc:date>" not in figure.svg for figure in first.all())


def test_names_are_unique_and_safe_for_files_whatever_the_sensors_are_called(tmp_path: Path) -> None:
    figures = drawn("two sensors, ten replications")
    names = [figure.name for figure in figures.all()]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[a-z0-9-]+", name) for name in names)
    paths = write_figures(figures, tmp_path / "figures")
    assert [path.read_bytes() for path in paths] == [figure.svg for figure in figures.all()]


def test_drift_is_drawn_only_where_there_are_replications() -> None:
    with style():
        assert drift_figure(run_view(Scene(axes=("x",))).sensors[0]) is not None
        assert drift_figure(run_view(Scene(axes=("x",), replications=1)).sensors[0]) is None


def test_no_figure_refers_to_anything_outside_itself() -> None:
    for figure in drawn("one axis, replicated").all():
        targets = re.findall(rb"(?:href|src)=\"([^\"]*)\"", figure.svg)
        assert all(target.startswith((b"#", b"data:")) for target in targets)


def test_the_marks_stand_where_the_residuals_are() -> None:
    # Read back from the drawing: the marks of each replication, in its colour, at heights that fall as residuals rise.
    sensor = run_view(SCENES["one axis, replicated"]).sensors[0]
    rows, solution = sensor.observations, sensor.axes[0].calibration
    assert rows is not None
    figures = drawn("one axis, replicated").all()
    for name in ("residuals-pitch", "residuals-roll", "residuals-time"):
        svg = next(figure.svg for figure in figures if figure.name.endswith(name)).decode()
        marks: dict[str, list[float]] = {}
        for height, symbol in re.findall(r'<use x="[\d.-]+" y="([\d.-]+)"[^>]* href="#(\w+)"', svg):
            marks.setdefault(symbol, []).append(float(height))
        heights_of = [heights for heights in marks.values() if len(heights) == 49]
        assert len(heights_of) == 3
        for label, heights in enumerate(heights_of, start=1):
            residuals_v = solution.residuals_v[rows.replication == label]
            drawn_as = np.corrcoef(heights, residuals_v)[0, 1]
            assert drawn_as == pytest.approx(-1.0, abs=1e-5), "drawn to a tenth of a point"


def test_row_labels_of_many_sensors_stand_on_the_page_whole() -> None:
    """The glyphs are drawn as outlines: the leftmost of them begins inside the picture."""
    view = run_view(Scene(axes=("x",)))
    serials = [f"QF-2026-{number:04d} x, pitch 22.5°, roll −112.5°" for number in range(MOST_LINES + 2)]
    traces = tuple(replace(view.reference[0], label=label) for label in serials)
    with style():
        (figure,) = reference_figures(replace(view, reference=traces))
    starts = re.findall(rb'<g class="[^"]*" transform="translate\(([-0-9.]+) [-0-9.]+\)', figure.svg)
    starts += re.findall(rb"translate\(([-0-9.]+)[ ,][-0-9.]+\) ?scale", figure.svg)
    assert len(starts) >= len(serials)
    assert min(map(float, starts)) >= 0.0


def test_the_map_of_many_channels_marks_interruptions_and_bears_a_sensor_that_was_dropped() -> None:
    view = run_view(Scene(axes=("x",), interruptions=2))
    whole = view.reference[0]
    dropped = replace(whole, hours=whole.hours[:2], change=whole.change[:2])
    several = replace(view, reference=(dropped, *(replace(whole, label=f"SN{number}") for number in range(12))))
    with style():
        (figure,) = reference_figures(several)
        (without,) = reference_figures(replace(several, interruptions=()))
    dashed = figure.svg.count(b"stroke-dasharray")
    assert dashed > without.svg.count(b"stroke-dasharray") == 0
    assert (figure.caption.endswith("Dashed lines: interruptions."), "Dashed" in without.caption) == (True, False)


def test_what_no_replication_alone_determines_has_no_strip() -> None:
    """Labels of temperature terms were cut at both edges beside strips that were empty."""
    sensor = run_view(Scene(axes=("x",))).sensors[0]
    axis = sensor.axes[0]
    unseen = replace(axis.parameters[0], name="offset_tc_v_per_degc", label="offset temperature")
    with style():
        shown = drift_figure(replace(sensor, axes=(replace(axis, parameters=(*axis.parameters, unseen)),)))
        before = drift_figure(sensor)
    assert shown is not None
    assert before is not None
    assert shown.svg == before.svg


def test_eight_replications_are_all_in_the_legend_and_nothing_is_drawn_beside_the_picture() -> None:
    """A mark or a text that begins left of the paper is not seen: the legend of eight lost its first two."""
    view = run_view(Scene(axes=("x",), pitch_deg=(-60, 0, 60), replications=8, noise_arcsec=1.0))
    (figure,) = (entry for entry in draw_figures(view).all() if entry.name.endswith("residuals-pitch"))
    root = ElementTree.fromstring(figure.svg)
    width, height = (float(number) for number in root.attrib["viewBox"].split()[2:])
    starts = [
        tuple(float(number) for number in found.groups())
        for group in root.iter("{http://www.w3.org/2000/svg}g")
        if (found := re.match(r"translate\((-?[\d.]+) (-?[\d.]+)\)", group.get("transform", "")))
    ]
    starts += [
        (float(use.attrib["x"]), float(use.attrib["y"]))
        for use in root.iter("{http://www.w3.org/2000/svg}use")
        if "y" in use.attrib
    ]
    assert len(starts) > 100
    assert [start for start in starts if not (0.0 <= start[0] <= width and 0.0 <= start[1] <= height)] == []
