"""The reports' own calibrations from the rig to angles: run, set, archive, every export, applied, with truths drawn.

SR's three examples on the servo mechanism, CR's gimbal with its sting and model packages, gyros by rates and by motion.
The truth of every sensor is drawn by a seed at the time of the test, none of it stands in a file. One seed each here,
forty in the soak: of that many 95 % intervals the count keeps to what chance allows in 99.9 %.
"""

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from cr_outputs import to_package
from motion_runs import motion_run
from scipy.spatial.transform import Rotation
from scipy.stats import binom
from small_run import bench

from ams.errors import SetError
from ams.exports.formats import FORMATS, export_set, load_set
from ams.exports.verify import verify
from ams.frames import body_rates_rad_s, specific_force
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.inference import Package, inference
from ams.sets.apply import apply, sensed_level
from ams.sets.canonical import listed, number, table
from ams.sets.coefficients import CoefficientSet
from procedures.delivery.deliver import SolvedRun, deliver, solve_run

pytestmark = pytest.mark.usefixtures("no_report")

NO_FORM = (
    "{sensor}: {what}: has no form of this set's equations: got convention CR, model {model}, needed are "
    "accelerometers of pitch and roll (TP) or straight lines (SR); nothing was written; {instead}"
)
REFUSED_OF_CR = {
    "linear": {"what": "linear form", "instead": "export c or json, which have every component of k"},
    "c-fixed": {"what": "C header in fixed point", "instead": "use the floating-point header (c)"},
}
"""CR's models are refused by these two formats and by no other, SR's lines by none."""
ACROSS = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}
FASTER_RATES = {
    r"dwell_s = 300.0": "dwell_s = 40.0",
    r"replications = \d": "replications = 3",
    r"\[10.0, 20.0\]": "[20.0]",
    r"\[9.0, 13.5\]": "[13.5]",
}


@dataclass
class Count:
    """How many intervals held, of how many."""

    held: int = 0
    of: int = 0

    def add(self, holds: object) -> None:
        found = np.atleast_1d(np.asarray(holds, dtype=bool))
        self.held, self.of = self.held + int(found.sum()), self.of + found.size

    def require(self, seeds: int) -> None:
        """Angles of one set go together: the count of sets is what chance is drawn from, not that of rows."""
        share, trials = self.held / self.of, min(self.of, 6 * seeds)
        assert share >= binom.ppf(0.0005, trials, 0.95) / trials, (self.held, self.of)


@dataclass
class Told:
    parameters: Count = field(default_factory=Count)
    angles: Count = field(default_factory=Count)


def lines(chance: np.random.Generator, offset: float) -> dict[str, tuple[float, float]]:
    """Return reading at zero and per unit of three straight axes."""
    return {axis: (float(chance.uniform(-offset, offset)), float(chance.uniform(0.94, 1.06))) for axis in "xyz"}


def of_lines(sensor: str, drawn: Mapping[str, tuple[float, float]], noise: float) -> dict[str, str]:
    """Return the change of a rig file that gives a twin these truths, its axes along those of the package."""
    rows = "".join(
        f"{axis} = {{ reading = {{ at_zero = {zero!r}, per_unit = {unit!r}, noise = {noise} }}, coning_deg = 0.0, "
        "azimuth_deg = 0.0 }\n"
        for axis, (zero, unit) in drawn.items()
    )
    return {rf"\[twin\.truth\.{sensor}\]\n(?:[xyz] = .*\n){{3}}": f"[twin.truth.{sensor}]\n{rows}"}


def cones(chance: np.random.Generator, scale: float, sign: float = 1.0) -> dict[str, tuple[float, float, float, float]]:
    """Return offset, sensitivity, coning and azimuth of three axes."""
    return {
        axis: (
            float(chance.uniform(-0.05, 0.05)), sign * scale * float(chance.uniform(0.95, 1.05)),
            float(chance.uniform(0.1, 0.6)), float(chance.uniform(-180.0, 180.0)),
        )
        for axis in "xyz"
    }  # fmt: skip


def of_cones(drawn: Mapping[str, tuple[float, ...]], unit: str, noise_v: float) -> str:
    return "".join(
        f"{axis} = {{ offset_v = {b!r}, sensitivity_v_per_{unit} = {s!r}, coning_deg = {c!r}, azimuth_deg = {a!r}, "
        f"noise_v = {noise_v} }}\n"
        for axis, (b, s, c, a) in drawn.items()
    )


def direction(axis: str, truth: tuple[float, ...]) -> np.ndarray:
    """Return k of a cone in TP's terms: cos Ω along the nominal axis, sin Ω across it."""
    along, (first, second) = "xyz".index(axis), ACROSS[axis]
    _, scale, coning, azimuth = truth
    k = np.zeros(3)
    k[along] = np.cos(np.deg2rad(coning))
    k[first], k[second] = np.sin(np.deg2rad(coning)) * np.array(
        [np.cos(np.deg2rad(azimuth)), np.sin(np.deg2rad(azimuth))]
    )
    return scale * k


def delivered(solved: SolvedRun, folder: Path, sensor: str) -> CoefficientSet:
    """Deliver to an archive, export to every format there is, and return the set as its file has it."""
    delivery = deliver(solved, f"sqlite:///{folder / 'archive.sqlite'}")
    assert delivery.archived is not None
    assert sensor in delivery.sets
    own = load_set(delivery.sets[sensor])
    for name, form in FORMATS.items():
        path = folder / f"{sensor}{form.ending}"
        if own.convention == "CR" and name in REFUSED_OF_CR:
            with pytest.raises(SetError) as refused:
                export_set(own, name, path)
            assert str(refused.value) == NO_FORM.format(sensor=sensor, model=own.model, **REFUSED_OF_CR[name])
            assert not path.exists()
            continue
        if name == "imucal" and not {one.form.unit for one in own.axes.values()} <= {"g", "dps"}:
            with pytest.raises(SetError, match="needed are three accelerometers or three gyros"):
                export_set(own, name, path)
            continue
        export_set(own, name, path)
        assert verify(path).forward_vectors == len(listed(own.test_vectors["forward"]))
        for axis, numbers in load_set(path).axes.items():
            assert numbers.primary == pytest.approx(dict(own.axes[axis].primary), rel=1e-12, abs=0.0)
        if name in READERS:
            READERS[name](own, path.read_text(encoding="ascii"))
    return own


def levels_of(own: CoefficientSet) -> np.ndarray:
    """Return (64, 3) levels over all that a set of lines is valid for."""
    limits = np.array([own.validity.levels[name] for name in next(iter(own.axes.values())).form.inputs])
    return np.random.default_rng(64).uniform(limits[:, 0], limits[:, 1], (64, 3))


def read_linear(own: CoefficientSet, text: str) -> None:
    """Two numbers an axis, by a reader of TOML alone: what the set reads of a level is that level again."""
    levels, axes = levels_of(own), tomllib.loads(text)["axes"]
    for axis, reading in apply(own, level=levels).items():
        gain, offset = (next(v for key, v in axes[axis].items() if key.startswith(begin)) for begin in ("a_", "b_"))
        sensed = levels[:, "xyz".index(axis)]
        assert gain * reading + offset == pytest.approx(
            sensed, abs=stated_error(axes[axis]) + 1e-12 * np.abs(sensed).max()
        )


def stated_error(axis: Mapping[str, object]) -> float:
    return float(next(value for key, value in axis.items() if key.startswith("largest_error_")))  # type: ignore[arg-type]


def read_c_fixed(own: CoefficientSet, text: str) -> None:
    """The macros alone, in whole numbers: what they make of a level is off by no more than the file says."""
    found = re.findall(r"^#define CALRIG_[A-Z0-9]+_FIXED_(\w+) \(?([-.e0-9]+)\)?$", text, re.MULTILINE)
    macros, levels = dict(found), levels_of(own)
    words = np.rint(levels * 2.0 ** int(macros["LEVEL_BITS"])).astype(int)
    for axis, reading in apply(own, level=levels).items():
        k = [int(macros[f"{axis.upper()}_K_{along}"]) for along in "XYZ"]
        sums = [sum(entry * int(word) for entry, word in zip(k, row, strict=True)) for row in words]
        whole = [int(macros[f"{axis.upper()}_OFFSET"]) + round(Fraction(total, 2**30)) for total in sums]
        off = np.abs(np.array(whole) / 2.0 ** int(macros["OUTPUT_BITS"]) - reading)
        (stated,) = (float(value) for name, value in macros.items() if name.startswith(f"{axis.upper()}_ERROR_"))
        assert off.max() <= stated


READERS: Mapping[str, Callable[[CoefficientSet, str], None]] = {"linear": read_linear, "c-fixed": read_c_fixed}
"""Of the forms that keep less than the set: their own numbers applied by another's arithmetic."""


def parameters_hold(own: CoefficientSet, truths: Mapping[str, Mapping[str, float]], count: Count) -> None:
    for axis, wanted in truths.items():
        stated = table(table(table(own.document["axes"])[axis])["parameters"])
        for name, truth in wanted.items():
            interval = table(stated[name])["interval_95"]
            if interval is not None:
                low, high = map(number, listed(interval))
                count.add(low <= truth <= high)


def angles_hold(
    found: Mapping[str, np.ndarray], truth_deg: Mapping[str, np.ndarray], count: Count, end: str = "half_95_deg"
) -> None:
    factor = 1.0 if end == "half_95_deg" else 1.96
    for name, truth in truth_deg.items():
        off = (found[f"{name}_deg"] - truth + 180.0) % 360.0 - 180.0
        count.add(np.abs(off) < factor * found[f"{name}_{end}"])


def sr_accelerometer(folder: Path, seed: int, expected: Told) -> None:
    chance = np.random.default_rng(seed)
    drawn = lines(chance, 0.06)
    changes = {"replications = 6": "replications = 4"}
    rig = of_lines("SCA3000", drawn, 0.002) | {r"seed = 11": f"seed = {seed}"}
    own = delivered(motion_run(folder, "servo-mechanism", "accelerometer", changes, rig).solved(), folder, "SCA3000")
    wanted = {a: {"gain_g_per_g": 1.0 / unit, "offset_g": -zero / unit} for a, (zero, unit) in drawn.items()}
    parameters_hold(own, wanted, expected.parameters)
    pitch, roll = chance.uniform(-50.0, 50.0, 8), chance.uniform(-170.0, 170.0, 8)
    force = specific_force(np.deg2rad(pitch), np.deg2rad(roll))
    columns = {axis: zero + unit * force[:, index] for index, (axis, (zero, unit)) in enumerate(drawn.items())}
    readings = {axis: clean + 0.002 * chance.normal(size=8) for axis, clean in columns.items()}
    package = Package(own, {axis: axis for axis in "xyz"})
    found = inference(package, reading_sd_v=0.002, intervals=True).infer(readings)
    angles_hold(found, {"pitch": pitch, "roll": roll}, expected.angles)  # type: ignore[arg-type]


def sr_gyro(folder: Path, seed: int, expected: Told) -> None:
    chance = np.random.default_rng(seed)
    drawn = lines(chance, 2.0)
    rig = of_lines("ITG3200", drawn, 0.1) | {r"seed = 11": f"seed = {seed}"}
    own = delivered(motion_run(folder, "servo-mechanism", "gyro", FASTER_RATES, rig).solved(), folder, "ITG3200")
    wanted = {a: {"gain_dps_per_dps": 1.0 / unit, "offset_dps": -zero / unit} for a, (zero, unit) in drawn.items()}
    parameters_hold(own, wanted, expected.parameters)
    truths = {axis: (zero, unit * np.eye(3)[index]) for index, (axis, (zero, unit)) in enumerate(drawn.items())}
    turned(own, truths, 0.1, chance, expected)


def turned(
    own: CoefficientSet,
    truths: Mapping[str, tuple[float, np.ndarray]],
    noise: float,
    chance: np.random.Generator,
    expected: Told,
) -> None:
    """Integrate ten seconds of a swing and count the angles that their standard deviations hold."""
    time_s = np.arange(201) / 20.0
    omega, size = 2 * np.pi * chance.uniform(0.03, 0.08, 3), np.deg2rad(chance.uniform(5.0, 20.0, 3))
    euler = size * np.sin(time_s[:, None] * omega)
    rates = np.rad2deg(body_rates_rad_s(euler, size * omega * np.cos(time_s[:, None] * omega)))
    readings = {axis: zero + rates @ k + noise * chance.normal(size=time_s.size) for axis, (zero, k) in truths.items()}
    angles = GyroAngles(GyroPackage(own, {axis: axis for axis in truths}, noise), Motion(20.0))
    first, last = angles.answer(readings), angles.finish()
    columns = {name: np.concatenate([values, last.columns[name]]) for name, values in first.columns.items()}
    ends = {name: values[[100, 200]] for name, values in columns.items()}
    known = dict(zip(("pitch", "yaw", "roll"), np.rad2deg(euler[[100, 200]]).T, strict=True))
    angles_hold(ends, known, expected.angles, "sd_deg")


def sr_magnetometer(folder: Path, seed: int, expected: Told) -> None:
    chance = np.random.default_rng(seed)
    drawn = lines(chance, 3.0)
    changes = {r"rest_s = 60.0": "rest_s = 15.0", r"replications = 4": "replications = 3"}
    rig = of_lines("MicroMag3", drawn, 0.2) | {r"seed = 11": f"seed = {seed}"}
    own = delivered(motion_run(folder, "servo-mechanism", "magnetometer", changes, rig).solved(), folder, "MicroMag3")
    wanted = {a: {"gain_ut_per_ut": 1.0 / unit, "offset_ut": -zero / unit} for a, (zero, unit) in drawn.items()}
    parameters_hold(own, wanted, expected.parameters)
    field_ut = np.array([22.0, -3.0, 40.0])
    heading = chance.uniform(-170.0, 170.0)
    sensed = Rotation.from_euler("z", -heading, degrees=True).apply(field_ut)
    counts = {axis: np.array(zero + unit * sensed[index]) for index, (axis, (zero, unit)) in enumerate(drawn.items())}
    found = sensed_level(own, counts)
    back = np.rad2deg(np.arctan2(field_ut[1], field_ut[0]) - np.arctan2(found[1], found[0]))
    expected.angles.add(abs((back - heading + 180.0) % 360.0 - 180.0) < 3.0)


def cr_gimbal(folder: Path, seed: int, expected: Told) -> None:
    """Both packages in one run; what they read of one attitude becomes its three angles."""
    chance = np.random.default_rng(seed)
    model, sting = cones(chance, 2.5), cones(chance, 2.5)
    yaw = (
        "[readouts.dmm]",
        '[axes.yaw]\ndriver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\nlimits_deg = [-90.0, 90.0]\n'
        "speed_dps = 20.0\naxis = 3\n[readouts.dmm]",
    )
    second = (
        "[twin]\nseed = 7",
        '[readouts.second]\ndriver = "hp3458a"\nresource = "twin"\nnplc = 1\n'
        "channels = { x = { scanner = 1, range_v = 10.0 }, y = { scanner = 2, range_v = 10.0 }, "
        "z = { scanner = 3, range_v = 10.0 } }\n"
        '[sensors.STING]\nmodel = "three-axis package"\nnominal_sensitivity_v_per_g = 2.5\n'
        'channels = { x = "second.x", y = "second.y", z = "second.z" }\nstage = ["pitch", "yaw"]\n'
        f"[twin]\nseed = {seed}\n[twin.truth.STING]\n{of_cones(sting, 'g', 2e-5)}",
    )
    made = bench(
        folder,
        (yaw, second, *_truth_of_the_bench(model)),
        (
            ("roll_deg = {", "yaw_deg = [-30.0, 0.0, 30.0]\nroll_deg = {"),
            ("[check]", '[solve]\nmodel = "pitch-yaw-roll"\n[check]'),
            ("replications = 2", "replications = 4"),
        ),
    )
    assert made.run(folder / "run").exit_status == 0
    solved = solve_run(folder / "run")
    own, carrying = delivered(solved, folder, "SN1"), delivered(solved, folder, "STING")
    for coefficients, truth in ((own, model), (carrying, sting)):
        wanted = {axis: {"offset_v": entry[0], "sensitivity_v_per_g": -entry[1]} for axis, entry in truth.items()}
        parameters_hold(coefficients, wanted, expected.parameters)
    euler = np.stack([chance.uniform(5.0, 28.0, 6), chance.uniform(-25.0, 25.0, 6), chance.uniform(-80.0, 80.0, 6)], -1)
    readings = {}
    for name, truth in (("model_", model), ("", sting)):
        for axis, entry in truth.items():
            clean = [
                entry[0] + direction(axis, entry) @ _force(each, is_model=bool(name)) for each in np.deg2rad(euler)
            ]
            readings[f"{name}{axis}"] = np.array(clean) + 2e-5 * chance.normal(size=6)
    packages = [Package(entry, {a: f"{pre}{a}" for a in "xyz"}) for entry, pre in ((carrying, ""), (own, "model_"))]
    found = inference(packages[0], packages[1], 2e-5, intervals=True).infer(readings)
    known = dict(zip(("pitch", "yaw", "roll"), euler.T, strict=True))
    angles_hold(found, known, expected.angles)  # type: ignore[arg-type]


def _truth_of_the_bench(drawn: Mapping[str, tuple[float, ...]]) -> list[tuple[str, str]]:
    """Return changes of the three rows of the bench's own sensor."""
    old = {
        "x": "x = { offset_v = 0.005, sensitivity_v_per_g = 2.5, coning_deg = 0.5, azimuth_deg = 35.0, "
        "noise_v = 2e-5 }",
        "y": "y = { offset_v = -0.003, sensitivity_v_per_g = 2.48, coning_deg = 0.3, azimuth_deg = -110.0, "
        "noise_v = 2e-5 }",
        "z": "z = { offset_v = 0.008, sensitivity_v_per_g = 2.52, coning_deg = 0.4, azimuth_deg = 160.0, "
        "noise_v = 2e-5 }",
    }
    new = of_cones(drawn, "g", 2e-5).splitlines()
    return list(zip(old.values(), new, strict=True))


def _force(euler_rad: np.ndarray, *, is_model: bool) -> np.ndarray:
    """Return the specific force by CR's rotations; roll does not reach the sting."""
    pitch, yaw, roll = euler_rad
    return -to_package(pitch, yaw, roll if is_model else 0.0) @ np.array([0.0, 0.0, -1.0])


def by_table(procedure: str, changes: Mapping[str, str]) -> Callable[[Path, int, Told], None]:
    def run(folder: Path, seed: int, expected: Told) -> None:
        chance = np.random.default_rng(seed)
        drawn = cones(chance, 1.25)
        pattern = r"\[twin\.truth\.ENC03J\]\n(?:[xyz] = .*\n){3}"
        rig = {pattern: f"[twin.truth.ENC03J]\n{of_cones(drawn, 'dps', 0.002)}", r"seed = \d+": f"seed = {seed}"}
        own = delivered(motion_run(folder, "rate-table", procedure, changes, rig).solved(), folder, "ENC03J")
        wanted = {axis: {"offset_v": entry[0], "sensitivity_v_per_dps": entry[1]} for axis, entry in drawn.items()}
        parameters_hold(own, wanted, expected.parameters)
        truths = {axis: (entry[0], direction(axis, entry)) for axis, entry in drawn.items()}
        turned(own, truths, 0.002, chance, expected)

    return run


SCENES: Mapping[str, Callable[[Path, int, Told], None]] = {
    "SR accelerometer": sr_accelerometer,
    "SR gyro": sr_gyro,
    "SR magnetometer": sr_magnetometer,
    "CR gimbal, sting and model": cr_gimbal,
    "gyro by rates": by_table("rates", {r"replications = 4": "replications = 3", r"\[10.0, 40.0\]": "[40.0]"}),
    "gyro by motion": by_table("harmonic", {}),
}


@pytest.mark.parametrize(
    "seeds", [pytest.param(1, marks=pytest.mark.thorough), pytest.param(40, marks=pytest.mark.soak)], ids=str
)
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.timeout(3600)
def test_the_reports_calibrations_reach_angles_that_hold(scene: str, seeds: int, tmp_path: Path) -> None:
    found = Told()
    for seed in range(2000, 2000 + seeds):
        folder = tmp_path / str(seed)
        folder.mkdir()
        SCENES[scene](folder, seed, found)
    found.parameters.require(seeds)
    found.angles.require(seeds)
