"""Scenes of drift: one sensor's axes change with time, each on its own, by sizes in arc seconds of the offset."""

from dataclasses import replace

import numpy as np

from physics_scenes.rotations import ARCSEC, FloatArray
from physics_scenes.scene import Scene
from physics_scenes.world import World, centred, chosen_event, since_event


def linear(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset drifts evenly with time by the size over the run, either way; the truth is the mean of the run."""
    return _added(world, size * _signs(world, chance) * _deviation_alone(world.schedule.run_phase()[None]))


def per_replication(world: World, size: float, chance: np.random.Generator) -> World:
    """Each replication has an offset of its own, normal with the size; the truth is what they scatter about."""
    levels = chance.standard_normal((world.campaigns, world.setup.replications, *world.shape[2:]))
    return _added(world, size * levels[:, np.maximum(world.schedule.replication, 0)])


def per_replication_gain(world: World, size: float, chance: np.random.Generator) -> World:
    """Each replication has a sensitivity of its own, normal with the size in ppm about the truth (TP's drift of S)."""
    levels = chance.standard_normal((world.campaigns, world.setup.replications, *world.shape[2:]))
    change = size * 1e-6 * levels[:, np.maximum(world.schedule.replication, 0)]
    return replace(world, gain=world.gain * (1.0 + change))


def step(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset of every axis jumps once, by the size, at one dwell; the truth is the mean of the run."""
    event = chosen_event(world, chance, inner=0.1)
    since = centred(world, since_event(world, event))
    return replace(_added(world, size * _signs(world, chance) * _deviation_alone(since)), event=event)


def random_walk(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset walks at random: the size is the standard deviation gathered over one replication.

    The truth is the mean of the run. Dwells close in time err alike.
    """
    steps = chance.standard_normal(world.shape)
    per_dwell = size / np.sqrt(world.schedule.dwells / world.setup.replications)
    return _added(world, per_dwell * centred(world, np.cumsum(steps, axis=1)))


def correlated_noise(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset wanders about the truth with the size as standard deviation and a memory of ten dwells."""
    kept = np.exp(-0.1)
    noise = chance.standard_normal(world.shape)
    wander = np.empty(world.shape)
    wander[:, 0] = noise[:, 0]
    for dwell in range(1, world.shape[1]):
        wander[:, dwell] = kept * wander[:, dwell - 1] + np.sqrt(1.0 - kept**2) * noise[:, dwell]
    return _added(world, size * wander)


def in_pitch_order(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset drifts by the size within each replication and starts anew, while pitch goes from end to end once.

    A raster: time and pitch are the same but for scale, and the drift is in the sensitivity of every replication.
    Nothing in the data tells them apart; the plan does.
    """
    phase = world.schedule.replication_phase() - 0.5
    return _added(world, size * _signs(world, chance) * _deviation_alone(phase[None]))


def raster_linear(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset drifts evenly by the size over the whole run while every replication is a raster."""
    return linear(world, size, chance)


def warm_up(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset settles from the size to the truth with a time constant of an hour from the first dwell on."""
    settled = np.exp(-world.schedule.time_s / 3600.0)[None]
    return _added(world, size * _signs(world, chance) * _deviation_alone(settled))


def settling(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset settles from the size, in standard deviations of a dwell, at the start of every replication.

    After a sixth of the dwells a twentieth is left. The truth is what it settles to.
    """
    fading = np.where(world.schedule.replication >= 0, np.exp(-18.0 * world.schedule.replication_phase()), 0.0)
    return _added(world, size * world.setup.noise_arcsec * _signs(world, chance) * _deviation_alone(fading[None]))


def _added(world: World, offset_arcsec: FloatArray) -> World:
    return replace(world, added_g=world.added_g + offset_arcsec * ARCSEC)


def _deviation_alone(column: FloatArray) -> FloatArray:
    return column[..., None, None]


def _signs(world: World, chance: np.random.Generator) -> FloatArray:
    return chance.choice([-1.0, 1.0], (world.campaigns, 1, *world.shape[2:]))


SIZES_ARCSEC = (0.0, 0.05, 0.1, 0.2, 0.35, 0.5, 1.0, 2.0, 5.0, 20.0)
DRIFT_SCENES = (
    Scene("drift-linear", linear, "arcsec", SIZES_ARCSEC, "drift", also=("autocorrelation",)),
    Scene("drift-replications", per_replication, "arcsec", SIZES_ARCSEC, "drift"),
    Scene("drift-sensitivity", per_replication_gain, "ppm", (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 50.0), "drift"),
    Scene(
        "drift-step", step, "arcsec", SIZES_ARCSEC, "drift", also=("autocorrelation", "sensor-change", "meter-offset")
    ),
    Scene("drift-walk", random_walk, "arcsec", SIZES_ARCSEC, "autocorrelation", also=("drift",)),
    Scene("drift-correlated", correlated_noise, "arcsec", SIZES_ARCSEC, "autocorrelation", also=("drift",)),
    Scene("drift-warm-up", warm_up, "arcsec", SIZES_ARCSEC, "drift", also=("autocorrelation",)),
    Scene("drift-settling", settling, "σ", (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0), "drift"),
    Scene(
        "drift-in-pitch-order",
        in_pitch_order,
        "arcsec",
        SIZES_ARCSEC,
        "time-confounded",
        design={"order": "raster"},
    ),
    Scene(
        "drift-raster",
        raster_linear,
        "arcsec",
        SIZES_ARCSEC,
        "drift",
        also=("time-confounded", "autocorrelation"),
        design={"order": "raster"},
    ),
)
