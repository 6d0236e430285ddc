"""What a sting's set leaves uncertain is in the model package that was calibrated against it: CR's second step.

The truth is drawn here and the outputs are made from it by rotations of their own. The sting is calibrated with twenty
times the noise with which it is read afterwards, so that nearly all that the model package's coefficients are wrong by
is what the sting's set is wrong by.
"""

import itertools
from pathlib import Path

import numpy as np
import pytest
from command import call
from cr_outputs import write_rows

AXES = ("--axis", "x=x_v", "--axis", "y=y_v", "--axis", "z=z_v")
NOISE = 8e-6
"""Of a reading, as part of the sensitivity."""
LOUDER = 20.0
STING_ANGLES_DEG = list(itertools.product(np.linspace(-30.0, 30.0, 5), repeat=2))
MODEL_ANGLES_DEG = list(itertools.product((-30.0, 0.0, 30.0), (-20.0, 0.0, 20.0), (-180.0, -108.0, -36.0, 36.0, 108.0)))
SEEDS = range(1, 7)


def gravity_g(pitch_deg: float, yaw_deg: float, roll_deg: float) -> np.ndarray:
    """(3,) gravity in the axes of a package: turned about y, then z, then x."""
    (p, y, r), zero = np.deg2rad([pitch_deg, yaw_deg, roll_deg]), 0.0
    about_y = np.array([[np.cos(p), zero, -np.sin(p)], [zero, 1.0, zero], [np.sin(p), zero, np.cos(p)]])
    about_z = np.array([[np.cos(y), np.sin(y), zero], [-np.sin(y), np.cos(y), zero], [zero, zero, 1.0]])
    about_x = np.array([[1.0, zero, zero], [zero, np.cos(r), np.sin(r)], [zero, -np.sin(r), np.cos(r)]])
    return about_x @ about_z @ about_y @ np.array([0.0, 0.0, 1.0])


def package(chance: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """(3,) offsets, volts, and (3, 3) sensitivities, volts per g, of sensors some degrees beside x, y and z."""
    along = np.eye(3) + 0.03 * chance.standard_normal((3, 3))
    k = chance.uniform(0.5, 3.0, 3)[:, None] * along / np.linalg.norm(along, axis=1)[:, None]
    return 0.2 * chance.standard_normal(3), k


def read_v(
    truth: tuple[np.ndarray, np.ndarray], gravity: np.ndarray, noise: float, chance: np.random.Generator
) -> list:
    offset, k = truth
    size = np.linalg.norm(k, axis=1)
    return [float(value) for value in offset + k @ gravity + noise * size * chance.standard_normal(3)]


def second_step(folder: Path, seed: int, capsys: pytest.CaptureFixture[str]) -> tuple[dict, np.ndarray]:
    """Return the document of a model package against its sting, and (3, 2) the true offsets and sensitivities."""
    chance = np.random.default_rng(seed)
    sting, model = package(chance), package(chance)
    rows, both = [], []
    for replication in range(1, 5):
        for point, (pitch, yaw) in enumerate(STING_ANGLES_DEG, start=1):
            volts = read_v(sting, gravity_g(pitch, yaw, 0.0), LOUDER * NOISE, chance)
            rows.append([replication, point, float(pitch), float(yaw), *volts])
        for point, (pitch, yaw, roll) in enumerate(MODEL_ANGLES_DEG, start=1):
            volts = read_v(model, gravity_g(pitch, yaw, roll), NOISE, chance)
            told = read_v(sting, gravity_g(pitch, yaw, 0.0), NOISE, chance)
            both.append([replication, point, roll, *volts, *told])
    outputs, of_sting = ("x_v", "y_v", "z_v"), ("sting_x_v", "sting_y_v", "sting_z_v")
    first = write_rows(folder / "sting.csv", ["pitch_deg", "yaw_deg", *outputs], rows)
    second = write_rows(folder / "model.csv", ["roll_deg", *outputs, *of_sting], both)
    fit = ("--model", "pitch-yaw-roll", "--package")
    where = ("--set", folder / "sting.json", "--sensor", "ST", "--gravity-mps2", "9.8")
    call(capsys, "fit", first, *fit, "sting", *AXES, *where)
    document = call(capsys, "fit", second, *fit, "model", "--sting", folder / "sting.json", *AXES, "--json").document
    return document, np.column_stack([model[0], np.linalg.norm(model[1], axis=1)])


def test_a_model_package_is_as_uncertain_as_the_sting_that_it_is_calibrated_against(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found, deviations = [], []
    for seed in SEEDS:
        document, truth = second_step(tmp_path, seed, capsys)
        for axis, true in zip("xyz", truth, strict=True):
            solved = document["axes"][axis]
            pairs = zip(("offset_v", "sensitivity_v_per_g"), true, strict=True)
            estimates = [(solved["parameters"][name], value) for name, value in pairs]
            deviations.append([(e["value"] - value) / e["standard_uncertainty"] for e, value in estimates])
            found += [(seed, axis, entry["kind"]) for entry in solved["findings"] if entry["significant"]]
    rms = np.sqrt(np.mean(np.square(deviations), axis=0))
    assert (rms > 0.5).all(), rms
    assert (rms < 1.5).all(), rms
    assert len({seed for seed, *_ in found}) <= 1, found
    budgets = [document["axes"][axis]["budget"] for axis in "xyz"]
    for budget, estimates in zip(budgets, (document["axes"][axis]["parameters"] for axis in "xyz"), strict=True):
        lines = {line["source"]: line["standard_uncertainty"]["sensitivity_v_per_g"] for line in budget["lines"]}
        assert lines["calibration of the sting package"] > 0.0
        whole = estimates["sensitivity_v_per_g"]["standard_uncertainty"]
        assert np.linalg.norm(list(lines.values())) == pytest.approx(whole, rel=1e-9)
