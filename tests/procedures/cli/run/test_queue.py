"""``calrig queue`` and ``calrig console people``: what is said at the terminal, and refused there."""

import subprocess
import sys
from pathlib import Path

import pytest
from command import Outcome, call
from small_run import PROCEDURE, RIG, bench

from procedures.queue import adding
from procedures.records.progress import Progress


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("CALRIG_QUEUES", str(tmp_path / "queues"))
    monkeypatch.setenv("CALRIG_PEOPLE", str(tmp_path / "people.json"))
    monkeypatch.setattr(adding, "checked", lambda procedure, rig, out: [])
    (tmp_path / "rig.toml").write_text(RIG)
    (tmp_path / "procedure.toml").write_text(PROCEDURE)
    return tmp_path


def _queue(capsys: pytest.CaptureFixture[str], *words: object) -> Outcome:
    return call(capsys, "queue", *words)


def test_a_night_is_told_to_the_queue(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    added = [files / "procedure.toml", "--rig", files / "rig.toml", "--out", files, "--operator", "Anna"]
    assert _queue(capsys, "list").status == 2
    assert _queue(capsys, "add", *added, "--not-after", "06:00").out == "item 1: small grid: waiting\n"
    assert _queue(capsys, "add", *added, "--json").document["item"] == 2
    assert "2  waiting" in _queue(capsys, "move", 2, "--before", 1).out.splitlines()[2]
    assert "SN1 datum A, says Anna" in _queue(capsys, "attest", "SN1=A", "--operator", "Anna").out
    assert "armed by Anna until" in _queue(capsys, "arm", "--until", "06:00", "--operator", "Anna").out
    assert _queue(capsys, "list", "--json").document["armed"]
    assert "disarmed: Ben disarmed it" in _queue(capsys, "disarm", "--operator", "Ben").out
    assert [entry["item"] for entry in _queue(capsys, "list", "--json").document["items"]] == [2, 1]
    _queue(capsys, "remove", 1)
    assert "small grid, not after" not in _queue(capsys, "list").out


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["arm", "--until", "06:00"], "queue: there is no queue in"),
        (["arm", "--until", "soon", "--rig", "rig.toml"], "--until: got 'soon', needed is a time such as"),
        (["arm", "--until", "06:00", "--rig", "rig.toml"], "queue arm: nothing waits"),
        (["decide", 1, "again", "--reason", "x", "--rig", "rig.toml"], "there is no item 1"),
        (["attest", "--rig", "rig.toml"], "needed is what is mounted"),
        (["remove", 7, "--rig", "rig.toml"], "there is no item 7"),
    ],
)
def test_what_the_queue_refuses_is_a_sentence(
    words: list[object], sentence: str, files: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(files)
    found = _queue(capsys, *words)
    assert (found.status, sentence in found.err) == (2, True)


@pytest.fixture
def armed(files: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """A night that somebody has armed."""
    _queue(capsys, "add", files / "procedure.toml", "--rig", files / "rig.toml", "--out", files / "night")
    _queue(capsys, "attest", "SN1")
    assert "armed by" in _queue(capsys, "arm", "--until", "2099-01-01T00:00").out
    return files


def test_a_jog_says_that_it_disarms_the_queue_and_no_runner_that_comes_after_it_starts_anything(
    armed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    jogged = call(capsys, "jog", "--rig", armed / "rig.toml", "--axis", "pitch", "--to", 10)
    assert jogged.status == 0
    assert "waits for this rig, armed by" in jogged.err
    assert "it is disarmed by this" in jogged.err
    listed = _queue(capsys, "list").out
    assert listed.startswith("disarmed: the rig was used outside the queue, by process")
    assert "mounted: SN1, says" in listed
    words = [sys.executable, "-m", "procedures.cli.main", "queue", "run"]
    with subprocess.Popen(words, cwd=armed, stderr=subprocess.PIPE, text=True) as runner:
        assert runner.stderr is not None
        try:
            assert any("item 1 is not begun: the queue is disarmed" in line for line in runner.stderr)
        finally:
            runner.kill()
    assert not (armed / "night").exists()


class Asks:
    """Says a word to a run after three dwells, as somebody at another terminal."""

    def __init__(self, run: Path, word: str, capsys: pytest.CaptureFixture[str]) -> None:
        self._run, self._word, self._capsys = run, word, capsys
        self.answer = ""

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and progress.dwells_done == 3:
            self.answer = call(self._capsys, self._word, self._run).out


@pytest.mark.parametrize("word", ["stop", "abort"])
def test_a_stop_and_an_abort_say_that_they_disarm_the_queue_of_the_rig(
    armed: Path, capsys: pytest.CaptureFixture[str], word: str
) -> None:
    """Whoever stops a run means to be at the rig: the queue has nothing armed when the answer is there."""
    run = armed / "by hand"
    asks = Asks(run, word, capsys)
    bench(armed).run(run, observer=asks)
    assert f"asked to {word}" in asks.answer
    assert "it is disarmed by this" in asks.answer
    listed = _queue(capsys, "list").out
    assert f"({word})" in listed.splitlines()[0]
    assert "mounted: SN1, says" in listed, "it mounts nothing else"


def test_arming_in_view_of_another_queue_is_refused(armed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    seen = _queue(capsys, "list", "--json").document["sequence"]
    _queue(capsys, "add", armed / "procedure.toml", "--rig", armed / "rig.toml", "--operator", "Ben")
    refused = _queue(capsys, "arm", "--until", "06:00", "--expects", seen)
    assert (refused.status, "arm was asked in view of another queue" in refused.err) == (2, True)
    assert _queue(capsys, "arm", "--until", "06:00", "--expects", seen + 1).status == 0


def test_people_are_added_listed_and_removed(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    added = call(capsys, "console", "people", "add", "Anna Ray", "--role", "move", "--json").document
    assert len(added["secret"].split("-")) == 4
    again = call(capsys, "console", "people", "add", "anna ray")
    assert (again.status, "has an account already" in again.err) == (2, True)
    renewed = call(capsys, "console", "people", "add", "Anna Ray", "--renew", "--json").document
    assert renewed["secret"] != added["secret"]
    (listed,) = call(capsys, "console", "people", "list", "--json").document["people"]
    assert (listed["name"], listed["role"]) == ("Anna Ray", "watch")
    assert call(capsys, "console", "people", "remove", "Anna Ray").status == 0
    assert call(capsys, "console", "people", "list").out == "nobody has an account\n"
