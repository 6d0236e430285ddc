"""A package that sits askew in its model: the rotation comes back, and angles are the model's, with honest spread."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from solved_sets import bent_set, gyro_set, tp_set

from ams.errors import DesignError, OutsideValidity, SetError
from ams.frames import specific_force
from ams.inference.alignment import Alignment, load_alignment, solve_alignment, store_alignment
from ams.inference.inference import Inference, Package
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
