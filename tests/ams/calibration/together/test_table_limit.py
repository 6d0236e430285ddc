"""A table beyond its declared limit is named, whatever its curve; one within it, or a sensor's own terms, are not."""

from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import campaigns
from scipy.optimize import lsq_linear
from solved_campaigns import columns_of, rows_of, table_of

from ams.analysis.diagnostics.beliefs import TABLE_LIMIT, BeliefTest
from ams.analysis.diagnostics.table_curves import TableLimit, _bounded, indices_of
from ams.analysis.diagnostics.words.table_limit_wording import of_table_limit
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.known_of_run import GAIN, OFFSET, KnownOfRun, ProvedChange, labels_of
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations


def _solved(name: str, size: float, count: int, table: TableUncertainty | None, seed: int = 4, **design):
    drawn = campaigns(name, size, np.random.default_rng(seed), count, **design)
    for index in range(count):
        outputs = {axis: columns_of(drawn, axis)[:, index] for axis in drawn.setup.axes}
        yield calibrate(replace(rows_of(drawn), outputs=outputs), CalibrationRequest(table=table))


def _of_table(solved: Calibration) -> list[Finding]:
    return [
        finding
        for axis in solved.axes.values()
        for finding in axis.findings
        if finding.details.get("test") == TABLE_LIMIT
    ]


def _share(found) -> float:
    return float(np.mean([any(entry.is_significant for entry in _of_table(solved)) for solved in found]))


@pytest.mark.parametrize("limit_deg", [30.0, 90.0])
@pytest.mark.parametrize("curve", ["table-once", "table-twice", "table-teeth"])
def test_a_curve_of_three_times_the_limit_is_the_tables(curve: str, limit_deg: float) -> None:
    assert _share(_solved(curve, 3.0, 8, table_of(), pitch_limit_deg=limit_deg)) >= 0.85


@pytest.mark.parametrize("curve", ["table-once", "table-twice", "table-harmonics", "table-teeth"])
def test_a_curve_that_reaches_its_limit_is_not_named(curve: str) -> None:
    assert _share(_solved(curve, 1.0, 12, table_of())) <= 1 / 12


def test_a_gain_of_the_meter_is_no_error_of_the_table_whether_it_is_proved_or_not() -> None:
    """A gain of 100 ppm from the middle of the second replication on: in raster order it looks like index errors."""
    drawn = campaigns("clean", 0.0, np.random.default_rng(6), 8, replications=3)
    rows = rows_of(drawn)
    first = int(np.flatnonzero(rows.replication == 2)[0]) + 40
    labels = labels_of(rows)
    proved = ProvedChange(frozenset(labels[: first - 6]), frozenset(labels[first + 6 :]), (GAIN, OFFSET))
    turned_up = np.where(np.arange(rows.rows) >= first, 1.0001, 1.0)
    shares = []
    for known in (KnownOfRun(), KnownOfRun(changes=(proved,))):
        request = CalibrationRequest(table=table_of(), known_of_run=known)
        outputs = ({axis: turned_up * columns_of(drawn, axis)[:, index] for axis in "xyz"} for index in range(8))
        shares.append(_share(calibrate(replace(rows, outputs=found), request) for found in outputs))
    assert max(shares) <= 1 / 8


def test_a_zeroed_curve_within_its_limit_is_not_named_and_beyond_it_is() -> None:
    assert _share(_solved("table-once-zeroed", 1.0, 12, table_of(zero_rad=0.0))) <= 1 / 12
    assert _share(_solved("table-once-zeroed", 5.0, 8, table_of(zero_rad=0.0))) >= 0.85


def test_a_curve_beyond_its_limit_that_passes_for_terms_of_one_output_is_told_to_that_output() -> None:
    """At ±30° pitch is told by x alone: of twice the limit one campaign in four was told, and the rest in silence."""
    assert _share(_solved("table-once-zeroed", 2.0, 12, table_of(zero_rad=0.0), pitch_limit_deg=30.0)) >= 0.85
    assert _share(_solved("table-once-zeroed", 1.0, 12, table_of(zero_rad=0.0), pitch_limit_deg=30.0)) <= 1 / 12


@pytest.mark.parametrize(
    ("scene", "size", "kinds"),
    [
        ("soft-mount", 20.0, {"quadratic", "cross-coupling"}),
        ("k2", 20.0, {"quadratic"}),
        ("k3", 50.0, {"cubic"}),
        ("k0-asymmetry", 50.0, {"asymmetry", "cubic", "lack-of-fit"}),
    ],
)
def test_a_sensor_is_not_blamed_on_the_table(scene: str, size: float, kinds: set[str]) -> None:
    found = list(_solved(scene, size, 8, table_of()))
    assert _share(found) <= 1 / 8
    said = [
        {finding.kind for axis in solved.axes.values() for finding in axis.findings if finding.is_significant}
        for solved in found
    ]
    assert np.mean([bool(entry & kinds) for entry in said]) >= 0.85


def _slipped_early(seed: int) -> Calibration:
    """Solve 4 × 40 attitudes of which the first fourteen dwells, at pitch −60° and 0° alone, are before a slip of 72″.

    The angles are read to 2″, as an encoder tells them, and the sensors are 0.1° off their axes.
    """
    chance = np.random.default_rng(seed)
    pitch_deg, roll_deg = (-60.0, 0.0, -30.0, 30.0, 60.0), np.arange(-180.0, 180.0, 45.0)
    at = np.array([(pitch, roll) for pitch in pitch_deg for roll in roll_deg])
    replication, point = np.repeat(np.arange(1, 5), 40), np.tile(np.arange(1, 41), 4)
    pitch, roll = np.radians(at[point - 1]).T + chance.normal(0.0, 1e-5, (2, 160))
    slipped = roll + np.where(np.arange(160) >= 14, np.radians(72.0 / 3600.0), 0.0)
    force = specific_force(pitch, slipped)
    outputs = {}
    for index, axis in enumerate("xyz"):
        k = 2.5 * (np.eye(3)[index] + np.radians(0.1) * chance.standard_normal(3))
        outputs[axis] = 0.01 + force @ k + chance.normal(0.0, 9e-6, 160)
    rows = Observations(replication, point, pitch, roll, outputs, time_s=60.0 * np.arange(160.0))
    return calibrate(rows, CalibrationRequest(table=table_of(limit_arcsec=3.0)))


def test_a_slip_that_is_told_leaves_nothing_to_be_told_as_errors_of_the_table() -> None:
    # What it did to an output was read off replications that hardly differed by it: 60″ of a cosine of pitch in x,
    # where all dwells before the slip were of two pitches.
    found = [_slipped_early(seed) for seed in range(4)]
    assert all("table-rotation" in {finding.kind for finding in each.axes["y"].findings} for each in found)
    assert _share(found) == 0.0


def test_one_output_alone_never_blames_the_table_for_its_own_terms() -> None:
    """A cosine of pitch is K₂ of x: nothing of one output tells them apart."""
    for scene in ("k2", "soft-mount"):
        assert _share(_solved(scene, 20.0, 8, table_of(), axes="x")) == 0.0


def _with_term(limit_arcsec: float, output: str, powers: tuple[int, int, int], micro: float, axes: str, count: int):
    """Solve clean campaigns of which one output has a term of its own, in µg."""
    drawn = campaigns("clean", 0.0, np.random.default_rng(12), count, axes=axes, pitch_limit_deg=60.0)
    rows = rows_of(drawn)
    force = specific_force(rows.pitch_rad, rows.roll_rad)
    for index in range(count):
        outputs = {axis: columns_of(drawn, axis)[:, index] for axis in drawn.setup.axes}
        linear = np.column_stack([np.ones(rows.rows), force])
        volts_per_g = np.linalg.norm(np.linalg.lstsq(linear, outputs[output], rcond=None)[0][1:])
        outputs[output] = outputs[output] + 1e-6 * micro * volts_per_g * np.prod(force ** np.array(powers), axis=1)
        yield calibrate(replace(rows, outputs=outputs), CalibrationRequest(table=table_of(limit_arcsec)))


@pytest.mark.parametrize(
    ("limit_arcsec", "output", "powers"),
    [(0.3, "y", (2, 1, 0)), (0.5, "y", (2, 1, 0)), (0.1, "x", (4, 0, 0)), (0.01, "x", (4, 0, 0))],
)
def test_a_term_of_one_output_alone_is_told_of_that_output_and_of_no_other(
    limit_arcsec: float, output: str, powers: tuple[int, int, int]
) -> None:
    """Beside a free curve of the table a term of third or fourth order of y is half explained; x and z see no curve."""
    for solved in _with_term(limit_arcsec, output, powers, 50.0, "xyz", 4):
        for axis, found in solved.axes.items():
            told = [finding for finding in found.findings if finding.details.get("test") == TABLE_LIMIT]
            assert all("or the sensor has" in each.text for each in told if each.is_significant and axis == output)
            assert axis == output or not any(each.is_significant for each in told)
        said = {axis: [each for each in found.findings if each.is_significant] for axis, found in solved.axes.items()}
        assert said.pop(output)
        assert all(each.is_held for findings in said.values() for each in findings)


def test_of_one_output_alone_table_and_sensor_are_both_named() -> None:
    found = list(_with_term(0.01, "y", (2, 1, 0), 200.0, "y", 4))
    named = [finding for solved in found for finding in _of_table(solved) if finding.is_significant]
    assert named
    for finding in named:
        assert "either the table " in finding.text
        assert "or the sensor has a nonlinearity of its own of higher order" in finding.text


@pytest.mark.parametrize("outputs", [1, 3])
def test_what_is_within_the_declared_limit_is_not_called_more(outputs: int) -> None:
    """The size is the least that the points ask for; what is tested is how much better larger ones explain them."""
    within = TableLimit(1e-6, {"pitch": 3e-8, "roll": 2e-8}, {"pitch": 5e-8, "roll": 5e-8}, {}, outputs)
    finding = of_table_limit(BeliefTest(TABLE_LIMIT, "lack-of-fit", 1e-6), within, is_significant=True)
    assert "more than is declared" not in finding.text
    assert "no index errors within the declared ±0.01″ in pitch and ±0.01″ in roll explain the points" in finding.text
    assert "p = 1e−06" in finding.text


@pytest.mark.parametrize("zero_deg", [0.0, 17.0])
def test_the_columns_of_a_zeroed_axis_are_the_curve_less_its_value_at_the_zero(zero_deg: float) -> None:
    shown = np.deg2rad([-60.0, 0.0, 30.0, -60.0, 300.0, 0.0])
    found = indices_of(table_of(zero_rad=np.deg2rad(zero_deg)), "pitch", shown)
    assert found is not None

    def curve(angle_rad: np.ndarray) -> np.ndarray:
        return np.sin(angle_rad + 0.3) + 0.2 * np.cos(3.0 * angle_rad)

    indices = np.deg2rad([-60.0, 0.0, 30.0] if zero_deg == 0.0 else [-60.0, 0.0, zero_deg, 30.0])
    expected = curve(shown) - curve(np.deg2rad([zero_deg]))
    np.testing.assert_allclose(found.columns @ curve(indices), expected, atol=1e-12)
    np.testing.assert_allclose(found.bound_rad, np.deg2rad(1.0 / 3600.0), rtol=1e-12)


def test_what_the_table_does_is_not_said_of_the_sensor_as_well() -> None:
    (solved,) = _solved("table-once", 5.0, 1, table_of(), seed=6)
    for axis in solved.axes.values():
        assert [finding.details["test"] for finding in axis.findings if finding.is_significant] == [TABLE_LIMIT]
        (finding,) = _of_table(replace(solved, axes={"x": axis}))
        assert finding.kind == "lack-of-fit"
        assert "the table is off by more than is declared: its index errors in " in finding.text
        assert "(declared ±1″)" in finding.text
        assert finding.text in axis.warnings
        largest = max(finding.details["pitch_arcsec"], finding.details["roll_arcsec"])
        assert 2.0 < largest < 8.0  # of 5″, as far as the attitudes show it
    assert solved.verdict != "sound"


def test_without_a_declared_limit_there_is_no_test_of_it() -> None:
    (solved,) = _solved("table-once", 5.0, 1, None)
    assert _of_table(solved) == []


def test_the_least_within_bounds_is_that_of_another_solver() -> None:
    chance = np.random.default_rng(9)
    for _ in range(20):
        columns, y = chance.standard_normal((40, 15)), 3.0 * chance.standard_normal(40)
        bound = chance.uniform(0.05, 0.5, 15)
        found, at_bound = _bounded(columns.T @ columns, columns.T @ y, bound)
        other = lsq_linear(columns, y, (-bound, bound), method="bvls", tol=1e-14)
        np.testing.assert_allclose(found, other.x, atol=1e-7)
        np.testing.assert_array_equal(at_bound, other.active_mask != 0)


@pytest.mark.soak
@pytest.mark.parametrize("curve", ["clean", "table-once", "table-twice", "table-harmonics", "table-teeth"])
def test_tables_within_their_limit_are_named_in_no_more_than_one_campaign_in_a_hundred(curve: str) -> None:
    size = 0.0 if curve == "clean" else 1.0
    assert _share(_solved(curve, size, 2000, table_of(), seed=77)) <= 0.01
