"""Laws of line templates: what is written is recognised, what is shortened or damaged is not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire.template import Template

MOVE = Template("{axis} MOVE {target_deg:+09.4f}")


def test_a_template_writes_the_line_of_the_worked_dialect() -> None:
    assert MOVE.render(axis=1, target_deg=10.0) == "1 MOVE +010.0000"  # the design's worked dialect


@given(st.integers(0, 99), st.integers(-3600000, 3600000))
def test_what_is_written_is_recognised(axis: int, tenthousandths: int) -> None:
    assert MOVE.match(MOVE.render(axis=axis, target_deg=tenthousandths / 1e4)) == {
        "axis": axis,
        "target_deg": tenthousandths / 1e4,
    }


@pytest.mark.parametrize(
    "line",
    [
        "1 MOVE +10.0000",
        "1 MOVE +010.000",
        "1 MOVE 010.0000",
        "1 MOVE +010,0000",
        "1 MOVE +010.0000 ",
        "x1 MOVE +010.0000",
    ],
)
def test_a_shortened_or_damaged_number_is_no_number(line: str) -> None:
    assert MOVE.match(line) is None


@given(st.text(max_size=30))
def test_any_text_is_taken_whole_or_not_at_all(line: str) -> None:
    found = MOVE.match(line)
    assert found is None or MOVE.render(**found) == line


@pytest.mark.parametrize("text", ["{angle_deg}", "{nonsense}", "{target_deg:8.4e}"])
def test_a_field_without_meaning_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"field|format"):
        Template(text)
