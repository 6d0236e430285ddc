"""Beliefs against campaigns drawn from physics: what is wrong is named, what is right is left alone."""

from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import rows_of_package, table_of

from ams.analysis.diagnostics.beliefs import SLIP, SQUARENESS, STEP
from ams.calibration.calibrate import calibrate
from ams.calibration.packages import calibrate_packages
from ams.calibration_result import AxisCalibration
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations
from ams.units import RAD_PER_ARCSEC

SMALL = {"pitch_count": 7, "roll_count": 6, "replications": 4}


def _found(drawn, table: TableUncertainty | None = None, axis: str = "x") -> list[AxisCalibration]:
    """One axis of every campaign, calibrated by itself."""
    request = CalibrationRequest(nominal_axes={axis: axis}, table=table)
    every = range(drawn.campaigns)
    return [calibrate(rows_of_package(drawn, index), request).axes[axis] for index in every]


def _kinds(found: AxisCalibration) -> set[str]:
    return {finding.kind for finding in found.findings if finding.is_significant}


def _named(kind: str, name: str, size: float, count: int, **design) -> float:
    drawn = campaigns(name, size, np.random.default_rng(5), count, **design)
    return float(np.mean([kind in _kinds(found) for found in _found(drawn)]))


def _wrong(axis: AxisCalibration) -> Finding:
    return next(finding for finding in axis.findings if finding.kind == "wrong-dwell")


def _run_rings(drawn, sensors: int = 1) -> float:
    """Share of runs of so many sensors, three axes each, in which anything is told: a run in every ``sensors``.

    Every test of a run is in it: of every axis, of all axes of a package, of the dwells of all packages.
    """
    axes, runs = drawn.setup.axes, drawn.campaigns // sensors
    request, rings = CalibrationRequest(tested_axes=len(axes) * sensors), []
    for first in range(0, runs * sensors, sensors):
        packages = {f"SN{index}": rows_of_package(drawn, index) for index in range(first, first + sensors)}
        solved = calibrate_packages(packages, request)
        rings.append(any(_kinds(axis) for package in solved.values() for axis in package.axes.values()))
    return float(np.mean(rings))


def test_in_clean_campaigns_some_test_rings_in_one_run_of_twenty() -> None:
    drawn = campaigns("clean", 0.0, np.random.default_rng(11), 300, **SMALL)
    assert 0.01 < _run_rings(drawn) < 0.09  # 300 runs of three axes: 0.05 ± 0.025; axis by axis it is 0.15


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("sensors", [1, 3])
@pytest.mark.parametrize("design", [SMALL, {}, {"order": "random"}, {"pitch_limit_deg": 30.0}])
def test_false_alarms_stay_at_five_percent_over_thousands_of_clean_campaigns(design, sensors: int) -> None:
    rings = []
    for seed in range(10 * sensors):
        drawn = campaigns("clean", 0.0, np.random.default_rng(seed), 252, **design)
        rings.append(_run_rings(drawn, sensors))
    assert np.mean(rings) == pytest.approx(0.05, abs=0.015)


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_one_wrong_dwell_is_named_and_nothing_else_is_blamed_for_it(seed: int) -> None:
    drawn = campaigns("wrong-dwell", 1500.0, np.random.default_rng(seed), 1)
    axis, dwell = drawn.setup.axes[drawn.event.axis[0]], drawn.event.dwell[0]
    rows = rows_of_package(drawn)
    steps = np.empty(rows.rows, dtype=np.int64)
    steps[:] = drawn.schedule.grid_rows().ravel() + 1
    solved = calibrate(replace(rows, step=steps, run="night-1"), CalibrationRequest())
    found = _wrong(solved.axes[axis])
    assert found.steps == (dwell + 1,)
    assert found.details["replication"] == drawn.schedule.replication[dwell]
    assert found.details["point"] == drawn.schedule.point[dwell]
    assert f"step {dwell + 1}, replication {drawn.schedule.replication[dwell]}" in found.text
    assert f"calrig void night-1 --from {dwell + 1} --operator NAME --reason TEXT" in found.text
    redo = f"calrig redo night-1 --replication {drawn.schedule.replication[dwell]} --operator NAME --reason TEXT"
    assert redo in found.text
    of_a_file = _wrong(calibrate(replace(rows, source="obs.csv"), CalibrationRequest()).axes[axis])
    assert of_a_file.text.endswith("; look at it, or take its row out of obs.csv and solve it again")
    assert _kinds(solved.axes[axis]) == {"wrong-dwell"}
    assert not any(test.is_significant for test in solved.axes[axis].replication.drift.values())
    assert found.text in solved.axes[axis].warnings
    assert solved.verdict == "usable"


def test_without_the_wrong_dwell_the_other_tests_are_those_of_a_campaign_that_never_had_it() -> None:
    rows = rows_of_package(campaigns("clean", 0.0, np.random.default_rng(2), 1, axes="x", **SMALL))
    struck = 37
    wrong = rows.outputs["x"].copy()
    wrong[struck] += 1.0
    kept = np.arange(rows.rows) != struck
    lacking = Observations(
        rows.replication[kept], rows.point[kept], rows.pitch_rad[kept], rows.roll_rad[kept],
        {"x": rows.outputs["x"][kept]}, temperature_degc=rows.temperature_degc[kept], time_s=rows.time_s[kept],
    )  # fmt: skip
    with_it = calibrate(replace(rows, outputs={"x": wrong}), CalibrationRequest()).axes["x"]
    without = calibrate(lacking, CalibrationRequest()).axes["x"]
    steps = (SLIP, STEP)  # looked for in all outputs of the package, before a dwell of one of them is convicted
    others = [
        {f.details["test"]: f.p_value for f in axis.findings[1:-1] if f.details["test"] not in steps}
        for axis in (with_it, without)
    ]
    assert others[0] == pytest.approx(others[1], rel=0.02)  # the terms are centred over slightly other rows


@pytest.mark.parametrize(("name", "size", "kind"), [
    ("k2", 5.0, "quadratic"),
    ("k3", 20.0, "cubic"),
    ("cross-coupling", 10.0, "cross-coupling"),
    ("drift-replications", 2.0, "drift"),
    ("drift-linear", 2.0, "drift"),
    ("drift-correlated", 2.0, "autocorrelation"),
    ("outliers", 20.0, "wrong-dwell"),
])  # fmt: skip
def test_what_is_plainly_there_is_named(name: str, size: float, kind: str) -> None:
    assert _named(kind, name, size, 40) >= 0.9


def test_a_table_that_is_not_square_is_told_from_a_sensor_that_couples() -> None:
    named: dict[str, list[float]] = {"table-orthogonality": [], "soft-mount": []}
    for name, sizes_arcsec in named.items():
        drawn = campaigns(name, 5.0, np.random.default_rng(5), 20)
        for found in _found(drawn, axis="y"):
            said = [
                finding
                for finding in found.findings
                if finding.details["test"] == SQUARENESS and finding.is_significant
            ]
            sizes_arcsec += [abs(float(entry.details["size"])) / RAD_PER_ARCSEC for entry in said]
    assert len(named["table-orthogonality"]) >= 19
    assert named["table-orthogonality"] == pytest.approx([5.0] * len(named["table-orthogonality"]), abs=0.6)
    assert len(named["soft-mount"]) <= 2


def test_an_effect_of_size_nothing_is_not_named() -> None:
    assert _named("quadratic", "k2", 0.0, 60) <= 0.05


def test_a_sensor_that_lags_its_chamber_and_one_that_bends_are_told_apart() -> None:
    for name, size, kind in (
        ("temperature-lag", 0.3, "temperature-lag"),
        ("temperature-curvature", 1.0, "temperature-curvature"),
        ("temperature-curvature", 0.0, None),
    ):
        drawn = campaigns(name, size, np.random.default_rng(3), 1, axes="x")
        request = CalibrationRequest(temperature="estimate", reference_temperature_degc=20.0)
        assert _kinds(calibrate(rows_of_package(drawn), request).axes["x"]) == ({kind} if kind else set())


def test_terms_of_second_order_take_up_the_bend_that_a_straight_line_leaves() -> None:
    drawn = campaigns("temperature-curvature", 1.0, np.random.default_rng(3), 1, axes="x")
    request = CalibrationRequest(temperature="estimate", temperature_order=2, reference_temperature_degc=20.0)
    found = calibrate(rows_of_package(drawn), request).axes["x"]
    assert not _kinds(found)
    bend = next(p for p in found.parameters if p.name == "offset_tc2_v_per_degc2")
    assert abs(bend.value) > 5.0 * bend.standard_uncertainty


@pytest.mark.parametrize("name", ["temperature-in-step", "temperature-alternating"])
def test_a_recorded_temperature_that_is_not_modelled_is_named_where_it_matters(name: str) -> None:
    drawn = campaigns(name, 0.5, np.random.default_rng(4), 5, axes="x")
    found = [calibrate(rows_of_package(drawn, index), CalibrationRequest()).axes["x"] for index in range(5)]
    assert all("temperature-residual" in _kinds(axis) for axis in found)
    assert all("drift" not in _kinds(axis) for axis in found)


def test_a_raster_cannot_tell_time_from_pitch_and_there_and_back_can() -> None:
    for order, is_confounded in (("raster", True), ("there-and-back", False), ("random", False)):
        rows = rows_of_package(campaigns("clean", 0.0, np.random.default_rng(1), 1, axes="x", order=order))
        found = calibrate(rows, CalibrationRequest()).axes["x"]
        assert ("time-confounded" in _kinds(found)) is is_confounded


def test_an_error_of_the_table_within_its_certificate_is_no_soft_mount() -> None:
    drawn = campaigns("table-once", 1.0, np.random.default_rng(6), 40)
    assert np.mean([bool(_kinds(found)) for found in _found(drawn, table_of())]) <= 0.1
    assert np.mean([bool(_kinds(found)) for found in _found(drawn)]) > 0.8


def test_the_lack_of_fit_of_the_replications_is_that_of_the_findings() -> None:
    """A table within its certificate: z repeats plainly against precision alone, and the certificate explains it."""
    rows = rows_of_package(campaigns("table-wrong-zero", 1.0, np.random.default_rng(5), 1))
    for table, is_told in ((table_of(), False), (None, True)):
        found = calibrate(rows, CalibrationRequest(table=table)).axes
        for axis in found.values():
            stated = next(finding for finding in axis.findings if finding.details.get("test") == "lack of fit")
            assert axis.replication is not None
            test = axis.replication.lack_of_fit
            assert (test.p_value, test.is_significant) == (stated.p_value, stated.is_significant)
        plain = found["z"].replication
        assert plain is not None
        assert plain.lack_of_fit.t > plain.lack_of_fit.f_95
        assert plain.lack_of_fit.is_significant == is_told


def test_a_sensitivity_that_is_not_told_from_zero_has_no_set_and_is_not_usable() -> None:
    rows = rows_of_package(campaigns("clean", 0.0, np.random.default_rng(1), 1, **SMALL))
    noise_v = 1e-5 * np.random.default_rng(2).standard_normal(rows.rows)
    dead = calibrate(replace(rows, outputs={**rows.outputs, "y": 0.01 + noise_v}), CalibrationRequest())
    assert dead.verdict == "not usable"
    assert list(dead.unusable_axes) == ["y"]
    assert "is not told from zero" in dead.unusable_axes["y"]
    assert calibrate(rows, CalibrationRequest()).verdict in ("sound", "usable")


def test_a_dead_channel_of_two_replications_is_not_usable_however_badly_its_scatter_is_known() -> None:
    """Of outputs of noise alone all but Student's one in a hundred are told: at two u a third was usable."""
    rows = rows_of_package(campaigns("clean", 0.0, np.random.default_rng(1), 1, **{**SMALL, "replications": 2}))
    noise_v = 1e-5 * np.random.default_rng(2).standard_normal((60, rows.rows))
    found = [
        calibrate(replace(rows, outputs={"y": 0.01 + of_channel}), CalibrationRequest(nominal_axes={"y": "y"}))
        for of_channel in noise_v
    ]
    assert np.mean([calibration.verdict == "not usable" for calibration in found]) > 0.95
    assert "y" not in calibrate(rows, CalibrationRequest()).unusable_axes


def test_interchanged_and_reversed_channels_are_not_usable_and_what_is_declared_is_sound() -> None:
    """x and y change places, or x changes its sign: which of them a direction is, is arithmetic."""
    rows = rows_of_package(campaigns("clean", 0.0, np.random.default_rng(1), 1, **SMALL))
    swapped = replace(rows, outputs={**rows.outputs, "x": rows.outputs["y"], "y": rows.outputs["x"]})
    found = calibrate(swapped, CalibrationRequest())
    assert found.verdict == "not usable"
    assert sorted(found.unusable_axes) == ["x", "y"]
    assert "declared along x, but it reads as y (" in found.unusable_axes["x"]

    turned = {"x": DeclaredDirection("y"), "y": DeclaredDirection("x")}
    assert not calibrate(swapped, CalibrationRequest(declared=turned)).unusable_axes
    reversed_x = replace(rows, outputs={**rows.outputs, "x": -rows.outputs["x"]})
    plain = calibrate(rows, CalibrationRequest()).axes
    signs: dict[str, Literal[1, -1]] = {
        axis: 1 if plain[axis].sensitive_axis_v_per_g["xyz".index(axis)] > 0.0 else -1 for axis in "xyz"
    }
    polar = CalibrationRequest(declared={axis: DeclaredDirection(axis, 1, sign) for axis, sign in signs.items()})
    assert not calibrate(rows, polar).unusable_axes
    assert list(calibrate(reversed_x, polar).unusable_axes) == ["x"]
    assert "polarity reversed" in calibrate(reversed_x, polar).unusable_axes["x"]
    against = CalibrationRequest(declared={"x": DeclaredDirection("x", -1, signs["x"])})
    assert list(calibrate(rows, against).unusable_axes) == ["x"]
    assert any("left-handed" in text for text in calibrate(reversed_x, CalibrationRequest()).remarks) == (
        float(np.prod(list(signs.values()))) > 0.0
    )


@pytest.mark.parametrize("order", ["random", "alternating"], ids=["differs", "always the same"])
def test_a_sensor_that_remembers_where_it_was_turned_from_is_named_with_its_size(order: str) -> None:
    """0.1 mV a g of what it was turned from stays in the output, drawn here and not by the library."""
    chance = np.random.default_rng(3)
    grid = np.array([(p, r) for p in range(-90, 91, 30) for r in range(-180, 180, 45)], dtype=float)
    points = [chance.permutation(len(grid)) for _ in range(4)]
    if order == "alternating":
        points = [points[0]] * 4
    location = np.concatenate(points)
    pitch, roll = np.deg2rad(grid[location]).T
    sensed = 0.002 + 2.5 * np.sin(pitch)
    for kept_v_per_g, named in ((1e-4, True), (0.0, False)):
        before = np.where(np.arange(location.size) % len(grid) == 0, sensed, np.roll(sensed, 1))
        outputs = sensed + kept_v_per_g / 2.5 * (before - sensed) + 2e-5 * chance.normal(size=location.size)
        rows = Observations(np.repeat([1, 2, 3, 4], len(grid)), location + 1, pitch, roll, {"x": outputs})
        found = [
            finding for finding in calibrate(rows, CalibrationRequest()).axes["x"].findings if finding.is_significant
        ]
        remembered = [entry for entry in found if "a dwell remembers the attitude before it" in entry.text]
        assert bool(remembered) == named, found
        for finding in remembered:
            assert finding.kind == "autocorrelation"
            size, uncertainty = (finding.details[name] for name in ("size", "standard_uncertainty"))
            assert isinstance(size, float)
            assert isinstance(uncertainty, float)
            assert abs(size - kept_v_per_g) < 4 * uncertainty < kept_v_per_g


def _robust_of(findings: tuple[Finding, ...]) -> list[Finding]:
    return [entry for entry in findings if entry.details.get("test") == "robust fit"]


@pytest.mark.parametrize(("share", "named"), [(0.0, False), (0.1, True)])
def test_dwells_that_stand_out_a_little_to_one_side_part_a_robust_fit_from_the_estimate(
    share: float, named: bool
) -> None:
    """Three standard deviations up, too little for each to be named by itself; the difference is always told."""
    grid = np.deg2rad([(p, r) for p in range(-90, 91, 15) for r in range(-180, 180, 30)])
    found = []
    for seed in range(3):
        chance = np.random.default_rng(seed)
        pitch, roll = np.tile(grid, (6, 1)).T
        off = 3.0 * (chance.random(pitch.size) < share)
        outputs = 0.002 + 2.5 * np.sin(pitch) + 2e-5 * (chance.normal(size=pitch.size) + off)
        replication, point = np.divmod(np.arange(pitch.size), len(grid))
        rows = Observations(replication + 1, point + 1, pitch, roll, {"x": outputs})
        said = calibrate(rows, CalibrationRequest()).axes["x"].findings
        (robust,) = _robust_of(said)
        assert "by chance ±" in robust.text
        found.append(robust.is_significant)
        table = TableUncertainty(20.0 * RAD_PER_ARCSEC, 20.0 * RAD_PER_ARCSEC, "limit")
        (wide,) = _robust_of(calibrate(rows, CalibrationRequest(table=table)).axes["x"].findings)
        assert wide.is_held or not wide.is_significant, "with a table of 20 arc seconds U holds it"
        assert not (robust.is_significant and robust.is_held), "a tenth at 3 standard deviations moves it beyond U"
    assert found == [named] * 3


def test_a_product_that_attitudes_at_right_angles_never_excite_is_not_told_as_a_number() -> None:
    attitudes = np.deg2rad([(p, r) for p in (-60.0, 0.0, 60.0) for r in (-180.0, -90.0, 0.0, 90.0)] * 3)
    pitch, roll = attitudes.T  # the accelerations by y and z are never there together
    noise = np.random.default_rng(3).normal(0.0, 1e-6, (3, pitch.size))
    outputs = dict(zip("xyz", 1e-3 + 0.5 * specific_force(pitch, roll).T + noise, strict=True))
    replication, point = np.repeat([1, 2, 3], 12), np.tile(np.arange(1, 13), 3)
    solved = calibrate(Observations(replication, point, pitch, roll, outputs), CalibrationRequest())
    sizes = {
        (axis, str(finding.details["test"])): float(finding.details["size"] or 0.0)
        for axis, solved_axis in solved.axes.items()
        for finding in solved_axis.findings
        if finding.kind in ("quadratic", "cross-coupling")
    }
    assert {name for axis, name in sizes if axis == "x"} == {"K2", "Kpp", "Kip", "Kio"}
    assert max(map(abs, sizes.values())) < 1e-3
    assert not {("x", "Kpo"), ("y", "Kip"), ("z", "Kio")} & set(sizes)


def _memories(found: AxisCalibration) -> list[Finding]:
    return [entry for entry in found.findings if entry.is_significant and "remembers the attitudes" in entry.text]


@pytest.mark.parametrize("order", ["there-and-back", "random", "raster-and-back"])
def test_an_after_effect_of_several_dwells_is_told_as_that_with_its_size(order: str) -> None:
    drawn = campaigns("after-effect", 10.0, np.random.default_rng(3), 20, order=order)
    told = [_memories(found) for found in _found(drawn, axis="y")]
    assert np.mean([bool(findings) for findings in told]) >= 0.9
    sizes = [
        1e6 * abs(finding.details["size"]) / 2.5
        for findings in told
        for finding in findings
        if "about 3" in finding.text
    ]
    assert np.median(sizes) == pytest.approx(10.0, rel=0.25)
    assert np.mean(["3 dwells" in finding.text for findings in told for finding in findings]) >= 0.9
    assert not any("is contained" in finding.text for findings in told for finding in findings)


@pytest.mark.parametrize("order", ["there-and-back", "raster-and-back"])
def test_three_outputs_tell_together_what_none_of_them_tells_alone(order: str) -> None:
    drawn = campaigns("after-effect", 5.0, np.random.default_rng(4), 20, order=order)
    axes, every = drawn.setup.axes, range(drawn.campaigns)
    alone = np.array([["autocorrelation" in _kinds(found) for found in _found(drawn, axis=axis)] for axis in axes])
    packages = [calibrate(rows_of_package(drawn, index), CalibrationRequest()).axes for index in every]
    together = np.array([["autocorrelation" in _kinds(package[axis]) for package in packages] for axis in axes])
    assert together.all(axis=0).mean() >= 0.75
    told = [entry for package in packages for found in package.values() for entry in _memories(found)]
    numbers = [(entry.details["size"], entry.details["standard_uncertainty"]) for entry in told]
    assert all(abs(float(size or 0.0)) > 3.0 * float(u or 0.0) for size, u in numbers)  # what is told is what rang
    assert any("show it together" in entry.text for entry in told)
    assert alone.all(axis=0).mean() < 0.5


@pytest.mark.parametrize("order", ["there-and-back", "random"])
def test_one_output_that_remembers_is_not_told_of_the_others(order: str) -> None:
    """What one of them shows was told of all, as large as theirs is by chance: 3.3 ± 8.9 µg a g."""
    drawn = campaigns("clean", 0.0, np.random.default_rng(6), 1, order=order)
    rows = rows_of_package(drawn)
    assert rows.time_s is not None
    force, kept = specific_force(rows.pitch_rad, rows.roll_rad)[:, 0], np.exp(-1.0 / 3.0)
    shown, still = np.zeros(rows.rows), np.zeros(rows.rows)
    in_time = np.argsort(rows.time_s)
    shown[in_time[0]] = force[in_time[0]]
    for before, now in pairwise(in_time.tolist()):
        shown[now] = force[now] + (shown[before] - force[now]) * kept
        still[now] = shown[now] - force[now]
    creeping = {**rows.outputs, "x": rows.outputs["x"] + 2.5 * 30e-6 * still}
    solved = calibrate(replace(rows, outputs=creeping), CalibrationRequest())
    assert {axis: "autocorrelation" in _kinds(found) for axis, found in solved.axes.items()} == {
        "x": True, "y": False, "z": False,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("scene", "size"), [("drift-sensitivity", 10.0), ("drift-replications", 1.0), ("drift-walk", 2.0)]
)
def test_a_drift_of_the_replications_is_no_memory_of_what_alternates(scene: str, size: float) -> None:
    drawn = campaigns(scene, size, np.random.default_rng(8), 40, order="raster-and-back")
    found = _found(drawn, axis="y")
    assert np.mean(["drift" in _kinds(entry) for entry in found]) >= 0.9
    assert np.mean([bool(_memories(entry)) for entry in found]) <= 0.05


def test_nothing_is_usable_with_what_the_outputs_remember() -> None:
    drawn = campaigns("after-effect", 10.0, np.random.default_rng(5), 1, order="raster-and-back")
    solved = calibrate(rows_of_package(drawn), CalibrationRequest())
    assert solved.verdict == "not usable"
    assert all(
        any("stated uncertainties only a limit that is declared" in said.text for said in axis.findings)
        for axis in solved.axes.values()
    )


@pytest.mark.parametrize("order", ["there-and-back", "random"])
@pytest.mark.parametrize(("along", "size"), [(2, 150e-6), (2, 1e-3), (3, 500e-6)])
def test_a_bend_is_no_transient_and_no_temperature(order: str, along: int, size: float) -> None:
    """A large bend shows in part in every column of the points; it is told first, and the others beside it."""
    drawn = campaigns("use-good", 0.0, np.random.default_rng(7), 1, order=order).calibration
    rows = rows_of_package(drawn)
    bent = {
        axis: values + size * (values / 2.5) ** along if axis == "y" else values
        for axis, values in rows.outputs.items()
    }
    temperature = 20.0 + 0.02 * np.random.default_rng(8).standard_normal(rows.rows)
    solved = calibrate(replace(rows, outputs=bent, temperature_degc=temperature), CalibrationRequest())
    told = {finding.kind for finding in solved.axes["y"].findings if finding.is_significant}
    assert {"quadratic" if along == 2 else "cubic"} <= told <= {"quadratic", "cubic"}
    assert solved.verdict == "usable"
