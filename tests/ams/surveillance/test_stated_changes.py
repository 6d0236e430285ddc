"""A sound second calibration is called changed in 5 % at most, of however few replications; a real change shows."""

from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from archived_runs import a_sensor

from ams.archive.synthetic import AXES, GRAVITY_MPS2, RIG, START
from ams.surveillance.characteristics import PackageNumbers
from ams.surveillance.control_chart import history_of
from ams.surveillance.history_points import point_row, unpack
from ams.surveillance.series import PointLabel, Population
from ams.surveillance.stated_changes import StatedScatter, difference_dof, stated_change, stated_scatter
from ams.units import RAD_PER_ARCSEC

PAIRS = 2000
SCATTER_ARCSEC = 0.5
"""Of one calibration, whatever it consists of."""
NO_STANDARDS: tuple[tuple[str, str, str], ...] = ()


def drawn(
    chance: np.random.Generator, replications: tuple[int, ...], step_arcsec: float = 0.0
) -> tuple[Population, list[StatedScatter]]:
    """Return calibrations of an aligned package that stayed, the last with offset x off by a step.

    Each states the scatter of its replications: of a mean of n, with n − 1 degrees of freedom, parameter by parameter.
    """
    sd_v = 2.5 * SCATTER_ARCSEC * RAD_PER_ARCSEC
    level = np.hstack([np.full((3, 1), 0.005), 2.5 * np.eye(3)])
    primary = level + sd_v * chance.standard_normal((len(replications), 3, 4))
    primary[-1, 0, 0] += 2.5 * step_arcsec * RAD_PER_ARCSEC
    labels, stated = [], []
    for year, n in enumerate(replications):
        when = START + timedelta(days=365.25 * year)
        labels.append(PointLabel(str(year), "SN0", None, when, RIG, False, GRAVITY_MPS2))
        found = (SCATTER_ARCSEC * RAD_PER_ARCSEC) ** 2 * chance.chisquare(n - 1, (3, 4)) / (n - 1)
        offsets, gains = np.diag(found[:, 0]), np.diag(found[[0, 1, 2], [1, 2, 3]])
        pairs = ((0, 1), (0, 2), (1, 2))  # an angle between two axes turns with either
        angles = np.array([[found[a, 1 + b] * (axis == a) + found[b, 1 + a] * (axis == b) for a, b in pairs]
                           for axis in range(3)])  # fmt: skip
        variance = np.hstack([offsets, gains, angles])
        stated.append(StatedScatter(variance, np.full(3, n - 1.0), np.zeros(3, dtype=bool), NO_STANDARDS))
    spread = np.broadcast_to(np.eye(4) * sd_v**2, (len(labels), 3, 4, 4)).copy()
    return Population(labels, PackageNumbers(AXES, primary, spread, spread)), stated


def changed_share(replications: tuple[int, ...], step_arcsec: float = 0.0, pairs: int = PAIRS) -> float:
    changed = 0
    for seed in range(pairs):
        population, stated = drawn(np.random.default_rng(seed), replications, step_arcsec)
        changed += (
            "offset x" in stated_change(population, "SN0", stated).sentence
            if step_arcsec
            else bool(stated_change(population, "SN0", stated).sentence)
        )
    return changed / pairs


@pytest.mark.parametrize("replications", [(2, 2), (3, 3), (6, 6), (2, 6), (6, 3), (3, 3, 3, 3)])
def test_a_sound_calibration_is_called_changed_in_five_of_a_hundred_at_most(replications: tuple[int, ...]) -> None:
    assert changed_share(replications) <= 0.05 + 3.0 * np.sqrt(0.05 * 0.95 / PAIRS)


@pytest.mark.parametrize(("replications", "in_u"), [((3, 3), 13.0), ((6, 6), 6.0)])
def test_a_step_of_a_few_expanded_uncertainties_is_told(replications: tuple[int, ...], in_u: float) -> None:
    """``in_u``: standard uncertainties of one calibration; three expanded ones of three replications are thirteen."""
    assert changed_share(replications, in_u * SCATTER_ARCSEC, 300) > 0.6


def test_equal_parts_have_the_degrees_of_freedom_of_both_and_a_certificate_all() -> None:
    one = np.ones((2, 1))
    assert difference_dof(one, np.array([2.0, 2.0])) == pytest.approx(4.0)
    assert difference_dof(one, np.array([1.0, 5.0])) == pytest.approx(2.0)
    assert difference_dof(one, np.array([2.0, np.inf])) == pytest.approx(8.0)
    assert np.isinf(difference_dof(one, np.array([np.inf, np.inf])))
    assert np.isinf(difference_dof(0.0 * one, np.array([2.0, 2.0])))


def test_what_a_standard_is_wrong_by_is_in_no_difference_under_one_certificate() -> None:
    population, stated = drawn(np.random.default_rng(1), (6, 6), 8.0)
    meter = np.full((1, 9), (5.0 * RAD_PER_ARCSEC) ** 2)

    def is_changed(certificate: str) -> bool:
        having = [
            replace(
                part,
                variance_rad2=np.vstack([part.variance_rad2, meter]),
                dof=np.append(part.dof, np.inf),
                is_of_standards=np.append(part.is_of_standards, True),
                certificates=(("meter", "2823A", named),),
            )
            for part, named in zip(stated, ("C-1", certificate), strict=True)
        ]
        return bool(stated_change(population, "SN0", having).sentence)

    assert is_changed("C-1")
    assert not is_changed("C-2")


def test_a_set_states_what_its_point_scatters_by_part_by_part() -> None:
    coefficients = a_sensor(0).coefficients
    stated = stated_scatter(coefficients.document, "SN1")
    row = point_row(coefficients, is_check=False)
    label = PointLabel(coefficients.sha256, "SN1", None, coefficients.created_utc, RIG, False, GRAVITY_MPS2)
    point = Population([label], unpack("xyz", [row["numbers"]], row["sensitivity_name"]))
    assert stated.variance_rad2.sum(axis=0) == pytest.approx(point.scatter_rad[0] ** 2)
    of_replications = stated.dof[np.isfinite(stated.dof)]
    assert set(of_replications) == {2.0}, "three replications"
    assert history_of(point, "SN1").explained_deg is None
