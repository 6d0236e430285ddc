"""A rest is told from a turn by the readings themselves, whatever noise of them is stated."""

import numpy as np
import pytest

from ams.inference.gyros.zero_at_rest import zero_at_rest
from ams.statistics import distributions, without_scipy

NOISE_V = 2e-3


@pytest.mark.parametrize("has_scipy", [True, False])
@pytest.mark.parametrize("stated_v", [6e-5, NOISE_V])
def test_gyros_at_rest_rest(stated_v: float, has_scipy: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Found later: of four rests with the noise that a set states, four were told as none. Three axes at 1 in 1000."""
    if not has_scipy:
        monkeypatch.setattr(distributions, "_special", lambda: without_scipy)
    chance = np.random.default_rng(3)
    rests = [zero_at_rest(NOISE_V * chance.standard_normal((3, 900)), np.full(3, stated_v)) for _ in range(500)]
    assert sum(not rest.is_still for rest in rests) <= 6
    pulls = np.array([rest.mean_v / np.sqrt(np.diag(rest.covariance_v2)) for rest in rests])
    assert np.mean(np.abs(pulls) <= 1.96) == pytest.approx(0.95, abs=0.02)


@pytest.mark.parametrize("stated_v", [6e-5, NOISE_V])
def test_a_turn_is_none(stated_v: float) -> None:
    chance, turn = np.random.default_rng(3), np.zeros((3, 900))
    turn[1] = np.linspace(0.0, 4e-3, 900)
    found = zero_at_rest(NOISE_V * chance.standard_normal((3, 900)) + turn, np.full(3, stated_v))
    assert not found.is_still
    assert found.scatter_v[1] == pytest.approx(4e-3 / np.sqrt(12.0), rel=0.2)


def test_outputs_that_do_not_change_at_all_rest() -> None:
    assert zero_at_rest(np.ones((3, 900)), np.zeros(3)).is_still
