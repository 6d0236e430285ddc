"""The observer of ``examples/own_line_output``: real bytes on a real socket, in InfluxDB's line protocol."""

import re
import socket
from pathlib import Path

import pytest
from installed_examples import install_example

from procedures.observers.audience import with_observers
from procedures.records.progress import Progress
from procedures.records.states import State

HELD = Progress("state", State.HELD, 3, 24, 1, 2, 7.25, None, 'the "air", 41 °C \\ too warm\nwait', rejected=2)
FIELDS = (
    r'state="held",dwells_done=3i,dwells_planned=24i,rejected=2i,replication=1i,rate_per_min=7\.25,'
    r'message="the \\"air\\", 41 °C \\\\ too warm wait"'
)


class Screen:
    def on_event(self, progress: Progress) -> None:
        """It shows nothing."""


@pytest.fixture(autouse=True)
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install_example("own_line_output", tmp_path / "site", monkeypatch)


def test_every_moment_is_a_datagram_of_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as telegraf:
        telegraf.bind(("127.0.0.1", 0))
        telegraf.settimeout(10.0)
        monkeypatch.setenv("CALRIG_LINE_OUTPUT", f"127.0.0.1:{telegraf.getsockname()[1]}")
        audience = with_observers(Screen(), tmp_path / "run=1, a", pytest.fail)
        audience.on_event(HELD)
        audience.on_event(Progress("dwell", State.RUNNING, 4, 24, 1, 2, None, None, ""))
        first, second = (telegraf.recv(65536).decode("utf-8") for _ in range(2))
    assert re.fullmatch(rf"calrig,event=state,run=run\\=1\\,\\ a {FIELDS} \d{{16}}000\n", first), first
    assert re.fullmatch(r'calrig,event=dwell,run=\S+\\ a state="running",dwells_done=4i,\S+=1i \d{19}\n', second)


def test_nobody_listens_and_the_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as closed:
        closed.bind(("127.0.0.1", 0))
        monkeypatch.setenv("CALRIG_LINE_OUTPUT", f"127.0.0.1:{closed.getsockname()[1]}")
    audience = with_observers(Screen(), tmp_path / "run", pytest.fail)
    for _ in range(3):
        audience.on_event(HELD)


def test_an_address_that_is_none_is_told_and_the_run_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CALRIG_LINE_OUTPUT", "telegraf")
    failures = list[str]()
    with_observers(Screen(), tmp_path / "run", failures.append)
    assert len(failures) == 1
    assert failures[0].startswith("observer line-output: ValueError: ")


def test_without_a_name_it_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CALRIG_LINE_OUTPUT", raising=False)
    screen = Screen()
    assert with_observers(screen, tmp_path, pytest.fail) is screen
