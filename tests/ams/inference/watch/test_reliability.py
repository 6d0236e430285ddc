"""What rows do not show of their outputs: errors of the size that is told are found as often as is told.

Held against Baarda's noncentrality where his test is the same, and against simulated files elsewhere.
"""

from statistics import NormalDist

import numpy as np
import pytest
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, accelerometer_v
from package_outputs import TRUTH, output_v
from solved_sets import SITE, package_set, tp_set

from ams.attitude import flag_codes
from ams.frames import specific_force
from ams.inference.inference import Inference, Package, inference
from ams.inference.package.alignment import Alignment
from ams.inference.watch.faulted_rows import FaultedRows
from ams.inference.watch.reliability import AngleChange, Unseen, UnseenError, unseen_errors, unseen_of
from ams.inference.watch.reliability_words import unseen_in_words
from ams.inference.watch.watched_axes import WatchedAxes
from ams.sets.coefficients import CoefficientSet

SD_V = 2e-5
SETS = 30
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}
MODEL_COLUMNS = {axis: f"model_{axis}_v" for axis in "xyz"}
SHORT_DEG = [(pitch, 0.3, 0.0) for pitch in np.linspace(-4.0, 4.0, 8)]
WIDE_DEG = [(pitch, 12.0 * np.sin(pitch), 3.0 * pitch) for pitch in np.linspace(-30.0, 25.0, 8)]


def of_one(attitudes: list[tuple[float, float]]) -> dict[str, np.ndarray]:
    return {f"{a}_v": np.array([output_v(a, TRUTH[a], *at) for at in attitudes]) for a in "xyz"}


def of_two(eulers: list[tuple[float, float, float]]) -> dict[str, np.ndarray]:
    sting = {COLUMNS[a]: [accelerometer_v(a, TABLE_3_STING[a], e, "sting") for e in eulers] for a in "xyz"}
    model = {MODEL_COLUMNS[a]: [accelerometer_v(a, TABLE_3_MODEL[a], e, "model") for e in eulers] for a in "xyz"}
    return {name: np.array(values) for name, values in (sting | model).items()}


def by_two(site: tuple[float, float] | None = None) -> Inference:
    packages = (Package(package_set("sting"), COLUMNS), Package(package_set("model"), MODEL_COLUMNS))
    if site is not None:
        packages = tuple(Package(p.coefficients, p.columns, site[0], None, site[1]) for p in packages)
    return inference(*packages, SD_V)


def by_one(coefficients: CoefficientSet, sd_v: float = SD_V) -> Inference:
    return inference(Package(coefficients, COLUMNS), None, sd_v)


def column_of(output: UnseenError) -> str:
    return (MODEL_COLUMNS if output.package == "model" else COLUMNS)[output.axis]


def flagged(angles: Inference, read: dict[str, np.ndarray]) -> np.ndarray:
    return (angles.answer(read).codes & flag_codes.REDUNDANCY) != 0


def test_one_row_of_one_package_is_baardas_test() -> None:
    """δ₀ = z(99.95 %) + z(95 %) = 4.94, an error of δ₀ σ(r)/|∂r/∂v|; his table has 4.13 for 80 %."""
    angles, read = by_one(tp_set()), of_one([(25.0, 40.0)])
    found = unseen_errors(angles, read, np.random.default_rng(1))
    assert found is not None
    noncentrality = NormalDist().inv_cdf(0.9995) + NormalDist().inv_cdf(0.95)
    k = np.stack([numbers.direction_v_per_g for numbers in tp_set().axes.values()])
    slopes = np.linalg.inv(k).T @ specific_force(*np.deg2rad([[25.0], [40.0]]))[0]
    for output, slope in zip(found.outputs, slopes, strict=True):
        assert output.found_v == pytest.approx(noncentrality * SD_V * np.linalg.norm(slopes) / abs(slope), rel=0.05)
        assert output.dead_found_share == 1.0


@pytest.mark.parametrize("eulers", [SHORT_DEG, WIDE_DEG, [(12.0, 6.0, 20.0)]], ids=["short", "wide", "row"])
@pytest.mark.parametrize("site", [None, (SITE["gravity_mps2"] * 1.001, 0.003)], ids=["calibrated", "elsewhere"])
def test_errors_of_two_packages_are_found_as_often_as_is_told(
    eulers: list[tuple[float, float, float]], site: tuple[float, float] | None
) -> None:
    angles, clean, chance, files = by_two(site), of_two(eulers), np.random.default_rng(5), 150
    if site is not None:
        for table, columns in ((TABLE_3_STING, COLUMNS), (TABLE_3_MODEL, MODEL_COLUMNS)):
            clean |= {c: table[a][0] + (clean[c] - table[a][0]) * 1.001 for a, c in columns.items()}
    found = unseen_errors(angles, clean, chance)
    assert found is not None
    assert [(output.package, output.axis) for output in found.outputs] == [
        (p, a) for p in ("sting", "model") for a in "xyz"
    ]
    found_shares, smaller_shares = [], []
    for output in found.outputs:
        shares = []
        for error_v in (output.found_v, -output.found_v, 0.4 * output.found_v, -0.4 * output.found_v):
            gravity = 1.0 + (0.0 if site is None else site[1] / site[0]) * chance.standard_normal((files, 1))
            read = {}
            for table, columns in ((TABLE_3_STING, COLUMNS), (TABLE_3_MODEL, MODEL_COLUMNS)):
                for axis, column in columns.items():
                    true_v = table[axis][0] + (clean[column] - table[axis][0]) * gravity
                    read[column] = (true_v + SD_V * chance.standard_normal(true_v.shape)).ravel()
            read[column_of(output)] += error_v
            shares.append(flagged(angles, read).reshape(files, -1).any(axis=1).mean())
        smaller_shares.append(min(shares[2:]))
        # Where an axis lies level, the two signs of its error are found at different sizes.
        found_shares.append(min(shares[:2]))
    assert found_shares == pytest.approx([0.95] * 6, abs=0.06)
    assert np.mean(found_shares) == pytest.approx(0.95, abs=0.025)
    assert np.median(smaller_shares) < 0.6


@pytest.mark.parametrize(
    ("calibration_sd_v", "sd_v", "roll_deg"), [(2e-5, 2e-5, 0.5), (1e-4, 1e-5, 0.5), (1e-4, 1e-5, 40.0)]
)
def test_what_calibrations_are_wrong_by_in_all_rows_alike_is_counted(
    calibration_sd_v: float, sd_v: float, roll_deg: float
) -> None:
    """Of many calibrations a file of eight rows: with independent rows the errors told would be too small."""
    chance = np.random.default_rng(3)
    clean = of_one([(pitch, roll_deg) for pitch in np.linspace(-4.0, 4.0, 8)])
    shares, dead = [], []
    for _ in range(SETS):
        angles = by_one(tp_set(noise_v=calibration_sd_v, chance=chance), sd_v)
        read = {name: values + sd_v * chance.standard_normal(8) for name, values in clean.items()}
        found = unseen_errors(angles, read, chance)
        assert found is not None
        for output in found.outputs:
            column, error_v = column_of(output), output.found_v
            shifted = [flagged(angles, read | {column: read[column] + e}).any() for e in (error_v, -error_v)]
            silent = read | {column: TRUTH[output.axis][0] + sd_v * chance.standard_normal(8)}
            shares.append(shifted)
            dead.append([flagged(angles, silent).any(), output.dead_found_share])
    assert np.mean(shares, axis=0).min() == pytest.approx(0.95, abs=0.05)
    by_axis = np.mean(np.reshape(dead, (SETS, 3, 2)), axis=0)
    assert by_axis[:, 0] == pytest.approx(by_axis[:, 1], abs=0.25)
    assert (by_axis[1, 1] < 0.95) == (roll_deg < 1.0)


@pytest.mark.parametrize("is_aligned", [False, True])
def test_angles_are_off_by_what_is_told(*, is_aligned: bool) -> None:
    turned = Alignment("TP1", np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]]), 1e-8 * np.eye(3), 9, 0.01)
    alone = Package(tp_set(), COLUMNS, alignment=turned if is_aligned else None)
    scenes = [(inference(alone, None, SD_V), of_one([(5.0, 12.0), (-20.0, 30.0)]))]
    if not is_aligned:
        unequal = tp_set(noise_v=1e-3, chance=np.random.default_rng(4))
        scenes += [(by_two(), of_two(WIDE_DEG)), (by_two(), of_two(SHORT_DEG))]
        scenes += [(by_one(unequal, 1e-6), of_one([(5.0, 12.0), (-20.0, 30.0)]))]
    for angles, clean in scenes:
        found, right = unseen_errors(angles, clean, np.random.default_rng(2)), angles.answer(clean).columns
        assert found is not None
        for output in found.outputs:
            column = column_of(output)
            off = [angles.answer(clean | {column: clean[column] + sign * output.found_v}).columns for sign in (1, -1)]
            for change in output.changes:
                told = right[f"{change.angle}_deg"]
                apart = [np.abs((wrong[f"{change.angle}_deg"] - told + 180.0) % 360.0 - 180.0) for wrong in off]
                assert np.nanmax(apart) == pytest.approx(change.change_deg, rel=1e-3, abs=1e-7)
                row = int(np.argmax(np.nanmax(apart, axis=0)))
                stated = 2.0 * right[f"{change.angle}_sd_deg"][row]
                assert change.expanded_uncertainty_deg == pytest.approx(stated, rel=0.05)


@pytest.mark.parametrize("site", [None, (SITE["gravity_mps2"] * 1.001, 0.003)], ids=["calibrated", "elsewhere"])
def test_what_is_drawn_has_the_covariance_that_the_test_counts(site: tuple[float, float] | None) -> None:
    """In whitened coordinates that is one, of every part together and of gravity that two packages have in common."""
    scenes = [
        (by_two(site), of_two(WIDE_DEG)),
        (by_one(tp_set(noise_v=1e-4, chance=np.random.default_rng(4))), of_one([(9.0, 40.0)])),
    ]
    for angles, read in scenes:
        drawn = FaultedRows(angles, read).noise(6000, np.random.default_rng(1))
        for row in drawn:
            assert np.atleast_2d(np.cov(row)) == pytest.approx(np.eye(len(row)), abs=0.12)


def test_more_rows_show_smaller_errors_and_level_axes_show_them_last() -> None:
    few = unseen_errors(by_two(), of_two(SHORT_DEG), np.random.default_rng(1))
    many = unseen_errors(
        by_two(), of_two([(12.0 + p, 9.0, 20.0 + p) for p, _, _ in SHORT_DEG]), np.random.default_rng(1)
    )
    assert few is not None
    assert many is not None
    for level, away in zip(few.outputs, many.outputs, strict=True):
        assert level.found_arcsec > (3.0 if level.axis == "y" else 0.9) * away.found_arcsec
    assert few.outputs[1].is_dead_unseen
    assert not few.outputs[0].is_dead_unseen


def test_what_is_proven_wrong_and_what_nothing_tests_has_no_such_limit() -> None:
    clean, chance = of_one([(p, 2.0 * p) for p in np.linspace(-30.0, 30.0, 40)]), np.random.default_rng(1)
    two = inference(Package(tp_set(), {a: COLUMNS[a] for a in "xy"}), None, SD_V)
    assert unseen_errors(two, clean, chance) is None
    for factor, is_told in ((1.0, True), (1.05, False)):
        watched = WatchedAxes(by_one(tp_set()))
        watched.answer(clean | {"z_v": factor * clean["z_v"]})
        watched.finish()
        assert (unseen_of(watched, chance) is not None) == is_told
    empty = {name: np.full(4, np.nan) for name in clean}
    assert unseen_errors(by_one(tp_set()), empty, chance) is None


def test_words_name_what_is_beyond_the_stated_uncertainty_and_else_one_figure() -> None:
    def of(axis: str, change_deg: float, dead_share: float = 1.0) -> UnseenError:
        changes = (AngleChange("pitch", 0.1 * change_deg, 0.004), AngleChange("roll", change_deg, 0.004))
        return UnseenError("SN1", "model", axis, 1e-4, 35.2, changes, dead_share, changes)

    said = unseen_in_words(Unseen(8, (of("x", 0.01), of("y", 0.02, 0.3), of("z", 0.03))))
    assert said.startswith("SN1: what 8 rows do not show (an error of one output that has no flag in 5 % of such files")
    assert "up to 35″ of z of the model package, roll off by up to 0.03° (stated ±0.004°, k = 2); a dead y" in said
    assert "a dead y of the model package (no flag in 70 %), roll off by up to 0.02°" in said
    assert "pitch" not in said
    quiet = unseen_in_words(Unseen(1, (of("x", 0.001), of("y", 0.0031))))
    assert quiet.startswith("SN1: what 1 row does not show: ")
    assert "turns no angle by more than 0.0031°, which is within what is stated" in quiet
