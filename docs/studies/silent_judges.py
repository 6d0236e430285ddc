"""How one cell of the study of silent scenes is judged: what its intervals hold, and what is told of its cause.

Every judge takes campaigns of ``physics_scenes`` and returns shares over them. *After* is what calrig does by default;
*before* is a linear sensor on a table of independent teeth, with no findings and no flags.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np
from physics_scenes import SCENES, Campaign, FieldReadings, GimbalReadings, UseReadings, campaigns
from physics_scenes.temperature_scenes import OFFSET_TC_G_PER_DEGC, SENSITIVITY_TC_PER_DEGC
from solved_campaigns import ARCSEC, Coverage, columns_of, coverage, rows_of, solved, table_of

from ams.analysis.diagnostics.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LEVEL, SQUARENESS, TABLE_LIMIT
from ams.analysis.diagnostics.declared_field import FieldAxis, field_finding, judge_field
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration.columns import SolvedColumns
from ams.calibration.diagnosis import Circumstances, diagnose, evidence_of
from ams.calibration.steps import judge_steps
from ams.calibration.table_limit import judge_table
from ams.calibration_result import AxisCalibration
from ams.findings import Finding
from ams.frames import from_level_axes
from ams.inference.inference import Package, inference
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import Effect, SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.field_triad import FieldTriad
from ams.models.model import Model
from ams.models.straight_line import StraightLine
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.sets.provenance import Provenance
from ams.solve.layout import Layout
from ams.statistics.intervals import t_quantile
from ams.surveillance.common_mode import judge_visits
from ams.surveillance.common_mode_columns import Visits, WatchedAxes
from ams.surveillance.common_mode_words import findings_of

Shares = Mapping[str, float]
TABLE = "table"
"""A finding that names the table: a general lack of fit does not count where its curve is beyond the limit."""
DECLARED = "declared_arcsec"
"""Of a design: the limits of the level of the base and of setting the axes to zero, as a rig file declares them."""
USED = "declared_degc"
"""Of a design: how far from its calibration a sensor is used, with its largest coefficients, as a rig file has them."""
NOMINAL_V_PER_G = 2.5
_LEVEL: tuple[Effect, ...] = ("pitch", "base-tilt")
FALSE_ALARM = 1e-4
"""Of a reference visit, as in a run."""
_PROVENANCE = Provenance(
    sensor="study", gravity_mps2=9.80665, gravity_source="declared", pitch_range_deg=(-90.0, 90.0),
    roll_range_deg=(-180.0, 180.0), created_utc=datetime(2026, 1, 1, tzinfo=UTC), software_version="study", rig="",
    procedure="", simulated=True,
)  # fmt: skip


@dataclass(frozen=True)
class JudgedCell:
    """Of one cell."""

    after: Shares
    """``offset``, ``k`` and ``prediction`` or ``angle``; what a scene does not have is not there."""
    before: Shares
    named: float | None
    """Share of the campaigns in which the true cause is named, or rows in use are flagged."""
    rings: float | None
    """Share of the campaigns in which anything is told."""
    half_width_arcsec: float | None = None


def of_columns(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge campaigns of one schedule: all of an axis are solved at once."""
    declared_arcsec, errors = design.get(DECLARED, 0.0), _declared_errors(design)
    design = {name: value for name, value in design.items() if name not in (DECLARED, USED)}
    chance = np.random.default_rng(seed)
    drawn = campaigns(scene, size, chance, count, **design)
    table, teeth = _tables(scene, declared_arcsec)
    found, plain = solved(drawn, table, errors), solved(drawn, teeth, extended=False)
    kinds: list[set[str]] = [set() for _ in range(count)]
    limits = [
        judge_table([(columns, [index]) for columns in found.values()], rows_of(drawn), table) for index in range(count)
    ]
    for index, rows in _of_one_temperature(drawn):
        parts = found if rows is None else solved(_only(drawn, index), table, errors)
        for which, diagnoses in enumerate(_diagnoses(drawn, parts, index, table, errors, limits), start=index):
            kinds[which] |= diagnoses
    state = chance.bit_generator.state
    after = coverage(drawn, found, chance)
    chance.bit_generator.state = state
    before = coverage(drawn, plain, chance)
    return JudgedCell(
        {"offset": after.offset, "k": after.sensitivities, "prediction": after.prediction},
        {"offset": before.offset, "k": before.sensitivities, "prediction": before.prediction},
        _named(scene, size, kinds),
        float(np.mean([bool(named) for named in kinds])),
        after.prediction_half_width_arcsec,
    )


def _declared_errors(design: Mapping[str, float]) -> list[SharedError]:
    level_rad, away_degc = (design.get(name, 0.0) / 3.0**0.5 for name in (DECLARED, USED))
    return [
        *(SharedError(f"level, {effect}", effect, level_rad * ARCSEC) for effect in _LEVEL),
        SharedError("temperature of use, offset", "reading", away_degc * OFFSET_TC_G_PER_DEGC * NOMINAL_V_PER_G),
        SharedError("temperature of use, sensitivity", "gain", away_degc * SENSITIVITY_TC_PER_DEGC),
    ]


def _diagnoses(
    drawn: Campaign,
    found: Mapping[str, SolvedColumns],
    first: int,
    table: TableUncertainty | None = None,
    errors: Sequence[SharedError] = (),
    limits: Sequence[TableLimit | None] = (),
    family: int | None = None,
) -> list[set[str]]:
    """Return the kinds of what is told of each of the campaigns solved, the first of them ``first``."""
    seen, axes = _seen(drawn, first), family or len(found)
    evidence = {axis: evidence_of(columns, seen) for axis, columns in found.items()}
    count = next(iter(found.values())).primary.shape[0]
    steps = [judge_steps([(evidence[axis], index) for axis in found], axes) for index in range(count)]
    kinds: list[set[str]] = [set() for _ in range(count)]
    for which, (axis, columns) in enumerate(found.items()):
        outputs = columns_of(drawn, axis)[:, first : first + count]
        of_table = limits[first : first + count]
        changed = [axis_steps[which] for axis_steps in steps]
        circumstances = Circumstances(seen, outputs, table, errors, of_table, axes, steps=changed)
        for index, diagnosis in enumerate(diagnose(columns, circumstances, evidence[axis])):
            kinds[index] |= _significant(diagnosis.findings)
    return kinds


def _tables(scene: str, declared_arcsec: float) -> tuple[TableUncertainty | None, TableUncertainty | None]:
    """Return what is declared of the table; ``declared_arcsec``: limit of its zeros, 0: none."""
    if not scene.startswith("table-"):
        return None, None
    zero = 0.0 if scene.endswith("zeroed") or declared_arcsec > 0.0 else None
    return table_of(zero_rad=zero, zero_u_arcsec=declared_arcsec / 3.0**0.5), table_of(shape="independent")


def _of_one_temperature(drawn: Campaign) -> list[tuple[int, int | None]]:
    """All campaigns at once where they recorded the same temperature, else one by one."""
    if float(np.ptp(drawn.temperature_degc, axis=0).max()) == 0.0:
        return [(0, None)]
    return [(index, index) for index in range(drawn.campaigns)]


def _only(drawn: Campaign, index: int) -> Campaign:
    column = slice(index, index + 1)
    return replace(drawn, output_v=drawn.output_v[column], temperature_degc=drawn.temperature_degc[column])


def _seen(drawn: Campaign, index: int, axes: Sequence[str] = ()) -> Observations:
    rows = rows_of(drawn)
    temperature = drawn.grid(drawn.temperature_degc).reshape(drawn.campaigns, -1)[index]
    time_s = drawn.schedule.time_s[drawn.schedule.grid_rows()].ravel()
    outputs = {axis: columns_of(drawn, axis)[:, index] for axis in axes}
    return replace(rows, time_s=time_s, temperature_degc=temperature, outputs=outputs)


def _significant(findings: Sequence[Finding]) -> set[str]:
    """Kinds of findings; one that names the table has its name beside."""
    significant = [finding for finding in findings if finding.is_significant]
    of_table = (TABLE_LIMIT, SQUARENESS)
    return {finding.kind for finding in significant} | {
        TABLE for finding in significant if finding.details.get("test") in of_table
    }


def _named(scene: str, size: float, kinds: Sequence[set[str]]) -> float | None:
    entry = SCENES[scene]
    if entry.true_cause is None or size == 0.0:
        return None
    is_table = scene.startswith("table-")
    right = {TABLE, *entry.also} if is_table else {entry.true_cause, *entry.also}
    return float(np.mean([bool(named & right) for named in kinds]))


def of_temperature(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge campaigns over plateaus, temperature coefficients estimated, one by one."""
    drawn = campaigns(scene, size, np.random.default_rng(seed), count, **design)
    points = drawn.points_deg
    best = drawn.package.best_linear(points[:, 0], points[:, 1])
    held: dict[str, list[FloatArray]] = {"after": [], "before": []}
    kinds = []
    for index in range(count):
        seen, kinds_found = _seen(drawn, index, drawn.setup.axes), set()
        for word, extended in (("after", "yes"), ("before", "no")):
            request = CalibrationRequest(temperature="estimate", reference_temperature_degc=20.0, extended=extended)  # type: ignore[arg-type]
            for which, axis in enumerate(calibrate(seen, request).axes.values()):
                truth = np.append(best[0][index, 0, which], best[1][index, 0, which])
                held[word].append(_holds(axis, truth))
                kinds_found |= _significant(axis.findings) if word == "after" else set()
        kinds.append(kinds_found)
    shares = {word: _offset_and_k(np.array(each)) for word, each in held.items()}
    rings = float(np.mean([bool(named) for named in kinds]))
    return JudgedCell(shares["after"], shares["before"], _named(scene, size, kinds), rings)


def _holds(axis: AxisCalibration, truth: FloatArray) -> FloatArray:
    size = truth.size
    half = t_quantile(0.95, axis.primary_dof[:size]) * np.sqrt(np.diag(axis.primary_covariance)[:size])
    return np.asarray(np.abs(axis.primary[:size] - truth) <= half)


def _offset_and_k(held: FloatArray) -> Shares:
    return {"offset": float(held[:, 0].mean()), "k": float(held[:, 1:].mean())}


def of_use(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge a package in use after a good calibration: angles of rows that nothing flags, and the flags.

    *Before* are the same angles of all rows. A campaign has told where one row in twenty or more is flagged: a good
    package has one in a thousand.
    """
    drawn: UseReadings = campaigns(scene, size, np.random.default_rng(seed), count, **design)
    axes, noise_v = drawn.use.setup.axes, drawn.use.setup.noise_arcsec * np.pi / 180.0 / 3600.0 * 2.5
    pitch, roll = drawn.use.schedule.pitch_deg, drawn.use.schedule.roll_deg
    held, unflagged, flags = [], [], []
    for index in range(count):
        found = calibrate(_seen(drawn.calibration, index, axes), CalibrationRequest())
        package = Package(build_set(found, _PROVENANCE), {axis: f"{axis}_v" for axis in axes})
        readings = {f"{axis}_v": drawn.use.output_v[index, :, 0, which] for which, axis in enumerate(axes)}
        answer = replace(inference(package, reading_sd_v=noise_v), intervals=True).infer(readings)
        flagged = np.array([flag != "" for flag in answer["flag"]])
        for name, truth in (("pitch", pitch), ("roll", roll)):
            away = np.abs((answer[f"{name}_deg"] - truth + 180.0) % 360.0 - 180.0)
            inside = away <= answer[f"{name}_half_95_deg"]
            held.append(inside)
            unflagged.append(inside[~flagged])
        flags.append(float(flagged.mean()))
    good = np.concatenate(unflagged)
    after = {"angle": float(good.mean())} if good.size else {}
    share = float(np.mean(np.array(flags) >= 0.05))
    return JudgedCell(
        {**after, "flagged": float(np.mean(flags))}, {"angle": float(np.mean(held))},
        None if size == 0.0 else share, share,
    )  # fmt: skip


def of_two_packages(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge CR's two packages on a gimbal, both calibrated, then used with something wrong, as :func:`of_use` does."""
    drawn: GimbalReadings = campaigns(scene, size, np.random.default_rng(seed), count, **design)
    noise_v = drawn.setup.noise_arcsec * np.pi / 180.0 / 3600.0 * 2.5
    held, unflagged, flags = [], [], []
    for index in range(count):
        sting, model = (_package_of(drawn, index, which) for which in range(2))
        how = replace(inference(sting, model, noise_v), intervals=True)
        columns = [(name, which) for which, package in enumerate((sting, model)) for name in package.columns.values()]
        readings = {name: drawn.use_v[index, :, which, at % 3] for at, (name, which) in enumerate(columns)}
        answer = how.infer(readings)
        flagged = np.array([flag != "" for flag in answer["flag"]])
        for which, name in enumerate(("pitch", "yaw", "roll")):
            away = np.abs((answer[f"{name}_deg"] - drawn.use_euler_deg[:, which] + 180.0) % 360.0 - 180.0)
            inside = away <= answer[f"{name}_half_95_deg"]
            held.append(inside)
            unflagged.append(inside[~flagged])
        flags.append(float(flagged.mean()))
    good = np.concatenate(unflagged)
    after = {"angle": float(good.mean())} if good.size else {}
    share = float(np.mean(np.array(flags) >= 0.05))
    return JudgedCell(
        {**after, "flagged": float(np.mean(flags))}, {"angle": float(np.mean(held))},
        None if size == 0.0 else share, share,
    )  # fmt: skip


def _package_of(drawn: GimbalReadings, index: int, which: int) -> Package:
    pitch, yaw, roll = np.deg2rad(drawn.calibration_euler_deg).T
    n, points = drawn.calibration_v.shape[1:3]
    rows = Observations(
        np.repeat(np.arange(n), points), np.tile(np.arange(points), n), np.tile(pitch, n), np.tile(roll, n),
        {axis: drawn.calibration_v[index, :, :, which, at].ravel() for at, axis in enumerate("xyz")},
        yaw_rad=np.tile(yaw, n),
    )  # fmt: skip
    name = ("sting", "model")[which]
    found = calibrate(rows, CalibrationRequest(model=f"pitch-yaw-roll-{name}"))
    coefficients = build_set(found, replace(_PROVENANCE, yaw_range_deg=(-90.0, 90.0)))
    return Package(coefficients, {axis: f"{name}_{axis}_v" for axis in "xyz"})


def of_slips(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge reference visits of all sensors one after the other as a run does, and every sensor's fit after it.

    Offset and k are those over the whole run, which is what a result holds that nobody stopped.
    """
    chance = np.random.default_rng(seed)
    drawn = campaigns(scene, size, chance, count, **design)
    kinds: list[set[str]] = [set() for _ in range(count)]
    if drawn.setup.reference_every:
        schedule, output_v = drawn.visits("reference")
        visits = output_v.reshape(count, -1, 2, output_v.shape[2] * output_v.shape[3])
        pitch, roll = (np.deg2rad(angle[:2]) for angle in (schedule.pitch_deg, schedule.roll_deg))
        kinds = [_between_visits(drawn, visit, pitch, roll) for visit in visits]
    held, family = [], drawn.setup.sensors * len(drawn.setup.axes)
    for sensor in range(drawn.setup.sensors):
        alone = _of_sensor(drawn, sensor)
        found = solved(alone)
        for which, diagnoses in enumerate(_diagnoses(alone, found, 0, family=family)):
            kinds[which] |= diagnoses
        held.append([coverage(alone, columns, chance) for columns in (found, solved(alone, extended=False))])
    rings = float(np.mean([bool(named) for named in kinds]))
    after, before = (_mean_shares([pair[which] for pair in held]) for which in (0, 1))
    return JudgedCell(after, before, _named(scene, size, kinds), rings)


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
            kinds_found |= _significant(findings_of(judge_visits(watched, pair, FALSE_ALARM), watched.sensors, ""))
            if kinds_found:
                return kinds_found
    return kinds_found


def of_field(scene: str, size: float, count: int, seed: int, design: Mapping[str, float]) -> JudgedCell:
    """Judge two-level calibrations of a magnetometer; before, every axis was a straight line along its own."""
    drawn: FieldReadings = campaigns(scene, size, np.random.default_rng(seed), count, **design)
    replications, levels = drawn.setup.replications, len(drawn.setup.levels)
    pitch = np.deg2rad(np.repeat([90.0, -90.0, 0.0, 0.0, 0.0, 0.0], levels))
    roll = np.deg2rad(np.repeat([0.0, 0.0, -90.0, 90.0, 180.0, 0.0], levels))
    turned = from_level_axes(pitch, np.zeros_like(pitch), roll)
    assert np.allclose(turned[::levels], drawn.to_package)
    applied = np.tile(drawn.nominal_coil_ut[:, 2], 6)
    field = turned @ drawn.nominal_earth_ut + turned[..., 2] * applied[:, None]
    identity = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    beside = tuple(float(component) for component in drawn.nominal_earth_ut)
    held: dict[str, list[FloatArray]] = {"after": [], "before": []}
    kinds = []
    for index in range(count):
        kinds_found: set[str] = set()
        for which, axis in enumerate("xyz"):
            reading = drawn.counts[index, ..., which].reshape(-1)
            order = [which, *(other for other in range(3) if other != which)]
            truth = np.append(drawn.offset_counts[index, which], drawn.matrix_counts_per_ut[index, which, order])
            triad = FieldTriad(axis, "ut", "counts", identity, (0.0, 0.0, 1.0), beside)  # type: ignore[arg-type]
            line = StraightLine(axis, "ut", "counts")
            for word, model, level in (("after", triad, applied), ("before", line, field[:, which])):
                rows = _field_rows(axis, reading, (pitch, roll, level), replications)
                found = _of_model(axis, model, rows)
                held[word].append(_holds(found, truth[: 4 if word == "after" else 2])[:2])
                kinds_found |= _significant(found.findings) if word == "after" else set()
        kinds.append(kinds_found | _of_all_axes(drawn, index, turned, applied))
    shares = {word: _offset_and_k(np.array(each)) for word, each in held.items()}
    rings = float(np.mean([bool(named) for named in kinds]))
    return JudgedCell(shares["after"], shares["before"], _named(scene, size, kinds), rings)


def _of_all_axes(drawn: FieldReadings, index: int, turned: FloatArray, applied: FloatArray) -> set[str]:
    """Return what all axes together say of the field, at the share of the level that they have in a run of three."""
    replications, rows = drawn.setup.replications, applied.size
    readings = drawn.counts[index].reshape(replications * rows, 3)
    axes = {axis: FieldAxis(readings[:, which], drawn.nominal_earth_ut, {}) for which, axis in enumerate("xyz")}
    layout = Layout(
        np.repeat(np.arange(replications), rows), np.tile(np.arange(rows), replications),
        tuple(range(replications)), tuple(range(rows)),
    )  # fmt: skip
    attitudes, strength = np.tile(turned, (replications, 1, 1)), np.tile(applied, replications)
    test = judge_field(attitudes, np.array([0.0, 0.0, 1.0]), strength, axes, layout, is_declared=True)
    return set() if test is None else _significant([field_finding(test, LEVEL / MOST_TESTS, "µT")])


def _field_rows(
    axis: str, reading: FloatArray, stimulus: tuple[FloatArray, FloatArray, FloatArray], replications: int
) -> Observations:
    pitch, roll, level = (np.tile(column, replications) for column in stimulus)
    points = pitch.size // replications
    return Observations(
        np.repeat(np.arange(replications), points), np.tile(np.arange(points), replications), pitch, roll,
        {axis: reading}, units={axis: "counts"}, reference_level=level,
    )  # fmt: skip


def _of_model(axis: str, model: Model, rows: Observations) -> AxisCalibration:
    return calibrate(rows, CalibrationRequest(nominal_axes={axis: axis}, models={axis: model}, tested_axes=3)).axes[
        axis
    ]


Judge = Callable[[str, float, int, int, Mapping[str, float]], JudgedCell]


def judge_of(scene: str) -> Judge:
    """Return what judges a scene."""
    if scene in ("temperature-lag", "temperature-curvature"):
        return of_temperature
    kinds: tuple[tuple[tuple[str, ...], Judge], ...] = (
        (("use-",), of_use),
        (("two-packages-",), of_two_packages),
        (("field-",), of_field),
        (("slip-", "meter-", "supply", "sensor-", "remount", "fixture-"), of_slips),
    )
    return next((judge for starts, judge in kinds if scene.startswith(starts)), of_columns)
