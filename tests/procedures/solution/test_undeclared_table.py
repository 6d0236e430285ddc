"""A run on a table of whose indices nothing is declared says so, and no certificate is issued of its sets."""

from datetime import date
from pathlib import Path

from small_run import bench

from ams.archive.sign_offs import SignOff
from ams.sets.verdict_conditions import NO_TABLE
from procedures.certificate.grounds import Grounds, gaps_of
from procedures.delivery.deliver import sets_of, solve_run
from procedures.report.assemble import assemble_view

LIMITS = ("increment_deg = 1.0", "increment_deg = 1.0\nuncertainty_arcsec = 1.0")


def said_of(folder: Path, *changes: tuple[str, str]) -> tuple[list[str], str, list[str]]:
    """Kinds of what the set of a run says of an axis, its verdict, and what a certificate lacks of the table."""
    folder.mkdir()
    made = bench(folder, changes)
    made.run(folder / "run")
    solved = solve_run(folder / "run")
    (entry,) = sets_of(solved).values()
    grounds = Grounds("1", date(2026, 3, 2), entry, None, SignOff(entry.sha256, (), ()))
    kinds = [finding["kind"] for finding in entry.document["axes"]["x"]["findings"]]  # type: ignore[index, call-overload]
    gaps = [gap for gap in gaps_of(grounds) if gap.startswith(NO_TABLE)]
    return kinds, assemble_view(solved.record, solved.sensors).verdict.sentence, gaps


def test_a_table_of_which_nothing_is_declared_is_told_in_set_verdict_and_certificate(tmp_path: Path) -> None:
    kinds, sentence, gaps = said_of(tmp_path / "nothing")
    assert "table-undeclared" in kinds
    assert "the uncertainty of the table's indices" in sentence
    assert len(gaps) == 1
    assert gaps[0].startswith(f"{NO_TABLE} (pitch, roll): ")
    kinds, sentence, gaps = said_of(tmp_path / "limits", (LIMITS[0], LIMITS[1]))
    assert "table-undeclared" not in kinds
    assert "indices" not in sentence
    assert not gaps
