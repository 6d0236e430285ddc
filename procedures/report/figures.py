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
from procedures.report.run_figures import drift_figure, run_figures
from procedures.report.section_figures import section_figures
from procedures.report.view import RunView, SensorView


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
            tell(f"drawing {sensor.name} ({sensor.place} of {len(view.sensors)})")
            of_sensors[sensor.name] = _of_sensor(view, sensor)
        return Figures(of_run, of_sensors)


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
