"""Terms that points have by chance alone stand in no fit: a table's last digit is no second order of a sensor."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.models.extended import centring_over
from ams.models.leverage import attitudes_between, least_lever
from ams.models.rate_terms import rate_centring_over
from ams.observations import Observations

AXES = "xyz"
QUARTERS_DEG = np.array([-180.0, -90.0, 0.0, 90.0])
PITCH_DEG = np.array([-60.0, -30.0, 0.0, 30.0, 60.0])
NOISE_V, K_V_PER_G = 1.5e-5, 2.5


def grid_deg(pitch_deg: np.ndarray, roll_deg: np.ndarray, beside_deg: np.ndarray | float) -> tuple[np.ndarray, ...]:
    pitch, roll = np.meshgrid(pitch_deg, roll_deg, indexing="ij")
    return pitch.ravel(), (roll + beside_deg).ravel()


@pytest.mark.parametrize("beside_deg", [0.0, 1e-4, 1e-3, 0.01, 0.1, 1.0])
def test_four_rolls_determine_no_terms_however_the_table_stands_beside_them(beside_deg: float) -> None:
    """From 0.001° on a term of f_y·f_z was estimated with a lever of that: 82 000″ between the rolls."""
    beside = beside_deg * np.array([0.9, -0.4, 0.1, -1.0])
    pitch_deg, roll_deg = grid_deg(PITCH_DEG, QUARTERS_DEG, beside)
    force = specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
    assert [centring_over(force, len(force), axis) for axis in AXES] == [None] * 3


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("beside_deg", [1e-3, 0.02, 0.3])
def test_outputs_between_the_rolls_are_as_good_as_at_them(beside_deg: float, seed: int) -> None:
    """The sensor is linear: what its calibration says of any attitude in the range is off by its noise alone."""
    chance = np.random.default_rng(seed)
    beside = beside_deg * chance.uniform(-1.0, 1.0, 4)
    pitch_deg, roll_deg = grid_deg(PITCH_DEG, QUARTERS_DEG, beside)
    force = np.tile(specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg)), (6, 1))
    points = pitch_deg.size
    truth = {axis: K_V_PER_G * np.eye(3)[index] + 0.01 * chance.normal(size=3) for index, axis in enumerate(AXES)}
    outputs = {axis: 0.005 + force @ k + NOISE_V * chance.normal(size=len(force)) for axis, k in truth.items()}
    rows = Observations(
        np.repeat(np.arange(6), points), np.tile(np.arange(points), 6), np.tile(np.deg2rad(pitch_deg), 6),
        np.tile(np.deg2rad(roll_deg), 6), outputs,
    )  # fmt: skip
    between = specific_force(
        *(angles.ravel() for angles in np.meshgrid(np.deg2rad(PITCH_DEG), np.deg2rad([-135, 45.0])))
    )
    for axis, solved in calibrate(rows, CalibrationRequest()).axes.items():
        offset_v, *k = solved.primary
        assert len(k) == 3
        off_v = offset_v + between @ np.array(k) - (0.005 + between @ truth[axis])
        assert np.abs(off_v).max() < 2.0 * NOISE_V


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg", "terms"),
    [
        (np.arange(-90, 91, 15), np.arange(-180, 180, 30), 6),
        (np.arange(-30, 31, 10), np.arange(-30, 31, 15), 6),
        (np.arange(-5, 6), np.arange(-180, 180, 30), 6),
        (np.array([-60, 0, 60]), np.arange(-180, 180, 60), 5),
        (PITCH_DEG, np.arange(-180, 180, 72), 6),
    ],
)
def test_designs_that_have_them_keep_them(pitch_deg: np.ndarray, roll_deg: np.ndarray, terms: int) -> None:
    force = specific_force(*map(np.deg2rad, grid_deg(pitch_deg, roll_deg, 0.0)))
    assert len(centring_over(force, len(force), "x") or ()) == terms


@pytest.mark.parametrize(
    ("rates_dps", "terms"), [((-60.0, 60.0), 0), ((-60.0, 0.0, 60.0), 1), ((-60.0, -20.0, 20.0, 60.0), 2)]
)
def test_rates_that_a_servo_does_not_hold_exactly_determine_no_term_of_their_own(
    rates_dps: tuple[float, ...], terms: int
) -> None:
    chance = np.random.default_rng(5)
    along = np.repeat(rates_dps, 12) + chance.uniform(-0.3, 0.3, 12 * len(rates_dps))
    across = chance.uniform(-60.0, 60.0, (along.size, 2))
    found = rate_centring_over(np.column_stack([along, across]), along.size, "x")
    assert len(found or ()) == terms


def test_the_lever_is_that_of_the_weakest_combination() -> None:
    """Two columns that are alike at the points and not between them: their difference is what is not told."""
    steps = np.linspace(-1.0, 1.0, 201)
    within = np.column_stack([steps, steps**3])
    assert least_lever(within, within) == pytest.approx(1.0)
    ends = np.array([[-1.0, -1.0], [1.0, 1.0]])
    assert least_lever(ends, within) == pytest.approx(0.0, abs=1e-7)
    assert least_lever(0.05 * within, within) == pytest.approx(0.05)


def test_rolls_that_go_round_have_no_gap_at_their_end() -> None:
    """Four rolls a quarter of a turn apart reach all round, four of five do not."""
    round_deg = np.array([-179.999, -90.0004, 0.0, 89.999])
    for roll_deg, is_round in ((round_deg, True), (np.array([-144.0, -72.0, 0.0, 72.0]), False)):
        forces = attitudes_between(specific_force(np.zeros(4), np.deg2rad(roll_deg)))
        reached_deg = np.rad2deg(np.arctan2(-forces[:, 1], -forces[:, 2]))
        assert (np.ptp(reached_deg) > 330.0) == is_round
