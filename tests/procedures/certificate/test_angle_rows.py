"""Laws of the errors as left that a certificate prints: every attitude once, and the one that its sentence names."""

import numpy as np
import pytest

from ams.surveillance.adjustment import RULES, judge
from ams.surveillance.attitude_errors import AngleErrors
from procedures.certificate.results import AngleRow, angle_rows, is_visited_again
from procedures.report.filters import FILTERS

ATTITUDES = [(pitch, roll) for pitch in (-30.0, 0.0, 30.0) for roll in (-90.0, 0.0, 90.0)]


def errors(error_deg: list[float], attitudes: list[tuple[float, float]] = ATTITUDES) -> dict[str, AngleErrors]:
    pitch, roll = np.array(attitudes).T
    count = len(attitudes)
    found = AngleErrors("pitch", pitch, roll, np.array(error_deg), np.full(count, 1e-3), np.full(count, 2.0), 0)
    return {"pitch": found}


def attitudes_of(rows: list[AngleRow]) -> list[tuple[str, str]]:
    return [(row.pitch, row.roll) for row in rows]


def test_the_attitude_that_the_sentence_names_has_a_row_where_it_lies_on_neither_line() -> None:
    found = errors([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.004])
    rows = list(angle_rows(found, [judge(found["pitch"], 0.1, "guard-band")], None))
    assert len(rows) == 6
    assert (rows[-1].pitch, rows[-1].roll, rows[-1].error) == ("30°", "90°", "−0.0040")


@pytest.mark.parametrize("rule", ["guard-band", "simple"])
@pytest.mark.parametrize("limit_deg", [0.001, 0.0035, 0.1])
def test_by_every_rule_and_outcome_the_row_of_the_sentence_is_there(rule: str, limit_deg: float) -> None:
    found = errors(list(np.random.default_rng(4).normal(0.0, 0.003, len(ATTITUDES))))
    judgement = judge(found["pitch"], limit_deg, rule)  # type: ignore[arg-type]
    rows = list(angle_rows(found, [judgement], None))
    named = [row for row in rows if (row.pitch, row.roll) == _printed(judgement.pitch_deg, judgement.roll_deg)]
    assert [float(row.error.replace("−", "-")) for row in named] == [pytest.approx(judgement.error_deg, abs=6e-5)]


def _printed(pitch_deg: float, roll_deg: float) -> tuple[str, str]:
    return tuple(f"{angle:g}°".replace("-", "−") for angle in (pitch_deg, roll_deg))  # type: ignore[return-value]


def test_an_attitude_that_was_visited_twice_has_one_row_with_the_visit_that_is_farthest_out() -> None:
    first = [0.001 * (place % 3) for place in range(len(ATTITUDES))]
    second = [-0.0015 * (place % 2) for place in range(len(ATTITUDES))]
    found = errors([*first, *second], [*ATTITUDES, *ATTITUDES])
    rows = list(angle_rows(found, [], None))
    assert len(set(attitudes_of(rows))) == len(rows)
    assert is_visited_again(found)
    assert not is_visited_again(errors(first))
    for row in rows:
        visits = [place for place, attitude in enumerate(ATTITUDES) if _printed(*attitude) == (row.pitch, row.roll)]
        (place,) = visits
        farthest = max(first[place], second[place], key=abs)
        assert float(row.error.replace("−", "-")) == pytest.approx(farthest, abs=6e-5)


def uneven() -> AngleErrors:
    """Errors of which the largest is where U is small, and |error| + U is largest somewhere else; both off level."""
    error_deg, u_deg = np.zeros(len(ATTITUDES)), np.full(len(ATTITUDES), 1e-4)
    error_deg[-1], error_deg[0], u_deg[0] = -0.00048, -0.0001, 5e-4
    pitch, roll = np.array(ATTITUDES).T
    return AngleErrors("pitch", pitch, roll, error_deg, u_deg, np.full(len(ATTITUDES), 1.97), 0)


def test_the_largest_error_has_a_row_and_u_stands_with_its_k() -> None:
    rows = {(row.pitch, row.roll): row for row in angle_rows({"pitch": uneven()}, [], None)}
    assert {("30°", "90°"), ("−30°", "−90°")} <= set(rows)
    assert (rows["30°", "90°"].error, rows["30°", "90°"].factor) == ("−0.00048", "1.97")
    capable = {(row.pitch, row.roll): row for row in angle_rows({"pitch": uneven()}, [], 0.0005)}
    assert [(capable[at].factor, capable[at].is_capability) for at in (("30°", "90°"), ("−30°", "−90°"))] == [
        ("2.00", True),
        ("1.97", False),
    ]


def test_the_report_and_the_archive_name_the_largest_error_where_it_is() -> None:
    assert FILTERS["largest_error"](uneven()) == "−0.00048°"
    assert FILTERS["largest_at"](uneven()) == "pitch 30°, roll 90°"
    assert FILTERS["largest_expanded"](uneven()) == "0.00020°"


def test_a_judgement_has_minus_signs_and_the_rule_names_the_risk() -> None:
    sentence = judge(uneven(), 0.1, "guard-band").sentence
    assert "error −0.0001° with U 0.0010° at pitch −30°, roll −90° is inside" in sentence
    assert "-" not in sentence
    assert "|error| − U" in RULES["guard-band"]
    assert "2.5 %" in RULES["guard-band"]
    assert "50 %" in RULES["simple"]
