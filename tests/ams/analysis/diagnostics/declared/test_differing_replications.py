"""Replications that differ in sensitivity or offset by more than 1 % are named, and dwells that scatter by as much not.

A replication of three linear sensors at written-out attitudes is read with another gain or another zero; what is stated
of it must hold what was put in.
"""

from dataclasses import replace

import numpy as np
import pytest
from campaign_of_a_package import campaign, solved

from ams.analysis.diagnostics.words.held_words import held_words
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding, leaves_nothing
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SHIFTS_WITHIN, Effect, SharedError
from ams.observations import Observations

V_PER_G = 2.5


def with_x(rows: Observations, x_v: np.ndarray) -> Observations:
    return replace(rows, outputs={**rows.outputs, "x": x_v})


def changed(rows: Observations, replication: int, *, gain: float = 0.0, offset_g: float = 0.0) -> Observations:
    """The x of one replication is read larger by a part of it, and by an offset."""
    there = rows.replication == replication
    return with_x(rows, rows.outputs["x"] * (1.0 + gain * there) + V_PER_G * offset_g * there)


def noisy(rows: Observations, noise_g: float, seed: int) -> Observations:
    chance = np.random.default_rng([75, seed])
    outputs = {
        label: values + V_PER_G * noise_g * chance.standard_normal(rows.rows) for label, values in rows.outputs.items()
    }
    return replace(rows, outputs=outputs)


def told(found: Calibration, label: str = "x") -> list[Finding]:
    return [said for said in found.axes[label].findings if said.details.get("test") == "replication against the others"]


@pytest.mark.parametrize(("replications", "which"), [(3, 1), (3, 3), (4, 2), (5, 3), (6, 2)])
@pytest.mark.parametrize(("quantity", "size"), [("sensitivity", 0.03), ("sensitivity", -0.03), ("offset", 0.04)])
def test_a_replication_of_another_gain_or_zero_is_named_and_not_usable(
    replications: int, which: int, quantity: str, size: float
) -> None:
    """The true size lies within what is stated of it, at three times its standard uncertainty."""
    rows = campaign(replications, replications, steps=True)
    is_gain = quantity == "sensitivity"
    found = solved(changed(rows, which, gain=size) if is_gain else changed(rows, which, offset_g=size))
    assert found.verdict == "not usable"
    assert not [said for label in "yz" for said in told(found, label)]
    named = [said for said in told(found) if said.details["quantity"] == quantity]
    if not named:  # told as a change in mid-run, which is another name of the same
        assert [said for said in found.axes["x"].findings if said.kind == "sensor-change" and not said.is_held]
        return
    (said,) = named
    sensitivity = float(np.linalg.norm(found.axes["x"].sensitive_axis_v_per_g))
    true = 100.0 * size if is_gain else size * V_PER_G / sensitivity
    stated, u = (float(said.details[key] or 0.0) for key in ("size", "standard_uncertainty"))
    # An offset is stated in the sensitivity of the axis, which its orthogonal terms move by parts in a thousand.
    assert abs(stated - true) < 3.0 * u + (0.0 if is_gain else 0.01 * abs(true))
    assert said.details["replication"] == which
    assert f"replication {which} by {'+' if size > 0 else '−'}" in said.fact
    assert "calrig redo" not in said.fact
    assert f"calrig redo R17 --replication {which}" in said.what_to_do
    assert not said.is_held
    assert not leaves_nothing(said)
    texts = " ".join(other.text for other in found.axes["x"].findings if other.is_significant)
    assert "contained" not in texts
    assert "contained" not in held_words(found.axes["x"].findings, is_drift=True)


def test_of_two_replications_neither_is_blamed() -> None:
    for which in (1, 2):
        found = solved(changed(campaign(1, 2, steps=True), which, gain=0.03))
        (said,) = told(found)
        assert found.verdict == "not usable"
        assert "replication" not in said.details
        assert "of two replications nothing tells which is wrong" in said.fact
        assert "calrig redo" not in said.text


@pytest.mark.parametrize(("gain", "offset_g"), [(0.008, 0.0), (0.0, 0.008)])
def test_what_differs_by_less_stays_a_drift_that_is_contained(gain: float, offset_g: float) -> None:
    found = solved(changed(campaign(2, 5), 3, gain=gain, offset_g=offset_g))
    assert not told(found)
    assert "contained" in held_words(found.axes["x"].findings, is_drift=True)


@pytest.mark.parametrize("replications", [2, 3, 4, 6])
def test_dwells_that_scatter_by_a_hundredth_of_a_g_are_no_difference(replications: int) -> None:
    for seed in range(12):
        found = solved(noisy(campaign(seed, replications), 0.01, seed))
        assert not [said for label in "xyz" for said in told(found, label)]


def test_a_replication_that_was_shaken_is_no_difference() -> None:
    """By 4 % of a g at every dwell of it, and nothing between them."""
    for seed in range(12):
        rows = campaign(seed, 4)
        chance, there = np.random.default_rng([76, seed]), rows.replication == 2
        shaken = with_x(rows, rows.outputs["x"] + V_PER_G * 0.04 * there * chance.standard_normal(rows.rows))
        assert not told(solved(shaken))


def test_a_difference_is_told_through_that_scatter() -> None:
    for seed in range(4):
        found = solved(noisy(changed(campaign(seed, 5), 3, gain=0.04), 0.01, seed))
        (said,) = told(found)
        assert said.details["replication"] == 3.0


@pytest.mark.parametrize(
    ("name", "effect", "limit", "gain", "offset_g"),
    [
        (SHIFTS_WITHIN[1], "gain-course", 0.03, 0.03, 0.0),
        (SHIFTS_WITHIN[0], "reading-course", 0.04 * V_PER_G, 0.0, 0.04),
    ],
)
def test_what_is_declared_of_the_sensor_is_no_contradiction(
    name: str, effect: Effect, limit: float, gain: float, offset_g: float
) -> None:
    """As far as it is declared, and no further."""
    nominal = dict(zip("xyz", "xyz", strict=True))
    for times, is_told in ((1.0, False), (1.4, True)):
        rows = changed(campaign(3, 5), 3, gain=times * gain, offset_g=times * offset_g)
        declared = SharedError(name, effect, limit * 1.02 / 3.0**0.5, stated="a data sheet")
        request = CalibrationRequest(nominal_axes=nominal, shared_errors={"x": (declared,)})
        assert bool(told(calibrate(rows, request))) is is_told


@pytest.mark.thorough
def test_clean_campaigns_of_every_noise_and_size_are_not_refused() -> None:
    found = 0
    for seed in range(400):
        rows = noisy(campaign(seed, 2 + seed % 5), (0.002, 0.01, 0.03, 0.1)[seed % 4], seed)
        result = solved(rows)
        found += len([said for label in "xyz" for said in told(result, label)])
    assert found == 0
