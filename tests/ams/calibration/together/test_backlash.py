"""Play of the table turns all axes of a package by the way that it came, and is named the table's; nothing else is."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import Campaign, campaigns
from physics_scenes.rotations import ARCSEC
from solved_campaigns import columns_of, rows_of, solved, table_of

from ams.archive.run_at_fault import KINDS_OF_THE_RUN
from ams.calibration.calibrate import calibrate
from ams.calibration.output.believed import evidence_of
from ams.calibration.together.backlash import judge_play
from ams.calibration.together.backlash_found import Play
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest

SHARE = 0.05 / 38.0
SMALL = {"pitch_count": 9, "roll_count": 8, "replications": 4}


def _drawn(scene: str, size: float, count: int, seed: int = 3, **design: object) -> Campaign:
    alone = {"sensors": 1, "reference_every": 0, "check_set": False}
    return campaigns(scene, size, np.random.default_rng(seed), count, **{**alone, **design})


def _plays(
    drawn: Campaign, level: float = SHARE, axes: str = "xyz", single_approach: frozenset[str] = frozenset()
) -> list[Sequence[Play]]:
    """Return the play that is told in each campaign by some of the axes."""
    rows = rows_of(drawn)
    evidence = {axis: evidence_of(columns, rows) for axis, columns in solved(drawn).items()}
    return [
        judge_play([(evidence[axis], index) for axis in axes], level, single_approach)
        for index in range(drawn.campaigns)
    ]


def _solved(drawn: Campaign, index: int = 0, request: CalibrationRequest | None = None) -> Calibration:
    outputs = {axis: columns_of(drawn, axis)[:, index] for axis in drawn.setup.axes}
    return calibrate(replace(rows_of(drawn), outputs=outputs), request or CalibrationRequest())


def _told(of: Calibration) -> list[Finding]:
    return [found for axis in of.axes.values() for found in axis.findings if found.is_significant]


@pytest.mark.parametrize("order", ["random", "there-and-back", "serpentine"])
@pytest.mark.parametrize("axis", ["pitch", "roll"])
def test_play_is_named_with_its_axis_and_size(axis: str, order: str) -> None:
    drawn = _drawn(f"table-backlash-{axis}", 4.0, 16, order=order)
    told = _plays(drawn)
    assert [[play.axis for play in plays] for plays in told] == [[axis]] * 16
    size, u = (
        np.array([getattr(play, name) for (play,) in told]) / ARCSEC
        for name in ("size_rad", "standard_uncertainty_rad")
    )
    away = (np.abs(size) - 4.0) / u
    assert np.abs(away).max() < 4.0
    assert np.mean(away**2) < 2.5
    if order == "random":
        assert np.mean(away**2) > 0.4


def test_the_way_before_the_first_move_is_the_one_that_the_dwells_show() -> None:
    """The first row of a run is come to from nobody knows where: as neither, 20″ were 20.2″."""
    told = _plays(_drawn("table-backlash-pitch", 20.0, 16, order="there-and-back"))
    assert all(len(plays) == 1 for plays in told)
    assert np.mean([abs(play.size_rad) for (play,) in told]) / ARCSEC == pytest.approx(20.0, abs=0.1)


def test_both_axes_may_have_play_each_told_beside_the_other() -> None:
    pitch, roll = (_drawn(f"table-backlash-{axis}", 6.0, 6, order="random") for axis in ("pitch", "roll"))
    clean = _drawn("clean", 0.0, 6, order="random")
    both = replace(pitch, output_v=pitch.output_v + roll.output_v - clean.output_v)
    for plays in _plays(both):
        assert {play.axis for play in plays} == {"pitch", "roll"}
        assert [abs(play.size_rad) / ARCSEC for play in plays] == pytest.approx([6.0, 6.0], abs=1.2)


def test_where_nothing_is_wrong_play_is_told_no_more_often_than_the_level() -> None:
    """Of two tests; that the outputs have to agree makes it rarer."""
    level, runs = 0.05, 100
    for order in ("random", "there-and-back"):
        told = _plays(_drawn("clean", 0.0, runs, seed=7, order=order, **SMALL), level)
        bound = 2.0 * level
        assert np.mean([bool(plays) for plays in told]) <= bound + 3.0 * np.sqrt(bound / runs)


@pytest.mark.parametrize(
    ("scene", "size", "order"),
    [
        ("after-effect", 10.0, "there-and-back"),
        ("after-effect", 10.0, "random"),
        ("hysteresis", 20.0, "random"),
        ("k0-asymmetry", 50.0, "random"),
        ("fixture-play", 72.0, "random"),
        ("fixture-play", 72.0, "there-and-back"),
        ("table-teeth", 5.0, "there-and-back"),
        ("table-once", 5.0, "serpentine"),
        ("table-teeth", 5.0, "serpentine"),
        ("table-wrong-zero", 100.0, "serpentine"),
        ("slip-pitch", 720.0, "random"),
    ],
)
def test_neither_what_sensors_remember_nor_what_follows_gravity_nor_index_errors_are_named_play(
    scene: str, size: float, order: str
) -> None:
    told = _plays(_drawn(scene, size, 30, seed=21, order=order))
    assert sum(map(bool, told)) <= 1


def test_one_axis_alone_that_does_what_play_does_is_not_the_table() -> None:
    """The same change of the output of y, which no other shares, is its sensor's."""
    play, clean = (_drawn(scene, 6.0, 8, order="random") for scene in ("table-backlash-roll", "clean"))
    output = clean.output_v.copy()
    output[..., 1] = play.output_v[..., 1]
    alone = replace(clean, output_v=output)
    assert not any(_plays(alone))
    for axes, is_alone in (("y", True), ("yz", False)):
        assert [each.is_of_lone_output for (each,) in _plays(play, axes=axes)] == [is_alone] * 8
    assert sum(each.is_of_lone_output for (each,) in _plays(play, axes="xy")) >= 6  # x hardly sees roll


@pytest.mark.parametrize(("nominal", "axis"), [("x", "pitch"), ("y", "pitch"), ("y", "roll"), ("z", "roll")])
def test_a_package_of_one_axis_is_told_both_that_it_may_be(nominal: str, axis: str) -> None:
    """A y alone on a table whose pitch has play of 10″ was "usable", its sensitivities held in 0.67."""
    solution = _solved(_drawn(f"table-backlash-{axis}", 10.0, 1, order="random", axes=nominal))
    (told,) = (found for found in _told(solution) if "backlash_arcsec" in found.details)
    assert told.fact.startswith("either the table comes to rest ")
    assert "or the sensor has a hysteresis of its own" in told.fact
    assert told.details["confounded_with"] == "sensor-change"
    assert solution.verdict == "not usable"


def test_an_axis_that_the_machine_lets_come_from_one_side_is_not_asked() -> None:
    drawn = _drawn("table-backlash-roll", 6.0, 3, order="random")
    assert all(_plays(drawn, single_approach=frozenset({"pitch"})))
    assert not any(_plays(drawn, single_approach=frozenset({"roll"})))
    request = CalibrationRequest(single_approach=frozenset({"roll"}))
    assert not any("backlash_arcsec" in found.details for found in _told(_solved(drawn, request=request)))


def test_in_an_order_that_comes_to_every_index_but_one_from_one_side_no_package_turns_together() -> None:
    """But for the first index of each row the roll axis rises always: there y alone is off, as by an index error."""
    told = _plays(_drawn("table-backlash-roll", 10.0, 12, order="raster"))
    assert all(play.is_of_lone_output for plays in told for play in plays)


@pytest.mark.parametrize(("axis", "order"), [("pitch", "random"), ("roll", "random"), ("pitch", "there-and-back")])
def test_a_run_on_a_table_with_play_names_the_table_and_no_sensor(axis: str, order: str) -> None:
    solution = _solved(_drawn(f"table-backlash-{axis}", 10.0, 1, order=order))
    told = _told(solution)
    assert {found.kind for found in told} == {"table-rotation"}
    assert len(told) == len(solution.axes)
    assert solution.verdict == "not usable"
    for found in told:
        assert f"apart about {axis} by the direction that it came from" in found.fact
        assert f"approach_deg of axes.{axis}" in found.what_to_do
        u = float(found.details["standard_uncertainty_arcsec"] or 0.0)
        assert float(found.details["backlash_arcsec"] or 0.0) == pytest.approx(10.0, abs=4.0 * u)
        assert found.kind in KINDS_OF_THE_RUN
        assert found.text in next(iter(solution.axes.values())).warnings


@pytest.mark.parametrize(("axis", "size"), [("roll", 4.0), ("pitch", 10.0)])
def test_a_declared_limit_of_index_errors_holds_a_play_of_twice_as_much(axis: str, size: float) -> None:
    """Where it does not, that the limit is broken is said by the play alone."""
    drawn = _drawn(f"table-backlash-{axis}", size, 1, order="random")
    held = {}
    for limit_arcsec in (1.0, size):
        told = _told(_solved(drawn, request=CalibrationRequest(table=table_of(limit_arcsec))))
        found = [each for each in told if each.kind == "table-rotation"]
        assert len(found) == 3
        assert f"±{limit_arcsec:g}″" in found[0].fact
        assert not any(each.details.get("test") == "table's declared limit" for each in told)
        held[limit_arcsec] = {each.is_held for each in found}
    assert held == {1.0: {False}, size: {True}}
