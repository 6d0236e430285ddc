"""A journal of every past version is still solved, to the same numbers.

``run_v1`` holds the journal of a small run on twins as the first version wrote it, and the set that it solved from it.
"""

import json
import shutil
from pathlib import Path

from procedures.delivery import sets_of, solve_run
from procedures.resolving import number_changes

RUN_V1 = Path(__file__).parents[1] / "data" / "run_v1"


def test_the_first_versions_journal_gives_the_same_coefficients(tmp_path: Path) -> None:
    """Coefficients to 1e-12 of the scale. Uncertainties may follow better models; they are positive and no wilder."""
    run = Path(shutil.copytree(RUN_V1, tmp_path / "run"))
    then = json.loads((RUN_V1 / "SN1.json").read_text(encoding="utf-8"))
    now = sets_of(solve_run(run))["SN1"].document
    changed = list(number_changes("SN1", then, now))
    assert [change for change in changed if not change.name.startswith("u(")] == []
    for change in changed:
        assert change.old is not None
        assert change.new is not None
        assert 0.3 < change.new / change.old < 3.0, change


def test_the_first_versions_journal_is_read_as_it_is(tmp_path: Path) -> None:
    run = Path(shutil.copytree(RUN_V1, tmp_path / "run"))
    before = (run / "journal.sqlite").read_bytes()
    first, again = (sets_of(solve_run(run))["SN1"].sha256 for _ in range(2))
    assert first == again
    assert (run / "journal.sqlite").read_bytes() == before
