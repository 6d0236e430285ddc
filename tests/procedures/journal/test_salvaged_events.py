"""What a salvage makes of a damaged event: that one is lost, by name; what it took back stays taken back."""

import re
import shutil
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest
from journals import a_clock, a_dwell, journal_with

from procedures.errors import JournalError
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.lost_events import LOST, LostEvent, losses_in
from procedures.journal.salvage import Salvaged, salvage
from procedures.journal.storage import JOURNAL_FILE
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import key_of, void_detail
from procedures.records.states import State
from procedures.solution.lost_record import lost_record

DWELLS = 12
TAKEN_BACK = (3, 4, 5)


def _changed(journal: Path, statement: str) -> Path:
    connection = sqlite3.connect(journal)
    assert connection.execute(statement).rowcount == 1
    connection.commit()
    connection.close()
    return journal


def _with_dwells_taken_back(folder: Path) -> Path:
    """A finished run of which three dwells were taken back by a person."""
    path = journal_with(folder / JOURNAL_FILE, DWELLS)
    journal = Journal.open_for_append(path)
    dwells = [a_dwell(step) for step in TAKEN_BACK]
    journal.append_event("state", {"to": State.FINISHED, "by": "", "reason": ""}, a_clock())
    journal.append_event(VOIDED, void_detail(map(key_of, dwells), "Anna", "a bump", "redo"), a_clock())
    journal.append_event("state", {"to": State.STOPPED, "by": "Anna", "reason": "redo: a bump"}, a_clock())
    journal.close()
    return path


def _accepted(run: Path) -> set[int]:
    with JournalReader.open(run) as reader:
        reader.verify()
        return {dwell.step for dwell in reader.dwells(accepted_only=True)}


def _state(run: Path) -> State:
    with JournalReader.open(run) as reader:
        return reader.state()


def _saved(journal: Path, folder: Path) -> tuple[Salvaged, Path]:
    return salvage(journal, folder / "saved"), folder / "saved"


@pytest.mark.parametrize("number", range(2, 2 * DWELLS, 5))
def test_fault_07_one_damaged_event_takes_no_dwell_with_it_but_its_own(tmp_path: Path, number: int) -> None:
    """It is marked as lost in its place and named; what stands behind it is taken as it was written."""
    whole = journal_with(tmp_path / JOURNAL_FILE, DWELLS)
    with JournalReader.open(whole) as reader:
        before = {event.sequence: event for event in reader.events()}
    kind = before[number].kind
    _changed(whole, f"UPDATE events SET detail = detail || ' ' WHERE sequence = {number}")
    found, saved = _saved(whole, tmp_path)
    assert found.lost == (LostEvent(number, kind),)
    assert found.dwells == DWELLS - (kind == "dwell")
    assert len(found.quarantined) == (kind == "dwell")
    with JournalReader.open(saved) as reader:
        reader.verify()
        after = list(reader.events())
    assert after[number - 1].kind == LOST
    assert [event for event in after if event.sequence in before and event.sequence != number] == [
        event for event in before.values() if event.sequence != number
    ]
    assert losses_in(after).events == found.lost


def test_fault_07_an_event_whose_own_sum_is_damaged_is_proved_by_the_one_behind_it(tmp_path: Path) -> None:
    whole = journal_with(tmp_path / JOURNAL_FILE, DWELLS)
    _changed(whole, "UPDATE events SET sha256 = replace(sha256, substr(sha256, 1, 1), 'x') WHERE sequence = 8")
    found, saved = _saved(whole, tmp_path)
    assert (found.lost, found.dwells, _accepted(saved)) == ((), DWELLS, set(range(DWELLS)))


def test_fault_07_an_event_that_is_gone_takes_the_next_one_with_it_and_no_more(tmp_path: Path) -> None:
    """Nothing tells what the next one was chained to."""
    whole = journal_with(tmp_path / JOURNAL_FILE, DWELLS)
    _changed(whole, "DELETE FROM events WHERE sequence = 8")
    found, saved = _saved(whole, tmp_path)
    assert [event.sequence for event in found.lost] == [8, 9]
    assert len(_accepted(saved)) == found.dwells == DWELLS - 1


def test_fault_07_a_stretch_of_hundreds_of_rows_that_is_gone_is_not_the_end(tmp_path: Path) -> None:
    """Many rows share a page of the file, and many pages may be lost in a row."""
    count, first, last = 400, 5, 360
    whole = journal_with(tmp_path / JOURNAL_FILE, count)
    connection = sqlite3.connect(whole)
    gone = connection.execute(f"DELETE FROM dwells WHERE number BETWEEN {first} AND {last}").rowcount
    connection.commit()
    connection.close()
    found, saved = _saved(whole, tmp_path)
    assert (gone, found.dwells) == (last - first + 1, count - gone)
    assert count - 1 in _accepted(saved)


def test_fault_07_no_event_is_believed_that_the_chain_does_not_prove(tmp_path: Path) -> None:
    whole = journal_with(tmp_path / JOURNAL_FILE, DWELLS)
    _changed(whole, "UPDATE events SET detail = replace(detail, '\"step\":5', '\"step\":50') WHERE kind = 'dwell' AND "
                    "detail LIKE '%\"step\":5,%'")  # fmt: skip
    found, saved = _saved(whole, tmp_path)
    assert found.quarantined == ("step 5, attempt 1, epoch 1",)
    assert _accepted(saved) == set(range(DWELLS)) - {5}


@pytest.mark.parametrize(
    "damage",
    [
        "detail = replace(detail, 'a bump', 'a bomp')",
        "detail = replace(detail, '}', ')')",
        "detail = CAST(replace(detail, 'bump', x'ff') AS TEXT)",
        "kind = 'vpided'",
        "utc = replace(utc, '2026', '2O26')",
        "sha256 = 'f' || substr(sha256, 2), detail = replace(detail, 'Anna', 'Anma')",
    ],
)
def test_fault_07_what_a_damaged_event_took_back_stays_taken_back(tmp_path: Path, damage: str) -> None:
    """Whichever byte of the line was changed: what it names as taken back is taken back again, by the salvage."""
    whole = _changed(_with_dwells_taken_back(tmp_path), f"UPDATE events SET {damage} WHERE kind = 'voided'")
    found, saved = _saved(whole, tmp_path)
    assert _accepted(saved) == set(range(DWELLS)) - set(TAKEN_BACK)
    assert [name.split(",")[0] for name in found.taken_back] == [f"step {step}" for step in TAKEN_BACK]
    assert found.dwells == DWELLS
    assert _state(saved) is State.STOPPED


def _digits(text: str) -> Iterator[tuple[int, str]]:
    """Yield where each digit stands, and the text with another one there."""
    for index, letter in enumerate(text):
        if letter.isdigit():
            yield index, f"{text[:index]}{(int(letter) + 1) % 10}{text[index + 1 :]}"


@pytest.mark.parametrize("column", ["utc", "detail", "sha256"])
def test_fault_07_no_digit_of_what_took_dwells_back_gives_one_back_unseen(tmp_path: Path, column: str) -> None:
    """A changed digit can name other dwells. Both what it names now stays out, and what it may have named is unknown:
    the line is lost by name and the run is not usable until a person answers, or every dwell is out as before.
    """
    whole = _with_dwells_taken_back(tmp_path)
    connection = sqlite3.connect(whole)
    (stored,) = connection.execute(f"SELECT {column} FROM events WHERE kind = 'voided'").fetchone()
    connection.close()
    before, found_digits = set(range(DWELLS)) - set(TAKEN_BACK), 0
    for index, changed in _digits(stored):
        found_digits += 1
        copy = Path(shutil.copytree(tmp_path, tmp_path.with_name(f"{tmp_path.name}-{column}-{index}")))
        _changed(copy / JOURNAL_FILE, f"UPDATE events SET {column} = '{changed}' WHERE kind = 'voided'")
        found, saved = _saved(copy / JOURNAL_FILE, copy)
        counts = _accepted(saved)
        if column == "sha256":
            assert (found.lost, counts) == ((), before), "the event behind it proves it"
            continue
        assert [event.kind for event in found.lost] == [VOIDED], changed
        named = {int(step) for step in re.findall(r"\[(\d+),1,1\]", changed)} if column == "detail" else set(TAKEN_BACK)
        assert not counts & named, changed
        assert _state(saved) is State.STOPPED
        with JournalReader.open(saved) as reader:
            finding = lost_record(reader.events())
        assert finding is not None
        assert not finding.is_held, "no result is usable until a person answers"
    assert found_digits >= 3 * len(TAKEN_BACK) if column == "detail" else found_digits > 9


def test_fault_07_a_finished_run_whose_stop_is_lost_behind_what_was_taken_back_is_stopped(tmp_path: Path) -> None:
    whole = _with_dwells_taken_back(tmp_path)
    _changed(whole, "UPDATE events SET detail = detail || ' ' WHERE detail LIKE '%redo: a bump%'")
    _, saved = _saved(whole, tmp_path)
    assert _state(saved) is State.STOPPED
    assert _accepted(saved) == set(range(DWELLS)) - set(TAKEN_BACK)


def test_a_mark_of_a_lost_event_that_no_salvage_names_is_damage(tmp_path: Path) -> None:
    whole = journal_with(tmp_path / JOURNAL_FILE, DWELLS)
    _changed(whole, "UPDATE events SET kind = 'lost' WHERE sequence = 8")
    with JournalReader.open(whole) as reader, pytest.raises(JournalError, match=r"event 8 \(lost\) is not as it was"):
        reader.verify()


def test_a_salvaged_journal_is_salvaged_again_with_what_was_lost_before(tmp_path: Path) -> None:
    whole = journal_with(tmp_path / JOURNAL_FILE, DWELLS)
    _changed(whole, "UPDATE events SET detail = detail || ' ' WHERE sequence = 8")
    _, saved = _saved(whole, tmp_path)
    _changed(saved / JOURNAL_FILE, "UPDATE events SET detail = detail || ' ' WHERE sequence = 12")
    found = salvage(saved, tmp_path / "again")
    assert [event.sequence for event in found.lost] == [12]
    with JournalReader.open(tmp_path / "again") as reader:
        reader.verify()
        assert [event.sequence for event in losses_in(reader.events()).events] == [8, 12]


@pytest.mark.parametrize("column", ["accepted = 1 - accepted", "step = 99", "sha256 = 'x'"])
def test_fault_06_a_column_beside_a_dwell_is_put_right_from_its_record(tmp_path: Path, column: str) -> None:
    whole = journal_with(tmp_path / JOURNAL_FILE, DWELLS)
    _changed(whole, f"UPDATE dwells SET {column} WHERE step = 7")
    _, saved = _saved(whole, tmp_path)
    assert _accepted(saved) == set(range(DWELLS))
