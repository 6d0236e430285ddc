"""The report as one self-contained HTML file: no script, no external resource, the same bytes for the same run.

Everything printed comes from the view; templates only place it. Names and notes of the laboratory are escaped by
Jinja's autoescape, and a content security policy forbids the page to load anything but its own pictures.
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path

from jinja2 import Environment

from ams.rounding import to_place
from procedures.pages import page_environment, page_style, with_whole_options
from procedures.plan.order import TWICE
from procedures.report.figures import Figures
from procedures.report.filters import FILTERS
from procedures.report.section import sections_in_order
from procedures.report.view import RunView
from procedures.solution.budget_view import FORMS

TEMPLATES = Path(__file__).parent / "templates"
STYLE_SHEET = TEMPLATES / "page.css"


def render_page(view: RunView, figures: Figures) -> str:
    """Return the page's text: its head, and every registered section in its order."""
    environment = report_environment(TEMPLATES)
    shown = [section for section in sections_in_order() if section.is_shown(view)]
    page = environment.get_template("page.html.j2").render(
        view=view,
        **page_style(STYLE_SHEET),
        attitudes=_attitudes(view),
        temperature=_temperature(view),
        contents={anchor: title for section in shown for anchor, title in section.contents(view).items()},
        sections=[section.rendered(environment, view, figures) for section in shown],
    )
    return with_whole_options(page)


def _attitudes(view: RunView) -> str:
    design = view.design
    each = f"{design.points // 2} × 2 visits" if design.order == TWICE else f"{design.points}"
    return f"{each} × {design.replications} replications"


@cache
def report_environment(*folders: Path) -> Environment:
    """Return the templates that print their cells as the report does; each is compiled once, not once a document."""
    environment = page_environment(*folders)
    environment.filters.update(FILTERS)
    environment.globals["budget_forms"] = FORMS
    return environment


def _temperature(view: RunView) -> str:
    parts: Mapping[str, str] = {
        trace.name: f"{to_place(float(trace.temperature_degc.min()), -2)} to "
        f"{to_place(float(trace.temperature_degc.max()), -2)} °C"
        for trace in view.temperature
    }
    return "; ".join(f"{name} {span}" for name, span in parts.items()) or "not measured"
