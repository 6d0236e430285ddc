"""Errors of angles hold their stated uncertainty at attitudes of which the rig itself is not sure.

Tables and bases are drawn within what is declared of them, and turned by explicit rotations. The truth is what the set
under test is wrong by where the reference is right: the angles that it tells of a package without noise that truly
stands at the nominal attitude, less these.
"""

from dataclasses import replace

import numpy as np
import pytest
from inferred_by_sets import inferred_errors_deg
from packages_on_tables import GRID, LIMIT_ARCSEC, SHAPES, SLACK, Rig, outputs_v
from physics_scenes.rotations import ARCSEC
from physics_scenes.tables import eight_harmonics, once_per_turn, white_teeth

from ams.inputs.table_uncertainty import IndexErrors, known_errors
from ams.solve.table_errors import TablePriors
from ams.surveillance.adjustment import Acceptance, adjust, from_document, to_document
from ams.surveillance.attitude_errors import REFERENCE, AngleErrors, errors_of
from ams.surveillance.reference_attitude import ReferenceAttitude, ReferenceInWords


def held(errors: AngleErrors, truth_deg: np.ndarray) -> list[bool]:
    """Whether |error − truth| ≤ U at every point, by either attitude where two may be meant."""
    at = {(round(p, 6), round(r, 6)): t for (p, r), t in zip(np.rad2deg(GRID), truth_deg, strict=True)}
    points = zip(errors.pitch_deg, errors.roll_deg, errors.error_deg, errors.expanded_deg, strict=True)
    return [
        bool((np.abs(error - at[round(float(p), 6), round(float(r), 6)]) <= half).all()) for p, r, error, half in points
    ]


def shares_held(rig: Rig, axes: str, seed: int, campaigns: int, *, as_found: bool = False) -> tuple[float, float]:
    """Return the shares that are held with the reference counted, and without."""
    chance = np.random.default_rng(seed)
    inside: tuple[list[bool], list[bool]] = ([], [])
    for _ in range(campaigns):
        rows = rig.observe(axes, 6, chance)
        new = rig.solved(rows)
        applied = rig.solved(rig.observe(axes, 6, chance, gain=1.0002)) if as_found else new
        truth = inferred_errors_deg(applied, outputs_v(axes, *GRID.T, np.zeros(3), 1.0), *GRID.T, SLACK)
        for found, reference in zip(inside, (rig.reference, None), strict=True):
            by_angle = errors_of(applied, new, rows, (-80.0, 80.0), reference)
            for angle, errors in by_angle.items():
                found += held(errors, truth[angle])
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
