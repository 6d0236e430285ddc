"""Signs of angles and outputs, and the order of angles, that the readings contradict: what is named, and how it counts.

Outputs are those of one gravity turned through written-out rotations (tests/support/physics_scenes), not of the models.
"""

from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from typing import Literal

import numpy as np
import pytest
from archive_kinds import archive, postgres
from physics_scenes.gimbal_scenes import GRAVITY_IN_TUNNEL
from physics_scenes.rotations import ARCSEC, FloatArray, gimbal_matrix, specific_force, turned
from solved import provenance

from ams.analysis.diagnostics.words.held_words import held_words
from ams.archive.sets import publish
from ams.archive.signatures import accept, sign
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.errors import ArchiveForbids
from ams.findings import Finding
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import NONLINEARITY, SharedError
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.sets.stated_findings import significant_findings
from ams.sets.stated_verdict import verdict_in_words

__all__ = ["archive", "postgres"]

MODELS = {"TP": "pitch-roll", "sting": "pitch-yaw-roll-sting", "model": "pitch-yaw-roll-model"}
TUMBLES = {
    "TP": [(0, 0, roll) for roll in (0, 90, 180, -90)] + [(90, 0, 0), (-90, 0, 0)],
    "sting": [(0, 0, 0), (90, 0, 0), (-90, 0, 0), (90, 90, 0), (-90, 90, 0), (45, 45, 0), (45, -45, 0)],
    "model": [(0, 0, roll) for roll in (0, 90, 180, -90)]
    + [(90, 0, 0), (-90, 0, 0), (90, 30, 0), (-90, 30, 0), (45, 30, 45), (45, -30, -45)],
}
SIGNED = ("pitch", "yaw", "roll")


def points_of(package: str, design: str) -> FloatArray:
    """(K, 3) pitch, yaw, roll, radians."""
    if design == "tumble":
        return np.deg2rad(np.array(TUMBLES[package], dtype=float))
    yaws = [0.0] if package == "TP" else [-20.0, 0.0, 20.0]
    rolls = [0.0] if package == "sting" else list(range(-180, 180, 60))
    grid = [(pitch, yaw, roll) for pitch in range(-45, 46, 15) for yaw in yaws for roll in rolls]
    return np.deg2rad(np.array(grid, dtype=float))


@cache
def rows(package: str, design: str = "grid", axes: str = "xyz", replications: int = 3, seed: int = 1) -> Observations:
    """Three sensors a few tenths of a degree off their axes, at 1.65″ a dwell; each campaign another package."""
    chance = np.random.default_rng(seed)
    points = points_of(package, design)
    pitch, yaw, roll = np.tile(points, (replications, 1)).T
    rolled = np.zeros_like(roll) if package == "sting" else roll
    sensed = (
        specific_force(pitch, roll) if package == "TP" else turned(gimbal_matrix(pitch, yaw, rolled), GRAVITY_IN_TUNNEL)
    )
    k_v_per_g = 2.5 * (np.eye(3) + 0.006 * chance.standard_normal((3, 3)))
    volts = 0.01 * chance.standard_normal(3) + sensed @ k_v_per_g.T
    volts += 2.5 * 1.65 * ARCSEC * chance.standard_normal(volts.shape)
    return Observations(
        np.repeat(np.arange(replications) + 1, len(points)), np.tile(np.arange(len(points)), replications), pitch, roll,
        {axis: volts[:, "xyz".index(axis)] for axis in axes}, yaw_rad=None if package == "TP" else yaw,
    )  # fmt: skip


def mistaken(plain: Observations, *what: str) -> Observations:
    """The same readings, with angles of the opposite sign (``pitch``), interchanged (``pitch-roll``), outputs reversed.

    An output is named by its axis: ``y``.
    """
    for name in what:
        if name in SIGNED:
            plain = replace(plain, **{f"{name}_rad": -getattr(plain, f"{name}_rad")})
        elif "-" in name:
            one, other = (f"{angle}_rad" for angle in name.split("-"))
            plain = replace(plain, **{one: getattr(plain, other), other: getattr(plain, one)})
        else:
            plain = replace(plain, outputs={**plain.outputs, name: -plain.outputs[name]})
    return plain


def solved(observations: Observations, package: str, polarity: Literal[1, -1] | None = None) -> Calibration:
    declared = {axis: DeclaredDirection(axis, 1, polarity) for axis in observations.outputs}
    return calibrate(observations, CalibrationRequest(model=MODELS[package], declared=declared))


def told(calibration: Calibration) -> dict[str, Finding]:
    """By axis, the finding that names what the readings fit with."""
    return {
        label: finding
        for label, axis in calibration.axes.items()
        for finding in axis.findings
        if finding.kind == "axis-contradicted" and finding.is_significant and "fits_with" in finding.details
    }


def ways_out(calibration: Calibration) -> set[str]:
    return {str(finding.details["fits_with"]) for finding in told(calibration).values()}


@pytest.mark.parametrize("design", ["grid", "tumble"])
@pytest.mark.parametrize("replications", [1, 3])
@pytest.mark.parametrize("what", [*SIGNED, "pitch-roll", "pitch-yaw", "yaw-roll"])
def test_the_sign_or_the_order_of_angles_that_the_readings_fit_with_is_named(
    design: str, replications: int, what: str
) -> None:
    found = solved(mistaken(rows("model", design, replications=replications), what), "model")
    assert found.verdict == "not usable"
    expected = f"{what} of the opposite sign" if what in SIGNED else f"{what.replace('-', ' and ')} interchanged"
    assert ways_out(found) == {expected}
    assert set(told(found)) == set("xyz")
    for label, finding in told(found).items():
        assert finding.text in found.axes[label].warnings
        assert float(finding.details["fits_to_v"] or 0.0) < 2.5 * 4.0 * ARCSEC
        assert float(finding.details["as_declared_to_v"] or 0.0) > 0.05
        assert held_words(found.axes[label].findings, is_drift=False) != "it is contained in the stated uncertainties"
        assert not any("contained" in text for text in found.axes[label].warnings)


def test_two_angles_interchanged_are_named_of_every_package_that_has_two() -> None:
    for package, what in (("sting", "pitch-yaw"), ("TP", "pitch-roll")):
        found = solved(mistaken(rows(package), what), package)
        assert found.verdict == "not usable"
        assert ways_out(found) == {f"{what.replace('-', ' and ')} interchanged"}


def test_one_axis_names_every_sign_that_explains_it() -> None:
    """Turning round one of three signs and mirroring what is left of gravity is the same for a lone axis."""
    for axis in "xyz":
        found = solved(mistaken(rows("model", axes=axis), "roll"), "model")
        assert found.verdict == "not usable"
        assert ways_out(found) == {"pitch or yaw or roll of the opposite sign"}


@pytest.mark.parametrize(
    ("package", "what", "of", "ways"),
    [
        ("sting", ("y",), "y", "yaw of the opposite sign, or with output y of the opposite polarity"),
        ("sting", ("yaw",), "y", "yaw of the opposite sign, or with output y of the opposite polarity"),
        ("sting", ("x",), "x", "output x of the opposite polarity"),
        ("sting", ("pitch",), "z", "pitch of the opposite sign, or with output z of the opposite polarity"),
        ("model", ("y",), "y", "output y of the opposite polarity"),
        ("model", ("roll", "yaw"), "y", "output y of the opposite polarity"),
    ],
)
@pytest.mark.parametrize("design", ["grid", "tumble"])
def test_axes_that_do_not_read_with_one_polarity_are_one_finding_of_the_odd_one(
    package: str, what: tuple[str, ...], of: str, ways: str, design: str
) -> None:
    found = solved(mistaken(rows(package, design), *what), package, 1)
    assert set(told(found)) == {of}
    assert ways_out(found) == {ways}
    assert found.verdict == "not usable", "a rig file declares every polarity"
    undeclared = solved(mistaken(rows(package, design), *what), package)
    assert (set(told(undeclared)), undeclared.verdict) == ({of}, "usable")
    (text,) = (text for text in undeclared.axes[of].warnings if "do not read with one polarity" in text)
    assert "declare the polarity" in text


def test_two_axes_tell_it_as_three_do_and_nothing_says_which_of_them() -> None:
    for axes, angle, angles in (("xz", "pitch", "pitch"), ("yz", "pitch", "pitch or yaw"), ("xy", "yaw", "yaw")):
        found = solved(mistaken(rows("sting", axes=axes), angle), "sting")
        assert set(told(found)) == set(axes)
        outputs = " or ".join(axes)
        expected = f"{angles} of the opposite sign, or with output {outputs} of the opposite polarity"
        assert ways_out(found) == {expected}


def test_a_left_handed_package_of_undeclared_polarity_stays_a_remark() -> None:
    """Many have a sensor the other way round; where polarities are declared the axis is contradicted by itself.

    Three replications alone make it usable.
    """
    for what in ("pitch", "roll", "x", "y", "z"):
        found = solved(mistaken(rows("TP"), what), "TP")
        assert (told(found), found.verdict) == ({}, "usable")
        assert any("left-handed" in remark for remark in found.remarks)
        declared = solved(mistaken(rows("TP"), what), "TP", 1)
        assert (told(declared), declared.verdict, len(declared.unusable_axes)) == ({}, "not usable", 1)


def test_axes_of_undeclared_and_unlike_polarity_leave_every_sign_named() -> None:
    """z is wired the other way round and pitch too: by one polarity roll alone would do it, and the text says so."""
    plain = mistaken(rows("model"), "pitch", "z")
    undeclared = solved(plain, "model")
    assert ways_out(undeclared) == {"roll of the opposite sign"}
    (text,) = {finding.text for finding in told(undeclared).values()}
    assert "with pitch or yaw of the opposite sign as well, were the polarities of the axes unlike" in text
    signs: dict[str, Literal[1, -1]] = {"x": 1, "y": 1, "z": -1}
    request = CalibrationRequest(
        model=MODELS["model"], declared={axis: DeclaredDirection(axis, 1, sign) for axis, sign in signs.items()}
    )
    declared = calibrate(plain, request)
    assert ways_out(declared) == {"pitch of the opposite sign"}
    assert not any("as well" in finding.text for finding in told(declared).values())


def test_what_no_reading_tells_is_not_told() -> None:
    """Of x and z yaw is even; a lone axis of a sting is mirrored by any sign; all three reversed read with one."""
    assert not told(solved(mistaken(rows("sting", axes="xz"), "yaw"), "sting"))
    for axis in "xyz":
        for what in ("pitch", "yaw", axis):
            assert not told(solved(mistaken(rows("sting", axes=axis), what), "sting"))
    assert not told(solved(mistaken(rows("model"), "x", "y", "z"), "model", 1))


def test_a_turned_mount_is_counted_with_its_axis_and_sense() -> None:
    plain = rows("sting")
    turned_over = replace(plain, outputs={"x": plain.outputs["y"], "y": -plain.outputs["x"], "z": plain.outputs["z"]})
    mount = {"x": DeclaredDirection("y", 1, 1), "y": DeclaredDirection("x", -1, 1), "z": DeclaredDirection("z", 1, 1)}
    request = CalibrationRequest(model=MODELS["sting"], declared=mount)
    assert not told(calibrate(turned_over, request))
    assert set(told(calibrate(mistaken(turned_over, "y"), request))) == {"y"}


def test_it_is_accepted_by_name_and_the_verdict_by_its_own(archive: object) -> None:
    """The set exists: nothing says whether channel or angle is the other way round, and a person answers for it."""
    url, now = archive.url, datetime(2026, 6, 1, tzinfo=UTC)  # type: ignore[attr-defined]
    found = solved(mistaken(rows("sting"), "y"), "sting", 1)
    coefficients = build_set(found, provenance(mount={"x": "+x", "y": "+y", "z": "+z", "datum": "face A"}))
    assert [entry.name for entry in significant_findings(coefficients)] == ["y.axis-contradicted"]
    assert "y: axis-contradicted" in str(verdict_in_words(coefficients.document))
    publish(url, [coefficients], now)
    for role, name in (("prepared", "A. Ray"), ("reviewed", "B. Soo")):
        sign(url, "SN1047", role, name, now)
    with pytest.raises(ArchiveForbids, match=r"nobody has accepted y\.axis-contradicted; nothing was signed"):
        sign(url, "SN1047", "approved", "C. Lim", now)
    accept(url, "SN1047", "y.axis-contradicted", "B. Soo", now, "y looks left in this model")
    with pytest.raises(ArchiveForbids, match="nobody has accepted the verdict 'not usable'"):
        sign(url, "SN1047", "approved", "C. Lim", now)
    accept(url, "SN1047", "not usable", "B. Soo", now, "as before")
    assert sign(url, "SN1047", "approved", "C. Lim", now).is_approved


def test_a_lack_of_fit_of_degrees_is_never_contained() -> None:
    """Points in another order than the readings: no sign explains it, and no table or sensor does as much."""
    plain = rows("model")
    shuffled = np.random.default_rng(5).permutation(len(points_of("model", "grid")))
    at = np.concatenate([shuffled + first * len(shuffled) for first in range(3)])
    found = solved(replace(plain, outputs={axis: volts[at] for axis, volts in plain.outputs.items()}), "model")
    assert (found.verdict, told(found)) == ("not usable", {})
    each = np.tile(np.random.default_rng(6).normal(0.0, 0.7, len(shuffled)), 3)  # of every attitude its own
    wave = np.sin(7.0 * plain.pitch_rad)  # alike at all attitudes of one pitch
    for course, size_g, verdict in ((each, 0.004, "usable"), (each, 0.03, "not usable"), (wave, 0.004, "not usable")):
        bent = {axis: volts + 2.5 * size_g * course for axis, volts in plain.outputs.items()}
        found = solved(replace(plain, outputs=bent), "model")
        assert (found.verdict, told(found)) == (verdict, {})
        for axis in found.axes.values():
            words = held_words(axis.findings, is_drift=False)
            assert ("in the stated uncertainties as errors" in words) == (verdict == "usable")
            assert any(finding.kind == "lack-of-fit" and words in finding.text for finding in axis.findings)


@pytest.mark.parametrize("package", list(MODELS))
def test_residuals_of_degrees_in_one_replication_are_no_usable_result(package: str) -> None:
    """Nothing tells noise from lack of fit there; the outputs stand at other points than they were read at."""
    plain = rows(package, replications=1)
    assert solved(plain, package).verdict == "usable"
    at = np.random.default_rng(5).permutation(plain.rows)
    shuffled = replace(plain, outputs={axis: volts[at] for axis, volts in plain.outputs.items()})
    found = calibrate(shuffled, CalibrationRequest(model=MODELS[package]))
    assert (found.verdict, told(found)) == ("not usable", {})
    for size_g, verdict in ((0.004, "usable"), (0.05, "not usable")):
        chance = np.random.default_rng(7)
        rough = {axis: volts + 2.5 * size_g * chance.normal(size=plain.rows) for axis, volts in plain.outputs.items()}
        found = solved(replace(plain, outputs=rough), package)
        assert found.verdict == verdict
        texts = [text for axis in found.axes.values() for text in axis.warnings if "no replication tells" in text]
        assert bool(texts) == (verdict == "not usable")


def test_a_declared_nonlinearity_may_be_as_large() -> None:
    plain = rows("model", axes="z")
    bent = replace(plain, outputs={"z": plain.outputs["z"] + 0.075 * np.sin(7.0 * plain.pitch_rad)})
    for limit_v, verdict in ((0.2, "usable"), (0.01, "not usable")):
        error = SharedError(NONLINEARITY, "departure", limit_v / 3.0**0.5)
        request = CalibrationRequest(model=MODELS["model"], shared_errors={"z": (error,)})
        assert calibrate(bent, request).verdict == verdict


@pytest.mark.parametrize("package", list(MODELS))
@pytest.mark.parametrize("design", ["grid", "tumble"])
def test_clean_campaigns_are_told_nothing(package: str, design: str) -> None:
    for seed in range(100, 104):
        for axes in ("xyz", "x"):
            found = solved(rows(package, design, axes, seed=seed), package)
            assert not told(found)
            assert not found.unusable_axes


@pytest.mark.thorough
@pytest.mark.parametrize("package", list(MODELS))
@pytest.mark.parametrize("design", ["grid", "tumble"])
@pytest.mark.parametrize("axes", ["xyz", "x", "z"])
def test_three_hundred_clean_campaigns_ring_nowhere(package: str, design: str, axes: str) -> None:
    for seed in range(1000, 1300):
        plain = rows.__wrapped__(package, design, axes, seed=seed)
        assert not told(solved(plain, package, None if package == "TP" else 1))


@pytest.mark.thorough
@pytest.mark.parametrize("design", ["grid", "tumble"])
def test_every_sign_is_named_in_a_hundred_packages(design: str) -> None:
    for seed in range(2000, 2100):
        plain = rows.__wrapped__("model", design, seed=seed)
        for what in SIGNED:
            assert ways_out(solved(mistaken(plain, what), "model")) == {f"{what} of the opposite sign"}
