"""The report in Chromium: read with a keyboard, by day and by night, on a phone and at a desk."""

from pathlib import Path

import pytest
from axe import serious_findings
from chromium import chromium
from pages import CUT, OVER
from playwright.sync_api import Page
from report_journal import write_journal
from report_scene import Scene, run_view

from procedures.report.figures import Figures, draw_figures
from procedures.report.page import render_page
from procedures.run.stop_page import explain

SIZES = [(390, 844), (1440, 900)]
LUMINANCE = """name => {
  const probe = document.body.appendChild(document.createElement("i"));
  probe.style.color = `var(${name})`;
  const parts = getComputedStyle(probe).color.match(/[0-9.]+/g).slice(0, 3).map((one) => one / 255);
  probe.remove();
  const [r, g, b] = parts.map((one) => one <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}"""
"""Relative luminance of a colour of the page, by WCAG 2.2."""
THIN_LINE = 3.0
"""Contrast that WCAG 2.2 (1.4.11) asks for of what is no text."""


def _contrast(page: Page, one: str, other: str) -> float:
    low, high = sorted(float(page.evaluate(LUMINANCE, name)) for name in (one, other))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.thorough
def test_a_note_and_a_stop_are_read_on_a_phone(tmp_path: Path) -> None:
    """Nothing of the page of a stop stands beside the screen, and a note of the report has the width of it."""
    run = write_journal(tmp_path)
    stop, report = explain(run.parent, "somebody wants to know"), tmp_path / "report.html"
    view = run_view(Scene(note="the door of the hall stood open from three to four, and the lift was in use"))
    report.write_text(render_page(view, Figures((), {"SN1047": ()})), encoding="utf-8")
    assert stop is not None
    with chromium() as browser:
        page = browser.new_page(viewport={"width": 390, "height": 844})
        page.goto(stop.as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert page.evaluate("(name) => document.body.innerText.includes(name)", "accepted")
        page.goto(report.as_uri())
        cell = page.get_by_text("the door of the hall").bounding_box()
        assert cell is not None
        assert cell["x"] >= 0.0
        assert cell["width"] > 300.0
        assert cell["x"] + cell["width"] <= 390.0


@pytest.mark.thorough
def test_the_report_is_whole_by_day_and_by_night(tmp_path: Path) -> None:
    view = run_view(Scene(interruptions=3, rejected=4, note="bumped", tooth_arcsec=2.0, offset_drift_v=4e-6))
    place = tmp_path / "report.html"
    place.write_text(render_page(view, draw_figures(view)), encoding="utf-8")
    with chromium() as browser:
        for width, height in SIZES:
            for scheme in ("light", "dark"):
                context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)  # type: ignore[arg-type]
                page = context.new_page()
                page.goto(place.as_uri())
                assert page.evaluate("document.documentElement.scrollWidth") <= width
                assert (page.evaluate(CUT), page.evaluate(OVER)) == ([], [])
                assert serious_findings(page) == []
                assert page.locator("main").count() == 1
                assert _contrast(page, "--line", "--back") >= THIN_LINE
                assert _contrast(page, "--ink", "--back") > 12.0
                is_dark = page.evaluate(LUMINANCE, "--back") < 0.1
                assert is_dark == (scheme == "dark")
                context.close()
