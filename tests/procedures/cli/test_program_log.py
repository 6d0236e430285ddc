"""The log tells what was called and how it ended, holds no secret, and costs a command nothing when it fails."""

import json
import logging
import threading
from pathlib import Path
from typing import Any

import pytest
from command import call
from hypothesis import given
from hypothesis import strategies as st

from procedures.cli import program_log
from procedures.cli.program_log import LoggedObserver, log_path, logged, tell, without_addresses
from procedures.records.progress import Progress, SilentObserver
from procedures.records.states import State


def lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "a place" / "calrig.log"
    monkeypatch.setenv("CALRIG_LOG", str(path))
    monkeypatch.setenv("CALRIG_LOG_FORMAT", "json")
    return path


def test_a_command_its_error_and_its_end_are_a_line_each(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "status", "no-such-run")
    assert outcome.status == 2
    begun, error, ended = lines(log)
    assert (begun["what"], begun["message"], begun["level"]) == ("command", "calrig status no-such-run", "info")
    assert (error["level"], f"calrig: {error['message']}") == ("error", outcome.err.strip())
    assert ended["message"] == "ended with status 2"
    assert logging.getLogger("calrig").handlers == []


def test_text_is_one_line_whatever_a_message_holds(tmp_path: Path) -> None:
    path = tmp_path / "calrig.log"
    with logged(["note", "a\nb\u202e"], {"CALRIG_LOG": str(path)}):
        pass
    (line,) = path.read_text("utf-8").splitlines()
    assert line.endswith("command: calrig note a<U+000A>b<U+202E>")


def test_a_command_that_has_no_memory_for_a_thread_ends_with_its_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> int:
        raise RuntimeError("can't start new thread")

    def work() -> None:
        with logged([], {"CALRIG_LOG": str(tmp_path / "calrig.log")}):
            monkeypatch.setattr("rig.threads.start_new_thread", refused)
            raise MemoryError

    with pytest.raises(MemoryError):
        work()


@pytest.mark.parametrize("level", ["info", "debug"])
def test_what_a_run_tells_is_logged_and_told_on_and_dwells_to_those_who_ask(tmp_path: Path, level: str) -> None:
    path = tmp_path / "calrig.log"
    observer = LoggedObserver("runs/a", SilentObserver())
    with logged([], {"CALRIG_LOG": str(path), "CALRIG_LOG_LEVEL": level, "CALRIG_LOG_FORMAT": "json"}):
        for event in ("dwell", "state"):
            observer.on_event(Progress(event, State.HELD, 1, 9, 1, 1, None, None, "the air is too warm"))
    text = [line["message"] for line in lines(path) if line["what"] == "run"]
    assert text[-1] == "runs/a: state: held 1/9 · replication 1 of 1 · the air is too warm"
    assert len(text) == (2 if level == "debug" else 1)


def test_a_log_that_cannot_be_written_costs_a_command_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("CALRIG_LOG", str(tmp_path / "file" / "calrig.log"))
    outcome = call(capsys, "--version")
    assert (outcome.status, outcome.err) == (0, "")


def test_a_disk_that_hangs_is_not_waited_for(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    goes_on = threading.Event()
    monkeypatch.setattr(program_log._QuietFile, "emit", lambda *_: goes_on.wait())
    monkeypatch.setattr(program_log, "CLOSING_S", 0.05)
    monkeypatch.setattr(program_log, "MOST_WAITING", 3)
    with logged(["run"]):
        for _ in range(50):
            tell("run", "more than the queue holds")
    goes_on.set()


def test_a_file_that_is_full_is_turned_over_and_the_oldest_goes(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(program_log, "LARGEST_BYTES", 2000)
    monkeypatch.setattr(program_log, "KEPT_FILES", 2)
    with logged(["run"]):
        for index in range(60):
            tell("run", f"line {index} {'.' * 60}")
    assert sorted(path.name for path in log.parent.iterdir()) == ["calrig.log", "calrig.log.1", "calrig.log.2"]
    assert all(path.stat().st_size <= 2000 for path in log.parent.iterdir())
    assert lines(log)[-1]["message"].startswith("line 59 ")


def test_no_log_where_it_is_off_and_its_place_is_told_for_support(capsys: pytest.CaptureFixture[str]) -> None:
    assert log_path({"CALRIG_LOG": "off"}) is None
    assert log_path({}) is not None
    assert call(capsys, "--version", "--json").document["log"] is None  # tests leave it out


def test_a_setting_that_is_none_is_refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("CALRIG_LOG", "somewhere.log")
    monkeypatch.setenv("CALRIG_LOG_LEVEL", "loud")
    outcome = call(capsys, "--version")
    assert outcome.status == 2
    assert "CALRIG_LOG_LEVEL: got 'loud', allowed are info, debug, warning, error; nothing was done" in outcome.err


SECRET = st.text("abcdefXYZ0123456789-_.~%+", min_size=6, max_size=20).filter(lambda text: text.strip("."))


ADDRESSES = (
    "https://hooks.example.org/{}",
    "tgram://{}/chat",
    "postgresql+psycopg://u:{}@host/db",
    "sqlite://user:{}@host/x",
    "socket://me:{}@10.0.0.1:4001",
    "mailto://me:{}@host",
)


@given(SECRET, st.sampled_from(ADDRESSES))
def test_no_secret_of_an_address_gets_into_the_log(secret: str, address: str) -> None:
    written = without_addresses(f"archive list --archive='{address.format(secret)}', refused")
    assert secret not in written
    assert written.startswith("archive list")


def test_addresses_of_ports_and_files_stay_readable() -> None:
    text = "dmm: socket://10.0.0.1:4001: silent; sqlite:////home/a/archive.sqlite"
    assert without_addresses(text) == text
