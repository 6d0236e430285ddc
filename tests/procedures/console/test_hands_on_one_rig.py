"""Several hands on one rig, each a process of its own: what they ask for is refused, or every axis stands; in words."""

import os
import subprocess
import sys
import urllib.request
from pathlib import Path
from urllib.error import HTTPError
from urllib.parse import urlencode

import pytest
from consoles import served_console
from job_files import SMALL
from jog_bench import CLOCK, RIG, JogBench, WordPage, jog_bench, word_page
from starved import starved

from procedures.accounts.people import People

STOPPED_S = 0.5
pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="the console hands its benches over pipes of a loop"),
    pytest.mark.thorough,
]


@pytest.fixture
def people(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> People:
    """The accounts of the consoles that are served from here."""
    path = tmp_path / "people.json"
    monkeypatch.setenv("CALRIG_PEOPLE", str(path))
    return People(path)


def _calrig(*words: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "procedures.cli.main", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def _turning(bench: JogBench, page: WordPage) -> None:
    page.take()
    page.home()
    page.hold(5.0)
    bench.until_turning()


def _turns_it_anew(bench: JogBench, page: WordPage) -> None:
    """Who has the bench turns it: also where a machine without a processor let the lease before run out."""
    page.release()
    page.hold(5.0)
    bench.until_turning()


def test_a_second_console_does_not_get_a_rig_that_a_page_turns(tmp_path: Path) -> None:
    with (
        jog_bench(tmp_path) as bench,
        served_console(tmp_path / "runs", tmp_path / "none.sqlite", bench.files) as second,
        word_page(bench) as page,
        word_page(bench, console=second) as other,
        starved() as meter,
    ):
        _turning(bench, page)
        other.say(say="take")
        other.until("in use by process")
        assert "(jog)" in str(other.messages)
        _turns_it_anew(bench, page)
        other.say(say="stop")  # nothing of it is there to be stopped by its own socket; by its form the guard is asked
        stopped_s = CLOCK.monotonic_s()
        assert _posted(other, "stop") == (202, True)
        assert bench.late_s(stopped_s) < STOPPED_S + meter.allowance_s
        page.until("the stop guard told the axes to stop at once, asked for by")
        page.until("every axis stands still")


def test_a_role_that_is_taken_away_in_mid_motion_ends_the_motion(tmp_path: Path, people: People) -> None:
    secret = people.add("Anna", "move", CLOCK.now_utc())
    with (
        jog_bench(tmp_path) as bench,
        word_page(bench, account=("Anna", secret)) as page,
        word_page(bench) as other,
        starved() as meter,
    ):
        _turning(bench, page)
        people.add("Anna", "watch", CLOCK.now_utc(), renews=True)
        written_s = CLOCK.monotonic_s()  # its hash takes a while, by intention
        assert bench.late_s(written_s) < STOPPED_S + meter.allowance_s
        page.until("the session has ended, or its account is another one now; what moved by this page was stopped")
        other.until("Anna has the bench no more")


def test_a_session_that_ends_sees_the_bench_no_more_though_it_says_nothing(tmp_path: Path, people: People) -> None:
    secret = people.add("Bob", "watch", CLOCK.now_utc())
    with (
        jog_bench(tmp_path) as bench,
        word_page(bench) as page,
        word_page(bench, account=("Bob", secret)) as watcher,
    ):
        page.take()
        watcher.until("has the bench")
        people.remove("Bob")
        watcher.until("the session has ended")


def test_a_run_does_not_begin_while_a_page_turns_the_rig_nor_a_page_during_a_run(tmp_path: Path) -> None:
    procedure = tmp_path / "procedure.toml"
    procedure.write_text(SMALL, encoding="utf-8")
    with jog_bench(tmp_path) as bench, word_page(bench) as page:
        run = ["run", str(procedure), "--rig", str(bench.files / RIG), "--out", str(tmp_path / "runs")]
        _turning(bench, page)
        told = _calrig(*run)
        assert told.returncode != 0
        assert "in use by process" in told.stderr
        assert "(jog)" in told.stderr
        assert "nothing was opened" in told.stderr
        assert list((tmp_path / "runs").iterdir()) == []
        _turns_it_anew(bench, page)
        page.release()
        page.say(say="give")
        page.until("every axis stands still")
        began = subprocess.Popen(
            [sys.executable, "-m", "procedures.cli.main", *run], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            until_s = CLOCK.monotonic_s() + 60.0
            while not list((tmp_path / "runs").glob("*/journal.sqlite")):
                assert CLOCK.monotonic_s() < until_s
                assert began.poll() is None
                CLOCK.sleep(0.1)
            page.say(say="take")
            page.until(f"in use by process {began.pid} (run)")
        finally:
            began.terminate()
            began.wait(60)


def test_a_stop_of_the_shell_is_told_on_the_page_and_the_next_motion_moves(tmp_path: Path) -> None:
    with jog_bench(tmp_path) as bench, word_page(bench) as page:
        _turning(bench, page)
        told = _calrig("jog", "--rig", str(bench.files / RIG), "--stop")
        assert told.returncode == 0, told.stderr
        assert "roll: told to stop" in told.stdout
        bench.late_s(0.0)
        page.until("the stop guard told the axes to stop at once, asked for by")
        page.until("every axis stands still")
        page.release()
        page.hold(5.0)
        bench.until_turning()


def _posted(page: WordPage, act: str, **changed: str) -> tuple[int, bool]:
    """Post what the form of the page posts; ``changed`` fields in place of its own."""
    fields = {"csrf": page.csrf, "key": "k1"} | changed
    request = urllib.request.Request(
        f"{page.base}/api/v1/jog/{RIG}/{act}",
        urlencode(fields).encode(),
        {"origin": page.base, "cookie": page.cookie, "accept": "application/json"},
    )
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, True
    except HTTPError as refused:
        return refused.code, b'"done":true' in refused.read()


def test_a_stop_without_its_token_is_refused_and_what_it_says_is_true(tmp_path: Path) -> None:
    with jog_bench(tmp_path) as bench, word_page(bench) as page:
        _turning(bench, page)
        assert _posted(page, "stop", csrf="x") == (403, False)
        _turns_it_anew(bench, page)
        assert "stop" not in [line["kind"] for line in bench.log()], "nothing was done, it said"
        assert _posted(page, "stop") == (202, True)
        bench.late_s(0.0)
