"""Laws of the verdict in words: each ground by its own name, all of them, and none where the set is usable."""

from dataclasses import replace
from itertools import product

import pytest
from solved import provenance, solved_package

from ams.findings import Finding
from ams.sets.coefficients import build_set
from ams.sets.stated_verdict import NOT_USABLE, grounds_in_words, verdict_in_words

EXCEEDED = Finding("cubic", "said.", True, 0.001, is_held=False)
HELD = Finding("quadratic", "said.", True, 0.001)
TURNED = Finding("table-rotation", "said.", True, 1e-9, details={"turned_arcsec": 18.0, "confounded_with": None})
SMALL_TURN = Finding("table-rotation", "said.", True, 1e-9, details={"turned_arcsec": 2.0, "confounded_with": None})
LIKE_THE_METER = replace(TURNED, details={"turned_arcsec": 18.0, "confounded_with": "meter-gain"})
NOT_SIGNIFICANT = replace(EXCEEDED, is_significant=False)

TABLE = "the table, its base or the fixture turned or stood off while it was measured"
BEYOND = "the stated uncertainties do not hold what the data show"


def with_findings(**findings: tuple[Finding, ...]):
    plain = solved_package()
    return replace(
        plain, axes={name: replace(axis, findings=findings.get(name, ())) for name, axis in plain.axes.items()}
    )


def document_of(**findings: tuple[Finding, ...]):
    return build_set(with_findings(**findings), provenance()).document


def test_a_turn_of_the_table_is_the_ground_and_not_the_uncertainties_which_hold_it() -> None:
    every = document_of(x=(TURNED,), y=(TURNED,), z=(TURNED,))
    assert verdict_in_words(every) == f"{NOT_USABLE}: {TABLE} (x, y, z: table-rotation)"


def test_every_ground_is_told_and_each_finding_under_one() -> None:
    every = document_of(x=(TURNED, EXCEEDED), z=(replace(TURNED, is_held=False), replace(EXCEEDED, kind="drift")))
    assert grounds_in_words(every) == f"{TABLE} (x, z: table-rotation); {BEYOND} (x: cubic; z: drift)"


def test_an_axis_without_a_result_is_a_ground_beside_the_others() -> None:
    # The document of a fit has the axis; a set has not.
    none = Finding("axis-contradicted", "said.", True)
    findings = {"x": [none.to_document()], "z": [EXCEEDED.to_document()]}
    fit = {"verdict": NOT_USABLE, "axes": {axis: {"findings": found} for axis, found in findings.items()}}
    assert verdict_in_words(fit) == (
        f"{NOT_USABLE}: there is no result to use of an axis (x: axis-contradicted); {BEYOND} (z: cubic)"
    )


@pytest.mark.parametrize(
    "findings", list(product((EXCEEDED, HELD, TURNED, SMALL_TURN, LIKE_THE_METER, NOT_SIGNIFICANT), repeat=2))
)
def test_a_set_has_a_ground_where_and_only_where_its_calibration_is_not_usable(findings: tuple[Finding, ...]) -> None:
    calibration = with_findings(x=findings[:1], y=findings[1:])
    document = build_set(calibration, provenance()).document
    assert document["verdict"] == calibration.verdict
    assert (grounds_in_words(document) != "") is (calibration.verdict == NOT_USABLE)


@pytest.mark.parametrize(("found", "shown"), [((HELD,), "x: quadratic"), ((), ""), ((NOT_SIGNIFICANT,), "")])
def test_what_the_data_show_of_a_usable_set_stands_in_its_verdict(found: tuple[Finding, ...], shown: str) -> None:
    """A dwell that was off by 110 000 standard deviations left the words of a verdict as they were without it."""
    words = verdict_in_words(document_of(x=found))
    assert ("the data show" in str(words)) == bool(shown)
    assert shown in str(words)
