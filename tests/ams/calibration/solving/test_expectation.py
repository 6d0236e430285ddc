"""Laws of the expectation: what is said beforehand is what solved campaigns state, in the root of the mean square."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, VECTOR_V_PER_G, Campaign

from ams.calibration.calibrate import calibrate
from ams.calibration.solving.expectation import Expectation, expect
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import IndexErrors, TableUncertainty
from ams.solve.expected import Belief

CIRCLE = np.linspace(-180.0, 150.0, 12)
TABLE = Campaign(index_limit_arcsec=1.0)
SCENES = {
    "nothing but noise": Campaign(),
    "a table": TABLE,
    "lack of fit": Campaign(lack_of_fit_arcsec=2.0),
    "everything": Campaign(index_limit_arcsec=3.0, lack_of_fit_arcsec=1.0, offset_drift_arcsec=1.0),
    "drift": Campaign(sensitivity_drift=1e-5, offset_drift_arcsec=2.0),
    "one replication": Campaign(replications=1, index_limit_arcsec=1.0),
    "few points, many replications": Campaign(
        np.linspace(-90.0, 90.0, 3), np.linspace(-180.0, 90.0, 4), replications=8, index_limit_arcsec=1.0
    ),
    "a small range": Campaign(np.linspace(-30.0, 30.0, 7), CIRCLE, index_limit_arcsec=1.0, noise_arcsec=1.5),
}


def _request(scene: Campaign, extended: str = "yes") -> CalibrationRequest:
    limit = scene.index_limit_arcsec * ARCSEC
    shape = dict.fromkeys(("pitch", "roll"), IndexErrors("independent"))
    table = TableUncertainty(limit, limit, "limit", errors=shape) if limit > 0.0 else None
    return CalibrationRequest(table=table, extended=extended)  # type: ignore[arg-type]


def _expected(scene: Campaign, request: CalibrationRequest) -> Expectation:
    nothing = replace(
        scene, noise_arcsec=0.0, lack_of_fit_arcsec=0.0, offset_drift_arcsec=0.0, sensitivity_drift=0.0,
        index_limit_arcsec=0.0,
    )  # fmt: skip
    beliefs = {}
    for axis, k in VECTOR_V_PER_G.items():
        arcsec_v = ARCSEC * float(np.linalg.norm(k))
        drift = {f"k_{name}_v_per_g": abs(part) * scene.sensitivity_drift for name, part in zip("xyz", k, strict=True)}
        beliefs[axis] = Belief(
            scene.noise_arcsec * arcsec_v,
            scene.lack_of_fit_arcsec * arcsec_v,
            {"offset_v": scene.offset_drift_arcsec * arcsec_v, **drift},
        )
    return expect(nothing.observe(np.random.default_rng(0)), request, beliefs)


def _ratios(scene: Campaign, request: CalibrationRequest, seeds: int) -> np.ndarray:
    """Expected over root mean square of stated, for every parameter of every axis that was always determined."""
    squares: dict[tuple[str, str], list[float]] = {}
    for seed in range(seeds):
        for axis, solved in calibrate(scene.observe(np.random.default_rng([7, seed])), request).axes.items():
            for item in solved.parameters:
                if item.standard_uncertainty is not None:
                    squares.setdefault((axis, item.name), []).append(item.standard_uncertainty**2)
    expected = _expected(scene, request).axes
    return np.array(
        [
            item.standard_uncertainty / np.sqrt(np.mean(squares[axis, item.name]))
            for axis, entry in expected.items()
            for item in entry.parameters
            if item.standard_uncertainty is not None and len(squares.get((axis, item.name), ())) == seeds
        ]
    )


def test_of_a_table_the_expectation_is_what_is_stated() -> None:
    """Few seeds: where a table is in it, what is stated hardly scatters."""
    ratios = _ratios(replace(TABLE, noise_arcsec=0.2), _request(TABLE), 8)
    assert ratios.size > 20
    assert np.median(ratios) == pytest.approx(1.0, abs=0.08)


@pytest.mark.thorough
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_the_expectation_is_the_root_mean_square_of_what_is_stated(scene: Campaign) -> None:
    """The median over all parameters: one alone scatters by 1/√(2 × seeds × degrees of freedom)."""
    ratios = _ratios(scene, _request(scene), 20)
    assert np.median(ratios) == pytest.approx(1.0, abs=0.07)


@pytest.mark.soak
@pytest.mark.parametrize("number", range(30))
def test_every_parameter_is_expected_within_a_fifth(number: int) -> None:
    """Thirty scenes drawn at random, 100 seeds each."""
    chance = np.random.default_rng([15, number])
    reach = float(chance.choice([30.0, 60.0, 90.0]))
    scene = Campaign(
        np.linspace(-reach, reach, int(chance.integers(3, 14))),
        np.linspace(-180.0, 180.0, int(chance.integers(5, 14))),
        replications=int(chance.integers(4, 9)),
        noise_arcsec=float(chance.uniform(0.2, 2.0)),
        index_limit_arcsec=float(chance.choice([0.0, 1.0, 3.0])),
        lack_of_fit_arcsec=float(chance.choice([0.0, 0.5, 2.0])),
        offset_drift_arcsec=float(chance.choice([0.0, 0.5])),
        sensitivity_drift=float(chance.choice([0.0, 3e-6])),
    )
    ratios = _ratios(scene, _request(scene, str(chance.choice(["yes", "no"]))), 100)
    assert ratios.size > 0
    assert np.all(np.abs(ratios - 1.0) < 0.2), (scene, np.sort(ratios)[[0, -1]])


def test_less_noise_more_replications_and_a_better_table_are_never_expected_to_be_worse() -> None:
    base = Campaign(index_limit_arcsec=2.0, lack_of_fit_arcsec=1.0, noise_arcsec=1.0)

    def offset(scene: Campaign) -> float:
        return float(np.sqrt(_expected(scene, _request(scene)).package.covariance[0, 0]))

    better = [replace(base, noise_arcsec=0.5), replace(base, replications=8), replace(base, index_limit_arcsec=1.0)]
    assert all(offset(scene) < offset(base) for scene in better)
