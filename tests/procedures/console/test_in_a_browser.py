"""The pages in Chromium, in every size and both schemes: nothing is cut, small, foreign or dead."""

import json
from collections.abc import Iterator
from contextlib import ExitStack, closing
from datetime import UTC, datetime
from pathlib import Path

import pytest
from axe import serious_findings
from chromium import chromium
from consoles import served_console
from journals import a_clock
from pages import CUT, OVER, SMALL
from playwright.sync_api import Page, expect
from run_folders import make_run
from slow_wires import Wire

from procedures.journal.journal import Journal
from procedures.journal.sidecar.owner import owning
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.states import State

SIZES = [(390, 844), (820, 1180), (1440, 900)]
MOST_BYTES = 60_000
"""Of a page with its script and style, without data."""
LIVE = (State.RUNNING, State.HELD, State.PAUSED)
STATES = (State.FINISHED, State.TRIPPED, State.STOPPED, State.FAILED, *LIVE)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("console") / "runs"
    for state in STATES:
        make_run(folder / str(state), state, started_utc=datetime.now(UTC), dwells=9)
    return folder


@pytest.fixture
def page(runs: Path, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[tuple[Page, list[str], list[str]]]:
    """A page that has entered, what its browser complained of, and what it asked for."""
    (width, height), scheme = request.param
    complaints, requests = list[str](), list[str]()
    with served_console(runs, tmp_path / "none.sqlite") as console, chromium() as browser:
        shown = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme).new_page()
        shown.on("console", lambda expected: complaints.append(expected.text) if expected.type == "error" else None)
        shown.on("pageerror", lambda error: complaints.append(str(error)))
        shown.on("request", lambda entry: requests.append(entry.url))
        shown.goto(console.link())
        shown.wait_for_url("**/")
        yield shown, complaints, requests


def _require_whole(page: Page) -> None:
    assert page.evaluate("document.documentElement.scrollWidth") <= page.evaluate("innerWidth")
    assert page.evaluate(CUT) == []
    assert page.evaluate(OVER) == []
    assert page.evaluate(SMALL) == []
    assert serious_findings(page) == []


def _require_steering(page: Page, run: Path, base: str) -> None:
    """A touch asks for a pause; a stop of the axes is held; what was asked stands in the run's folder, once."""
    with owning(run):
        page.goto(f"{base}/run/{run.name}")
        _require_whole(page)
        page.get_by_text("Pause after dwell").click()
        expect(page.locator("#said")).to_contain_text("pause was asked for")
        stop = page.get_by_text("Stop axes: keep pressed")
        expect(stop).to_be_in_viewport()
        stop.click()
        expect(page.locator("#said")).to_contain_text("hold it for half a second")
        stop.hover()
        page.mouse.down()
        expect(page.locator("#said")).to_contain_text("abort was asked for")
        page.mouse.up()
    request = [json.loads(path.read_text()) for path in sorted((run / "requests").glob("*.json"))]
    assert [(entry["kind"], entry["via"]) for entry in request] == [("pause", "console"), ("abort", "console")]


ONE = [((390, 844), "dark")]
ALL = [(size, scheme) for size in SIZES for scheme in ("light", "dark")]


@pytest.mark.parametrize("page", ONE, indirect=True, ids=str)
def test_a_page_on_a_phone_is_whole_alive_and_asks_nobody_else(
    page: tuple[Page, list[str], list[str]], runs: Path
) -> None:
    shown, complaints, request = page
    base = shown.url.rstrip("/")
    shown.goto(f"{base}/run/tripped")
    expect(shown.locator("#fresh")).to_have_text("● live")
    _require_whole(shown)
    journal = Journal.open_for_append(runs / "tripped" / JOURNAL_FILE)
    journal.append_event("note", {"by": "anna", "text": "the door was open", "at_utc": "x"}, a_clock())
    journal.close()
    expect(shown.locator(".news li").first).to_contain_text("note by anna: the door was open", timeout=2000)
    _require_steering(shown, runs / "running", base)
    shown.goto(f"{base}/queue")
    _require_whole(shown)
    shown.keyboard.press("Tab")
    expect(shown.locator(".skip")).to_be_focused()
    assert complaints == []
    parts = {entry for entry in request if "/static/" in entry} | {f"{base}/queue"}
    assert sum(len(shown.request.get(part).body()) for part in parts) < MOST_BYTES
    assert [entry for entry in request if not entry.startswith((base, base.replace("http", "ws"), "data:"))] == []


@pytest.mark.thorough
@pytest.mark.parametrize("page", ALL, indirect=True, ids=str)
def test_every_page_in_every_state_is_whole(page: tuple[Page, list[str], list[str]], runs: Path) -> None:
    shown, complaints, _ = page
    base = shown.url.rstrip("/")
    with ExitStack() as alive:
        for state in LIVE:
            alive.enter_context(owning(runs / str(state)))
        for path in ("/night", "/queue", "/login", *(f"/run/{state}" for state in STATES)):
            shown.goto(f"{base}{path}")
            _require_whole(shown)
            shown.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
            _require_whole(shown)
    shown.set_viewport_size({"width": 195, "height": 422})  # a phone at 200 %
    for path in ("/night", "/queue", "/run/tripped"):
        shown.goto(f"{base}{path}")
        assert shown.evaluate("document.documentElement.scrollWidth") <= 195
    assert complaints == []
    shown.set_viewport_size({"width": 390, "height": 844})
    for path in (
        "/archive/none",
        "/run/none",
    ):  # what cannot be shown; the browser complains of its status
        shown.goto(f"{base}{path}")
        _require_whole(shown)


SAID_WHEN = """() => {
  const acts = document.getElementById("acts"), note = window.told = [];
  const look = () => note.push([performance.now(), document.getElementById("said").textContent]);
  new MutationObserver(look).observe(acts, { childList: true, subtree: true });
}"""


@pytest.mark.thorough
def test_on_a_network_of_two_seconds_the_page_says_within_a_second_that_it_waits_and_tries_again(
    tmp_path: Path,
) -> None:
    """An answer takes two seconds each way, which is longer than the first try: it is the second that hears it."""
    run = tmp_path / "runs" / "running"
    make_run(run, State.RUNNING, started_utc=datetime.now(UTC), dwells=9)
    with served_console(run.parent, tmp_path / "none.sqlite") as console:
        host, _, port = console.address.removeprefix("http://").partition(":")
        wire = Wire((host, int(port)), is_proxy=True)
        with closing(wire.listener), owning(run), chromium(f"socks5://127.0.0.1:{wire.address[1]}") as browser:
            page = browser.new_page(viewport={"width": 390, "height": 844})
            posted = list[str]()
            page.on("request", lambda one: posted.append(one.url) if one.method == "POST" else None)
            page.goto(console.link())
            page.wait_for_url("**/")
            page.evaluate(SAID_WHEN)
            wire.delay_s = 2.0
            page.get_by_text("Stop axes: keep pressed").hover()
            page.mouse.down()
            expect(page.locator("#said")).to_contain_text("still waiting, and trying again", timeout=10_000)
            page.mouse.up()
            expect(page.locator("#said")).to_contain_text("abort was asked for", timeout=60_000)
            told = [(when_ms, words) for when_ms, words in page.evaluate("window.told")]
            (asked_ms, _), (waits_ms, _) = [one for one in told if "waiting" in one[1]][:2]
            assert waits_ms - asked_ms < 1000.0
            assert any("NOT answered after 1 try; trying again" in words for _, words in told)
            assert len(posted) == 2
    asked = [json.loads(one.read_text()) for one in (run / "requests").glob("*.json")]
    assert {one["kind"] for one in asked} == {"abort"}
    assert len({one["key"] for one in asked}) == 1, "a run takes what came twice once"
