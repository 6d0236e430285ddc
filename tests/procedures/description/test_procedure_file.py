"""Laws of the procedure file."""

import re
from decimal import Decimal
from pathlib import Path

import pytest
from example_files import EXAMPLE_PROCEDURE, changed
from hypothesis import given
from hypothesis import strategies as st

from procedures.description.procedure_file import Range
from procedures.kinds.read import read_procedure
from rig.errors import DescriptionError

MISTAKES = [
    ("step does not divide", "step = 10.0", "step = 7.0", "design.pitch_deg: got"),
    ("misspelt end", "{ from = -90.0", "{ form = -90.0", "design.pitch_deg.form: unknown key; did you mean from?"),
    ("missing unit", "pitch_deg = {", "pitch = {", "design.pitch: unknown key: the unit is missing; write pitch_deg"),
    (
        "missing unit in settle",
        "window_s = 1.5",
        "window = 1.5",
        "dwell.settle.window: unknown key: the unit is missing; write window_s",
    ),
    ("no replication", "replications = 6", "replications = 0", "procedure.replications: got 0"),
    ("one sample has no scatter", "samples = 20", "samples = 1", "dwell.samples: got 1"),
    ("kind not there", 'kind = "grid"', 'kind = "gird"', "procedure.kind: got 'gird'"),
    (
        "tumble needs T",
        'kind = "grid"',
        'kind = "tumble"',
        'design.kind: kind = "tumble" goes with a design of kind "T"',
    ),
    ("format not there", '"mat"', '"matlab"', "export.formats.2: got 'matlab'"),
    ("settle shorter than its windows", "max_s = 60.0", "max_s = 2.5", "is shorter than min_s or than 2 windows"),
    ("apply what", 'temperature = "none"', 'temperature = "apply"', "needs known_temperature"),
    ("fractional on a full design", 'kind = "D1"', 'kind = "D1"\nfractional = [3, 4]', "fractional belongs to kind"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), [m[1:] for m in MISTAKES], ids=[m[0] for m in MISTAKES])
def test_a_mistake_is_named_by_file_line_and_key(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    path = changed(EXAMPLE_PROCEDURE, old, new, tmp_path / "procedure.toml")
    with pytest.raises(DescriptionError, match=re.escape(sentence)) as caught:
        read_procedure(path)
    assert all(re.match(rf"{re.escape(str(path))}:\d+: ", line) for line in str(caught.value).splitlines())


def test_a_grid_without_its_design_is_told_what_is_missing(tmp_path: Path) -> None:
    text = EXAMPLE_PROCEDURE.read_text(encoding="utf-8")
    path = tmp_path / "procedure.toml"
    path.write_text(re.sub(r"^\[design\]\n(?:[^\[].*\n|\n)*", "", text, flags=re.MULTILINE), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"design: is missing; this is a procedure of kind 'grid'") as caught:
        read_procedure(path)
    assert "tumble" not in str(caught.value)


def test_the_example_has_nineteen_pitch_and_thirteen_roll_angles() -> None:
    design = read_procedure(EXAMPLE_PROCEDURE).design
    assert design.pitch_deg.values() == tuple(float(angle) for angle in range(-90, 91, 10))
    assert design.roll_deg.values() == tuple(float(angle) for angle in range(-180, 181, 30))


@given(tenths=st.integers(1, 50), steps=st.integers(0, 60), start=st.integers(-900, 900))
def test_ranges_are_exact_in_decimals(tenths: int, steps: int, start: int) -> None:
    step, first = Decimal(tenths) / 10, Decimal(start) / 10
    last = first + step * steps
    if abs(last) > 360:
        return
    values = Range.model_validate({"from": float(first), "to": float(last), "step": float(step)}).values()
    assert values == tuple(float(first + step * index) for index in range(steps + 1))


def test_a_plan_error_names_the_line_of_its_key() -> None:
    line = EXAMPLE_PROCEDURE.read_text().splitlines().index('order = "there-and-back"') + 1
    assert str(read_procedure(EXAMPLE_PROCEDURE).error(("design", "order"), "no")).endswith(
        f"procedure.toml:{line}: design.order: no"
    )
