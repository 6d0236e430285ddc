"""What a joint fit says of its data: a table within its certificate is no bent sensor, one beyond it is named."""

from collections.abc import Callable

import numpy as np
import pytest
from joint_campaigns import mountings_of
from physics_scenes.designs import Setup
from physics_scenes.mounting_scenes import ABOUT_Z, UPRIGHT, Sizes, remounted
from physics_scenes.rotations import ARCSEC
from physics_scenes.tables import Curve, eight_harmonics, once_per_turn

from ams.calibration.joint_diagnosis import diagnose_joint
from ams.findings import Finding
from ams.inputs.table_uncertainty import IndexErrors, TableUncertainty, known_errors
from ams.solve.joint import joint_fit
from ams.solve.table_errors import TablePriors

LIMIT = TableUncertainty(ARCSEC, ARCSEC, "limit")
PRIORS = TablePriors(table=LIMIT, pitch_zero_rad=0.2 * ARCSEC, seat_rad=5.0 * ARCSEC)
SETUP = Setup(replications=3, noise_arcsec=0.5)
CurveOf = Callable[[float, int, np.random.Generator], Curve]


def findings(
    curve: CurveOf, sizes: Sizes, campaigns: int, turns: tuple[np.ndarray, ...] = (UPRIGHT, ABOUT_Z)
) -> list[list[Finding]]:
    """Return the significant findings of every campaign."""
    drawn = remounted(curve, sizes, SETUP, campaigns, np.random.default_rng(21), turns)
    found = []
    for campaign in range(campaigns):
        mountings = mountings_of(drawn, campaign)
        told = diagnose_joint(mountings, joint_fit(mountings, "xyz", PRIORS), PRIORS).findings
        found.append([finding for axis in told.values() for finding in axis if finding.is_significant])
    return found


@pytest.mark.parametrize("turns", [(UPRIGHT,), (UPRIGHT, ABOUT_Z)], ids=["one mounting", "two"])
@pytest.mark.parametrize(("campaigns", "most"), [(6, 0.34), pytest.param(60, 0.12, marks=pytest.mark.thorough)])
def test_a_table_within_its_certificate_is_told_as_nothing(
    turns: tuple[np.ndarray, ...], campaigns: int, most: float
) -> None:
    """Once a turn at its limit of 1″, which with one mounting is 4.8 µg/g² of K₂; all tests of a run at 5 %."""
    found = findings(once_per_turn, Sizes(terms_micro=0.0), campaigns, turns)
    assert np.mean([len(told) > 0 for told in found]) <= most, found


@pytest.mark.parametrize("campaigns", [4, pytest.param(40, marks=pytest.mark.thorough)])
def test_a_table_beyond_its_certificate_is_named(campaigns: int) -> None:
    """A curve of 4″ where 1″ is declared."""
    found = findings(eight_harmonics, Sizes(curve_arcsec=4.0), campaigns)
    named = [any("limit" in finding.text or "prior" in finding.text for finding in told) for told in found]
    assert np.mean(named) >= 0.95


def test_a_zero_of_pitch_beyond_what_is_declared_is_named() -> None:
    def off_by_5(limit_rad: float, campaigns: int, chance: np.random.Generator) -> Curve:
        return lambda angle: np.full((1, angle.size), 5.0 * ARCSEC)

    for told in findings(off_by_5, Sizes(terms_micro=0.0), 3):
        assert any(finding.text.startswith("pitch zero: +") for finding in told), (
            "drawn towards 0.2″, and its sign told"
        )


def test_what_a_certificate_lists_is_taken_off_in_a_reversed_mounting_too() -> None:
    """Errors of 20″ that the certificate lists, a zero declared with them: nothing is left to be told."""
    angles = np.arange(-180.0, 180.0, 15.0)

    def listed(limit_rad: float, campaigns: int, chance: np.random.Generator) -> Curve:
        return lambda angle: 20.0 * ARCSEC * np.sin(3.0 * angle + 1.0)[None]

    errors = known_errors(angles, 20.0 * np.sin(np.deg2rad(3.0 * angles) + 1.0), np.full(angles.size, 0.05))
    table = TableUncertainty(
        ARCSEC, ARCSEC, "limit", errors=dict.fromkeys(("pitch", "roll"), IndexErrors(known=errors))
    )
    priors = TablePriors(table=table, seat_rad=5.0 * ARCSEC)
    drawn = remounted(listed, Sizes(terms_micro=0.0), SETUP, 3, np.random.default_rng(22))
    for campaign in range(3):
        mountings = mountings_of(drawn, campaign)
        fit = joint_fit(mountings, "xyz", priors)
        told = diagnose_joint(mountings, fit, priors).findings
        assert [finding.text for axis in told.values() for finding in axis if finding.is_significant] == []
        for axis, best in zip("xyz", drawn.best_linear()[campaign], strict=True):
            np.testing.assert_allclose(fit.primary[axis][:4], best, atol=0.5 * ARCSEC * 2.5)
