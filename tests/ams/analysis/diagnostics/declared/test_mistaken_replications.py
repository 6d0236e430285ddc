"""Cables that change places and rows that slip by a dwell in one replication: named, and no noise or drift instead.

The outputs are those of three linear sensors at written-out attitudes; two of their cables, or the rows, are moved.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from campaign_of_a_package import POINTS, campaign, solved
from physics_scenes.rotations import ARCSEC

from ams.analysis.diagnostics.declared.declared_signs import Package
from ams.analysis.diagnostics.declared.mistaken_replications import mistaken_replications
from ams.calibration_result import Calibration
from ams.findings import Finding, leaves_nothing
from ams.inputs.declared_direction import DeclaredDirection
from ams.models.registry import model_named
from ams.observations import Observations
from ams.solve.layout import layout_of

Mistake = Callable[[Observations], Observations]


def exchanged(one: str, other: str, replication: int = 2, first: int = 0, end: int = POINTS) -> Mistake:
    """Two cables changed places in some dwells of a replication."""

    def mistake(rows: Observations) -> Observations:
        at = np.flatnonzero(rows.replication == replication)[first:end]
        outputs = {label: values.copy() for label, values in rows.outputs.items()}
        outputs[one][at], outputs[other][at] = rows.outputs[other][at], rows.outputs[one][at]
        return replace(rows, outputs=outputs)

    return mistake


def slipped(by: int, replication: int = 2, first: int = 0) -> Mistake:
    """Every reading stands ``by`` rows lower than it was taken, from one row of a replication on; one stands twice."""

    def mistake(rows: Observations) -> Observations:
        at = np.flatnonzero(rows.replication == replication)[first:]
        outputs = {label: values.copy() for label, values in rows.outputs.items()}
        for label, values in outputs.items():
            values[at] = rows.outputs[label][np.clip(at - by, at[0], at[-1])]
        return replace(rows, outputs=outputs)

    return mistake


def told(found: Calibration) -> dict[str, list[Finding]]:
    """By axis, all that is significant."""
    return {
        label: [finding for finding in axis.findings if finding.is_significant] for label, axis in found.axes.items()
    }


def named(found: Calibration) -> dict[str, Finding]:
    """By axis, the finding of readings that stand elsewhere than they were taken; it is all that is told of them."""
    every = {label: findings for label, findings in told(found).items() if findings}
    assert {label: len(findings) for label, findings in every.items()} == dict.fromkeys(every, 1)
    return {label: findings[0] for label, findings in every.items()}


@pytest.mark.parametrize("replications", [2, 4, 6])
@pytest.mark.parametrize(("one", "other"), [("x", "y"), ("x", "z"), ("y", "z")])
def test_exchanged_cables_are_named_with_their_replication(replications: int, one: str, other: str) -> None:
    for replication in (1, 2):
        found = solved(exchanged(one, other, replication)(campaign(1, replications)))
        assert set(found.unusable_axes) == {one, other}
        assert found.verdict == "not usable"
        for finding in named(found).values():
            assert finding.kind == "axis-contradicted"
            assert leaves_nothing(finding)
            assert (finding.details["replication"], finding.details["dwells"]) == (replication, POINTS)
            assert f"readings of replication {replication} fit" in finding.fact
            assert f"outputs {one} and {other} exchanged to" in finding.fact
            assert f"rows of replication {replication} of a.csv" in finding.what_to_do


@pytest.mark.parametrize("replications", [2, 4, 6])
@pytest.mark.parametrize(("first", "end"), [(28, POINTS), (0, 28), (10, 41)])
def test_cables_exchanged_for_a_part_are_named_from_which_dwell_to_which(
    replications: int, first: int, end: int
) -> None:
    rows = campaign(2, replications, steps=True)
    found = solved(exchanged("x", "y", 2, first, end)(rows))
    assert (found.verdict, set(named(found))) == ("not usable", {"x", "y"})
    for finding in named(found).values():
        assert finding.steps == tuple(range(100 + POINTS + first, 100 + POINTS + end))
        assert "calrig redo R17 --replication 2" in finding.what_to_do
        assert (f"step {100 + POINTS + first}," in finding.fact) == (first > 0)
        assert (f"step {100 + POINTS + end - 1}," in finding.fact) == (end < POINTS)


@pytest.mark.parametrize("replications", [2, 4, 6])
@pytest.mark.parametrize(("by", "first"), [(1, 0), (-1, 0), (1, 20), (-1, 30)])
def test_rows_that_slip_by_a_dwell_are_named(replications: int, by: int, first: int) -> None:
    found = solved(slipped(by, 2, first)(campaign(4, replications)))
    assert (found.verdict, set(named(found))) == ("not usable", set("xyz"))
    for finding in named(found).values():
        where = "before" if by > 0 else "after"
        assert f"replication 2 fit the other replication{'s' if replications > 2 else ''} with each reading at" in (
            finding.fact
        )
        assert f"the attitude of the dwell {where} it" in finding.fact
        assert (" on, to " in finding.fact) == (first > 0)
        assert float(finding.details["fits_to_v"] or 0.0) < 2.5 * 4.0 * ARCSEC
        assert float(finding.details["as_read_to_v"] or 0.0) > 0.3


def test_most_replications_may_be_mistaken_and_the_declared_axes_tell_which() -> None:
    rows = campaign(4)
    for replication in (2, 3, 4):
        rows = exchanged("x", "y", replication)(rows)
    found = solved(rows)
    which = {finding.details["replication"] for findings in told(found).values() for finding in findings}
    assert (found.verdict, which) == ("not usable", {2.0, 3.0, 4.0})


def test_the_axes_that_are_right_keep_their_result() -> None:
    plain = solved(campaign(5)).axes["z"]
    found = solved(exchanged("x", "y")(campaign(5))).axes["z"]
    assert found.parameters == plain.parameters
    assert [finding.text for finding in found.findings] == [finding.text for finding in plain.findings]


def test_clean_and_drifting_campaigns_ring_nowhere() -> None:
    """Also where each replication has other offsets and sensitivities, by far more than its noise."""
    for seed in range(200, 212):
        plain = campaign(seed, 2 + seed % 4)
        chance = np.random.default_rng(seed)
        drifted = {
            label: values * (1.0 + 0.002 * chance.standard_normal(8))[plain.replication]
            for label, values in plain.outputs.items()
        }
        for rows in (plain, replace(plain, outputs=drifted)):
            assert not any("contradicted" in finding.kind for found in told(solved(rows)).values() for finding in found)


@pytest.mark.thorough
def test_of_two_thousand_clean_campaigns_none_is_explained_so_where_it_is_asked_of_all() -> None:
    """Of a calibration it is asked only where a dwell scatters by 0.1 % of the sensitivity."""
    models, declared = [model_named("pitch-roll", axis) for axis in "xyz"], [DeclaredDirection(axis) for axis in "xyz"]
    for seed in range(1000, 3000):
        rows = campaign(seed, 2 + seed % 5)
        package = Package(rows, layout_of(rows), "xyz", models, declared)
        assert not list(mistaken_replications(package))
