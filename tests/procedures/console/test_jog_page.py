"""Jogging in Chromium: what a hand on the page does to the machine, and what the page says of it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from axe import serious_findings
from chromium import chromium
from jog_bench import CLOCK, RIG, JogBench, jog_bench
from many_packages import rig_text
from pages import CUT, OVER, SMALL
from playwright.sync_api import Browser, Page, expect

from rig.assembly.simulate import serve_rig, write_rig
from rig.description.read import read_rig

SIZES = [(390, 844), (820, 1180), (1440, 900)]
STOPPED_S = 0.5
MOST_STATIC_BYTES = 40_000
LONG_MS = 60_000
HANG = "() => { const from = performance.now(); while (performance.now() - from < 1500); }"


@contextmanager
def _browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


def _entered(
    browser: Browser, bench: JogBench, rig: str = RIG, size: tuple[int, int] = SIZES[0], scheme: str = "dark"
) -> Page:
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)  # type: ignore[arg-type]
    page = context.new_page()
    page.goto(bench.console.link())
    page.wait_for_url("**/")
    page.goto(f"{page.url.rstrip('/')}/jog/{rig}")
    expect(page.locator("#fresh")).to_have_text("● live")
    return page


def _take(page: Page) -> None:
    page.get_by_text("Take the bench").click()
    expect(page.locator("#who")).to_have_text("YOURS", timeout=LONG_MS)


def _home(page: Page, axis: str) -> None:
    page.get_by_label(f"{axis}: Home").click()
    expect(page.locator("#news")).to_contain_text(f"{axis}: homed", timeout=LONG_MS)


def _require_whole(page: Page) -> None:
    assert page.evaluate("document.documentElement.scrollWidth") <= page.evaluate("innerWidth")
    assert (page.evaluate(CUT), page.evaluate(OVER), page.evaluate(SMALL)) == ([], [], [])
    assert serious_findings(page) == []


def test_a_hand_on_the_page_moves_the_machine_and_lets_it_go(tmp_path: Path) -> None:
    complaints: list[str] = []
    with jog_bench(tmp_path) as bench, _browser() as browser:
        page = _entered(browser, bench)
        page.on("console", lambda told: complaints.append(told.text) if told.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        _require_whole(page)
        _take(page)
        _home(page, "roll")
        other = _entered(browser, bench, size=SIZES[1], scheme="light")
        expect(other.locator("#who")).to_have_text("TAKEN")
        expect(other.get_by_label("roll: hold +")).to_be_disabled()
        other.get_by_text("Take the bench").click()
        expect(other.locator("#said")).to_contain_text("has the bench; nothing was done")
        page.bring_to_front()
        _require_whole(page)
        page.get_by_label("roll: hold +").hover()
        page.mouse.down()
        bench.until_turning()
        shown = page.locator(".axis").last.locator(".where span")
        expect(shown).to_contain_text("turns at")
        page.mouse.up()
        assert bench.late_s(CLOCK.monotonic_s()) < STOPPED_S
        expect(shown).to_have_text("at rest")
        page.get_by_label("Go to").last.fill("181")
        page.get_by_text("Go", exact=True).last.click()
        expect(page.locator("#said")).to_have_text("roll: got 181°, allowed are −180 to 180°; nothing moved")
        page.get_by_label("Go to").last.fill("120")
        page.keyboard.press("Enter")
        bench.until_turning()
        other.bring_to_front()
        other.get_by_role("button", name="STOP").click()
        bench.late_s(0.0)
        expect(page.locator("#news")).to_contain_text("every axis stands still", timeout=LONG_MS)
        page.bring_to_front()
        page.get_by_text("Give it back").click()
        expect(page.locator("#who")).to_have_text("FREE", timeout=LONG_MS)
        asked = [(line["kind"], line.get("via")) for line in bench.log() if line["kind"] in ("take", "stop", "give")]
        assert asked[0] == ("take", "console")
        assert {("stop", "console"), ("give", "console")} <= set(asked)
        static = [page.request.get(f"{page.url.partition('/jog')[0]}/static/{name}") for name in
                  ("console.css", "console.js", "jog.css", "jog.js", "post.js")]  # fmt: skip
        assert sum(len(one.body()) for one in static) < MOST_STATIC_BYTES
        assert complaints == []


@pytest.mark.thorough
@pytest.mark.parametrize("loss", ["key", "blur", "hung", "closed", "escape"])
def test_a_page_that_is_lost_moves_nothing_any_more(tmp_path: Path, loss: str) -> None:
    with jog_bench(tmp_path) as bench, _browser() as browser:
        page = _entered(browser, bench)
        _take(page)
        _home(page, "roll")
        page.get_by_label("roll: − hold").focus()
        page.keyboard.down("Enter")
        bench.until_turning()
        CLOCK.sleep(0.6)
        assert bench.rate_dps() != 0.0, "a key that is held goes on"
        lost_s = CLOCK.monotonic_s()
        match loss:
            case "key":
                page.keyboard.up("Enter")
            case "blur":
                page.evaluate("window.dispatchEvent(new Event('blur'))")
            case "hung":
                page.evaluate(HANG)
            case "closed":
                page.close()
            case "escape":
                page.keyboard.press("Escape")
        assert bench.late_s(lost_s) < STOPPED_S


@pytest.mark.thorough
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_eight_packages_are_whole_in_every_size(tmp_path: Path, size: tuple[int, int], scheme: str) -> None:
    (tmp_path / "many.toml").write_text(rig_text(8), encoding="utf-8")
    with (
        jog_bench(tmp_path) as bench,
        serve_rig(read_rig(tmp_path / "many.toml"), CLOCK) as simulated,
        _browser() as browser,
    ):
        write_rig(tmp_path / "many.toml", simulated.addresses, "real", bench.files / "many.toml")
        page = _entered(browser, bench, "many.toml", size, scheme)
        _require_whole(page)
        _take(page)
        expect(page.locator("#readings section").last).to_contain_text("SN1048")
        expect(page.locator("#readings tbody tr").first.locator("td").last).not_to_have_text("0", timeout=LONG_MS)
        _require_whole(page)
        page.get_by_label("Sensor").select_option("SN1042")
        expect(page.locator("#readings section:visible")).to_have_count(1)
        page.goto(f"{page.url.partition('/jog')[0]}/jog")
        _require_whole(page)


@pytest.mark.thorough
@pytest.mark.parametrize(("code", "word"), [(1013, "put aside"), (1008, ""), (1001, "")])
def test_a_page_that_is_not_heard_does_not_say_that_it_takes_the_bench(tmp_path: Path, code: int, word: str) -> None:
    with jog_bench(tmp_path) as bench, _browser() as browser:
        page = _entered(browser, bench)
        page.route_web_socket("**/jog/**", lambda line: line.close(code=code))
        page.reload()
        expect(page.locator("#who")).to_have_text("NOT HEARD")
        expect(page.locator("#said")).to_contain_text(word)
        page.get_by_text("Take the bench").dispatch_event("click")
        expect(page.locator("#said")).to_have_text("not connected; nothing was done")
        _require_whole(page)
