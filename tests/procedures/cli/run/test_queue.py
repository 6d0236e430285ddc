"""``calrig queue`` and ``calrig console people``: what is said at the terminal, and refused there."""

from pathlib import Path

import pytest
from command import Outcome, call
from small_run import PROCEDURE, RIG

from procedures.queue import adding


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
