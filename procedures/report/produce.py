"""From a run's journal to its report: the one call that the command makes."""

from collections.abc import Mapping
from math import hypot
from pathlib import Path

from procedures.report.assemble import RunRecord, assemble_view
from procedures.report.figures import draw_figures, write_figures
from procedures.report.page import write_page
from procedures.report.view import RunView
from procedures.solving import SolvedSensor, solve_sensors, standard_uncertainty_arcsec
from rig.description import RigDescription

REPORT_FILE = "report.html"
FIGURES_FOLDER = "figures"


def solve_record(record: RunRecord) -> dict[str, SolvedSensor]:
    """Every sensor of the run, solved from its accepted dwells as the procedure asks."""
    return solve_sensors(record.dwells, record.rig, record.plan.sensors, record.plan.solve, f"run {record.run_id}")


def view_of(record: RunRecord, solved: Mapping[str, SolvedSensor]) -> RunView:
    """The run as every screen draws it."""
    return assemble_view(record, solved, _table_arcsec(record.rig))


def write_report(view: RunView, folder: Path) -> Path:
    """``report.html`` and ``figures/`` into the run's folder; returns the page's path."""
    figures = draw_figures(view)
    write_figures(figures, folder / FIGURES_FOLDER)
    write_page(view, figures, folder / REPORT_FILE)
    return folder / REPORT_FILE


def _table_arcsec(rig: RigDescription) -> float | None:
    """Standard uncertainty of one attitude of the table, pitch and roll together; None where none is declared."""
    return hypot(*(standard_uncertainty_arcsec(rig, axis) for axis in ("pitch", "roll"))) or None
