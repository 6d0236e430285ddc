"""All figures of a run's report, in the order in which the page shows them.

The same view gives the same bytes, so a report can be compared with its reprint.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from ams.whole_file import write_whole
from procedures.report.angle_figures import angle_error_figure
from procedures.report.canvas import Figure, style
from procedures.report.history_figure import history_figure
from procedures.report.residual_figures import residual_figures
from procedures.report.run_figures import drift_figure, reference_figures, run_figures
from procedures.report.section_figures import section_figures
from procedures.report.view import RunView, SensorView

MOST_WITH_ALL = 4
"""Sensors whose figures all stand on one page; of more some stand in each sensor's own document."""
IN_SENSOR_DOCUMENT = ("drift", "distribution")


def are_left_out(view: RunView) -> bool:
    """Return whether some figures of each sensor are not on this page."""
    return len(view.sensors) > MOST_WITH_ALL


def for_page(view: RunView, figures: "Figures") -> "Figures":
    """Return what the page of this view shows."""
    if not are_left_out(view):
        return figures
    kept = {
        name: tuple(figure for figure in of_sensor if figure.name.rpartition("-")[2] not in IN_SENSOR_DOCUMENT)
        for name, of_sensor in figures.sensors.items()
    }
    return Figures(figures.run, kept)


@dataclass(frozen=True)
class Figures:
    """Figures of the run, and of each sensor by its name."""

    run: tuple[Figure, ...]
    sensors: Mapping[str, tuple[Figure, ...]]

    def all(self) -> tuple[Figure, ...]:
        return (*self.run, *(figure for figures in self.sensors.values() for figure in figures))


def draw_figures(view: RunView, tell: Callable[[str], None] = lambda _step: None) -> Figures:
    """Draw every figure that has something to show; ``tell`` hears of each sensor."""
    with style():
        tell("drawing the run")
        of_run, of_sensors = tuple(run_figures(view)), {}
        for sensor in view.sensors:
            tell(f"drawing {sensor.name} ({sensor.number} of {len(view.sensors)})")
            of_sensors[sensor.name] = _of_sensor(view, sensor)
        return Figures(of_run, of_sensors)


def figures_of_sensor(view: RunView, whole: Figures) -> Figures:
    """Return the figures of a view that holds one sensor of those of the whole: what shows others is drawn anew."""
    with style():
        of_run = (
            *(figure for figure in whole.run if not figure.name.startswith("reference")),
            *reference_figures(view),
        )
    return Figures(of_run, {sensor.name: whole.sensors[sensor.name] for sensor in view.sensors})


def write_figures(figures: Figures, folder: Path) -> tuple[Path, ...]:
    """Write one SVG file a figure, for slides and papers. Raises: WriteFailed where the folder cannot be written."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = tuple(folder / f"{figure.name}.svg" for figure in figures.all())
    for path, figure in zip(paths, figures.all(), strict=True):
        write_whole(path, figure.svg)
    return paths


def _of_sensor(view: RunView, sensor: SensorView) -> tuple[Figure, ...]:
    if sensor.section is not None:
        return tuple(section_figures(sensor.section, sensor.slug))
    ends = (angle_error_figure(sensor), drift_figure(sensor), _history(sensor)) if sensor.axes else ()
    return (*residual_figures(view, sensor), *(figure for figure in ends if figure is not None))


def _history(sensor: SensorView) -> Figure | None:
    """Draw the sensor's control charts up to this calibration, or return None."""
    return None if sensor.history is None else replace(history_figure(sensor.history), name=f"{sensor.slug}-history")
