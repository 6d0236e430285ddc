from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from report_dwells import START, dwell

from procedures.errors import JournalError
from procedures.plan.channels import TemperatureChannel
from procedures.solution.observations import observations_of, run_times_s

X = {"x": "dmm.x"}


def test_only_accepted_design_dwells_enter() -> None:
    dwells = [
        dwell(0, "check", 0, 0),
        dwell(1, point=1, volts={"dmm.x": (1.0, 3.0)}),
        dwell(2, point=2, accepted=False),
        dwell(3, "reference", 1, 0),
        dwell(4, point=3, pitch_deg=30.0, roll_deg=-60.0),
    ]
    rows = observations_of(dwells, X)
    assert rows.point.tolist() == [1, 3]
    assert rows.outputs["x"].tolist() == [2.0, 1.0]
    assert np.rad2deg(rows.pitch_rad[1]) == pytest.approx(30.0)
    assert np.rad2deg(rows.roll_rad[1]) == pytest.approx(-60.0)


def test_rows_stand_in_the_order_of_the_plan_whatever_order_they_were_measured_in() -> None:
    dwells = [dwell(step, point=step) for step in range(1, 6)]
    assert observations_of(dwells[::-1], X).point.tolist() == [1, 2, 3, 4, 5]


def test_a_point_accepted_twice_is_refused() -> None:
    with pytest.raises(JournalError, match=r"replication 1, point 7 was accepted twice: steps 3 and 9"):
        observations_of([dwell(3, point=7), dwell(9, point=7)], X)


@pytest.mark.parametrize("volts", [{"dmm.x": (1.0, float("nan"))}, {"dmm.y": (1.0, 1.0)}])
def test_an_accepted_dwell_without_a_finite_mean_is_refused(volts: dict[str, tuple[float, ...]]) -> None:
    with pytest.raises(JournalError, match=r"dmm\.x: the accepted dwell of step 3 has no finite mean"):
        observations_of([dwell(3, volts=volts)], X)


def test_the_sensors_own_temperature_is_converted_from_its_channel() -> None:
    rows = [dwell(1, volts={"dmm.x": (1.0, 1.0), "dmm.t": (0.25, 0.25)})]
    own = observations_of(rows, X, TemperatureChannel("dmm.t", -5.0, 100.0)).temperature_degc
    assert own is not None
    assert own.tolist() == [20.0]


def test_the_environment_stands_for_it_and_one_missing_reading_means_none() -> None:
    known = observations_of([dwell(1, degc=21.5)], X, "air").temperature_degc
    assert known is not None
    assert known.tolist() == [21.5]
    assert observations_of([dwell(1), dwell(2, point=2, degc=None)], X, "air").temperature_degc is None
    assert observations_of([dwell(1)], X).temperature_degc is None


def test_time_goes_on_over_a_restart_although_its_monotonic_clock_began_anew() -> None:
    dwells = [dwell(0), dwell(1, point=2), dwell(100, point=3, epoch=2, epoch_start_s=2990.0)]
    assert dwells[2].started_s == 10.0
    assert run_times_s(dwells).tolist() == [5.0, 35.0, 3005.0]


def test_an_epoch_comes_after_the_one_before_where_rig_seconds_pass_faster_than_those_of_the_wall_clock() -> None:
    """A twin at hundred times the speed, stopped and resumed a moment later; rows stand in the order of the plan."""
    first = [dwell(step, point=step) for step in (0, 1, 3)]
    again = [dwell(step, point=step, epoch=2, epoch_start_s=60.0) for step in (2, 4)]
    fast = [replace(row, started_utc=START + timedelta(seconds=0.3 * row.step)) for row in first]
    fast += [replace(row, started_utc=START + timedelta(seconds=2.0 + 0.3 * row.step)) for row in again]
    rows = observations_of(fast, X)
    assert rows.time_s is not None
    assert rows.point[np.argsort(rows.time_s)].tolist() == [0, 1, 3, 2, 4]
    assert rows.time_s.tolist() == [5.0, 35.0, 105.0, 95.0, 165.0]


def test_times_begin_with_the_first_point_though_it_was_measured_again_in_a_later_epoch() -> None:
    first, again = dwell(1, point=2), dwell(0, point=1, epoch=2, epoch_start_s=-600.0)
    times = run_times_s([replace(again, started_utc=START + timedelta(seconds=20)), first])
    assert times.tolist() == [5.0, -5.0]


def test_a_run_without_dwells_gives_no_rows() -> None:
    assert observations_of([], X).rows == 0
