"""Points, orders and times of a campaign."""

import numpy as np
import pytest
from physics_scenes import FINE, REPEATED_ROLL, WITHOUT_ROLL, Setup, scene
from physics_scenes.designs import ORDERS, schedule_of

CHANCE = np.random.default_rng(3)


@pytest.mark.parametrize(
    ("design", "points"), [({}, 13 * 12), (FINE, 37 * 36), (REPEATED_ROLL, 13 * 13), (WITHOUT_ROLL, 13)]
)
def test_designs_have_their_points(design, points):
    drawn = scene("clean", 0.0, np.random.default_rng(1), **design)
    assert drawn.points_deg.shape == (points, 2)
    assert drawn.grid(drawn.output_v).shape == (1, 6, points, 1, len(drawn.setup.axes))


@pytest.mark.parametrize("order", ORDERS)
def test_every_order_visits_every_point_once_in_each_replication(order):
    setup = Setup(order=order, reference_every=25, check_set=True)
    schedule = schedule_of(setup, CHANCE)
    rows = schedule.grid_rows()
    assert rows.shape == (6, 156)
    np.testing.assert_array_equal(schedule.pitch_deg[rows], np.tile(setup.points_deg()[:, 0], (6, 1)))
    np.testing.assert_array_equal(schedule.roll_deg[rows], np.tile(setup.points_deg()[:, 1], (6, 1)))
    assert np.unique(rows).size == 6 * 156
    assert (np.diff(schedule.time_s) >= setup.dwell_s).all()


@pytest.mark.parametrize(("order", "least", "most"), [("raster", 0.98, 1.0), ("there-and-back", 0.0, 0.15)])
def test_time_and_pitch_are_one_in_a_raster_and_nearly_orthogonal_there_and_back(order, least, most):
    schedule = schedule_of(Setup(order=order), CHANCE)
    rows = schedule.grid_rows()[2]
    correlation = abs(np.corrcoef(schedule.time_s[rows], schedule.pitch_deg[rows])[0, 1])
    assert least <= correlation <= most


def test_visits_stand_where_they_were_asked_for():
    drawn = scene("clean", 0.0, np.random.default_rng(1), reference_every=26, check_set=True, replications=2)
    purposes = drawn.schedule.purpose
    assert (purposes[:6] == "check-before").all()
    assert (purposes[-6:] == "check-after").all()
    visits, outputs = drawn.visits("reference")
    assert visits.dwells == outputs.shape[1] == 2 * (1 + 2 * 156 // 26)
    assert len(set(zip(visits.pitch_deg, visits.roll_deg, strict=True))) == 2


def test_a_check_set_may_break_off():
    drawn = scene("slip-roll", 720.0, np.random.default_rng(1), check_before_count=2)
    assert drawn.visits("check-before")[0].dwells == 2
    assert drawn.visits("check-after")[0].dwells == 6


def test_the_attitude_before_is_that_of_the_dwell_before():
    schedule = schedule_of(Setup(order="random"), CHANCE)
    np.testing.assert_array_equal(schedule.previous_pitch_deg[1:], schedule.pitch_deg[:-1])
    np.testing.assert_array_equal(schedule.previous_roll_deg[1:], schedule.roll_deg[:-1])


def test_a_chamber_that_changes_soaks_first():
    schedule = schedule_of(Setup(plateaus_degc=(15.0, 25.0), soak_s=1800.0, replications=2), CHANCE)
    first = schedule.grid_rows()[1].min()
    assert schedule.chamber_degc[first - 1] == 15.0
    assert schedule.chamber_degc[first] == 25.0
    assert schedule.time_s[first] - schedule.time_s[first - 1] > 1800.0


def test_an_unknown_order_or_a_mirrored_mount_is_refused():
    with pytest.raises(ValueError, match="zigzag"):
        schedule_of(Setup(order="zigzag"), CHANCE)
    with pytest.raises(ValueError, match="without reflection"):
        Setup(mounts=("-x+y+z",)).mount_matrices()
