"""From the button to the first stop on the wire: an abort with many tabs, idle connections and a busy machine."""

import json
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from http.cookies import SimpleCookie
from pathlib import Path
from urllib.parse import urlencode, urlsplit

import numpy as np
import pytest
from consoles import served_console
from guarded_engine import guarded_engine
from run_folders import make_run
from turning_rig import STAGE_FOR_ROLL
from websockets.sync.client import connect

from procedures.journal.sidecar.owner import owning
from procedures.records.states import State
from rig.clock import SystemClock

TABS, IDLE, BUSY, ABORTS = 8, 60, 12, 100
CLOCK = SystemClock()


class Opener:
    """A browser's cookie and its token."""

    def __init__(self, link: str, run: str) -> None:
        self.base = "http://" + urlsplit(link).netloc
        self.address = self.base[7:].rpartition(":")
        with urllib.request.urlopen(link) as answer:
            cookie = SimpleCookie(answer.headers["set-cookie"])
        self.cookie = f"calrig={cookie['calrig'].value}"
        page = urllib.request.Request(f"{self.base}/run/{run}", headers={"cookie": self.cookie})
        with urllib.request.urlopen(page) as answer:
            self.csrf = answer.read().decode().partition('name="csrf" value="')[2].partition('"')[0]

    def post(self, path: str, **fields: str) -> dict[str, object]:
        headers = {"cookie": self.cookie, "origin": self.base}
        data = urlencode({"csrf": self.csrf, **fields}).encode()
        request = urllib.request.Request(self.base + path, data, headers)
        with urllib.request.urlopen(request) as answer:
            return json.loads(answer.read())


@contextmanager
def _busy_machine() -> Iterator[None]:
    processes = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(BUSY)]
    try:
        yield
    finally:
        for running in processes:
            running.kill()
            running.wait()


@pytest.mark.soak
@pytest.mark.timeout(600)
def test_an_abort_reaches_the_wire_in_a_third_of_a_second(
    tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    """A real guard holds the line of an axis; noted is when its stop reaches the machine."""
    with ExitStack() as stack:
        engine = stack.enter_context(guarded_engine(tmp_path, STAGE_FOR_ROLL, stays=True))
        engine.run.rmdir()
        run = make_run(engine.run, State.RUNNING)
        stack.enter_context(owning(run))
        console = stack.enter_context(served_console(run.parent, tmp_path / "none.sqlite"))
        browser = Opener(console.link(), run.name)
        for _ in range(TABS):
            where = f"ws://{browser.base[7:]}/live/{run.name}"
            headers = {"cookie": browser.cookie}
            stack.enter_context(connect(where, origin=browser.base, additional_headers=headers, ping_interval=None))
        host, _, port = browser.address
        stack.enter_context(_busy_machine())
        took: list[float] = []
        for number in range(ABORTS):
            if number % 20 == 0:  # they are sent away after five seconds
                for _ in range(IDLE):
                    stack.enter_context(socket.create_connection((host, int(port))))
            began_s = CLOCK.monotonic_s()
            answer = browser.post(f"/api/v1/runs/{run.name}/abort", key=f"a{number}")
            assert answer["done"], answer
            assert engine.until(partial(engine.line.first_s, b"stop", began_s), 5.0), f"abort {number}: {answer}"
            first_s = engine.line.first_s(b"stop", began_s)
            assert first_s is not None
            took.append(first_s)
    p50_s, p99_s = np.quantile(took, [0.5, 0.99])
    record_property("p50, p99 in seconds", (p50_s, p99_s))
    assert p99_s < 0.3, f"median {1e3 * p50_s:.0f} ms, p99 {1e3 * p99_s:.0f} ms of {ABORTS}"
