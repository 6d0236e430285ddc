"""An output that is off at one index or one attitude alone is told so, and never as contained.

Scenes of ``index_scenes``: 7 × 8 points in four replications, three axes, 8 µg a dwell.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import Campaign, campaigns
from solved_campaigns import rows_of_package, table_of

from ams.analysis.diagnostics.beliefs import AT_A_LOCATION, LACK_OF_FIT
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import NONLINEARITY, SharedError
from ams.observations import Observations

SMALL = {"pitch_count": 7, "roll_count": 8, "replications": 4}
COUNT = 8
CONTAINED = "contained in the stated uncertainties"


def _drawn(scene: str, size: float) -> Campaign:
    return campaigns(scene, size, np.random.default_rng(31), COUNT, **SMALL)


def _solved(drawn: Campaign, *, has_table: bool) -> Iterator[Calibration]:
    request = CalibrationRequest(table=table_of(1.0) if has_table else None)
    yield from (calibrate(rows_of_package(drawn, index), request) for index in range(COUNT))


def _told(solved: Calibration, test: str) -> list[Finding]:
    every = (said for axis in solved.axes.values() for said in axis.findings)
    return [said for said in every if said.is_significant and said.details.get("test") == test]


@pytest.mark.parametrize("has_table", [False, True])
def test_vibration_at_one_pitch_is_told_with_the_index_and_held_by_nothing(has_table: bool) -> None:
    drawn = _drawn("vibration-at-pitch", 50.0)
    clean = campaigns("vibration-at-pitch", 0.0, np.random.default_rng(31), COUNT, **SMALL)
    off = np.abs(drawn.grid(drawn.output_v) - clean.grid(clean.output_v))[:, 0, :, 0, 2] > 0.0
    for index, solved in enumerate(_solved(drawn, has_table=has_table)):
        told = _told(solved, AT_A_LOCATION)
        at_deg = float(drawn.points_deg[off[index]][0, 0])
        assert told
        assert solved.verdict == "not usable"
        assert {said.details["pitch_deg"] for said in told} == {at_deg}
        first = int(np.flatnonzero(drawn.points_deg[:, 0] == at_deg)[0])
        assert all(f"points {first} to {first + 7}" in said.text for said in told)
        assert not any(said.is_held or CONTAINED in said.text for said in told)


@pytest.mark.parametrize(("scene", "where"), [("output-at-roll", "roll_deg"), ("output-at-attitude", "pitch_deg")])
def test_one_output_off_at_one_roll_or_attitude_is_told_of_it_alone(scene: str, where: str) -> None:
    """The attitude of the first dwells is one where the output may settle as well."""
    every = list(_solved(_drawn(scene, 50.0), has_table=False))
    named = [told for solved in every for told in _told(solved, AT_A_LOCATION)]
    assert len(named) >= COUNT - 1
    assert all(where in told.details for told in named)
    assert not any(_told(solved, AT_A_LOCATION) and _told(solved, LACK_OF_FIT) for solved in every)


def test_a_lack_of_fit_that_goes_alike_over_an_index_is_not_contained() -> None:
    """A wave of seven periods in a turn of pitch, on one output: not one index, and no error of each attitude."""
    for solved in _solved(_drawn("wave-along-pitch", 30.0), has_table=True):
        texts = [said.text for said in (*_told(solved, LACK_OF_FIT), *_told(solved, AT_A_LOCATION))]
        assert solved.verdict == "not usable"
        assert texts
        assert not any(CONTAINED in text for text in texts)


def _read_back(drawn: Campaign, index: int, jitter_deg: float) -> Observations:
    """Return the rows of a campaign whose axes stand a little otherwise each time, and are read so."""
    rows, chance = rows_of_package(drawn, index), np.random.default_rng(index)
    planned = rows.pitch_rad, rows.roll_rad
    stood = [angle + np.deg2rad(jitter_deg) * chance.standard_normal(angle.size) for angle in planned]
    true_v = [drawn.true_output_v(*map(np.rad2deg, angles))[index, :, 0] for angles in (stood, planned)]
    moved_v = dict(zip("xyz", (true_v[0] - true_v[1]).T, strict=True))
    outputs = {axis: output + moved_v[axis] for axis, output in rows.outputs.items()}
    return replace(rows, pitch_rad=stood[0], roll_rad=np.angle(np.exp(1j * stood[1])), outputs=outputs)


@pytest.mark.parametrize(
    ("scene", "size", "campaign", "jitter_deg"),
    [("output-at-pitch", 50.0, 0, 0.001), ("output-at-pitch", 50.0, 0, 0.02), ("wave-along-pitch", 30.0, 1, 0.002)],
)
def test_what_is_alike_over_an_index_is_told_of_angles_as_they_are_read_back(
    scene: str, size: float, campaign: int, jitter_deg: float
) -> None:
    rows = _read_back(_drawn(scene, size), campaign, jitter_deg)
    solved = calibrate(rows, CalibrationRequest(table=table_of(1.0)))
    at_a_location, lack = _told(solved, AT_A_LOCATION), _told(solved, LACK_OF_FIT)
    assert solved.verdict == "not usable"
    assert at_a_location if scene == "output-at-pitch" else lack
    assert not any(CONTAINED in said.text for said in (*at_a_location, *lack))


def test_errors_that_differ_from_attitude_to_attitude_are_contained() -> None:
    every = list(_solved(_drawn("output-at-attitudes", 30.0), has_table=True))
    assert all(any(CONTAINED in said.text for said in _told(solved, LACK_OF_FIT)) for solved in every)
    assert sum(bool(_told(solved, AT_A_LOCATION)) for solved in every) <= 1
    assert sum(solved.verdict == "usable" for solved in every) >= COUNT - 1


def test_what_is_declared_of_the_sensor_holds_a_place_within_it() -> None:
    drawn = _drawn("output-at-pitch", 50.0)
    for limit_ug, is_held in ((100.0, True), (10.0, False)):
        error = SharedError(NONLINEARITY, "departure", 2.5e-6 * limit_ug / 3.0**0.5)
        request = CalibrationRequest(shared_errors=dict.fromkeys("xyz", (error,)))
        (told,) = _told(calibrate(rows_of_package(drawn), request), AT_A_LOCATION)
        assert told.is_held is is_held
        assert ("within the declared largest_nonlinearity_v" in told.text) is is_held
