"""From a solved run to its report: the view, the page with its figures, and the paper."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import hypot
from pathlib import Path

from ams.whole_file import write_whole
from procedures.journal.sidecar.verdict_file import write_verdict_file
from procedures.report.assemble import assemble_view
from procedures.report.figures import Figures, draw_figures, figures_of_sensor, for_page, write_figures
from procedures.report.overview import overview_rows
from procedures.report.page import render_page
from procedures.report.paper.pdf import Attachment, Imprint, paper_of
from procedures.report.view import Past, RunView, Verdict
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from procedures.solution.type_b import standard_uncertainty_arcsec
from rig.description.rig_file import RigDescription

REPORT_FILE = "report.html"
PAPER_FILE = "report.pdf"
FIGURES_FOLDER = "figures"
DOCUMENTS_FOLDER = "documents"
"""Where the document of each sensor lies, where a run has several."""


def view_of(
    record: RunRecord, solved: Mapping[str, SolvedSensor], past: Past | None = None, only: str | None = None
) -> RunView:
    """Return the run as every screen draws it; ``past``: what the archive says of the sensors.

    ``only``: the sensor whose own document it is.
    """
    return assemble_view(record, solved, _table_arcsec(record.rig), past, only)


@dataclass(frozen=True)
class Drawn:
    """A report before it is written: its page's text and the figures on it."""

    view: RunView
    figures: Figures
    page: str


def draw_report(view: RunView, tell: Callable[[str], None] = lambda _step: None) -> Drawn:
    """Draw figures and page; nothing is written. ``tell`` hears of each sensor."""
    figures = draw_figures(view, tell)
    return Drawn(view, figures, render_page(view, for_page(view, figures)))


def sensor_document(view: RunView, whole: Figures) -> Drawn:
    """Draw the document of one sensor, of a view that holds no other; ``whole``: the figures of the run."""
    figures = figures_of_sensor(view, whole)
    return Drawn(view, figures, render_page(view, figures))


def write_sensor_document(drawn: Drawn, folder: Path, attachments: Sequence[Attachment] = ()) -> Path:
    """``documents/SENSOR.html`` and ``.pdf``; returns the page's path. Raises: WriteFailed."""
    (folder / DOCUMENTS_FOLDER).mkdir(exist_ok=True)
    path = folder / DOCUMENTS_FOLDER / f"{drawn.view.sensors[0].slug}.html"
    write_whole(path, drawn.page.encode("utf-8"))
    write_whole(path.with_suffix(".pdf"), paper_of(drawn.page, _imprint(drawn.view), attachments))
    return path


def write_screen(drawn: Drawn, folder: Path) -> Path:
    """``report.html``, ``verdict.json`` and ``figures/``; returns the page's path. Raises: WriteFailed."""
    write_figures(drawn.figures, folder / FIGURES_FOLDER)
    rows = [asdict(row) for row in overview_rows(drawn.view)]
    write_verdict(folder, drawn.view.verdict, rows, drawn.view.state)
    write_whole(folder / REPORT_FILE, drawn.page.encode("utf-8"))
    return folder / REPORT_FILE


def write_verdict(
    folder: Path,
    verdict: Verdict,
    rows: Sequence[Mapping[str, object]],
    state: str,
    not_made: Mapping[str, str] | None = None,
) -> None:
    """``verdict.json``. ``state``: of the run when it was judged. Raises: WriteFailed.

    ``not_made``: the parts that a defect hindered, each with its sentence.
    """
    hindered = {"not_made": dict(not_made)} if not_made else {}
    document = {**asdict(verdict), "state": str(state), "sensors": list(rows), **hindered}
    write_verdict_file(folder, document)


def write_paper(drawn: Drawn, folder: Path, attachments: Sequence[Attachment] = ()) -> Path:
    """``report.pdf``: the same page with the attachments inside; returns its path. Raises: WriteFailed."""
    write_whole(folder / PAPER_FILE, paper_of(drawn.page, _imprint(drawn.view), attachments))
    return folder / PAPER_FILE


def _imprint(view: RunView) -> Imprint:
    moment = view.ended_utc or view.started_utc
    return Imprint(f"{view.title}: calibration report", view.stamps, f"Run {view.run_id}", moment)


def _table_arcsec(rig: RigDescription) -> float | None:
    """Return the standard uncertainty of one attitude of the table, pitch and roll together, or None."""
    return hypot(*(standard_uncertainty_arcsec(rig, axis) for axis in ("pitch", "roll"))) or None
