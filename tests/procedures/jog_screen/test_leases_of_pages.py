"""Leases of pages: whatever people, networks and servers do, nothing moves that nobody is there to keep moving."""

from pathlib import Path

import numpy as np
import pytest
from jog_pages import JogScene, choice_of, jog_scene

DRIVEN_S, MOVING_S = 0.32, 0.75
"""From the last moment at which somebody who wanted it was there: told to stop, and at rest from 20°/s."""
ACTS, PAUSES_S = 14, (0.0, 0.05, 0.2, 0.6, 1.5)


def _walk(scene: JogScene, seed: int) -> list[str]:
    chance = np.random.default_rng(seed)
    scene.begin(pages=3)
    scene.pages[0].say(scene.clock.monotonic_s(), say="take")
    scene.live(0.3)
    done = []
    for _ in range(ACTS):
        done.append(scene.do(chance))
        scene.live(choice_of(PAUSES_S, chance))
    return done


def _require_still_in_time(scene: JogScene, seeds: range) -> None:
    for seed in seeds:
        scene.driven_s = scene.moving_s = 0.0
        done = _walk(scene, seed)
        late = f"seed {seed}: driven for {scene.driven_s:.2f} s, moving for {scene.moving_s:.2f} s after {done}"
        assert scene.driven_s <= DRIVEN_S, late
        assert scene.moving_s <= MOVING_S, late
    assert scene.moved > 5 * len(seeds), "hardly anything moved: the law was not tried"


def test_a_page_that_takes_what_it_has_while_it_holds_a_button_lets_go_all_the_same(tmp_path: Path) -> None:
    with jog_scene(tmp_path) as scene:
        scene.begin(pages=1)
        (page,) = scene.pages
        page.say(scene.clock.monotonic_s(), say="take")
        scene.live(0.3)
        page.press, page.held = 1, {"axis": "roll", "rate_dps": 5.0}
        scene.live(1.0)
        page.say(scene.clock.monotonic_s(), say="take")
        scene.live(0.3)
        assert scene.moving() == ["roll"]
        page.held = None
        scene.live(MOVING_S)
        assert scene.moving() == []


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
