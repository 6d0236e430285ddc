"""A test without words would end the fit in which it first rings: their list is closed, and each has its words."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from ams.analysis.diagnostics import beliefs
from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import AT_A_LOCATION, DRIFT_OF, TABLE_LIMIT, TESTS
from ams.analysis.diagnostics.words.wording import DIAGNOSED, WORDS

AMS = Path(beliefs.__file__).parents[2]
MADE_BY = {"BeliefTest", "Column", "slope_test"}
"""Who makes a test: the first argument is its name."""
WORDED = (TABLE_LIMIT, AT_A_LOCATION)
BY_ANOTHER_NAME = {
    "analysis/diagnostics/beliefs.py:name": "rows of TERMS, MEMORIES and HELD_ACROSS, in COLUMNS",
    "analysis/diagnostics/over_time/settling.py:name": "slope_test itself",
    "analysis/diagnostics/axis/point_columns.py:column.name": "of a Column",
    "calibration/steps/judged_steps.py:name": "SLIP and STEP, from the lines above it",
    "calibration/together/memory.py:name": "that of a test which was made before",
}


def _named() -> Iterator[tuple[str, str]]:
    """Yield the file and how it names the test, of everything that makes one."""
    for path in sorted(path for room in ("analysis", "calibration") for path in (AMS / room).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in MADE_BY:
                yield path.relative_to(AMS).as_posix(), ast.unparse(node.args[0])


@pytest.mark.parametrize("name", TESTS)
def test_every_test_has_words_or_a_diagnosis_that_tells_it(name: str) -> None:
    """The table's limit is told with the limit itself, and a place with its points, wherever they are tested."""
    assert sum((name in WORDS, name in DIAGNOSED, name in WORDED)) == 1


def test_nothing_else_has_words() -> None:
    assert {*WORDS, *DIAGNOSED, *WORDED} == set(TESTS)
    assert len(set(TESTS)) == len(TESTS)


def test_whoever_makes_a_test_names_it_from_the_closed_list() -> None:
    found = list(_named())
    assert len(found) > 20
    for file, how in found:
        name = vars(beliefs).get(how.split("[")[0])
        names = {*name.values()} if isinstance(name, dict) else {name}
        is_listed = names <= set(TESTS)
        assert is_listed or how.startswith("f'{DRIFT_OF}") or f"{file}:{how}" in BY_ANOTHER_NAME, (file, how)
    assert {f"{file}:{how}" for file, how in found} >= set(BY_ANOTHER_NAME)
    assert not any(name.startswith(DRIFT_OF) for name in TESTS)


def test_a_new_test_is_counted_among_the_most_that_one_axis_makes() -> None:
    """The level is divided by that number, so one that is forgotten there loosens every other.

    Of 41 names and the drifts of four quantities 39 are counted for one axis; 34 is the most that a fit of the tests of
    calibrations makes.
    """
    drifts, never_beside_others = 4, 6
    assert len(TESTS) + drifts - never_beside_others == MOST_TESTS
