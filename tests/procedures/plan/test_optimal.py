"""Laws of the design of kind ``optimal``: no swap betters it, the seed makes it, and what cannot be is a sentence."""

import numpy as np
import pytest
from planning_files import procedure_file, rig_file

from procedures.errors import PlanError
from procedures.kinds.planner import make_plan
from procedures.plan.exchange import criterion, exchanged
from procedures.plan.optimal import terms

LATTICE = np.array([(pitch, roll) for pitch in np.arange(-90.0, 91.0, 15.0) for roll in np.arange(-180.0, 180.0, 30.0)])
ROWS = terms(np.deg2rad(LATTICE), "extended", with_roll=True)
MEAN = ROWS.T @ ROWS / len(ROWS)


def test_six_points_of_the_linear_sensor_are_nearly_as_good_as_a_tumble_test() -> None:
    """det XᵀX ≤ 6 · 2³ by the arithmetic and the geometric mean; TP's tumble reaches it, an exchange comes near."""
    rows = terms(np.deg2rad(LATTICE), "linear", with_roll=True)
    found = exchanged(rows, 6, np.random.default_rng(0), None)
    assert 0.98 * 48.0 < np.linalg.det(rows[found].T @ rows[found]) <= 48.0 + 1e-9


@pytest.mark.parametrize("region", [None, MEAN], ids=["D", "I"])
def test_no_single_swap_betters_it_and_chance_does_not_find_a_better_one(region: np.ndarray | None) -> None:
    found = exchanged(ROWS, 24, np.random.default_rng(1), region)
    best = criterion(ROWS[found], region)
    assert len(set(found)) == 24
    others = np.setdiff1d(np.arange(len(ROWS)), found)
    for index in range(0, 24, 5):
        swapped = [criterion(ROWS[[*found[:index], other, *found[index + 1 :]]], region) for other in others]
        assert min(swapped) > best - 1e-6 * abs(best)
    chance = np.random.default_rng(2)
    assert best < min(criterion(ROWS[chance.permutation(len(ROWS))[:24]], region) for _ in range(200))


def test_the_same_seed_makes_the_same_design() -> None:
    entry, other = (exchanged(ROWS, 24, np.random.default_rng(5), MEAN) for _ in range(2))
    assert entry == other


OPTIMAL = [
    ('kind = "D1"', 'kind = "optimal"\npoints = 30\nkeep_deg = [[0.0, 0.0]]'),
    ("from = -30.0, to = 30.0, step = 10.0", "from = -60.0, to = 60.0, step = 15.0"),
    ("step = 90.0", "step = 30.0"),
]


def test_a_procedure_is_planned_with_it_and_keeps_the_points_that_must_stand(tmp_path) -> None:
    design = make_plan(rig_file(tmp_path), procedure_file(tmp_path, *OPTIMAL)).design
    attitudes = {(point.pitch_deg, point.roll_deg) for point in design.points}
    assert len(attitudes) == len(design.points) == 30
    assert (0.0, 0.0) in attitudes


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("points = 30", "points = 900", "900 points asked for, the lattice has 117"),
        ("[[0.0, 0.0]]", "[[7.0, 0.0]]", "pitch 7°, roll 0° is no point of the lattice, nearest is pitch 0°"),
        ("[[0.0, 0.0]]", "[[0.0, 0.0], [0.0, 0.0]]", "names a point twice"),
        ("points = 30", "points = 9", "9 points of this lattice do not determine 12 terms"),
    ],
)
def test_what_cannot_be_is_a_sentence(tmp_path, old: str, new: str, sentence: str) -> None:
    (kind, text), *others = OPTIMAL
    with pytest.raises(PlanError, match=sentence):
        make_plan(rig_file(tmp_path), procedure_file(tmp_path, (kind, text.replace(old, new)), *others))
