"""Laws of chance by counters: a number depends on its address alone."""

import numpy as np
import pytest

from rig.twins.physics.chance import Announcement, Chance


def _drawn(chance: Chance, source: str, numbers: int) -> list[float]:
    return [chance.normal(source) for _ in range(numbers)]


def _announced(seed: int, step: int, phase: str = "read", attempt: int = 0) -> Chance:
    chance = Chance(seed)
    chance.announce(Announcement(step, phase, attempt, 0.0))
    return chance


def test_a_resumed_step_draws_what_it_would_have_drawn() -> None:
    uninterrupted = Chance(7)
    for step in range(5):
        uninterrupted.announce(Announcement(step, "read", 0, 0.0))
        last = _drawn(uninterrupted, "dmm.x", 70)
    assert last == _drawn(_announced(7, 4), "dmm.x", 70)


def test_reading_another_channel_in_between_changes_nothing() -> None:
    alone, mixed = _announced(7, 1), _announced(7, 1)
    numbers = []
    for _ in range(40):
        mixed.normal("dmm.y")
        numbers.append(mixed.normal("dmm.x"))
    assert numbers == _drawn(alone, "dmm.x", 40)


@pytest.mark.parametrize(
    "other",
    [_announced(8, 1), _announced(7, 2), _announced(7, 1, "settle"), _announced(7, 1, attempt=1)],
    ids=["seed", "step", "phase", "attempt"],
)
def test_every_part_of_the_address_gives_other_numbers(other: Chance) -> None:
    assert not set(_drawn(_announced(7, 1), "dmm.x", 64)) & set(_drawn(other, "dmm.x", 64))


def test_announcing_again_starts_the_same_numbers_again() -> None:
    chance = _announced(7, 1)
    first = _drawn(chance, "dmm.x", 3)
    chance.announce(chance.announcement)
    assert _drawn(chance, "dmm.x", 3) == first


def test_the_numbers_are_standard_normal_and_uncorrelated_between_steps_and_channels() -> None:
    rows = []
    for step in range(400):
        chance = _announced(3, step)
        rows.append(_drawn(chance, "dmm.x", 20) + _drawn(chance, "dmm.y", 20))
    drawn = np.array(rows)
    assert abs(drawn.mean()) < 4 / np.sqrt(drawn.size)
    assert abs(drawn.std() - 1.0) < 4 / np.sqrt(2 * drawn.size)
    correlation = np.corrcoef(drawn.T) - np.eye(40)
    assert np.abs(correlation).max() < 5 / np.sqrt(400)


def test_fixed_numbers_do_not_follow_the_announcement() -> None:
    chance = Chance(7)
    before = chance.fixed("tooth", "pitch", 3).uniform()
    chance.announce(Announcement(9, "read", 1, 2.0))
    assert chance.fixed("tooth", "pitch", 3).uniform() == before
    assert chance.fixed("tooth", "roll", 3).uniform() != before
