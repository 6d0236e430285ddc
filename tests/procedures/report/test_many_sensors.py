"""A page of many sensors: as large as its sensors are many, whole on a phone, and every word of it on the paper."""

import re
import subprocess
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import pytest
from chromium import chromium
from pages import CUT, OVER
from programs import require_program
from report_scene import Scene, run_view

from procedures.report.figures import draw_figures, for_page
from procedures.report.page import render_page
from procedures.report.paper.pdf import Imprint, paper_of

pytestmark = pytest.mark.thorough
LEAST_MARGIN_PT = 20.0
WORD = re.compile(r'xMin="([\d.-]+)" yMin="([\d.-]+)" xMax="([\d.-]+)" yMax="([\d.-]+)">([^<]*)<')


@cache
def page_of(sensors: int) -> str:
    view = run_view(
        Scene(
            sensors=tuple(f"SN{number}" for number in range(1, sensors + 1)), axes=("x",), replications=8,
            pitch_deg=(-60, 0, 60), interruptions=3, rejected=30, note="bumped", offset_drift_v=4e-6,
        )
    )  # fmt: skip
    return render_page(view, for_page(view, draw_figures(view)))


def test_a_page_grows_with_its_sensors_and_no_faster() -> None:
    """Twelve packages once took 4.7 MB where eight took 2.2: what stands once a sensor must not know of the others."""
    five, seven, nine = (len(page_of(sensors)) for sensors in (5, 7, 9))
    assert nine - seven < 1.02 * (seven - five)


def test_what_is_alike_is_said_once_and_not_nine_times() -> None:
    page = page_of(9)
    assert page.count("all 9 sensors, x: offset changed by 12″") == 1
    assert page.count("allowed 3 times") == 1, "thirty rejected dwells of one reason"
    assert page.count("Every prediction is made from these.") == 1


def test_a_page_of_nine_is_whole_on_a_phone_and_no_word_lies_beside_the_paper(tmp_path: Path) -> None:
    place = tmp_path / "report.html"
    place.write_text(page_of(9), encoding="utf-8")
    with chromium() as browser:
        for width, scheme in ((390, "light"), (820, "dark"), (1440, "light")):
            shown = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)  # type: ignore[arg-type]
            page = shown.new_page()
            page.goto(place.as_uri())
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert (page.evaluate(CUT), page.evaluate(OVER)) == ([], [])
            if width == 1440:
                page.pdf(path=str(tmp_path / "printed.pdf"), prefer_css_page_size=True)
            shown.close()
    imprint = Imprint("nine", ("SIMULATED",), "Run 1", datetime(2026, 3, 1, tzinfo=UTC))
    (tmp_path / "paper.pdf").write_bytes(paper_of(page_of(9), imprint))
    for name in ("printed.pdf", "paper.pdf"):
        words = _words(tmp_path / name)
        assert len(words) > 2000
        assert [word for word, outside in words if outside] == [], name


def _words(pdf: Path) -> list[tuple[str, bool]]:
    """Every word of a paper, and whether it lies beside its page or in its margin; by poppler."""
    program = require_program("pdftotext")
    text = subprocess.run([program, "-bbox", str(pdf), "-"], capture_output=True, encoding="utf-8", check=True).stdout
    found = []
    for page in text.split("<page ")[1:]:
        width = float(re.search(r'width="([\d.]+)"', page)[1])  # type: ignore[index]
        height = float(re.search(r'height="([\d.]+)"', page)[1])  # type: ignore[index]
        for x_min, y_min, x_max, y_max, word in WORD.findall(page):
            inside = float(x_min) >= LEAST_MARGIN_PT and float(x_max) <= width - LEAST_MARGIN_PT
            found.append((word, not (inside and float(y_min) >= 0.0 and float(y_max) <= height)))
    return found
