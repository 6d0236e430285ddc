"""A package that sits askew in its model: the rotation comes back, and angles are the model's, with honest spread."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from solved_sets import bent_set, gyro_set, tp_set

from ams.errors import DesignError, OutsideValidity, SetError
from ams.frames import specific_force
from ams.inference.inference import Inference, Package
from ams.inference.package.alignment import Alignment, load_alignment, solve_alignment, store_alignment
from ams.sets.canonical import render, with_checksum
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import predicted_v

ASKEW = Rotation.from_rotvec(np.deg2rad([0.8, -1.5, 2.5]))
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}
PITCH_DEG, ROLL_DEG = np.array([-20.0, 0.0, 15.0, 5.0, -5.0]), np.array([0.0, 30.0, -45.0, 90.0, 170.0])


def readings(coefficients: CoefficientSet, chance: np.random.Generator | None = None, sd_v: float = 0.0) -> dict:
    """Return what a package reads that sits askew in a model at known attitudes."""
    force = ASKEW.inv().apply(specific_force(np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG)))
    noise = np.zeros((3, PITCH_DEG.size)) if chance is None else sd_v * chance.normal(size=(3, PITCH_DEG.size))
    return {
        f"{axis}_v": predicted_v(solved_axis, force, None) + noise[index]
        for index, (axis, solved_axis) in enumerate(coefficients.axes.items())
    }


def solved(coefficients: CoefficientSet, expected: dict) -> Alignment:
    found = Inference(Package(coefficients, COLUMNS), reading_sd_v=1e-4).answer(expected).columns
    angles = np.deg2rad(found["pitch_deg"]), np.deg2rad(found["roll_deg"])
    return solve_alignment(coefficients.sensor, angles, (np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG)))


@pytest.mark.parametrize("make", [tp_set, bent_set])
def test_known_attitudes_tell_the_rotation_and_the_model_s_angles_come_back(make: object, tmp_path: Path) -> None:
    coefficients = make()  # type: ignore[operator]
    said = readings(coefficients)
    alignment = solved(coefficients, said)
    assert alignment.rotation == pytest.approx(ASKEW.as_matrix(), abs=1e-9)
    store_alignment(alignment, tmp_path / "a.json")
    again = load_alignment(tmp_path / "a.json")
    found = Inference(Package(coefficients, COLUMNS, alignment=again), reading_sd_v=1e-4).answer(said).columns
    assert found["pitch_deg"] == pytest.approx(PITCH_DEG, abs=1e-8)
    assert found["roll_deg"] == pytest.approx(ROLL_DEG, abs=1e-8)


def test_the_spread_of_the_model_s_angles_holds_that_of_the_alignment() -> None:
    """Draws of noise in the known attitudes alone: the angles' errors are as large as their standard deviation says."""
    chance, coefficients, ratios = np.random.default_rng(9), tp_set(), []
    clean = readings(coefficients)
    for _ in range(60):
        alignment = solved(coefficients, readings(coefficients, chance, 2e-3))
        package = Package(coefficients, COLUMNS, alignment=alignment)
        found = Inference(package, reading_sd_v=1e-9).answer(clean).columns
        for angle, true in (("pitch", PITCH_DEG), ("roll", ROLL_DEG)):
            ratios.append((found[f"{angle}_deg"] - true) / found[f"{angle}_sd_deg"])
    assert float(np.mean(np.square(ratios))) == pytest.approx(1.0, abs=0.45)  # Student's t of seven: 1.4


def askew_reference(sd_deg: float, chance: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return what a reference that sits askew on the model takes its attitudes for: one small turn in all of them."""
    turn = Rotation.from_rotvec(np.deg2rad(sd_deg) * chance.normal(size=3))
    x, y, z = turn.apply(specific_force(np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG))).T
    return np.arcsin(x), np.arctan2(-y, -z)


def ratios(known_sd_rad: float | None, sd_deg: float, draws: int) -> np.ndarray:
    """Return the model's angles' errors over their standard deviations, and whether their 95 % intervals hold."""
    chance, coefficients, found = np.random.default_rng(4), tp_set(), []
    clean = readings(coefficients)
    for _ in range(draws):
        told = Inference(Package(coefficients, COLUMNS), reading_sd_v=1e-9).answer(
            readings(coefficients, chance, 2e-4)
        ).columns  # fmt: skip
        angles = np.deg2rad(told["pitch_deg"]), np.deg2rad(told["roll_deg"])
        known = askew_reference(sd_deg, chance)
        package = Package(
            coefficients, COLUMNS, alignment=solve_alignment(coefficients.sensor, angles, known, known_sd_rad)
        )
        model = Inference(package, reading_sd_v=1e-9, intervals=True).answer(clean).columns
        found += [
            [(model[f"{angle}_deg"] - true) / model[f"{angle}_{divisor}_deg"] for divisor in ("sd", "half_95")]
            for angle, true in (("pitch", PITCH_DEG), ("roll", ROLL_DEG))
        ]
    return np.array(found)


@pytest.mark.parametrize("draws", [80, pytest.param(600, marks=pytest.mark.thorough)])
def test_what_the_known_attitudes_have_in_common_is_in_the_angles_spread(draws: int) -> None:
    """A reference that sits 0.05° askew about each axis, scatter of 0.005°: a turn of the model that no scatter tells.

    The five attitudes of a draw hang together by three angles.
    """
    by_sd, by_half = np.moveaxis(ratios(np.deg2rad(0.05), 0.05, draws), 1, 0)
    assert float(np.mean(np.square(by_sd))) == pytest.approx(1.0, abs=4.0 / np.sqrt(draws))
    assert np.mean(np.abs(by_half) <= 1.0) == pytest.approx(0.95, abs=0.5 / np.sqrt(draws))
    silent = ratios(None, 0.05, 20)
    assert np.mean(np.abs(silent[:, 1]) <= 1.0) < 0.4, "without it the intervals hold nothing"


def test_what_is_stated_of_the_known_attitudes_is_stored_and_older_files_state_nothing(tmp_path: Path) -> None:
    path, alignment = tmp_path / "a.json", solved(tp_set(), readings(tp_set()))
    store_alignment(replace(alignment, known_sd_rad=np.deg2rad(0.02)), path)
    assert load_alignment(path).known_sd_rad == pytest.approx(np.deg2rad(0.02), rel=1e-12)
    document = {name: value for name, value in alignment.document().items() if name not in ("known_sd_deg", "checksum")}
    path.write_bytes(render(with_checksum({**document, "version": 1})))
    assert load_alignment(path).known_sd_rad is None


def test_what_cannot_be_aligned_is_a_sentence(tmp_path: Path) -> None:
    level = np.zeros(3)
    with pytest.raises(DesignError, match="do not tell the rotation about every axis"):
        solve_alignment("S", (level, level), (level, level))
    with pytest.raises(DesignError, match="got 1 known attitudes, needed two or more"):
        solve_alignment("S", (level[:1], level[:1]), (level[:1], level[:1]))
    alignment = replace(solved(tp_set(), readings(tp_set())), sensor="G1")
    with pytest.raises(OutsideValidity, match="turns three accelerometers"):
        Package(gyro_set(), COLUMNS, alignment=alignment)
    with pytest.raises(OutsideValidity, match="alignment: is that of G1"):
        Package(tp_set(), COLUMNS, alignment=alignment)
    path = tmp_path / "a.json"
    store_alignment(alignment, path)
    path.write_bytes(path.read_bytes().replace(b'"G1"', b'"G2"'))
    with pytest.raises(SetError, match="checksum: does not fit the content"):
        load_alignment(path)
    path.write_text("{}")
    with pytest.raises(SetError, match="is no alignment of this version"):
        load_alignment(path)
