"""Who asks for something says what he saw: what crosses a change of state is refused and told, a stop never is."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest
from journals import a_clock

from procedures.journal.requests.spool import Request, Spool, Taken
from procedures.run.steering import Steering
from rig.clock import SystemClock
from rig.errors import WaitEnded

WHOLE = Request("pause", "anna", "2026-03-01T12:00:00+00:00", "tea", 41, "console", "bench-pc", "a-key")


def _steered(folder: Path, state_sequence: int = 41) -> tuple[Steering, Spool, list[Taken]]:
    messages: list[Taken] = []
    spool = Spool(folder)
    clock = a_clock()
    return Steering(spool, clock, clock, messages.append, state_sequence=lambda: state_sequence), spool, messages


def test_everything_that_a_request_says_comes_out_and_is_kept(tmp_path: Path) -> None:
    steering, spool, found = _steered(tmp_path)
    spool.submit(WHOLE)
    steering.look()
    assert found[0].request == steering.pause == WHOLE
    assert found[0].detail() == {
        "file": found[0].file, "kind": "pause", "by": "anna", "at_utc": WHOLE.at_utc, "text": "tea", "expects": 41,
        "via": "console", "place": "bench-pc", "key": "a-key",
    }  # fmt: skip


@pytest.mark.parametrize("kind", ["pause", "continue", "ack"])
@pytest.mark.parametrize(("expects", "words"), [(40, "look again, then ask again"), (None, "in view of which state")])
def test_what_was_asked_in_view_of_another_state_is_refused_and_told(
    tmp_path: Path, kind: str, expects: int | None, words: str
) -> None:
    steering, spool, found = _steered(tmp_path)
    spool.submit(replace(WHOLE, kind=kind, expects=expects))  # type: ignore[arg-type]
    steering.look()
    assert (steering.pause, steering.continued) == (None, None)
    assert words in str(found[0].detail()["refused"])


def test_stop_and_note_are_taken_as_they_come(tmp_path: Path) -> None:
    steering, spool, found = _steered(tmp_path)
    for kind in ("stop", "note"):
        spool.submit(Request(kind, "anna", WHOLE.at_utc, key=kind, expects=3))  # type: ignore[arg-type]
    steering.look()
    assert steering.stop is not None
    assert [taken.complaint for taken in found] == ["", ""]


def test_an_abort_is_taken_as_it_comes(tmp_path: Path) -> None:
    steering, spool, _ = _steered(tmp_path)
    spool.submit(Request("abort", "anna", WHOLE.at_utc))
    with pytest.raises(WaitEnded, match="abort, asked for by anna"):
        steering.look()


def test_a_request_that_comes_twice_is_taken_once(tmp_path: Path) -> None:
    steering, spool, found = _steered(tmp_path)
    spool.submit(WHOLE)
    steering.look()
    steering.pause = None
    spool.submit(WHOLE)
    steering.look()
    assert steering.pause is None
    assert found[1].complaint == "pause with the key a-key was taken already"


def test_an_abort_by_the_key_of_another_request_is_taken(tmp_path: Path) -> None:
    steering, spool, _ = _steered(tmp_path)
    spool.submit(WHOLE)
    steering.look()
    spool.submit(Request("abort", "anna", WHOLE.at_utc, key=WHOLE.key))
    with pytest.raises(WaitEnded, match="abort, asked for by anna"):
        steering.look()


def test_a_request_that_comes_within_one_tick_of_the_file_system_s_clock_is_taken(tmp_path: Path) -> None:
    """Some file systems write times of change in whole seconds, or two: the folder looks as it did before."""
    spool = Spool(tmp_path, SystemClock())
    spool.folder.mkdir()
    assert spool.take() == []
    looked = os.stat(spool.folder)
    spool.submit(WHOLE)
    os.utime(spool.folder, ns=(looked.st_atime_ns, looked.st_mtime_ns))
    assert [taken.request for taken in spool.take()] == [WHOLE]


@pytest.mark.parametrize("expects", [True, "41", 4.1, [41]])
def test_an_expectation_that_is_no_number_of_an_event_is_no_request(tmp_path: Path, expects: object) -> None:
    steering, spool, found = _steered(tmp_path)
    spool.folder.mkdir()
    (spool.folder / "x.json").write_text(json.dumps({**WHOLE.to_document(), "expects": expects}))
    steering.look()
    assert found[0].complaint.startswith("not a request: expects: got")
