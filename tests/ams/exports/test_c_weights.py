"""The angles of the C header are those of calrig attitude, whatever the axes' sharpness."""

from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from c_program import needs_compiler, printed

from ams.calibration.calibrate import calibrate
from ams.exports.c_header import to_c_header
from ams.inference.inference import Package, inference
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.axis_section import lack_of_fit_of
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance

pytestmark = needs_compiler
SD_V = np.array([[1e-5], [1e-5], [4e-4]])
"""Of x, y and z: z is forty times less sharp."""
OFFSET_V = np.array([[0.01], [-0.02], [0.03]])
K = np.array([[2.0, 0.01, -0.02], [-0.015, 1.9, 0.01], [0.02, 0.03, -2.1]])
COLUMNS = {"x": "x_v", "y": "y_v", "z": "z_v"}
OUTPUTS_DISAGREE = 2
KINDS = ["straight", "bent", "warm", "warm and bent"]
DEGC = (10.0, 40.0)


def force(pitch_deg: np.ndarray, roll_deg: np.ndarray) -> np.ndarray:
    """(3, N) by the definition of the attitude."""
    pitch, roll = np.radians(pitch_deg), np.radians(roll_deg)
    return np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])


def outputs_v(kind: str, f: np.ndarray, degc: np.ndarray) -> np.ndarray:
    """(3, N) without noise: a mount that gives way, a sensor that saturates, and what warms."""
    sensed = K @ f
    if "bent" in kind:
        sensed = sensed + np.array([[2e-3], [-1e-3], [1.5e-3]]) * (f * np.roll(f, 1, axis=0) + 0.4 * f**3)
    rise = (degc - 25.0) if "warm" in kind else np.zeros_like(degc)
    return OFFSET_V * (1.0 + 0.004 * rise) + sensed * (1.0 + np.array([[2e-4], [-1e-4], [3e-4]]) * rise)


@cache
def set_of(kind: str) -> CoefficientSet:
    """Four replications of 56 attitudes."""
    rng = np.random.default_rng(5)
    grid = [(p, r) for p in np.linspace(-60.0, 60.0, 7) for r in np.arange(-180.0, 180.0, 45.0)]
    pitch, roll = np.tile(np.array(grid), (4, 1)).T
    degc = rng.uniform(*DEGC, pitch.size)
    read = outputs_v(kind, force(pitch, roll), degc) + SD_V * rng.normal(size=(3, pitch.size))
    rows = Observations(
        np.repeat(np.arange(1, 5), len(grid)), np.tile(np.arange(len(grid)), 4), np.radians(pitch), np.radians(roll),
        dict(zip("xyz", read, strict=True)), temperature_degc=degc if "warm" in kind else None,
    )  # fmt: skip
    asked = CalibrationRequest(
        extended="yes" if "bent" in kind else "no", temperature="estimate" if "warm" in kind else "none"
    )
    origin = Provenance(
        sensor="W1", gravity_mps2=9.81, gravity_source="survey", simulated=False, rig="", procedure="fit",
        created_utc=datetime(2026, 3, 1, tzinfo=UTC), software_version="0.1.0", pitch_range_deg=(-90.0, 90.0),
        roll_range_deg=(-180.0, 180.0), temperature_range_degc=DEGC if "warm" in kind else None,
    )  # fmt: skip
    return build_set(calibrate(rows, asked), origin)


def in_c(
    folder: Path, used: CoefficientSet, read: np.ndarray, degc: np.ndarray, before: str = ""
) -> tuple[np.ndarray, np.ndarray]:
    """Return (N,) codes and (2, N) pitch and roll in degrees of (3, N) outputs by a compiled program."""
    values = ", ".join("{" + ", ".join(repr(float(v)) for v in row) + "}" for row in np.vstack([read, degc]).T)
    main = f"""
    static const double rows[{degc.size}][4] = {{{values}}};
    double pitch_deg = NAN, roll_deg = NAN;
    for (int i = 0; i < {degc.size}; i++) {{
        const int code = calrig_w1_angles(rows[i], rows[i][3], &pitch_deg, &roll_deg);
        printf("%d %.17g %.17g\\n", code, pitch_deg, roll_deg);
    }}
    """
    found = np.array(printed(folder, {"w1.h": before.encode() + to_c_header(used)}, main)).T
    return found[0], found[1:]


def by_calrig(
    package: Package, read: np.ndarray, degc: np.ndarray, reading_sd_v: float | None = None
) -> Mapping[str, np.ndarray]:
    readings = dict(zip(COLUMNS.values(), read, strict=True)) | {"temperature_degc": degc}
    return inference(package, reading_sd_v=reading_sd_v).infer(readings)


def angles_of(answer: Mapping[str, np.ndarray]) -> np.ndarray:
    return np.stack([answer["pitch_deg"], answer["roll_deg"]])


def drawn(kind: str, gravity: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (2, 300) angles in degrees, where z tells least of them, with (3, 300) readings and temperatures."""
    rng = np.random.default_rng(8)
    angles, degc = np.stack([rng.uniform(-60.0, 60.0, 300), rng.uniform(40.0, 140.0, 300)]), rng.uniform(*DEGC, 300)
    return angles, outputs_v(kind, gravity * force(*angles), degc) + SD_V * rng.normal(size=(3, 300)), degc


@pytest.mark.parametrize("kind", KINDS)
def test_c_has_the_angles_of_calrig_attitude(kind: str, tmp_path: Path) -> None:
    """It took the direction of K⁻¹(v − b): pitch was off by 0.0033 degrees (rms) in place of 0.0005."""
    used, (truth, read, degc) = set_of(kind), drawn(kind)
    codes, found = in_c(tmp_path, used, read, degc)
    answer = by_calrig(Package(used, COLUMNS), read, degc)
    assert not codes.any()
    assert found == pytest.approx(angles_of(answer), rel=0, abs=1e-10)
    pitch_rms, roll_rms = np.sqrt(np.mean((found - truth) ** 2, axis=1))
    assert pitch_rms < 0.001
    assert roll_rms < 0.009  # the direction's: 0.014 and more
    stated = np.stack([answer["pitch_sd_deg"], answer["roll_sd_deg"]])
    assert np.mean(np.abs(found - truth) < 1.96 * stated) > 0.92


def test_a_program_with_other_readings_states_their_sharpness(tmp_path: Path) -> None:
    """As ``--reading-sd`` does: what an axis lacks of its model stays beside the noise that is stated."""
    used, (_, read, degc) = set_of("straight"), drawn("straight")
    lacks_v = [lack_of_fit_of(used.document["axes"][axis], used.axes[axis]) for axis in "xyz"]
    sd_v = [repr(float(np.hypot(1e-4, lack))) for lack in lacks_v]
    before = "".join(f"#define CALRIG_W1_{a}_READING_SD_V {v}\n" for a, v in zip("XYZ", sd_v, strict=True))
    _, found = in_c(tmp_path, used, read, degc, before)
    expected = angles_of(by_calrig(Package(used, COLUMNS), read, degc, 1e-4))
    assert found == pytest.approx(expected, rel=0, abs=1e-10)
    assert np.abs(found - angles_of(by_calrig(Package(used, COLUMNS), read, degc))).max() > 1e-3


@pytest.mark.parametrize("kind", ["straight", "bent"])
def test_at_another_g_the_angles_are_those_of_calrig_there(kind: str, tmp_path: Path) -> None:
    used, (_, read, degc) = set_of(kind), drawn(kind, 9.79 / 9.81)
    codes, found = in_c(tmp_path, used, read, degc, "#define CALRIG_W1_GRAVITY_AT_USE_MPS2 9.79\n")
    there = Package(used, COLUMNS, site_gravity_mps2=9.79)
    assert not codes.any()
    assert found == pytest.approx(angles_of(by_calrig(there, read, degc)), rel=0, abs=1e-10)


@pytest.mark.parametrize("kind", ["straight", "warm and bent"])
def test_whatever_the_outputs_c_fits_them_no_worse_than_their_direction(kind: str, tmp_path: Path) -> None:
    """Outputs near an attitude and of no attitude at all, and dead axes: told, and angles wherever there is a force."""
    rng, used = np.random.default_rng(3), set_of(kind)
    _, read, degc = drawn(kind)
    read = read + rng.normal(size=read.shape) * 10.0 ** rng.uniform(-4.0, 1.0, read.shape[1])
    for axis in range(3):
        read[axis, 20 * axis : 20 * axis + 20] = OFFSET_V[axis]
    codes, found = in_c(tmp_path, used, read, degc)
    assert np.isfinite(found).all()
    assert np.mean(codes == OUTPUTS_DISAGREE) > 0.7
    if kind != "straight":
        return
    straight = np.linalg.solve(K, read - OFFSET_V)
    direction = straight / np.linalg.norm(straight, axis=0)
    left = [np.sum(((read - OFFSET_V - K @ f) / SD_V) ** 2, axis=0) for f in (force(*found), direction)]
    assert np.all(left[0] <= left[1] * (1.0 + 1e-3) + 1.0)  # the set is not the truth, nor are its weights
