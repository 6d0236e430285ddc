"""The laboratory's desk in the browser: what is due, what is recalled, runs by any word; looking changes nothing."""

import hashlib
import json
from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path

import pytest
from archived_runs import a_run, a_sensor, turned
from axe import serious_findings
from changed_sets import changed
from chromium import chromium
from consoles import served_console
from pages import CUT, OVER, SMALL
from playwright.sync_api import expect
from visited_console import Visited

from ams.archive.runs import Override, publish_run
from ams.archive.signatures import sign
from ams.sets.coefficients import from_document
from rig.local_time import local_day

NOW = datetime(2026, 9, 1, tzinfo=UTC)
SIZES = [(390, 844), (820, 1180), (1440, 900)]


def _fill(archive: Path) -> Path:
    """Publish three runs of two sensors with two tables: one past its day, one that turned under the second sensor."""
    url, late = f"sqlite:///{archive}", date(2026, 1, 1)
    publish_run(url, a_run(0), [a_sensor(0), a_sensor(0, "SN2", customer="Tunnel Ltd")], NOW)
    publish_run(url, a_run(30), [a_sensor(30, due=late, standard="QL-9")], NOW, override=Override("anna", "known"))
    publish_run(url, a_run(60), [turned(a_sensor(60, "SN2"))], NOW)
    return archive


def test_the_desk_tells_what_is_due_and_what_was_measured_with_a_standard(tmp_path: Path) -> None:
    archive = _fill(tmp_path / "none.sqlite")
    before = hashlib.sha256(archive.read_bytes()).hexdigest()
    visited = Visited(tmp_path)
    browser = visited.enter()
    page = browser.get("/archive").text
    assert "3 runs" in page
    over = (local_day(visited.clock.now_utc()) - date(2026, 1, 1)).days
    assert f"{over} days over" in page
    assert "calibrated 2026-02-10" in page
    assert "in quarantine" in page
    recalled = browser.get("/archive", params={"standard": "QL-9"}).text
    assert "1 run measured with standard QL-9" in recalled
    assert ("run-30" in recalled, "run-60" in recalled) == (True, False)
    assert "1 run with “tunnel”" in browser.get("/archive", params={"q": "tunnel"}).text
    unknown = browser.get("/archive", params={"standard": "QL"})
    assert (unknown.status_code >= 400, "stands behind no run" in unknown.text) == (True, True)
    visited.console.close()
    assert hashlib.sha256(archive.read_bytes()).hexdigest() == before


def test_every_page_tells_a_withdrawal_where_a_verdict_stood(tmp_path: Path) -> None:
    """The page of a sensor had no word of it, and the run's page and the night went on to say "Sound"."""
    visited = Visited(tmp_path)
    of_run = {"trust": "sound", "sentence": "Sound.", "grounds": [], "sensors": []}
    (visited.run / "verdict.json").write_text(json.dumps(of_run), encoding="utf-8")
    url = f"sqlite:///{tmp_path / 'none.sqlite'}"
    publish_run(url, a_run(0), [a_sensor(0)], NOW)
    measured = replace(a_run(90), run_id=visited.run.name)
    wrong = a_sensor(90)
    document = changed(wrong.coefficients, lambda d: d["provenance"].update(run_id=visited.run.name))
    publish_run(url, measured, [replace(wrong, coefficients=from_document(document, "a set"))], NOW)
    browser = visited.enter()
    pages = ("/archive", "/archive/SN1", f"/run/{visited.run.name}", "/night", f"/api/v1/runs/{visited.run.name}")
    before = {path: browser.get(path).text for path in pages}
    sign(url, "SN1", "withdrawn", "C. Lim", NOW, "wrong mount")
    said = "withdrawn by C. Lim on 2026-09-01 (UTC): wrong mount"
    for path in pages:
        page = browser.get(path).text
        assert (said in before[path], said in page) == (False, True), path
        if path in pages[2:]:
            assert ("Sound." in before[path], "Sound." in page) == (True, False), path
    row = browser.get("/archive/SN1").text.partition("<tbody>")[2].partition("</tr>")[0]
    assert (said in row, row.count("<td>—</td>")) == (True, 2), "neither as found nor as left"


@pytest.mark.thorough
def test_the_desk_is_whole_in_every_size_and_a_serial_number_leads_to_its_recall_list(tmp_path: Path) -> None:
    (tmp_path / "runs").mkdir()
    with served_console(tmp_path / "runs", _fill(tmp_path / "archive.sqlite")) as console, chromium() as browser:
        entered = browser.new_context()
        page = entered.new_page()
        page.goto(console.link())
        page.wait_for_url("**/")
        base = page.url.rstrip("/")
        for width, height in SIZES:
            page.set_viewport_size({"width": width, "height": height})
            for scheme in ("light", "dark"):
                page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
                for path in ("/archive", "/archive?standard=QL-9", "/archive?q=tunnel", "/archive/SN2"):
                    page.goto(f"{base}{path}")
                    assert page.evaluate("document.documentElement.scrollWidth") <= width
                    assert [page.evaluate(script) for script in (CUT, OVER, SMALL)] == [[], [], []], path
                    assert serious_findings(page) == []
        page.goto(f"{base}/archive")
        page.get_by_role("link", name="QL-9").click()
        expect(page.get_by_role("heading", name="1 run measured with standard QL-9")).to_be_visible()
        page.get_by_role("link", name="All runs").click()
        expect(page.get_by_role("heading", name="3 runs")).to_be_visible()
        entered.close()
