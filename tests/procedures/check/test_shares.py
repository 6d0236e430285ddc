"""Shares of U95 in words: what is small is told together, and what is told adds up to the whole."""

import re

import numpy as np
import pytest

from procedures.check.shares import shares_in_words

ARCSEC = 1.0 / 3600.0


@pytest.mark.parametrize(
    ("shares_arcsec", "words"),
    [
        ({"table": 3.0, "reading at use": 4.0}, "reading at use 4, table 3"),
        ({"table": 10.0, "meter": 0.3, "level": 0.4, "gain": 0.0}, "table 10, all others 0.5"),
        ({"table": 10.0, "meter": 0.3}, "table 10, meter 0.3"),
        ({"table": 1.0, "meter": 1.0, "level": 0.08, "gain": 0.15}, "table 1, meter 1, gain 0.15, level 0.08"),
    ],
)
def test_small_shares_are_told_together(shares_arcsec: dict[str, float], words: str) -> None:
    """Beyond a hundredth of the square of U95 none is small: 0.08 and 0.15 take 0.0144 of it."""
    assert shares_in_words({name: share * ARCSEC for name, share in shares_arcsec.items()}) == words


def test_what_is_told_adds_up_to_the_whole() -> None:
    chance = np.random.default_rng(1)
    for _ in range(200):
        shares = dict(zip("abcdefgh", 10.0 ** chance.uniform(-3.0, 1.0, 8) * ARCSEC, strict=True))
        told = [float(number) for number in re.findall(r"[\d.e-]+(?=,|$)", shares_in_words(shares))]
        whole = sum((share / ARCSEC) ** 2 for share in shares.values())
        assert sum(number**2 for number in told) == pytest.approx(whole, rel=0.1)
