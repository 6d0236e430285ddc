"""A drift or a step is in no scatter that it is judged by: a sensor that is alone in its archive is judged as well."""

from datetime import timedelta

import numpy as np
import pytest

from ams.archive.synthetic import AXES, GRAVITY_MPS2, RIG, START
from ams.arrays import FloatArray
from ams.surveillance.characteristics import PackageNumbers
from ams.surveillance.control_chart import History, history_of
from ams.surveillance.series import PointLabel, Population
from ams.units import RAD_PER_ARCSEC

STATED_ARCSEC = 0.5


def yearly(
    chance: np.random.Generator,
    offset_arcsec: FloatArray,
    scatter_arcsec: float,
    others: int = 0,
    *,
    alike: bool = False,
) -> Population:
    """Return yearly calibrations of SN0, whose offset x goes as told, and of others, which stay or go ``alike``.

    From year to year offsets and sensitivities scatter by ``scatter_arcsec``, beside what a calibration states.
    """
    labels, primary = [], []
    for sensor in range(1 + others):
        level = np.hstack([chance.normal(0.0, 0.005, (3, 1)), 2.5 * (np.eye(3) + chance.normal(0.0, 0.003, (3, 3)))])
        for year, offset in enumerate(offset_arcsec):
            day = scatter_arcsec * RAD_PER_ARCSEC * chance.standard_normal((3, 2))
            found = level + 2.5 * STATED_ARCSEC * RAD_PER_ARCSEC * chance.standard_normal((3, 4))
            found[:, 1:] *= 1.0 + day[:, 1:]
            found[:, 0] += 2.5 * day[:, 0]
            found[0 if sensor == 0 else slice(None), 0] += 2.5 * RAD_PER_ARCSEC * offset * (alike or sensor == 0)
            when = START + timedelta(days=365.25 * year)
            labels.append(PointLabel(f"{sensor}-{year}", f"SN{sensor}", None, when, RIG, False, GRAVITY_MPS2))
            primary.append(found)
    stated = np.broadcast_to(np.eye(4) * (2.5 * STATED_ARCSEC * RAD_PER_ARCSEC) ** 2, (len(labels), 3, 4, 4)).copy()
    return Population(labels, PackageNumbers(AXES, np.stack(primary), stated, stated))


def stepped(years: int, at: int, size_arcsec: float) -> FloatArray:
    return np.where(np.arange(years) >= at, size_arcsec, 0.0)


def told(found: History) -> set[tuple[str, int]]:
    """What was found of offset x, and at which calibration."""
    return {(each.kind, found.labels.index(each.at)) for each in found.findings if "offset_v.x" in each.characteristics}


@pytest.mark.parametrize("rate_arcsec", [20.0, 83.0, 1650.0, 1e5])
def test_a_steady_drift_of_a_lone_sensor_is_found_however_large(rate_arcsec: float) -> None:
    for seed in range(10):
        found = history_of(yearly(np.random.default_rng(seed), rate_arcsec * np.arange(8.0), 2.0), "SN0")
        assert {kind for kind, _ in told(found)} == {"drift"}, found.findings
        (drift,) = found.findings
        assert drift.size_deg == pytest.approx(rate_arcsec / 3600.0, rel=0.25)
        (chart,) = (chart for chart in found.charts if chart.name == "offset_v.x")
        assert chart.scatter * chart.deg_per_unit * 3600.0 < 6.0, "the drift is in the scatter"
        assert found.conclusion == ""


@pytest.mark.parametrize(("size_arcsec", "at"), [(50.0, 5), (50.0, 2), (50.0, 4), (1000.0, 3), (1000.0, 6)])
def test_a_step_of_a_lone_sensor_is_found_and_dated(size_arcsec: float, at: int) -> None:
    """Also one from before the scatter was known, or too small to be seen from one calibration."""
    for seed in range(10):
        found = history_of(yearly(np.random.default_rng(seed), stepped(8, at, size_arcsec), 2.0), "SN0")
        assert told(found) == {("step", at)}, (seed, found.findings)
        assert found.findings[0].size_deg == pytest.approx(size_arcsec / 3600.0, rel=0.3)


@pytest.mark.parametrize("scatter_arcsec", [0.0, 5.0])
@pytest.mark.parametrize("years", [5, 8, 12])
def test_sound_lone_sensors_ring_no_more_than_is_stated(years: int, scatter_arcsec: float) -> None:
    """0.3 % at every calibration; 60 histories have 2 false alarms in twelve years."""
    alarms = sum(
        bool(history_of(yearly(np.random.default_rng(seed), np.zeros(years), scatter_arcsec), "SN0").findings)
        for seed in range(60)
    )
    assert alarms <= 5


@pytest.mark.soak
@pytest.mark.parametrize("scatter_arcsec", [0.0, 1.5, 5.0])
@pytest.mark.parametrize("years", range(3, 13))
def test_false_alarms_of_lone_sensors(years: int, scatter_arcsec: float) -> None:
    alarms = sum(
        bool(history_of(yearly(np.random.default_rng(seed), np.zeros(years), scatter_arcsec), "SN0").findings)
        for seed in range(2000)
    )
    assert alarms <= 2000 * 0.003 * (years - 1)


def test_a_drift_of_a_whole_kind_is_in_no_scatter_either() -> None:
    """Every offset of every sensor drifts alike, as with the meter: the others do not vouch for it."""
    for seed in range(5):
        population = yearly(np.random.default_rng(seed), 83.0 * np.arange(8.0), 2.0, others=3, alike=True)
        assert "drift" in {kind for kind, _ in told(history_of(population, "SN0"))}


def test_what_would_not_be_seen_is_told_with_nothing_was_found() -> None:
    found = history_of(yearly(np.random.default_rng(2), np.zeros(8), 2.0), "SN0")
    step_deg, drift_deg = found.unseen_deg or (0.0, 0.0)
    assert (
        f"a step below {step_deg:.4f}° or a drift below {drift_deg:.4f}° a year would not be seen" in found.conclusion
    )
    twice = history_of(yearly(np.random.default_rng(2), 2.0 * 3600.0 * drift_deg * np.arange(8.0), 2.0), "SN0")
    assert "drift" in {kind for kind, _ in told(twice)}
