"""Every kind of finding has its row: whose doing it is, what it means and what to do; none is left to a default."""

from typing import get_args

import pytest

from ams.archive.run_at_fault import KINDS_OF_THE_RUN
from ams.finding_kinds import FINDING_KINDS, KINDS, OF_THE_METER, OF_THE_TABLE, UNUSABLE_AXIS, Whose, kinds_of


def test_every_kind_has_a_row_and_every_row_a_kind() -> None:
    assert list(KINDS) == list(FINDING_KINDS)


@pytest.mark.parametrize("kind", FINDING_KINDS)
def test_a_row_says_in_a_sentence_what_it_means_and_what_to_do(kind: str) -> None:
    row = {**KINDS}[kind]
    assert row.whose in get_args(Whose)
    for words in (row.meaning, row.what_to_do, *([row.together] if row.together else [])):
        assert words == words.strip()
        assert words[-1] not in ".;:"
        assert "|" not in words
        assert "\n" not in words
    assert row.meaning[0].isupper()
    assert row.what_to_do[0].isupper()


def test_every_kind_is_somebodys() -> None:
    parts = [kinds_of(whose) for whose in get_args(Whose)]
    assert sum(len(part) for part in parts) == len(FINDING_KINDS)
    assert kinds_of(*get_args(Whose)) == set(FINDING_KINDS)


def test_what_all_sensors_show_together_is_the_table_s_or_the_meter_s() -> None:
    assert {kind for kind, row in KINDS.items() if row.together} == OF_THE_TABLE | OF_THE_METER


def test_an_axis_without_a_result_says_nothing_of_how_its_sensor_was_found() -> None:
    assert UNUSABLE_AXIS <= KINDS_OF_THE_RUN
