"""What a console costs: from a commit to ten screens, a quiet night's processor and memory, the pace of a run, kills.

Figures of a quiet machine; ``--junitxml FILE -o junit_family=xunit1`` keeps them as properties.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from http.client import HTTPException
from http.cookies import SimpleCookie
from pathlib import Path
from threading import Thread
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

import numpy as np
import psutil
import pytest
from chromium import chromium
from consoles import ServedConsole, served_console
from job_files import job, simulated
from playwright.sync_api import expect
from run_folders import make_run, stored_run
from small_run import PROCEDURE, RIG
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect
from websockets.typing import Origin

from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.live import LiveFile
from procedures.journal.sidecar.owner import owning
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.dwells import ChannelReading, DwellRecord
from procedures.records.states import State
from rig.clock import SystemClock

pytestmark = [pytest.mark.soak, pytest.mark.timeout(3600)]
CLOCK = SystemClock()
CALRIG, BY = (sys.executable, "-m", "procedures.cli.main"), ("--operator", "Anna")
KILLS = 100
DAY = {"replications = 2": "replications = 120", "min_s = 0.5, max_s = 30.0": "min_s = 45.0, max_s = 90.0"}
"""Somewhat more than a day of the rig's time."""
Note = Callable[[str, object], None]
SEEN = """() => { window.seen = {};
  const look = () => document.querySelectorAll('.news li').forEach((line) => {
    const found = /commit (\\d+)$/.exec(line.textContent.trim());
    if (found && !(found[1] in window.seen)) {
      window.seen[found[1]] = 0;
      requestAnimationFrame(() => requestAnimationFrame(() => { window.seen[found[1]] = Date.now(); }));
    }
  });
  new MutationObserver(look).observe(document.getElementById('standing'), { childList: true, subtree: true }); }"""


class _Listener:
    """A browser without a screen: it has the cookie, and takes what the page of a run would be told."""

    def __init__(self, console: ServedConsole, run: str) -> None:
        link = console.link()
        self.base = "http://" + urlsplit(link).netloc
        with urlopen(link) as answer:
            self.headers = {"cookie": f"calrig={SimpleCookie(answer.headers['set-cookie'])['calrig'].value}"}
        self.heard = 0
        self._where = f"ws://{self.base[7:]}/live/{run}"
        Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        with (
            suppress(WebSocketException, OSError),
            connect(self._where, origin=Origin(self.base), additional_headers=self.headers) as line,
        ):
            for _ in line:
                self.heard += 1

    def get(self, path: str) -> bytes:
        with urlopen(Request(self.base + path, headers=self.headers)) as answer:
            return bytes(answer.read())


@contextmanager
def _going_run(folder: Path) -> Iterator[Path]:
    run = make_run(folder / "runs" / "night", State.RUNNING, started_utc=datetime.now(UTC))
    with owning(run):
        yield run


def test_a_commit_is_seen_on_ten_screens_in_half_a_second(tmp_path: Path, record_property: Note) -> None:
    """p95 of 100 commits on ten pages of one browser: the second frame after the line stands there."""
    with _going_run(tmp_path) as run, served_console(run.parent, tmp_path / "none.sqlite") as console:
        with chromium() as browser:
            pages = []
            for _ in range(10):
                page = browser.new_context().new_page()
                page.goto(console.link())
                page.wait_for_url("**/")
                expect(page.locator("#fresh")).to_have_text("● live")
                page.evaluate(SEEN)
                pages.append(page)
            journal, request = Journal.open_for_append(run / JOURNAL_FILE), []
            for number in range(100):
                request.append(CLOCK.now_utc().timestamp())
                journal.append_event("note", {"by": "anna", "text": f"commit {number}", "at_utc": "x"}, CLOCK)
                pages[number % 10].wait_for_timeout(400 + 13 * (number % 30))
            journal.close()
            pages[0].wait_for_timeout(1000)
            seen = [page.evaluate("window.seen") for page in pages]
        took = [entry[str(n)] / 1e3 - request[n] for entry in seen for n in range(100)]
    p50_s, p95_s = np.quantile(took, [0.5, 0.95])
    record_property("p50, p95 in seconds", (p50_s, p95_s))
    assert p95_s < 0.5


def test_a_quiet_run_costs_less_than_a_hundredth_of_a_core(tmp_path: Path, record_property: Note) -> None:
    """One run that commits nothing for a minute, one page that is open; the engine tells each second what it does."""
    with _going_run(tmp_path) as run, served_console(run.parent, tmp_path / "none.sqlite") as console:
        listener, live = _Listener(console, run.name), LiveFile(run, CLOCK)
        process = psutil.Process(console.process.pid)

        def live_on(seconds: int) -> None:
            for second in range(seconds):
                live.tell("soaking", soak_left_s=float(600 - second))
                live.look()
                CLOCK.sleep(1.0)

        live_on(5)
        before, began_s = process.cpu_times(), CLOCK.monotonic_s()
        live_on(60)
        after, took_s = process.cpu_times(), CLOCK.monotonic_s() - began_s
        assert listener.heard > 30
    share = (after.user + after.system - before.user - before.system) / took_s
    record_property("share of a core", share)
    assert share < 0.01


def _night_of(dwells: int) -> Iterator[DwellRecord]:
    """Dwells of 24 channels, half a minute each."""
    chance, began = np.random.default_rng(5), datetime(2026, 11, 24, tzinfo=UTC)
    _, (first, *_) = stored_run()
    for step in range(dwells):
        readings = {
            f"daq.s{n // 3}{'xyz'[n % 3]}": ChannelReading(
                f"daq.s{n // 3}{'xyz'[n % 3]}", 2.5 * np.cos(0.1 * step + n) + 2e-5 * chance.normal(size=5), 0.0, 0.2
            )
            for n in range(24)
        }
        started = began + timedelta(seconds=30 * step)
        yield replace(
            first, step=step, accepted=True, targets_deg={"pitch": float(step % 60 - 30), "roll": 0.0}, reasons=(),
            readings=readings, started_utc=started, ended_utc=started + timedelta(seconds=10), sha256="",
        )  # fmt: skip


def test_memory_is_flat_over_twenty_thousand_dwells_of_24_channels(tmp_path: Path, record_property: Note) -> None:
    run = make_run(tmp_path / "runs" / "night", State.RUNNING, started_utc=datetime.now(UTC), dwells=0)
    taken: list[int] = []
    with owning(run), served_console(run.parent, tmp_path / "none.sqlite") as console:
        listener, process = _Listener(console, run.name), psutil.Process(console.process.pid)
        journal = Journal.open_for_append(run / JOURNAL_FILE)
        for number, dwell in enumerate(_night_of(20_000), 1):
            journal.commit_dwell(dwell, CLOCK)
            if number % 2000 == 0:
                listener.get("/")
                listener.get(f"/api/v1/runs/{run.name}/map")
                CLOCK.sleep(1.0)
                taken.append(process.memory_info().rss)
        journal.close()
    record_property("resident bytes every 2000 dwells", taken)
    assert max(taken[5:]) < 1.05 * max(taken[1:5])


def test_memory_is_flat_over_a_simulated_day(tmp_path: Path, record_property: Note) -> None:
    """A real run on twins in virtual time that lasts a day of theirs, with the page of it open and looked at."""
    files, runs = tmp_path / "files", tmp_path / "runs"
    files.mkdir()
    runs.mkdir()
    procedure, rig = job(files, DAY)
    command = [
        *CALRIG,
        "run",
        procedure,
        "--rig",
        rig,
        "--out",
        str(runs),
        "--archive",
        f"sqlite:///{tmp_path}/a.sqlite",
    ]
    taken: list[int] = []
    with (
        served_console(runs, tmp_path / "a.sqlite") as console,
        subprocess.Popen([*command, *BY], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as engine,
    ):
        while not list(runs.glob("*/journal.sqlite")):
            CLOCK.sleep(0.2)
            assert engine.poll() is None
        (run,) = [one.parent for one in runs.glob("*/journal.sqlite")]
        listener, process = _Listener(console, run.name), psutil.Process(console.process.pid)
        while engine.poll() is None and not _is_measured(run):
            for path in ("/", "/night", f"/api/v1/runs/{run.name}/map"):
                listener.get(path)
            taken.append(process.memory_info().rss)
            CLOCK.sleep(1.0)
        engine.terminate()
        engine.wait()
    with JournalReader.open(run) as reader:
        dwells = list(reader.dwells())
    lasted_s = (dwells[-1].ended_utc - dwells[0].started_utc).total_seconds()
    quarters = [max(part) for part in np.array_split(taken, 4)]
    record_property("hours, dwells, resident bytes by quarters", (lasted_s / 3600.0, len(dwells), quarters))
    assert lasted_s > 86_400.0
    assert listener.heard > 100
    assert quarters[3] < 1.05 * quarters[1]


def _is_measured(run: Path) -> bool:
    with JournalReader.open(run) as reader:
        entered = reader.last_event("state")
    return entered is not None and entered.detail["to"] == State.FINISHED


def _pace(run: Path) -> list[float]:
    """Seconds from the end of a dwell to the end of the next, of every dwell but the first."""
    with JournalReader.open(run) as reader:
        ends = [dwell.ended_utc.timestamp() for dwell in reader.dwells()]
    return list(np.diff(ends))


def test_a_run_is_as_quick_with_a_console(tmp_path: Path, record_property: Note) -> None:
    """Medians of 500 dwells each, in four runs that alternate, ten times as fast as real."""
    files, archive = tmp_path / "files", f"sqlite:///{tmp_path}/archive.sqlite"
    files.mkdir()
    procedure, rig = job(files, {"replications = 2": "replications = 17"})
    paces: dict[bool, list[float]] = {False: [], True: []}
    with simulated(rig, files / "ports.toml", "--pty", "--time-factor", "10"):
        for number in range(4):
            has_console, runs = number % 2 == 1, tmp_path / f"runs{number}"
            runs.mkdir()
            command = [*CALRIG, "run", procedure, "--rig", str(files / "ports.toml"), "--out", str(runs)]
            with ExitStack() as stack:
                engine = subprocess.Popen(
                    [*command, "--archive", archive, "--operator", "Anna"], stderr=subprocess.DEVNULL
                )
                stack.callback(engine.wait)
                while not list(runs.glob("*/journal.sqlite")):
                    CLOCK.sleep(0.2)
                    assert engine.poll() is None
                (run,) = [entry.parent for entry in runs.glob("*/journal.sqlite")]
                if has_console:
                    console = stack.enter_context(served_console(runs, tmp_path / "archive.sqlite"))
                    listener = _Listener(console, run.name)
                assert engine.wait() == 0
                assert not has_console or listener.heard > 100
            paces[has_console] += _pace(run)
    alone_s, watched_s = (float(np.median(paces[key])) for key in (False, True))
    record_property("median of a dwell alone and watched, seconds", (alone_s, watched_s))
    assert watched_s < 1.01 * alone_s


def _measured(run: Path) -> tuple[object, object]:
    """What a run is for: its dwells to the last sample, and its coefficients."""
    with JournalReader.open(run) as reader:
        dwells = [
            (
                dwell.step,
                dwell.attempt,
                [(name, read.samples.tolist()) for name, read in sorted(dwell.readings.items())],
            )
            for dwell in reader.dwells()
        ]
    (found,) = (run / "coefficients").glob("*.json")
    document = json.loads(found.read_text(encoding="utf-8"))
    return dwells, (document["axes"], document["package"])


def _look_until_it_dies(console: ServedConsole, run: str) -> None:
    with suppress(OSError, HTTPException, AssertionError):
        listener = _Listener(console, run)
        while True:
            for path in ("/", "/night", f"/run/{run}", f"/api/v1/runs/{run}/map"):
                listener.get(path)


def test_a_console_that_is_killed_changes_no_run(tmp_path: Path) -> None:
    """Killed 100 times while it is looked at and runs go on beneath it; every run is the run that nobody watched."""
    (tmp_path / "rig.toml").write_text(RIG)
    (tmp_path / "procedure.toml").write_text(PROCEDURE)
    words = [
        "run",
        "procedure.toml",
        "--rig",
        "rig.toml",
        "--archive",
        f"sqlite:///{tmp_path}/a.sqlite",
        "--operator",
        "A",
    ]
    environment = {**os.environ, "CALRIG_QUEUES": str(tmp_path / "queues")}

    def run_once(out: str) -> None:
        subprocess.run([*CALRIG, *words, "--out", out], cwd=tmp_path, check=True, capture_output=True, env=environment)

    run_once("alone")
    (tmp_path / "runs").mkdir()
    is_over: list[bool] = []

    def run_on() -> None:
        while not is_over:
            run_once("runs")

    running, chance = Thread(target=run_on), np.random.default_rng(4)
    running.start()
    try:
        for _ in range(KILLS):
            with served_console(tmp_path / "runs", tmp_path / "a.sqlite") as console:
                newest = max((entry.name for entry in (tmp_path / "runs").glob("2*")), default="none")
                looking = Thread(target=_look_until_it_dies, args=(console, newest), daemon=True)
                looking.start()
                CLOCK.sleep(float(chance.uniform(0.3, 3.0)))
                console.process.kill()
                looking.join(30.0)
    finally:
        is_over.append(True)
        running.join()
    (alone,) = [entry.parent for entry in (tmp_path / "alone").glob("*/journal.sqlite")]
    runs = [entry.parent for entry in (tmp_path / "runs").glob("*/journal.sqlite")]
    assert len(runs) > 5
    expected = _measured(alone)
    for run in runs:
        assert _measured(run) == expected
