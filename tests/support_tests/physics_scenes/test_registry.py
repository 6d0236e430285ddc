"""Laws that every scene obeys."""

import ast
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import physics_scenes
import pytest
from physics_scenes import CAUSES, SCENES, campaigns, scene
from physics_scenes.rotations import ARCSEC, specific_force
from physics_scenes.world import draw_campaign

FAMILIES = ("table", "soft-mount", "k", "dwell", "temperature", "drift", "slip", "fixture", "use", "field", "gyro")


def readings(drawn) -> np.ndarray:
    """All that the laboratory is given, as one row of numbers a campaign."""
    if hasattr(drawn, "calibration"):
        drawn = drawn.use
    if hasattr(drawn, "use_v"):
        parts = [drawn.use_v, drawn.calibration_v]
    elif hasattr(drawn, "counts"):
        parts = [drawn.counts]
    else:
        parts = [drawn.output_v]
    return np.concatenate([part.reshape(part.shape[0], -1) for part in parts], axis=1)


def drawn(name: str, size: float, count: int = 2, seed: int = 5):
    return campaigns(name, size, np.random.default_rng(seed), count, replications=2)


def test_every_entry_is_complete():
    for name, entry in SCENES.items():
        assert entry.name == name
        assert len(entry.physics) > 40, name
        assert list(entry.sizes) == sorted(set(entry.sizes)), name
        assert entry.sizes[0] == 0.0 or not entry.zero_is_clean, name
        assert {entry.true_cause, *entry.also} <= {None, *CAUSES}, name
        assert entry.is_declared(0.0), name


@pytest.mark.parametrize("name", [name for name, entry in SCENES.items() if entry.zero_is_clean])
def test_a_scene_of_size_nothing_is_the_clean_campaign(name):
    entry = SCENES[name]
    clean = replace(entry, build=lambda world, size, chance: world)
    ours, theirs = (each.draw(0.0, np.random.default_rng(5), 2, replications=2) for each in (entry, clean))
    np.testing.assert_allclose(readings(ours), readings(theirs), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", [name for name, entry in SCENES.items() if len(entry.sizes) > 1])
def test_a_scene_grows_with_its_size(name):
    """With the same sensors and noise: the largest size is far from the smallest, and none lies much behind."""
    every = SCENES[name].sizes
    sizes = every if len(every) < 5 else (every[0], every[len(every) // 3], every[2 * len(every) // 3], every[-1])
    start = readings(drawn(name, sizes[0]))
    if name in ("gyro-missing-samples", "gyro-dropout"):
        changes = [np.isnan(readings(drawn(name, size))).mean() for size in sizes]
    elif name == "sting-without-yaw":
        changes = [np.ptp(drawn(name, size).calibration_euler_deg[:, 1]) for size in sizes]
    else:
        changes = [np.sqrt(np.mean((readings(drawn(name, size)) - start) ** 2)) for size in sizes]
    assert changes[0] == 0.0
    assert changes[-1] > 0.0
    assert all(late >= 0.9 * early for early, late in pairwise(changes))


def is_counted(name: str) -> bool:
    """Whether the size counts gross errors, each of them obvious."""
    return SCENES[name].unit == "dwells" or name == "outlier-share"


def seen(name: str, size: float) -> np.ndarray:
    """(campaigns) what is left of a scene outside of offset and sensitivities, in squares of a dwell's noise, of the
    axis that shows most: the non-centrality of the best possible test that knows the noise.
    """
    clean, happened = (campaigns(name, each, np.random.default_rng(5), 3) for each in (0.0, size))
    noise_v = 1.65 * ARCSEC * clean.package.sensitivity_v_per_g[:, None]
    rows = clean.schedule.rows("point")
    change = ((happened.output_v - clean.output_v) / noise_v)[:, rows]
    force = specific_force(np.deg2rad(clean.schedule.pitch_deg[rows]), np.deg2rad(clean.schedule.roll_deg[rows]))
    basis = np.linalg.qr(np.concatenate([np.ones((rows.size, 1)), force], axis=1))[0]
    fitted = np.einsum("ki,li,nlsa->nksa", basis, basis, change, optimize=True)
    return ((change - fitted) ** 2).sum(axis=1).max(axis=(1, 2))


@pytest.mark.parametrize(
    "name",
    [
        name
        for name, entry in SCENES.items()
        if entry.draws is draw_campaign and entry.true_cause and not is_counted(name)
    ],
)
def test_sizes_go_from_nothing_through_the_threshold_to_obvious(name):
    """A test at 5 % finds half of what has a non-centrality of 4, and nearly all of 25."""
    sizes = SCENES[name].sizes
    assert np.median(seen(name, sizes[1])) < 10.0
    assert np.median(seen(name, sizes[-1])) > 50.0


def test_a_size_that_was_declared_is_no_finding():
    assert SCENES["table-once"].causes(1.0) == ()
    assert SCENES["table-once"].causes(2.0) == ("lack-of-fit",)
    assert SCENES["k2"].causes(0.0) == ()
    assert SCENES["k2"].causes(1.0)[0] == "quadratic"
    assert SCENES["temperature-room"].causes(1.0) == ()


@pytest.mark.parametrize("name", SCENES)
def test_the_same_seed_draws_the_same_and_another_another(name):
    size = SCENES[name].sizes[-1]
    first, again, other = (readings(drawn(name, size, 2, seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first[np.isfinite(first)][:50], other[np.isfinite(other)][:50])
    assert not np.array_equal(first[0], first[1])


def test_one_generator_draws_one_campaign_after_the_other():
    chance = np.random.default_rng(1)
    first, second = (readings(scene("clean", 0.0, chance, replications=2)) for _ in range(2))
    assert not np.array_equal(first, second)


def test_every_family_of_the_physics_is_there():
    for family in FAMILIES:
        assert any(family in name for name in SCENES), family
    assert {entry.true_cause for entry in SCENES.values()} - {None} == set(CAUSES)


def test_an_unknown_scene_is_refused_with_those_that_there_are():
    with pytest.raises(KeyError, match="table-once"):
        scene("table-thrice", 1.0, np.random.default_rng(1))


def test_the_scenes_know_nothing_of_calrig():
    for file in Path(physics_scenes.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                known = {"numpy", "physics_scenes", "dataclasses", "functools", "collections", "types", "typing"}
                assert name.split(".")[0] in known, (file, name)
