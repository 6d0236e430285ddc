"""Laws of leases, on both kinds of database: one holder at a time, told who; what nobody renews lapses by itself."""

from datetime import UTC, datetime, timedelta

import pytest
from archive_kinds import Archive
from postgres_server import Server

from ams.archive.leases import CLOCKS_APART_S, Holder, claim, held, release
from ams.archive.sets import list_sets
from ams.archive.signatures import verify_archive
from ams.errors import ArchiveError

NOW = datetime(2026, 3, 1, 12, tzinfo=UTC)
TABLE, METER = "tcp 192.0.2.7 1234", "tcp 192.0.2.8 1234"
ANNA = Holder("a" * 32, "lab1", "anna", "run night", "boot 1 2")
BERT = Holder("b" * 32, "lab2", "bert", "jog", "boot 3 4")
LONG_S, OVER_S = 120.0, 0.0


def test_one_has_it_and_the_other_is_told_who_since_when_and_for_how_long(archive: Archive) -> None:
    assert claim(archive.url, [TABLE], ANNA, LONG_S, NOW).begun == (TABLE,)
    found = claim(archive.url, [METER, TABLE], BERT, LONG_S, NOW, all_or_none=True)
    assert found.begun == ()
    (lease,) = found.others
    assert (lease.resource, lease.holder) == (TABLE, ANNA)
    assert (str(lease), lease.since_utc.tzinfo is None) == ("lab1, user anna (run night)", False)
    apart_s = CLOCKS_APART_S if archive.is_sqlite else 0.0
    assert LONG_S + apart_s - 5.0 < lease.lapses_in_s <= LONG_S + apart_s
    assert [entry.holder for entry in held(archive.url, [METER, TABLE], NOW)] == [ANNA]
    assert claim(archive.url, [METER, TABLE], BERT, LONG_S, NOW).begun == (METER,), "what is free may be had alone"


def test_a_holder_renews_what_is_its_own_and_gives_it_back(archive: Archive) -> None:
    claim(archive.url, [TABLE], ANNA, LONG_S, NOW)
    again = claim(archive.url, [TABLE], ANNA, LONG_S, NOW + timedelta(seconds=60))
    assert (again.begun, again.others) == ((), ())
    release(archive.url, BERT.token)
    assert [lease.holder for lease in held(archive.url, [TABLE], NOW)] == [ANNA], "nobody gives back another's"
    release(archive.url, ANNA.token)
    assert claim(archive.url, [TABLE], BERT, LONG_S, NOW).begun == (TABLE,)


def test_what_nobody_renews_lapses_and_its_holder_sees_that_it_was_anothers(archive: Archive) -> None:
    claim(archive.url, [TABLE], ANNA, OVER_S, NOW)
    early, late = NOW + timedelta(seconds=CLOCKS_APART_S - 1), NOW + timedelta(seconds=CLOCKS_APART_S)
    if archive.is_sqlite:  # clocks that are a minute apart take no lease from anybody
        assert claim(archive.url, [TABLE], BERT, LONG_S, early).others[0].holder == ANNA
    assert claim(archive.url, [TABLE], BERT, LONG_S, late).begun == (TABLE,)
    assert claim(archive.url, [TABLE], ANNA, LONG_S, late).others[0].holder == BERT
    release(archive.url, BERT.token)
    assert claim(archive.url, [TABLE], ANNA, LONG_S, late).begun == (TABLE,)


def test_a_server_judges_by_its_own_clock(postgres: Server) -> None:
    url = postgres.new_database()
    claim(url, [TABLE], ANNA, LONG_S, NOW - timedelta(days=900))
    assert claim(url, [TABLE], BERT, LONG_S, NOW + timedelta(days=900)).others[0].holder == ANNA


def test_who_comes_from_where_the_dead_was_need_not_wait(archive: Archive) -> None:
    claim(archive.url, [TABLE], ANNA, LONG_S, NOW)
    after_it = Holder("c" * 32, "lab1", "anna", "resume", ANNA.place)
    assert claim(archive.url, [TABLE], after_it, LONG_S, NOW).begun == (TABLE,)
    nowhere = Holder("d" * 32, "lab1", "anna", "run", "")
    assert claim(archive.url, [METER], nowhere, LONG_S, NOW).begun == (METER,)
    assert claim(archive.url, [METER], Holder("e" * 32, "lab9", "eve", "run", ""), LONG_S, NOW).others


def test_leases_are_no_part_of_the_record(archive: Archive) -> None:
    claim(archive.url, [TABLE], ANNA, LONG_S, NOW)
    report = verify_archive(archive.url)
    assert (report.faults, report.head.sequence) == ((), 0)
    assert list_sets(archive.url) == ()


def test_a_database_that_refuses_is_a_sentence(archive: Archive) -> None:
    claim(archive.url, [TABLE], ANNA, LONG_S, NOW)
    archive.execute("DROP TABLE leases")
    with pytest.raises(ArchiveError, match="nothing was changed"):
        claim(archive.url, [TABLE], ANNA, LONG_S, NOW)
