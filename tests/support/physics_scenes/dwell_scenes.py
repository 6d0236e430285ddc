"""Scenes of single dwells: a reading or a position that is simply wrong."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from physics_scenes.rotations import ARCSEC, FloatArray
from physics_scenes.scene import Scene
from physics_scenes.world import Event, World, at_event, chosen_event

OUTLIERS = 0.005
OUTLIER_SD = 20.0


def wrong_dwell(world: World, size: float, chance: np.random.Generator) -> World:
    """One axis reads wrong at one dwell of the campaign by the size in standard deviations of a dwell, either way."""
    event = chosen_event(world, chance)
    sign = chance.choice([-1.0, 1.0], (world.campaigns, 1, 1, 1))
    wrong_v = size * sign * world.noise_v * at_event(world, event)
    return _after_noise(replace(world, event=event), lambda output_v: output_v + wrong_v)


def wrong_dwell_all(world: World, size: float, chance: np.random.Generator) -> World:
    """The table had not settled at one dwell: every axis of every sensor is wrong, each by its own normal deviate."""
    event = chosen_event(world, chance)
    nowhere = np.full(world.campaigns, -1)
    share = chance.standard_normal((world.campaigns, 1, *world.shape[2:]))
    wrong_v = size * share * world.noise_v * at_event(world, event, each=False)[..., None, None]
    known = replace(world, event=Event(event.dwell, nowhere, nowhere))
    return _after_noise(known, lambda output_v: output_v + wrong_v)


def outliers(world: World, size: float, chance: np.random.Generator) -> World:
    """One reading in two hundred is too high by the size in standard deviations: a relay's spike, always one way."""
    struck = chance.uniform(size=world.shape) < OUTLIERS
    wrong_v = size * world.noise_v * struck
    return _after_noise(world, lambda output_v: output_v + wrong_v)


def outlier_share(world: World, size: float, chance: np.random.Generator) -> World:
    """A share of the readings, the size in percent, is too high by twenty standard deviations."""
    struck = chance.uniform(size=world.shape) < size / 100.0
    wrong_v = OUTLIER_SD * world.noise_v * struck
    return _after_noise(world, lambda output_v: output_v + wrong_v)


def swapped_channel(world: World, size: float, chance: np.random.Generator) -> World:
    """The scanner gives two channels of one sensor in each other's place at so many dwells, the size.

    At attitudes where both read alike nothing is to be seen, nor does it harm.
    """
    dwells, known = _several(world, int(size), chance)
    first, second = world.shape[3] - 2, world.shape[3] - 1

    def swapped(output_v: FloatArray) -> FloatArray:
        left = np.swapaxes(output_v, 2, 3)
        exchanged = left.copy()
        exchanged[:, :, first], exchanged[:, :, second] = left[:, :, second], left[:, :, first]
        return np.where(dwells[..., None, None], np.swapaxes(exchanged, 2, 3), output_v)

    return _after_noise(known, swapped) if size else known


def wrong_tooth(world: World, size: float, chance: np.random.Generator) -> World:
    """The table seated beside its tooth at one dwell and says otherwise: pitch or roll is off by the size in degrees.

    All sensors see it. One degree is the neighbouring tooth; less is one that is not home.
    """
    event = chosen_event(world, chance)
    signed = np.deg2rad(size) * chance.choice([-1.0, 1.0], (world.campaigns, 1))
    is_roll = chance.integers(0, 2, (world.campaigns, 1))
    off = signed * at_event(world, event, each=False)
    nowhere = np.full(world.campaigns, -1)
    table = world.table.moved(pitch_rad=(1 - is_roll) * off, roll_rad=is_roll * off)
    return replace(world, table=table, event=Event(event.dwell, nowhere, nowhere))


def repeated_reading(world: World, size: float, chance: np.random.Generator) -> World:
    """The meter gives the reading before once more at so many dwells, the size: all channels are stale."""
    dwells, known = _several(world, int(size), chance)

    def stale(output_v: FloatArray) -> FloatArray:
        return np.where(dwells[..., None, None], np.roll(output_v, 1, axis=1), output_v)

    return _after_noise(known, stale) if size else known


def noisy_replication(world: World, size: float, chance: np.random.Generator) -> World:
    """Lorries pass while one replication is measured: the noise of its dwells is larger by so many times, the size."""
    struck = chance.integers(0, world.setup.replications, world.campaigns)
    louder = 1.0 + size * (world.schedule.replication == struck[:, None])
    return replace(world, noise_factor=louder[..., None, None])


def noise_by_attitude(world: World, size: float, chance: np.random.Generator) -> World:
    """The rig shakes about its pitch axis: noise goes as what each output takes of that, less where it stands upright.

    The sizes are how much more than the rest it is at a level attitude; the rest is the noise of a dwell.
    """
    level = np.abs(np.cos(np.deg2rad(world.schedule.pitch_deg)))
    return replace(world, noise_factor=(1.0 + size * level)[None, :, None, None])


def unrepeatable_index(world: World, size: float, chance: np.random.Generator) -> World:
    """The table never comes to rest twice at the same angle: both axes, by the size as a standard deviation."""
    off = size * ARCSEC * chance.standard_normal((2, *world.shape[:2]))
    return replace(world, table=world.table.moved(pitch_rad=off[0], roll_rad=off[1]))


def _several(world: World, count: int, chance: np.random.Generator) -> tuple[np.ndarray, World]:
    """Draw different dwells in every campaign, (n, D) of truth values; the event is the first drawn."""
    rows = world.schedule.rows("point")
    drawn = chance.permuted(np.tile(rows, (world.campaigns, 1)), axis=1)[:, : max(count, 1)]
    struck = np.zeros(world.shape[:2], dtype=bool)
    if count:
        np.put_along_axis(struck, drawn, True, axis=1)
    nowhere = np.full(world.campaigns, -1)
    return struck, replace(world, event=Event(drawn[:, 0], nowhere, nowhere))


def _after_noise(world: World, fault: Callable[[FloatArray], FloatArray]) -> World:
    return replace(world, faults_after_noise=(*world.faults_after_noise, fault))


SIGMAS = (0.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 30.0, 100.0, 1500.0)
DWELL_SCENES = (
    Scene("wrong-dwell", wrong_dwell, "σ", SIGMAS, "wrong-dwell"),
    Scene("wrong-dwell-all", wrong_dwell_all, "σ", SIGMAS, "wrong-dwell"),
    Scene("outliers", outliers, "σ", (0.0, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0), "wrong-dwell"),
    Scene("outlier-share", outlier_share, "%", (0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0), "wrong-dwell"),
    Scene("swapped-channel", swapped_channel, "dwells", (0.0, 1.0, 2.0, 5.0), "wrong-dwell", also=("lack-of-fit",)),
    Scene("repeated-reading", repeated_reading, "dwells", (0.0, 1.0, 2.0, 5.0), "wrong-dwell", also=("lack-of-fit",)),
    Scene("noisy-replication", noisy_replication, "×", (0.0, 0.1, 0.2, 0.3, 0.5, 1.0, 3.0, 9.0), "uneven-noise"),
    Scene("noise-by-attitude", noise_by_attitude, "×", (0.0, 0.5, 1.0, 3.0), declared_up_to=3.0),
    Scene("unrepeatable-index", unrepeatable_index, "arcsec", (0.0, 0.5, 1.0, 2.0, 5.0), declared_up_to=5.0),
    Scene(
        "wrong-tooth",
        wrong_tooth,
        "deg",
        (0.0, 0.001, 0.002, 0.003, 0.005, 0.01, 0.1, 1.0),
        "wrong-dwell",
        also=("table-rotation",),
    ),
)
