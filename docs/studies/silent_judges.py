"""How one cell of the study of silent scenes is judged: what its intervals hold, and what is told of its cause.

Every judge takes campaigns of ``physics_scenes`` and returns shares over them. *After* is what calrig does by default;
*before* is a linear sensor on a table of independent teeth, with no findings and no flags.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from types import MappingProxyType
from typing import Any

import numpy as np
from physics_scenes import Campaign, GimbalReadings, UseReadings, campaigns
from silent_cells import JudgedCell, Shares, holds, named, offset_and_k, significant
from silent_declared import JOINT, Declared, separated
from silent_field import of_field
from silent_joint import of_joint
from solved_campaigns import Coverage, coverage, rows_of_package, solved

from ams.arrays import BoolArray, FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration.packages import calibrate_packages
from ams.inference.inference import Package, inference
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.sets.provenance import Provenance
from ams.surveillance.common_mode import judge_visits
from ams.surveillance.common_mode_columns import Visits, WatchedAxes
from ams.surveillance.common_mode_words import findings_of

FALSE_ALARM = 1e-4
"""Of a reference visit, as in a run."""
_PROVENANCE = Provenance(
    sensor="study", gravity_mps2=9.80665, gravity_source="declared", pitch_range_deg=(-90.0, 90.0),
    roll_range_deg=(-180.0, 180.0), created_utc=datetime(2026, 1, 1, tzinfo=UTC), software_version="study", rig="",
    procedure="", simulated=True,
)  # fmt: skip


def of_columns(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge campaigns of one schedule: all of an axis are solved at once."""
    design, declared = separated(design)
    chance = np.random.default_rng(seed)
    drawn = campaigns(scene, size, chance, count, **design)
    (table, teeth), errors = declared.table(scene), declared.errors
    found, plain = solved(drawn, table, errors), solved(drawn, teeth, extended=False)
    axes = drawn.setup.axes
    request = CalibrationRequest(table=table, shared_errors=dict.fromkeys(axes, errors))
    kinds = [_kinds_named([rows_of_package(drawn, index)], request) for index in range(count)]
    state = chance.bit_generator.state
    after = coverage(drawn, found, chance)
    chance.bit_generator.state = state
    before = coverage(drawn, plain, chance)
    return JudgedCell(
        {"offset": after.offset, "k": after.sensitivities, "prediction": after.prediction},
        {"offset": before.offset, "k": before.sensitivities, "prediction": before.prediction},
        named(scene, size, kinds, design),
        float(np.mean([bool(of_campaign) for of_campaign in kinds])),
        after.prediction_half_width_arcsec,
    )


def _kinds_named(packages: Sequence[Observations], request: CalibrationRequest) -> set[str]:
    """Return the kinds of what is told of the axes of packages that one table turned, as ``calrig fit`` tells it."""
    solved_packages = calibrate_packages({f"SN{at}": rows for at, rows in enumerate(packages, start=1)}, request)
    axes = (axis for package in solved_packages.values() for axis in package.axes.values())
    return set[str]().union(*(significant(axis.findings) for axis in axes))


def of_temperature(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge campaigns over plateaus, temperature coefficients estimated, one by one."""
    design, declared = separated(design)
    drawn = campaigns(scene, size, np.random.default_rng(seed), count, **design)
    points = drawn.points_deg
    best = drawn.package.best_linear(points[:, 0], points[:, 1])
    held: dict[str, list[FloatArray]] = {"after": [], "before": []}
    kinds = []
    for index in range(count):
        seen, kinds_found = rows_of_package(drawn, index), set()
        for word, extended in (("after", "yes"), ("before", "no")):
            order = declared.order if word == "after" else 1
            request = CalibrationRequest(
                temperature="estimate", temperature_order=order, reference_temperature_degc=20.0, extended=extended
            )  # type: ignore[arg-type]
            for which, axis in enumerate(calibrate(seen, request).axes.values()):
                truth = np.append(best[0][index, 0, which], best[1][index, 0, which])
                held[word].append(holds(axis, truth))
                kinds_found |= significant(axis.findings) if word == "after" else set()
        kinds.append(kinds_found)
    shares = {word: offset_and_k(np.array(each)) for word, each in held.items()}
    rings = float(np.mean([bool(of_campaign) for of_campaign in kinds]))
    return JudgedCell(shares["after"], shares["before"], named(scene, size, kinds), rings)


class _AnglesInUse:
    """Angles answered in use, campaign by campaign: what their intervals hold, of all rows and of those unflagged."""

    def __init__(self) -> None:
        self._held: list[BoolArray] = []
        self._unflagged: list[BoolArray] = []
        self._flagged: list[float] = []
        self._half_95_deg: list[FloatArray] = []

    def take(self, answer: Mapping[str, Any], truths_deg: Mapping[str, FloatArray]) -> None:
        flagged = np.array([flag != "" for flag in answer["flag"]])
        for name, truth_deg in truths_deg.items():
            away_deg = np.abs((answer[f"{name}_deg"] - truth_deg + 180.0) % 360.0 - 180.0)
            inside = away_deg <= answer[f"{name}_half_95_deg"]
            self._held.append(inside)
            self._unflagged.append(inside[~flagged])
            self._half_95_deg.append(answer[f"{name}_half_95_deg"][~flagged])
        self._flagged.append(float(flagged.mean()))

    def judged(self, size: float) -> JudgedCell:
        good, widths_deg = np.concatenate(self._unflagged), np.concatenate(self._half_95_deg)
        after = {"angle": float(good.mean())} if good.size else {}
        share = float(np.mean(np.array(self._flagged) >= 0.05))
        return JudgedCell(
            {**after, "flagged": float(np.mean(self._flagged))},
            {"angle": float(np.mean(self._held))},
            None if size == 0.0 else share,
            share,
            3600.0 * float(widths_deg.mean()) if widths_deg.size else None,
        )


def of_use(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge a package in use after a good calibration: angles of rows that nothing flags, and the flags.

    *Before* are the same angles of all rows. A campaign has told where one row in twenty or more is flagged: a good
    package has one in a thousand.
    """
    design, declared = separated(design)
    drawn: UseReadings = campaigns(scene, size, np.random.default_rng(seed), count, **design)
    axes, noise_v = drawn.use.setup.axes, drawn.use.setup.noise_arcsec * np.pi / 180.0 / 3600.0 * 2.5
    pitch, roll = drawn.use.schedule.pitch_deg, drawn.use.schedule.roll_deg
    angles = _AnglesInUse()
    for index in range(count):
        found = calibrate(rows_of_package(drawn.calibration, index), CalibrationRequest(shared_errors=declared.by_axis))
        package = Package(build_set(found, _PROVENANCE), {axis: f"{axis}_v" for axis in axes})
        readings = {f"{axis}_v": drawn.use.output_v[index, :, 0, which] for which, axis in enumerate(axes)}
        answer = replace(inference(package, reading_sd_v=noise_v), intervals=True).infer(readings)
        angles.take(answer, {"pitch": pitch, "roll": roll})
    return angles.judged(size)


def of_two_packages(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge CR's two packages on a gimbal, both calibrated, then used with something wrong, as :func:`of_use` does."""
    design, declared = separated(design)
    drawn: GimbalReadings = campaigns(scene, size, np.random.default_rng(seed), count, **design)
    noise_v = drawn.setup.noise_arcsec * np.pi / 180.0 / 3600.0 * 2.5
    angles = _AnglesInUse()
    for index in range(count):
        sting, model = (_package_of(drawn, index, which, declared) for which in range(2))
        how = replace(inference(sting, model, noise_v), intervals=True)
        columns = [(name, which) for which, package in enumerate((sting, model)) for name in package.columns.values()]
        readings = {name: drawn.use_v[index, :, which, at % 3] for at, (name, which) in enumerate(columns)}
        answer = how.infer(readings)
        angles.take(answer, dict(zip(("pitch", "yaw", "roll"), drawn.use_euler_deg.T, strict=True)))
    return angles.judged(size)


def _package_of(drawn: GimbalReadings, index: int, which: int, declared: Declared) -> Package:
    pitch, yaw, roll = np.deg2rad(drawn.calibration_euler_deg).T
    n, points = drawn.calibration_v.shape[1:3]
    rows = Observations(
        np.repeat(np.arange(n), points), np.tile(np.arange(points), n), np.tile(pitch, n), np.tile(roll, n),
        {axis: drawn.calibration_v[index, :, :, which, at].ravel() for at, axis in enumerate("xyz")},
        yaw_rad=np.tile(yaw, n),
    )  # fmt: skip
    name = ("sting", "model")[which]
    found = calibrate(rows, CalibrationRequest(model=f"pitch-yaw-roll-{name}", shared_errors=declared.by_axis))
    coefficients = build_set(found, replace(_PROVENANCE, yaw_range_deg=(-90.0, 90.0)))
    return Package(coefficients, {axis: f"{name}_{axis}_v" for axis in "xyz"})


def of_slips(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge reference visits of all sensors one after the other as a run does, and every sensor's fit after it.

    What changed between any two dwells is looked for by the fit of one package, in all of its axes together; only the
    visits, and what the table did at single dwells, see all packages. Offset and k are over the whole run, which is
    what a result holds that nobody stopped.
    """
    design, declared = separated(design)
    (table, _), errors = declared.table(scene), declared.errors
    chance = np.random.default_rng(seed)
    drawn = campaigns(scene, size, chance, count, **design)
    kinds: list[set[str]] = [set() for _ in range(count)]
    if drawn.setup.reference_every or drawn.setup.check_set:
        attitudes_deg, visits = _visits(drawn)
        pitch, roll = np.deg2rad(attitudes_deg)
        kinds = [_between_visits(drawn, visit, pitch, roll) for visit in visits]
    axes, held = drawn.setup.axes, []
    each = [_of_sensor(drawn, sensor) for sensor in range(drawn.setup.sensors)]
    request = CalibrationRequest(
        table=table, shared_errors=dict.fromkeys(axes, errors), tested_axes=len(each) * len(axes)
    )
    for index in range(count):
        kinds[index] |= _kinds_named([rows_of_package(drawn, index, sensor) for sensor in range(len(each))], request)
    for alone in each:
        found = solved(alone, table, errors)
        held.append([coverage(alone, columns, chance) for columns in (found, solved(alone, extended=False))])
    rings = float(np.mean([bool(of_campaign) for of_campaign in kinds]))
    after, before = (_mean_shares([pair[which] for pair in held]) for which in (0, 1))
    half = float(np.mean([after.prediction_half_width_arcsec for after, _ in held]))
    return JudgedCell(after, before, named(scene, size, kinds), rings, half)


def _visits(drawn: Campaign) -> tuple[FloatArray, FloatArray]:
    """Return (2, a) attitudes and (n, visits, a, outputs): reference visits, else what both check sets have."""
    schedule, every = drawn.visits("reference" if drawn.setup.reference_every else "check-before")
    size = 2 if drawn.setup.reference_every else schedule.dwells
    if not drawn.setup.reference_every:
        every = np.concatenate([every, drawn.visits("check-after")[1][:, :size]], axis=1)
    angles = np.stack([schedule.pitch_deg[:size], schedule.roll_deg[:size]])
    return angles, every.reshape(drawn.campaigns, -1, size, every.shape[2] * every.shape[3])


def _mean_shares(each: Sequence[Coverage]) -> Shares:
    return {
        "offset": float(np.mean([shares.offset for shares in each])),
        "k": float(np.mean([shares.sensitivities for shares in each])),
        "prediction": float(np.mean([shares.prediction for shares in each])),
    }


def _of_sensor(drawn: Campaign, sensor: int) -> Campaign:
    """Return the campaign as one of its sensors saw it, which stands as the table does."""
    column, shape = slice(sensor, sensor + 1), (drawn.campaigns, drawn.setup.sensors)
    fields = {
        name: value[:, column] if isinstance(value, np.ndarray) and value.shape[:2] == shape else value
        for name, value in vars(drawn.package).items()
    }
    setup = replace(drawn.setup, sensors=1, mounts=drawn.setup.mounts[column])
    return replace(drawn, setup=setup, output_v=drawn.output_v[:, :, column], package=replace(drawn.package, **fields))


def _between_visits(drawn: Campaign, visits: FloatArray, pitch: FloatArray, roll: FloatArray) -> set[str]:
    sensors, axes = drawn.setup.sensors, drawn.setup.axes
    names = tuple(f"SN{index + 1}" for index in range(sensors) for _ in axes)
    k = np.tile(2.5 * np.eye(3)[["xyz".index(axis) for axis in axes]], (sensors, 1))
    watched = WatchedAxes(names, tuple(axes * sensors), ("dmm",) * len(names), k)
    noise_v = drawn.setup.noise_arcsec * np.pi / 180.0 / 3600.0 * 2.5
    kinds_found: set[str] = set()
    for earlier in (visits[:-1], np.repeat(visits[:1], len(visits) - 1, axis=0)):
        for visit, other in zip(earlier, visits[1:], strict=True):
            pair = Visits(pitch, roll, other - visit, other, np.full(other.shape, 2.0 * noise_v**2), 200.0)
            kinds_found |= significant(findings_of(judge_visits(watched, pair, FALSE_ALARM), watched.sensors, ""))
            if kinds_found:
                return kinds_found
    return kinds_found


Judge = Callable[[str, float, int, int, Mapping[str, float]], JudgedCell]


def judge_of(scene: str, design: Mapping[str, float] = MappingProxyType({})) -> Judge:
    """Return what judges a scene in a design."""
    if JOINT in design:
        return of_joint
    if scene in ("temperature-lag", "temperature-curvature"):
        return of_temperature
    kinds: tuple[tuple[tuple[str, ...], Judge], ...] = (
        (("use-",), of_use),
        (("two-packages-",), of_two_packages),
        (("field-",), of_field),
        (("slip-", "meter-", "supply", "sensor-", "remount", "fixture-"), of_slips),
    )
    return next((judge for starts, judge in kinds if scene.startswith(starts)), of_columns)
