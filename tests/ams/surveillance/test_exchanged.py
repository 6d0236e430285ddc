"""Two sensors that were exchanged are named from their second calibration on; sensors that are alike never are."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance
from ams.surveillance.exchanged import Recalibrated, exchanged
from ams.units import RAD_PER_ARCSEC

_GRID_DEG = np.array([(p, r) for p in range(-60, 61, 30) for r in range(-180, 180, 90)], dtype=float)
_PITCH, _ROLL = np.deg2rad(_GRID_DEG).T
_FORCE = np.stack([np.sin(_PITCH), -np.cos(_PITCH) * np.sin(_ROLL), -np.cos(_PITCH) * np.cos(_ROLL)], axis=1)
_FIRST = datetime(2026, 5, 1, tzinfo=UTC)
NOISE_ARCSEC = 0.5


def a_package(chance: np.random.Generator, unlike: float) -> FloatArray:
    """(3, 4) offsets and k of a package of 2.5 V/g; ``unlike``: 1 for millivolts, half a percent and minutes of arc."""
    k = np.eye(3) * (1.0 + unlike * chance.normal(0.0, 0.005, (3, 1))) + unlike * chance.normal(0.0, 0.003, (3, 3))
    return np.hstack([unlike * chance.normal(0.0, 0.005, (3, 1)), 2.5 * k])


def calibrated(
    sensor: str,
    package: FloatArray,
    chance: np.random.Generator,
    day: int,
    scatter_arcsec: float,
    gravity_mps2: float = 9.8,
) -> CoefficientSet:
    """Calibrate a package that was mounted anew, on a day of its own, three times over twenty attitudes."""
    count, scatter = len(_FORCE), scatter_arcsec * RAD_PER_ARCSEC
    offset = package[:, :1] + 2.5 * scatter * chance.standard_normal((3, 1))
    k = package[:, 1:] * (1.0 + scatter * chance.standard_normal((3, 1)))
    k = k + np.cross(30.0 * RAD_PER_ARCSEC * chance.standard_normal(3), k)
    noise = 2.5 * NOISE_ARCSEC * RAD_PER_ARCSEC * chance.standard_normal((3, 3 * count))
    outputs = {axis: np.tile(offset[row] + _FORCE @ k[row], 3) + noise[row] for row, axis in enumerate("xyz")}
    rows = Observations(
        np.repeat([1, 2, 3], count), np.tile(np.arange(count), 3), np.tile(_PITCH, 3), np.tile(_ROLL, 3), outputs
    )
    provenance = Provenance(
        sensor=sensor, gravity_mps2=gravity_mps2, gravity_source="survey", pitch_range_deg=(-60.0, 60.0),
        roll_range_deg=(-180.0, 180.0), created_utc=_FIRST + timedelta(days=day), software_version="0.1.0",
        rig="bench", procedure="small grid", simulated=False, run_id=f"run-{day}", serial=sensor,
        journal_sha256=f"{day:064x}",
    )  # fmt: skip
    return build_set(calibrate(rows, CalibrationRequest(extended="no")), provenance)


def second_calibrations(
    seed: int, order: tuple[int, ...], *, unlike: float = 1.0, scatter_arcsec: float = 2.0, dropped: int = 0
) -> list[Recalibrated]:
    """Packages calibrated twice; the second time each stands in the place of another, as ``order`` has it.

    ``dropped``: of so many the characteristics changed in between by as much as packages differ.
    """
    chance = np.random.default_rng(seed)
    packages = [a_package(chance, unlike) for _ in order]
    before = [calibrated(f"SN{at}", entry, chance, 0, scatter_arcsec) for at, entry in enumerate(packages)]
    for at in range(dropped):
        packages[at] = a_package(chance, unlike)
    new = [calibrated(f"SN{at}", packages[of], chance, 365, scatter_arcsec) for at, of in enumerate(order)]
    return [Recalibrated(made, old) for made, old in zip(new, before, strict=True)]


@pytest.mark.parametrize("scatter_arcsec", [0.0, 2.0, 20.0])
def test_two_that_were_exchanged_are_named_with_the_sets_that_they_fit(scatter_arcsec: float) -> None:
    found = exchanged(second_calibrations(1, (1, 0, 2), scatter_arcsec=scatter_arcsec))
    assert set(found) == {"SN0", "SN1"}
    assert len(set(found.values())) == 1
    assert not found["SN0"].is_of_before
    assert found["SN0"].sentence == (
        "SN0 and SN1 look exchanged: SN0's output fits SN1's set of 2026-05-01, and not its own of 2026-05-01; SN1's "
        "output fits SN0's set of 2026-05-01, and not its own of 2026-05-01"
    )


def test_three_that_went_round_are_named_together() -> None:
    assert set(exchanged(second_calibrations(2, (1, 2, 0, 3)))) == {"SN0", "SN1", "SN2"}


@pytest.mark.parametrize("gravity_mps2", [9.78, 9.8, 9.83])
@pytest.mark.parametrize("of_meter", [0.0, 1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("unlike", [0.1, 1.0])
def test_neither_another_site_nor_a_gain_of_the_meter_hides_an_exchange_or_feigns_one(
    unlike: float, of_meter: float, gravity_mps2: float
) -> None:
    """A tenth of the usual differences: 0 to 2 of 8 exchanges were named with 1000 ppm of either."""
    chance = np.random.default_rng(7)
    packages = [a_package(chance, unlike) for _ in range(3)]
    before = [calibrated(f"SN{at}", package, chance, 0, 2.0) for at, package in enumerate(packages)]
    read = [np.hstack([package[:, :1], package[:, 1:] * gravity_mps2 / 9.8]) * (1.0 + of_meter) for package in packages]
    for order, names in (((1, 0, 2), {"SN0", "SN1"}), ((0, 1, 2), set())):
        new = [calibrated(f"SN{at}", read[of], chance, 365, 2.0, gravity_mps2) for at, of in enumerate(order)]
        assert set(exchanged([Recalibrated(made, old) for made, old in zip(new, before, strict=True)])) == names


def test_a_run_after_an_exchanged_one_that_counts_is_the_sensors_own() -> None:
    """Right, exchanged, right again: two of three agree, and the third run was put into quarantine."""
    chance = np.random.default_rng(3)
    packages = [a_package(chance, 1.0) for _ in range(3)]
    runs = [
        [calibrated(f"SN{at}", packages[of], chance, 365 * year, 2.0) for at, of in enumerate(order)]
        for year, order in enumerate([(0, 1, 2), (1, 0, 2), (0, 1, 2)])
    ]
    found = exchanged([Recalibrated(new, before, earlier) for earlier, before, new in zip(*runs, strict=True)])
    assert {name: exchange.is_of_before for name, exchange in found.items()} == {"SN0": True, "SN1": True}
    assert found["SN0"].sentence == (
        "SN0 and SN1 look exchanged in their sets before (SN0's of 2027-05-01; SN1's of 2027-05-01), not now: each "
        "output fits its own set of before that"
    )
    unknown = exchanged([Recalibrated(new, before) for before, new in zip(*runs[1:], strict=True)])
    assert not any(exchange.is_of_before for exchange in unknown.values())
    assert set(unknown) == {"SN0", "SN1"}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("unlike", "scatter_arcsec", "dropped"),
    [(1.0, 2.0, 0), (1.0, 20.0, 0), (0.02, 2.0, 0), (0.0, 0.0, 0), (1.0, 2.0, 2)],
)
def test_good_second_calibrations_are_never_called_exchanged(
    unlike: float, scatter_arcsec: float, dropped: int
) -> None:
    """Of five packages: unlike or alike, with more scatter than their sets state, and two that were dropped."""
    for seed in range(10):
        made = second_calibrations(seed, (0, 1, 2, 3, 4), unlike=unlike, scatter_arcsec=scatter_arcsec, dropped=dropped)
        assert exchanged(made) == {}


def test_a_good_second_calibration_with_more_scatter_than_its_set_states_is_none() -> None:
    assert exchanged(second_calibrations(5, (0, 1, 2), scatter_arcsec=20.0)) == {}


def test_packages_that_are_alike_within_their_uncertainties_are_not_named_when_they_are_exchanged() -> None:
    assert exchanged(second_calibrations(3, (1, 0), unlike=0.0, scatter_arcsec=0.0)) == {}


def test_one_that_stands_for_another_which_was_not_changed_is_no_exchange() -> None:
    assert exchanged(second_calibrations(4, (1, 1))) == {}
