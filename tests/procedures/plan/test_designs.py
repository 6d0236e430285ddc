"""The designs of TP 4.1 and TP 7 against the report's own counts and matrices."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from procedures.errors import PlanError
from procedures.plan import designs
from procedures.plan.optimal import terms


def attitudes(design: designs.Design) -> list[tuple[float, float]]:
    return [(point.pitch_deg, point.roll_deg) for point in design.points]


@pytest.mark.parametrize(
    ("pitch_points", "roll_points", "every", "count"),
    [
        (19, 13, (3, 4), 139),  # TP figure 21(b)
        (5, 13, (2, 2), 53),  # TP 9.2.2
        (13, 7, (2, 2), 73),  # TP 9.3.4
    ],
)
def test_a_fractional_design_has_the_printed_number_of_points(pitch_points, roll_points, every, count):
    design = designs.fractional(range(pitch_points), range(roll_points), every)
    assert len(design.points) == count


@given(rows=st.integers(1, 12), columns=st.integers(1, 12), k_alpha=st.integers(1, 6), k_roll=st.integers(1, 6))
def test_a_fractional_count_is_tp_109_wherever_the_grid_divides(rows, columns, k_alpha, k_roll):
    n, m = rows * k_alpha + 1, columns * k_roll + 1
    kept = len(designs.fractional(range(n), range(m), (k_alpha, k_roll)).points)
    assert kept == pytest.approx(n * ((m - 1) / k_roll + 1) + (m - 1) * (1 - 1 / k_roll) * ((n - 1) / k_alpha + 1))


@given(n=st.integers(2, 20), m=st.integers(2, 20), data=st.data())
def test_a_fractional_design_keeps_every_border_point(n, m, data):
    every = (data.draw(st.integers(1, n - 1)), data.draw(st.integers(1, m - 1)))
    kept = set(attitudes(designs.fractional(range(n), range(m), every)))
    border = {(i, j) for i in range(n) for j in range(m) if i in (0, n - 1) or j in (0, m - 1)}
    assert border <= kept


def test_a_fractional_factor_that_leaves_no_interior_is_refused():
    with pytest.raises(PlanError, match=r"K_alpha got 19, allowed 1 to 18 for 19 values"):
        designs.fractional(range(19), range(13), (19, 4))


def test_the_tumbles_are_tp_56_and_57():
    assert attitudes(designs.tumble(with_roll=True)) == [(-90, 0), (0, 0), (90, 0), (180, 0), (0, -90), (0, 90)]
    assert attitudes(designs.tumble(with_roll=False)) == [(-90, 0), (0, 0), (90, 0), (180, 0)]


def test_uniform_roll_ends_one_step_before_the_circle_closes():
    assert designs.uniform_circle_deg(4) == (-180.0, -90.0, 0.0, 90.0)
    assert designs.uniform_circle_deg(4, repeat=True) == (-180.0, -90.0, 0.0, 90.0, 180.0)


def test_the_bench_form_of_tp_9_3_1_has_247_points():
    pitch = tuple(float(angle) for angle in range(-90, 91, 10))
    design = designs.uniform_symmetric(pitch, designs.uniform_circle_deg(12, repeat=True))
    assert (len(design.points), len(design.pitch_values_deg), len(design.roll_values_deg)) == (247, 19, 13)


def test_labels_count_from_one_without_gaps():
    design = designs.fractional(range(5), range(13), (2, 2))
    assert [point.label for point in design.points] == list(range(1, 54))


def test_d1_refuses_a_pitch_set_that_is_not_uniform_and_symmetric():
    circle = designs.uniform_circle_deg(8)
    with pytest.raises(PlanError, match="uniform and symmetric"):
        designs.uniform_symmetric((-30.0, 0.0, 20.0), circle)
    with pytest.raises(PlanError, match="uniform and symmetric"):
        designs.uniform_symmetric((-30.0, -30.0, 0.0, 30.0, 30.0), circle)


def test_d0_refuses_a_part_of_the_circle():
    with pytest.raises(PlanError, match=r"5 values from -90° to 90°.*use kind D"):
        designs.uniform_roll((0.0, 10.0), (-90.0, -45.0, 0.0, 45.0, 90.0))


def test_a_pitch_value_may_repeat_outside_d1():
    """TP table 1: sixteen points at each of ±30°, one at 0°."""
    pitch = (-30.0,) * 16 + (0.0,) + (30.0,) * 16
    assert len(designs.uniform_roll(pitch, designs.uniform_circle_deg(64)).points) == 33 * 64


def test_a_file_of_points_is_read_as_it_stands(tmp_path: Path):
    path = tmp_path / "points.csv"
    path.write_text("pitch_deg,roll_deg\n0,0\n10.5,-90\n", encoding="utf-8")
    assert attitudes(designs.read_points(path)) == [(0.0, 0.0), (10.5, -90.0)]
    path.write_text("pitch_deg\n-5\n5\n", encoding="utf-8")
    assert not designs.read_points(path).has_roll


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("pitch,roll\n0,0\n", r"points.csv:1: columns: got pitch, roll, needed pitch_deg"),
        ("pitch_deg,roll_deg\n0,0\n10,x\n", r"points.csv:3: roll_deg: got 'x', allowed −360 to 360 degrees"),
        ("pitch_deg,roll_deg\nnan,0\n", r"points.csv:2: pitch_deg: got 'nan'"),
        ("pitch_deg,roll_deg\n10\n", r"points.csv:2: roll_deg: got None"),
        ("pitch_deg,roll_deg\n1,2,3\n", r"points.csv:2: more"),
        ("pitch_deg,roll_deg\n", r"holds no points"),
    ],
)
def test_a_wrong_file_of_points_is_refused_with_its_line(tmp_path: Path, text, sentence):
    path = tmp_path / "points.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(PlanError, match=sentence):
        designs.read_points(path)


def test_a_factorial_has_24_points_and_determines_every_term_up_to_the_cubic():
    design = designs.factorial(designs.FACTORIAL_PITCH_DEG, designs.uniform_circle_deg(6))
    assert len(set(attitudes(design))) == 24
    columns = terms(np.deg2rad(np.array(attitudes(design))), "extended", with_roll=True)
    assert np.linalg.matrix_rank(columns) == columns.shape[1]
    with pytest.raises(PlanError, match="pitch got 3 values, allowed are 4"):
        designs.factorial((-90.0, 0.0, 90.0), designs.uniform_circle_deg(6))


def test_a_field_of_points_that_is_too_long_is_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text(f"pitch_deg,roll_deg\n0,{'1' * 140_000}\n")
    with pytest.raises(PlanError, match=r"points\.csv: not a CSV file \(field larger than field limit"):
        designs.read_points(path)
