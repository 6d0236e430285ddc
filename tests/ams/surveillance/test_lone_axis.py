"""Packages of three axes, two and one on one table: who is blamed for what one axis alone shows.

The truth is made by explicit rotations; sensitivities and directions are known as well as a run learns them.
"""

from collections import Counter

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ams.findings import Finding, turned_the_table
from ams.surveillance.common_mode import judge_visits
from ams.surveillance.common_mode_columns import Visits, WatchedAxes
from ams.surveillance.common_mode_words import findings_of

Floats = NDArray[np.float64]
Attitudes = tuple[tuple[float, float], ...]
ARCSEC = np.pi / 180.0 / 3600.0
V_PER_G, NOISE_V, SEATING_ARCSEC, FALSE_ALARM = 2.5, 1.3e-5, 0.5, 1e-4
MIXED = {"W1": "xyz", "S1": "x", "D1": "xy"}
ONE_OF_THREE_AXES = {"A1": "xyz", "B1": "x", "B2": "x", "B3": "x"}
TWO_PACKAGES = {"A1": "xyz", "B1": "x"}
LEVEL: Attitudes = ((0.0, 0.0),)
TWO: Attitudes = ((0.0, 0.0), (30.0, 60.0))
CHECK: Attitudes = ((0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, -90.0), (60.0, 0.0), (-60.0, 0.0))
SEEDS = 8


def felt(attitudes: Attitudes, turned_arcsec: Floats) -> Floats:
    """Gravity in the packages, (K, 3); ``turned_arcsec`` about pitch and roll at each attitude, (K, 2)."""
    turns = [
        Rotation.from_euler("YX", [np.deg2rad(pitch) + by_pitch * ARCSEC, np.deg2rad(roll) + by_roll * ARCSEC])
        for (pitch, roll), (by_pitch, by_roll) in zip(attitudes, turned_arcsec.tolist(), strict=True)
    ]
    return np.array([turn.inv().apply([0.0, 0.0, -1.0]) for turn in turns])


def told(
    rig: dict[str, str],
    attitudes: Attitudes,
    seed: int,
    *,
    own: tuple[str, str] = ("", ""),
    offset_v: float = 0.0,
    sensitivity: float = 0.0,
    turn_arcsec: float = 0.0,
    gain: float = 0.0,
    meter_v: float = 0.0,
) -> tuple[Finding, ...]:
    """What two visits tell; ``offset_v`` and ``sensitivity`` of one axis, the others of the table and the meter."""
    chance = np.random.default_rng(seed)
    outputs = [(sensor, axis) for sensor, axes in rig.items() for axis in axes]
    nominal = np.array([V_PER_G * np.eye(3)["xyz".index(axis)] for _, axis in outputs])
    true = nominal * (1.0 + 1e-3 * chance.standard_normal((len(outputs), 1)))
    true = true + 5e-4 * V_PER_G * chance.standard_normal(true.shape)
    zero_v = 0.01 * chance.standard_normal(len(outputs))
    before = felt(attitudes, np.zeros((len(attitudes), 2))) @ true.T + zero_v
    seated = np.sqrt(2.0) * SEATING_ARCSEC * chance.standard_normal((len(attitudes), 2))
    after = felt(attitudes, seated + np.array([0.0, turn_arcsec])) @ true.T + zero_v
    is_own = np.array([output == own for output in outputs], dtype=float)
    after = after * (1.0 + sensitivity * is_own) + offset_v * is_own
    after = after * (1.0 + gain) + meter_v
    change = after - before + np.sqrt(2.0) * NOISE_V * chance.standard_normal(after.shape)
    pitch, roll = np.deg2rad(np.array(attitudes)).T
    names = tuple(sensor for sensor, _ in outputs)
    watched = WatchedAxes(names, tuple(axis for _, axis in outputs), ("dmm",) * len(names), nominal)
    variance, seating_rad = np.full(change.shape, 2.0 * NOISE_V**2), np.sqrt(2.0) * SEATING_ARCSEC * ARCSEC
    visits = Visits(pitch, roll, change, before, variance, 200.0, float(seating_rad))
    return findings_of(judge_visits(watched, visits, FALSE_ALARM), watched.sensors, "between visits 1 and 9")


def kinds_told(findings: list[tuple[Finding, ...]]) -> Counter[str]:
    return Counter(finding.kind for found in findings for finding in found)


@pytest.mark.parametrize("attitudes", [LEVEL, TWO, CHECK], ids=["level", "two", "check set"])
@pytest.mark.parametrize(
    ("rig", "own"),
    [
        (MIXED, ("W1", "z")),
        (ONE_OF_THREE_AXES, ("A1", "y")),
        (TWO_PACKAGES, ("A1", "y")),
        (TWO_PACKAGES, ("A1", "z")),
    ],
    ids=["z of three packages", "y of four", "y of two", "z of two"],
)
@pytest.mark.parametrize("offset_v", [4e-5, 1e-4, 3e-4])
def test_an_offset_that_one_axis_alone_shows_is_its_sensors(
    rig: dict[str, str], own: tuple[str, str], attitudes: Attitudes, offset_v: float
) -> None:
    found = [told(rig, attitudes, seed, own=own, offset_v=offset_v) for seed in range(SEEDS)]
    blamed = kinds_told(found)
    assert not any(turned_the_table(findings) for findings in found)
    assert blamed["sensor-change"] >= sum(blamed.values()) - 1
    assert {finding.details["sensor"] for findings in found for finding in findings if "sensor" in finding.details} <= {
        own[0]
    }
    if offset_v > 2e-4:
        assert blamed["sensor-change"] >= SEEDS - 2


@pytest.mark.parametrize("attitudes", [LEVEL, TWO, CHECK], ids=["level", "two", "check set"])
@pytest.mark.parametrize("sensitivity", [2e-5, 6e-5, 2e-4])
def test_a_sensitivity_that_one_axis_alone_shows_is_its_sensors(attitudes: Attitudes, sensitivity: float) -> None:
    found = [told(MIXED, attitudes, seed, own=("W1", "z"), sensitivity=sensitivity) for seed in range(SEEDS)]
    assert set(kinds_told(found)) <= {"sensor-change"}
    assert {finding.details["sensor"] for findings in found for finding in findings} <= {"W1"}
    if sensitivity > 1e-4:
        assert kinds_told(found)["sensor-change"] >= SEEDS - 2


@pytest.mark.parametrize(
    ("own", "same"), [(("W1", "z"), "the meter's gain"), (("A1", "y"), "a rotation of the table")], ids=["z", "y"]
)
def test_what_would_look_the_same_is_said_where_no_other_axis_can_see_it(own: tuple[str, str], same: str) -> None:
    rig = MIXED if own[0] == "W1" else ONE_OF_THREE_AXES
    (at_level,) = told(rig, LEVEL, 1, own=own, offset_v=3e-4)
    assert at_level.text.startswith(f"{own[0]} changed by itself between visits 1 and 9 (")
    assert ", and no other axis shows it: the sensor" in at_level.text
    assert at_level.text.endswith(f"; {same} would look the same here")
    assert at_level.details["confounded_with"] in ("meter-gain", "table-rotation")
    (over_a_check_set,) = told(rig, CHECK, 1, own=own, offset_v=3e-4)
    assert "the same" not in over_a_check_set.text


@pytest.mark.parametrize("attitudes", [TWO, CHECK], ids=["two", "check set"])
@pytest.mark.parametrize("rig", [MIXED, ONE_OF_THREE_AXES, TWO_PACKAGES], ids=["three", "four", "two packages"])
@pytest.mark.parametrize("arcsec", [20.0, -72.0])
def test_a_turn_is_the_tables_where_one_package_of_three_axes_sees_it(
    rig: dict[str, str], attitudes: Attitudes, arcsec: float
) -> None:
    found = [told(rig, attitudes, seed, turn_arcsec=arcsec) for seed in range(SEEDS)]
    assert set(kinds_told(found)) <= {"table-rotation", "sensor-change"}
    held = [findings for findings in found if turned_the_table(findings)]
    assert len(held) >= SEEDS - 2
    expected = "not the sensors" if rig is MIXED else "A1 on its mount would look the same here"
    assert all(expected in findings[0].text for findings in held)


@pytest.mark.parametrize("attitudes", [TWO, CHECK], ids=["two", "check set"])
@pytest.mark.parametrize("rig", [MIXED, ONE_OF_THREE_AXES], ids=["three", "four"])
@pytest.mark.parametrize(("gain", "meter_v", "kind"), [(2e-4, 0.0, "meter-gain"), (0.0, 3e-4, "meter-offset")])
def test_the_meter_is_blamed_in_mixed_rigs(
    rig: dict[str, str], attitudes: Attitudes, gain: float, meter_v: float, kind: str
) -> None:
    found = [told(rig, attitudes, seed, gain=gain, meter_v=meter_v) for seed in range(SEEDS)]
    assert kinds_told(found)[kind] >= SEEDS - 1
    assert "sensor-change" not in kinds_told(found)


def test_rigs_of_packages_that_do_not_have_the_same_axes_ring_no_more_often() -> None:
    rung = sum(bool(told(rig, TWO, seed)) for rig in (MIXED, ONE_OF_THREE_AXES) for seed in range(40))
    assert rung == 0
