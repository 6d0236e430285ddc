"""The page of a run whose report could not be made: why, that nothing is lost, and what to do."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from ams.whole_file import write_whole
from procedures.pages import page_environment, page_style, with_whole_options
from procedures.report.overview import overview_rows
from procedures.report.page import STYLE_SHEET, TEMPLATES
from procedures.report.view import RunView, Verdict
from procedures.report.write import REPORT_FILE, write_verdict

NOT_JUDGED: Final = "There is no result to use: nobody has judged what was measured."


@dataclass(frozen=True)
class PlainPage:
    """What can be said without a solution or its picture."""

    title: str
    run_id: str
    state: str
    why: str
    """What hindered it, and what to do."""
    is_simulated: bool = False


def write_plain(folder: Path, page: PlainPage, sensors: Sequence[str], view: RunView | None = None) -> None:
    """``report.html`` and ``verdict.json``. ``view``: the run as it was judged, where only its page failed.

    Raises: WriteFailed.
    """
    if view is None:
        verdict = Verdict("unusable", NOT_JUDGED, (page.why,))
        rows: list[dict[str, object]] = [
            {"sensor": name, "verdict": "not usable", "failure": page.why} for name in sensors
        ]
    else:
        verdict, rows = view.verdict, [asdict(row) for row in overview_rows(view)]
    text = (
        page_environment(TEMPLATES)
        .get_template("plain.html.j2")
        .render(page=page, verdict=verdict, **page_style(STYLE_SHEET))
    )
    write_verdict(folder, verdict, rows, page.state)
    write_whole(folder / REPORT_FILE, with_whole_options(text).encode("utf-8"))
