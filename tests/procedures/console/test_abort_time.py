"""From the button to the stop guard: the time of an abort, with many tabs, idle connections and a busy machine."""

import json
import os
import socket
import subprocess
import sys
import urllib.request
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from http.cookies import SimpleCookie
from pathlib import Path
from urllib.parse import urlencode, urlsplit

import numpy as np
import pytest
from consoles import served_console
from run_folders import make_run
from websockets.sync.client import connect

from procedures.journal.owner import owning
from procedures.records.states import State
from rig.clock import SystemClock
from rig.guard.ask import FOLDER, KEYS, SUFFIX
from rig.machine_folder import machine_folder

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


def _answering(listener: socket.socket) -> float:
    """Answer one question as a guard does; returns when it was asked."""
    line, _ = listener.accept()
    with line:
        line.recv(4096)
        asked_s = CLOCK.monotonic_s()
        line.sendall(b"pitch\ttold to stop\n")
    return asked_s


@pytest.mark.soak
def test_an_abort_reaches_the_guard_in_a_third_of_a_second(tmp_path: Path) -> None:
    run = make_run(tmp_path / "runs" / "night-1", State.RUNNING)
    with ExitStack() as stack:
        stack.enter_context(owning(run))
        listener = stack.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_STREAM))
        name = f"calrig-test-guard-{os.getpid()}"
        listener.bind(f"\0{name}")
        listener.listen(8)
        told = {"socket": name, "pid": str(os.getpid()), "run": str(run.resolve())}
        guard = Path(machine_folder(FOLDER)) / f"{name}{SUFFIX}"
        guard.write_text("".join(told.get(key, "") + "\n" for key in KEYS))
        stack.callback(guard.unlink)
        console = stack.enter_context(served_console(tmp_path / "runs", tmp_path / "none.sqlite"))
        browser = Opener(console.link(), run.name)
        for _ in range(TABS):
            where = f"ws://{browser.base[7:]}/live/{run.name}"
            headers = {"cookie": browser.cookie}
            stack.enter_context(connect(where, origin=browser.base, additional_headers=headers, ping_interval=None))
        busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(BUSY)]
        stack.callback(lambda: [(one.kill(), one.wait()) for one in busy])
        host, _, port = browser.address
        took: list[float] = []
        threads = stack.enter_context(ThreadPoolExecutor(1))
        for number in range(ABORTS):
            if number % 20 == 0:  # they are sent away after five seconds
                for _ in range(IDLE):
                    stack.enter_context(socket.create_connection((host, int(port))))
            asked: Future[float] = threads.submit(_answering, listener)
            began_s = CLOCK.monotonic_s()
            answer = browser.post(f"/api/v1/runs/{run.name}/abort", key=f"a{number}")
            assert answer["done"], answer
            took.append(asked.result(10.0) - began_s)
    p50_s, p99_s = np.quantile(took, [0.5, 0.99])
    assert p99_s < 0.3, f"median {1e3 * p50_s:.0f} ms, p99 {1e3 * p99_s:.0f} ms of {ABORTS}"
