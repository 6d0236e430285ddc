"""Errors of angles hold their stated uncertainty at attitudes of which the rig itself is not sure.

Tables and bases are drawn within what is declared of them, and turned by explicit rotations. The truth is what the set
under test is wrong by where the reference is right: the angles that it tells of a package without noise that truly
stands at the nominal attitude, less these.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from physics_scenes.rotations import ARCSEC, LEVEL_FORCE, pitch_matrix, roll_matrix, turn_matrix, turned
from physics_scenes.tables import Curve, eight_harmonics, once_per_turn, white_teeth, zeroed
from solved_sets import tp_set

from ams.calibration.calibrate import calibrate
from ams.calibration.jointly import with_level
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import IndexErrors, Shape, TableUncertainty, known_errors
from ams.observations import Observations
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance
from ams.solve.table_errors import TablePriors
from ams.surveillance.adjustment import Acceptance, adjust, from_document, to_document
from ams.surveillance.attitude_errors import REFERENCE, AngleErrors, errors_of
from ams.surveillance.reference_attitude import ReferenceAttitude, ReferenceInWords, parts_of

LIMIT_ARCSEC = 1.0
NOISE_ARCSEC = 0.4
GRID = np.deg2rad([(p, r) for p in range(-90, 91, 15) for r in range(-180, 180, 30)])
OFFSET_V = {"x": 0.005, "y": -0.02, "z": 0.011}
K_V_PER_G = {"x": (2.4999, 0.0179, 0.0125), "y": (0.0091, -2.48, 0.015), "z": (-0.011, 0.02, 2.51)}
CurveOf = Callable[[float, int, np.random.Generator], Curve]
SHAPES: dict[str, CurveOf] = {"once": once_per_turn, "harmonics": eight_harmonics, "teeth": white_teeth}


@dataclass(frozen=True)
class Rig:
    """A table, its base and what is declared of both."""

    shape: CurveOf = once_per_turn
    zero_rad: float | None = None
    declared: Shape = "unknown"
    tilt_limit_arcsec: float = 0.0

    @property
    def shared(self) -> tuple[SharedError, ...]:
        u_rad = self.tilt_limit_arcsec * ARCSEC / np.sqrt(3.0)
        named = (("level of the base about pitch", "pitch"), ("level of the base about roll", "base-tilt"))
        return tuple(SharedError(name, effect, u_rad) for name, effect in named) if u_rad else ()

    @property
    def table(self) -> TableUncertainty:
        errors = dict.fromkeys(("pitch", "roll"), IndexErrors(self.declared, self.zero_rad))
        return TableUncertainty(LIMIT_ARCSEC * ARCSEC, LIMIT_ARCSEC * ARCSEC, kind="limit", errors=errors)

    @property
    def reference(self) -> ReferenceAttitude:
        shared = dict.fromkeys("xyz", self.shared)
        return ReferenceAttitude(
            with_level(TablePriors(self.table), shared), ReferenceInWords("table"), parts_of(shared)
        )

    def observe(self, axes: str, replications: int, chance: np.random.Generator, gain: float = 1.0) -> Observations:
        """Return the rows of one campaign: a table and a base of its own."""
        curves = [self.shape(LIMIT_ARCSEC * ARCSEC, 1, chance) for _ in range(2)]
        curves = curves if self.zero_rad is None else [zeroed(curve) for curve in curves]
        pitch, roll = (angle + curve(angle)[0] for angle, curve in zip(GRID.T, curves, strict=True))
        tilt = chance.uniform(-1.0, 1.0, 2) * self.tilt_limit_arcsec * ARCSEC
        clean = outputs_v(axes, pitch, roll, np.array([tilt[0], tilt[1], 0.0]), gain)
        points = GRID.shape[0]
        noise = {axis: 2.5 * NOISE_ARCSEC * ARCSEC * chance.standard_normal((replications, points)) for axis in axes}
        return Observations(
            np.repeat(np.arange(1, replications + 1), points),
            np.tile(np.arange(points), replications),
            *(np.tile(angle, replications) for angle in GRID.T),
            {axis: (clean[axis] + noise[axis]).ravel() for axis in axes},
        )

    def solved(self, rows: Observations) -> CoefficientSet:
        request = CalibrationRequest(table=self.table, shared_errors=dict.fromkeys(rows.outputs, self.shared))
        provenance = Provenance(
            sensor="TP1", gravity_mps2=9.79826, gravity_source="survey", pitch_range_deg=(-90.0, 90.0),
            roll_range_deg=(-180.0, 180.0), created_utc=tp_set("x").created_utc, software_version="0.1.0",
            rig="bench", procedure="fit", simulated=False,
        )  # fmt: skip
        return build_set(calibrate(rows, request), provenance)


def outputs_v(axes: str, pitch: np.ndarray, roll: np.ndarray, tilt: np.ndarray, gain: float) -> dict[str, np.ndarray]:
    force = turned(turn_matrix(tilt), LEVEL_FORCE)
    force = turned(roll_matrix(roll), turned(pitch_matrix(pitch), force))
    return {axis: OFFSET_V[axis] + gain * (force @ np.array(K_V_PER_G[axis])) for axis in axes}


def true_errors_deg(applied: CoefficientSet, gain: float) -> dict[str, np.ndarray]:
    """Angle to (K,) what the set tells of the package at the nominal attitudes, less these; by Newton's method."""
    axes, told, step = "".join(applied.axes), GRID.T.copy(), 1e-5
    angles = ("pitch", "roll") if len(axes) > 1 else ("pitch",)
    wanted = outputs_v(axes, *GRID.T, np.zeros(3), gain)

    def predicted(at: np.ndarray) -> np.ndarray:
        outputs = apply(applied, at[0], at[1], None, beyond_validity=True)
        return np.stack([outputs[axis] / np.linalg.norm(K_V_PER_G[axis]) for axis in axes], axis=-1)

    target = np.stack([wanted[axis] / np.linalg.norm(K_V_PER_G[axis]) for axis in axes], axis=-1)
    for _ in range(3):
        moves = [step * np.eye(2)[index][:, None] for index in range(len(angles))]
        slopes = np.stack([(predicted(told + by) - predicted(told - by)) / (2.0 * step) for by in moves], axis=-1)
        found = np.linalg.pinv(slopes) @ (target - predicted(told))[..., None]
        told[: len(angles)] += found[..., 0].T
    return {angle: np.rad2deg(told[index] - GRID.T[index]) for index, angle in enumerate(angles)}


def points_of(errors: AngleErrors) -> list[tuple[float, float]]:
    return [(round(float(p), 6), round(float(r), 6)) for p, r in zip(errors.pitch_deg, errors.roll_deg, strict=True)]


def held(errors: AngleErrors, truth_deg: np.ndarray, of_all: set[tuple[float, float]]) -> list[bool]:
    """Whether |error − truth| ≤ U at every point that tells all angles.

    Two axes on their side read more than one g where the gain of the set is off: no attitude does that, so that there
    is no truth to compare with.
    """
    at = {(round(p, 6), round(r, 6)): t for (p, r), t in zip(np.rad2deg(GRID), truth_deg, strict=True)}
    points = points_of(errors)
    is_inside = np.abs(errors.error_deg - np.array([at[point] for point in points])) <= errors.expanded_deg
    return [bool(inside) for inside, point in zip(is_inside, points, strict=True) if point in of_all]


def shares_held(rig: Rig, axes: str, seed: int, campaigns: int, *, as_found: bool = False) -> tuple[float, float]:
    """Return the shares that are held with the reference counted, and without."""
    chance = np.random.default_rng(seed)
    inside: tuple[list[bool], list[bool]] = ([], [])
    for _ in range(campaigns):
        rows = rig.observe(axes, 6, chance)
        new = rig.solved(rows)
        applied = rig.solved(rig.observe(axes, 6, chance, gain=1.0002)) if as_found else new
        truth = true_errors_deg(applied, 1.0)
        for found, reference in zip(inside, (rig.reference, None), strict=True):
            by_angle = errors_of(applied, new, rows, (-80.0, 80.0), reference)
            of_all = set.intersection(*(set(points_of(errors)) for errors in by_angle.values()))
            for angle, errors in by_angle.items():
                found += held(errors, truth[angle], of_all)
    return float(np.mean(inside[0])), float(np.mean(inside[1]))


@pytest.mark.parametrize(
    ("rig", "as_found"),
    [
        (Rig(once_per_turn), False),
        (Rig(once_per_turn, zero_rad=0.0, tilt_limit_arcsec=3.0), True),
        (Rig(eight_harmonics, tilt_limit_arcsec=3.0), False),
        (Rig(white_teeth), True),
        (Rig(white_teeth, zero_rad=0.0), False),
    ],
    ids=["once", "once-zeroed-tilted-as-found", "harmonics-tilted", "teeth-as-found", "teeth-zeroed"],
)
def test_three_axes_hold_their_uncertainty_against_the_truth(rig: Rig, *, as_found: bool) -> None:
    counted, left_out = shares_held(rig, "xyz", 11, 3, as_found=as_found)
    assert counted >= 0.93
    assert left_out < 0.93, "what was stated without the reference"


@pytest.mark.parametrize("axes", ["x", "xz"])
def test_fewer_axes_hold_it_too(axes: str) -> None:
    assert shares_held(Rig(once_per_turn), axes, 12, 3)[0] >= 0.93


@pytest.mark.thorough
@pytest.mark.parametrize("axes", ["x", "xy", "xyz"])
@pytest.mark.parametrize("tilt_limit_arcsec", [0.0, 3.0])
@pytest.mark.parametrize("zero_rad", [None, 0.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_of_table_and_base_is_held(
    shape: str, zero_rad: float | None, tilt_limit_arcsec: float, axes: str
) -> None:
    rig = Rig(SHAPES[shape], zero_rad, tilt_limit_arcsec=tilt_limit_arcsec)
    for as_found in (False, True):
        assert shares_held(rig, axes, 13, 20, as_found=as_found)[0] >= 0.93


@pytest.mark.parametrize("replications", [1, 2, 6])
@pytest.mark.parametrize("axes", ["x", "xz", "xyz"])
def test_no_uncertainty_is_less_for_the_reference_and_the_budget_adds_up(axes: str, replications: int) -> None:
    """With two replications Student's factor falls faster than the standard uncertainty grows."""
    rig = Rig(once_per_turn, zero_rad=0.0, tilt_limit_arcsec=0.5)
    rows = rig.observe(axes, replications, np.random.default_rng(3))
    new = rig.solved(rows)
    with_it, without = (errors_of(new, new, rows, None, reference) for reference in (rig.reference, None))
    for angle, errors in with_it.items():
        assert (errors.expanded_deg >= without[angle].expanded_deg * (1.0 - 1e-12)).all()
        assert (errors.standard_uncertainty_deg >= without[angle].standard_uncertainty_deg * (1.0 - 1e-12)).all()
        squares = sum(part**2 for part in errors.parts_deg.values())
        assert errors.standard_uncertainty_deg**2 == pytest.approx(squares)
        assert REFERENCE not in without[angle].parts_deg


def test_a_reference_that_is_declared_independent_is_its_limit_as_a_rectangle() -> None:
    """Neither less, as what the coefficients follow of it would be, nor that once more beside it. Source: GUM 4.3.7."""
    rig = Rig(white_teeth, declared="independent")
    rows = rig.observe("xyz", 6, np.random.default_rng(4))
    new = rig.solved(rows)
    for errors in errors_of(new, new, rows, (-80.0, 80.0), rig.reference).values():
        stated_arcsec = 3600.0 * errors.parts_deg[REFERENCE]
        assert stated_arcsec == pytest.approx(np.full(stated_arcsec.size, LIMIT_ARCSEC / np.sqrt(3.0)), rel=1e-3)


def test_errors_are_told_at_the_attitudes_that_the_list_of_the_certificate_gives() -> None:
    """A table that is 30″ off in pitch, as its list says: the set has no error for it."""
    rig, chance = Rig(white_teeth), np.random.default_rng(5)
    listed_deg = [-120.0, -60.0, 0.0, 60.0, 120.0, 180.0]
    known = known_errors(listed_deg, [30.0] * 6, [0.1] * 6)
    table = replace(rig.table, errors={"pitch": IndexErrors(known=known)})
    rows = rig.observe("xyz", 6, chance)
    shown = replace(rows, pitch_rad=rows.pitch_rad - 30.0 * ARCSEC)
    new = rig.solved(rows)
    reference = ReferenceAttitude(TablePriors(table), ReferenceInWords("table"))
    errors = errors_of(new, new, shown, (-80.0, 80.0), reference)["pitch"]
    assert 3600.0 * np.abs(errors.error_deg).max() < 5.0
    assert 3600.0 * np.abs(errors_of(new, new, shown, (-80.0, 80.0))["pitch"].error_deg).min() > 25.0


def test_the_guarded_verdict_counts_the_reference_and_its_document_says_so() -> None:
    rig = Rig(once_per_turn)
    rows = rig.observe("xyz", 6, np.random.default_rng(6))
    new = rig.solved(rows)
    found = [errors_of(new, new, rows, (-60.0, 60.0), each)["pitch"] for each in (None, rig.reference)]
    limit = Acceptance({"pitch": float(np.mean([(np.abs(e.error_deg) + e.expanded_deg).max() for e in found]))})
    blind = adjust(None, new, rows, limit, (-60.0, 60.0))
    known = adjust(None, new, rows, limit, (-60.0, 60.0), None, rig.reference)
    assert (blind.as_left.verdict, known.as_left.verdict) == ("pass", "conditional")
    assert "index errors of the table" in blind.reference.sentence
    assert known.reference.sentence == "U counts what the reference attitude itself is wrong by (table)."
    back = from_document(to_document(known))
    assert to_document(back) == to_document(known)
    assert back.as_left.errors["pitch"].parts_deg.keys() == {"coefficients", "readings", REFERENCE}


def test_an_adjustment_stored_before_is_read_and_says_what_its_uncertainty_lacks() -> None:
    rig = Rig(once_per_turn)
    rows = rig.observe("xyz", 2, np.random.default_rng(7))
    document = to_document(adjust(None, rig.solved(rows), rows, Acceptance({"pitch": 1.0}), None, None, rig.reference))
    del document["reference"]
    for errors in document["as_left"]["errors"].values():  # type: ignore[index, call-overload, union-attr]
        del errors["parts_deg"]  # type: ignore[union-attr]
    back = from_document(document)
    assert back.as_left.verdict == "pass"
    assert back.as_left.errors["pitch"].parts_deg == {}
    assert "stored before they were counted" in back.reference.sentence
