"""Leases of pages: whatever people, networks and servers do, nothing moves that nobody is there to keep moving."""

from pathlib import Path

import numpy as np
import pytest
from jog_pages import JogScene, jog_scene, one_of

STOPPED_S = 0.5
"""From the last moment at which somebody who wanted it was there to the standstill of the machine itself."""
ACTS, PAUSES_S = 14, (0.0, 0.05, 0.2, 0.6, 1.5)


def _walk(scene: JogScene, seed: int) -> list[str]:
    chance = np.random.default_rng(seed)
    scene.begin(pages=3)
    scene.pages[0].say(scene.clock.monotonic_s(), say="take")
    scene.live(0.3)
    done = []
    for _ in range(ACTS):
        done.append(scene.do(chance))
        scene.live(one_of(PAUSES_S, chance))
    return done


def _require_still_in_time(scene: JogScene, seeds: range) -> None:
    for seed in seeds:
        scene.worst_s = 0.0
        done = _walk(scene, seed)
        assert scene.worst_s <= STOPPED_S, f"seed {seed}: {scene.worst_s:.2f} s too long after {done}"
    assert scene.moved > 5 * len(seeds), "hardly anything moved: the law was not tried"


def test_nothing_moves_without_somebody_who_is_there(tmp_path: Path) -> None:
    with jog_scene(tmp_path) as scene:
        _require_still_in_time(scene, range(10))


@pytest.mark.thorough
def test_nothing_moves_in_hundreds_of_walks(tmp_path: Path) -> None:
    with jog_scene(tmp_path) as scene:
        _require_still_in_time(scene, range(1000, 1300))


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("part", range(4))
def test_nothing_moves_in_ten_thousand_walks(tmp_path: Path, part: int) -> None:
    with jog_scene(tmp_path) as scene:
        _require_still_in_time(scene, range(2500 * part + 10_000, 2500 * part + 12_500))
