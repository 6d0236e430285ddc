"""Many dwells of one reason are one row: a run that was taken back by half filled nine pages with one sentence."""

from dataclasses import replace
from datetime import timedelta

from report_scene import Scene, run_view

from procedures.report.sections.rejected import NotBelieved, RejectedDwell, rejected_rows


def _rejected(step: int, reason: str) -> RejectedDwell:
    brought = run_view(Scene(axes=("x",), rejected=1)).of_sections["rejected"]
    assert isinstance(brought, NotBelieved)
    (dwell,) = brought.dwells
    return replace(dwell, utc=dwell.utc + timedelta(minutes=step), step=step, point=step, reasons=(reason,))


def test_what_was_taken_back_together_is_a_row_and_the_others_stand_by_themselves() -> None:
    taken_back = [_rejected(step, "voided by B. Night: bumped") for step in range(40, 50)]
    dwells = [_rejected(7, "scatter 81 µV"), *taken_back[:5], _rejected(45, "scatter 90 µV"), *taken_back[5:]]
    rows = rejected_rows(dwells)
    assert [(row.steps, row.attitude, row.reason) for row in rows] == [
        ("7", "pitch −30°, roll 60°", "scatter 81 µV"),
        ("40 to 49", "10 dwells", "voided by B. Night: bumped"),
        ("45", "pitch −30°, roll 60°", "scatter 90 µV"),
    ]
    assert sum(len(row.dwells) for row in rows) == len(dwells)
    assert [row.dwells[-1].step for row in rows] == [7, 49, 45]


def test_a_few_alike_keep_a_row_each() -> None:
    rows = rejected_rows([_rejected(step, "overload") for step in (3, 5, 9)])
    assert [row.steps for row in rows] == ["3", "5", "9"]
    assert rejected_rows([]) == []
