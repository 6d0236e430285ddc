"""Two that publish to an archive which neither has seen: one makes it, and the other waits until all of it is there."""

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest
from solved import provenance, solved_package

from ams.archive.connection import is_emptied, migrate, writing
from ams.archive.sets import Publication, list_sets, publish
from ams.archive.signatures import verify_archive
from ams.errors import ArchiveError
from ams.sets.coefficients import CoefficientSet, build_set
from rig.threads import begun

PUBLISHED = datetime(2026, 3, 2, 8, 0, tzinfo=UTC)
LIMIT_S = 60.0
LOCKED = r"archive\.sqlite: the archive is locked by another program for over 0\.05 s; nothing was changed; try again"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "archive.sqlite"


def _set_of(sensor: str) -> CoefficientSet:
    created = datetime(2026, 3, 1, 6, 20, tzinfo=UTC)
    return build_set(solved_package("xyz"), provenance(sensor=sensor, created_utc=created))


def _list(url: str, busy_timeout_s: float) -> list[object]:
    return [*list_sets(url, busy_timeout_s=busy_timeout_s)]


@pytest.mark.parametrize("look", [_list, migrate, verify_archive, is_emptied])
def test_an_archive_that_is_being_made_is_not_taken_for_one_that_was_cut(
    path: Path, look: Callable[[str, float], object]
) -> None:
    """Its file has 0 bytes until all of it is committed."""
    url = f"sqlite:///{path}"
    with writing(url, LIMIT_S):
        assert path.stat().st_size == 0
        with pytest.raises(ArchiveError, match=LOCKED):
            look(url, 0.05)
    look(url, 0.05)


def test_who_looks_while_another_makes_the_archive_sees_what_that_one_published(path: Path) -> None:
    url, seen = f"sqlite:///{path}", list[object]()
    with writing(url, LIMIT_S):
        looking = begun(lambda: seen.extend(_list(url, LIMIT_S)), "a look at an archive that is being made")
    assert looking.join(LIMIT_S)
    assert looking.is_done
    assert seen == []


def test_both_that_begin_at_once_publish(path: Path) -> None:
    url, published = f"sqlite:///{path}", list[Publication]()

    def look_and_publish(sensor: str) -> None:
        if path.exists():
            _list(url, LIMIT_S)
        published.extend(publish(url, [_set_of(sensor)], PUBLISHED, busy_timeout_s=LIMIT_S))

    publishers = [begun(lambda name=name: look_and_publish(name), "a publisher") for name in ("SN1", "SN2")]  # type: ignore[misc]
    for publisher in publishers:
        assert publisher.join(LIMIT_S)
    assert sorted(new.sensor for new in published) == ["SN1", "SN2"]
