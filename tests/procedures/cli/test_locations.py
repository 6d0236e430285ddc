"""Laws of where a run is found."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from procedures.cli.locations import (
    archive_to_show,
    archive_url,
    find_run,
    left_out_where_empty,
    new_run_folder,
)
from procedures.cli.steer.archive_url import require_archive_url
from procedures.errors import RequestError


def make_run(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / "journal.sqlite").write_bytes(b"")
    return folder


def test_a_run_is_meant_by_folder_journal_name_or_only_child(tmp_path: Path) -> None:
    run = make_run(tmp_path / "runs" / "20260101T000000Z-grid")
    for meaning in (str(run), str(run / "journal.sqlite"), run.name, str(tmp_path / "runs")):
        assert find_run(meaning, tmp_path / "runs") == run


def test_two_runs_in_a_folder_are_ambiguous(tmp_path: Path) -> None:
    make_run(tmp_path / "a")
    make_run(tmp_path / "b")
    with pytest.raises(RequestError, match="holds 2 runs"):
        find_run(str(tmp_path), tmp_path / "runs")


def test_no_run_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match="no run is there"):
        find_run(str(tmp_path / "nowhere"), tmp_path / "runs")


def test_two_runs_of_one_second_get_two_folders(tmp_path: Path) -> None:
    now = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
    first = new_run_folder(tmp_path, "three-axis, ±90°", now)
    second = new_run_folder(tmp_path, "three-axis, ±90°", now)
    assert first.name == "20260102T030405Z-three-axis-90"
    assert second.name == "20260102T030405Z-three-axis-90-2"


def test_the_users_own_archive_can_be_made_on_the_first_day(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing else makes its folder: the first run of a new user must not fail to publish."""
    monkeypatch.delenv("CALRIG_ARCHIVE", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    url = archive_url()
    assert url == f"sqlite:///{tmp_path / 'state' / 'calrig' / 'archive.sqlite'}"
    assert Path(url.removeprefix("sqlite:///")).parent.is_dir()
    monkeypatch.setenv("CALRIG_ARCHIVE", "sqlite:////elsewhere.sqlite")
    assert archive_url() == "sqlite:////elsewhere.sqlite"


def test_the_pages_show_the_archive_beside_simulated_runs_until_there_is_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CALRIG_ARCHIVE", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    own, beside = tmp_path / "state" / "calrig" / "archive.sqlite", tmp_path / "archive.sqlite"
    assert archive_to_show(tmp_path) == f"sqlite:///{own}", "none is there: the user's own is the next"
    beside.touch()
    assert archive_to_show(tmp_path) == f"sqlite:///{beside}"
    assert archive_to_show(tmp_path, "sqlite:////named.sqlite") == "sqlite:////named.sqlite"
    own.touch()
    assert archive_to_show(tmp_path) == f"sqlite:///{own}", "a laboratory's own goes before that of rehearsals"
    own.unlink()
    monkeypatch.setenv("CALRIG_ARCHIVE", "sqlite:////elsewhere.sqlite")
    assert archive_to_show(tmp_path) == "sqlite:////elsewhere.sqlite"


@pytest.mark.parametrize("out", ["file", "file/below"])
def test_a_place_that_cannot_hold_runs_is_a_wrong_request(out: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RequestError, match="cannot hold runs: Not a directory"):
        new_run_folder(tmp_path / out, "grid", datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC))


@pytest.mark.parametrize("url", ["bogus://x", "archive.sqlite", "mysql+nodriver://u:secret@host/x", ""])
def test_a_url_that_no_archive_can_have_is_refused_and_no_password_shown(url: str) -> None:
    with pytest.raises(RequestError, match="no archive can have this URL") as refused:
        require_archive_url(url)
    assert "secret" not in str(refused.value)


def test_an_archive_in_a_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match="its folder is not there"):
        require_archive_url(f"sqlite:///{tmp_path / 'nowhere' / 'archive.sqlite'}")


def test_an_archive_that_is_still_to_be_made_or_does_not_answer_now_is_no_reason_not_to_begin(tmp_path: Path) -> None:
    require_archive_url(f"sqlite:///{tmp_path / 'archive.sqlite'}")
    require_archive_url("sqlite:///archive.sqlite")
    require_archive_url("postgresql+psycopg://u:secret@127.0.0.1:1/x")


@pytest.mark.parametrize("holds_something", [False, True])
def test_a_run_that_is_refused_before_its_journal_leaves_no_empty_folder(tmp_path: Path, holds_something: bool) -> None:
    folder = new_run_folder(tmp_path, "grid", datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC))
    if holds_something:
        (folder / "journal.sqlite").write_bytes(b"")
    with pytest.raises(RequestError, match="no room"), left_out_where_empty(folder):
        raise RequestError("no room")
    assert folder.exists() == holds_something
