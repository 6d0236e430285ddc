"""The night of ``docs/tutorials/first-night.md``: two runs queued, armed, watched and read by the console alone.

Its pictures are taken here, into the folder that ``CALRIG_PICTURES`` names: ``docs/images`` renews those of the page.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from chromium import chromium
from consoles import served_console
from job_files import job, simulated
from playwright.sync_api import Page, expect

LONGEST_S = 400
"""No run of the night lasts longer on a busy machine."""
FAULTS = """
[fault.jam]
line = "axes.pitch"
kind = "stall"
nth = 600
for_s = 60.0
[fault.cable]
line = "readouts.dmm"
kind = "rename"
nth = 3500
away_s = 300.0
"""
"""The table jams once in the first run and is driven again; the second run loses the meter and waits for it."""


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """The two procedures; the rig file comes from the ports."""
    folder = tmp_path / "jobs"
    folder.mkdir()
    bench = tmp_path / "bench"
    bench.mkdir()
    procedure = Path(job(bench)[0]).read_text(encoding="utf-8")
    for name, title in (("as-found.toml", "SN1047 as found"), ("as-left.toml", "SN1047 as left")):
        (folder / name).write_text(procedure.replace('title = "small"', f'title = "{title}"'), encoding="utf-8")
    (bench / "faults.toml").write_text(FAULTS, encoding="utf-8")
    (tmp_path / "runs").mkdir()
    return folder


@contextmanager
def _runner(folder: Path) -> Iterator[None]:
    command = [sys.executable, "-m", "procedures.cli.main", "queue", "run", "--rig", str(folder / "jobs/rig.toml")]
    process = subprocess.Popen([*command, "--archive", f"sqlite:///{folder}/archive.sqlite"], stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)


def _picture(page: Page, name: str, folder: Path) -> None:
    page.screenshot(path=Path(os.environ.get("CALRIG_PICTURES", folder)) / f"first-night-{name}.png", full_page=True)


def _add(page: Page, base: str, procedure: str) -> None:
    page.goto(f"{base}/queue")
    page.get_by_label("Procedure").select_option(procedure)
    page.get_by_role("button", name="Add to the queue").click(timeout=60_000)
    expect(page.get_by_role("heading")).to_contain_text("its check speaks against nothing", timeout=60_000)


def _arm(page: Page, base: str) -> None:
    page.goto(f"{base}/queue")
    page.get_by_text("Arm", exact=True).first.click()
    page.get_by_label("Until, such as 06:00").fill("2099-01-01T06:00")
    page.get_by_role("button", name="Arm").click()
    expect(page.get_by_role("heading")).to_contain_text("arm: done")


def _wait_for(page: Page, address: str, parts: str, times: int = 1) -> None:
    """Look at a page that does not follow by itself until it has these parts."""
    for _ in range(LONGEST_S):
        page.goto(address)
        if page.locator(parts).count() >= times:
            return
        page.wait_for_timeout(1000)
    raise AssertionError(f"{address} never had {parts!r}: {page.locator('main').inner_text()}")


@pytest.mark.soak
@pytest.mark.timeout(1200)
def test_a_night_by_the_console_alone(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOGNAME", "Anna Ray")
    monkeypatch.setenv("CALRIG_QUEUES", str(tmp_path / "queues"))
    bench, archive = tmp_path / "bench", tmp_path / "archive.sqlite"
    options = ("--pty", "--time-factor", "20", "--faults", str(bench / "faults.toml"))
    with (
        simulated(str(bench / "rig.toml"), files / "rig.toml", *options),
        served_console(tmp_path / "runs", archive, files) as console,
        _runner(tmp_path),
        chromium() as browser,
    ):
        page = browser.new_page(viewport={"width": 900, "height": 700})
        page.goto(console.link())
        page.wait_for_url("**/")
        base = page.url.rstrip("/")
        _add(page, base, "as-found.toml")
        _add(page, base, "as-left.toml")
        page.goto(f"{base}/queue")
        page.get_by_text("Say what is mounted").click()
        page.get_by_role("button", name="This is mounted").click()
        expect(page.get_by_role("heading")).to_contain_text("attest: done")
        _arm(page, base)
        page.goto(f"{base}/queue")
        expect(page.get_by_text("ARMED", exact=True)).to_be_visible()
        _picture(page, "queue", tmp_path)

        _wait_for(page, f"{base}/", ".banner.held")
        expect(page.locator("#banner")).to_contain_text("readouts.dmm")
        _picture(page, "held", tmp_path)

        _wait_for(page, f"{base}/night", ".verdict", 2)
        expect(page.get_by_text("FINISHED", exact=True)).to_have_count(2)
        _picture(page, "morning", tmp_path)
        page.get_by_text("SN1047 as found", exact=True).click()
        expect(page.locator("main")).to_contain_text("no progress")
        _picture(page, "jam", tmp_path)
