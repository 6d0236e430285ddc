"""The laboratory of the study of hours: one package or eight on a table whose errors are smooth, everything on twins.

What is there to be found: a table within its certificate's limit of one arc second but smooth, with teeth of a tenth;
a soft mount of one arc second in every package; an offset that drifts by a twentieth of an arc second a replication,
however short the replication is; readings of 20 µV (1.65 arc seconds).
"""

from dataclasses import dataclass
from datetime import UTC, datetime
from math import pi, sqrt
from pathlib import Path

import numpy as np

from ams.analysis.angle_uncertainty import KnownAxis, UsageBox, angle_uncertainties, inferred
from ams.arrays import FloatArray
from ams.calibration.columns import SolvedColumns, solve_columns
from ams.frames import Attitude
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.extended import TERM_NAMES, ExtendedPitchRoll, centring_of
from ams.observations import Observations
from ams.solve.package import SolvedAxis, package_covariance
from ams.statistics.intervals import t_quantile
from procedures.check.candidate import Candidate
from procedures.check.candidates import sees_drift_arcsec, sees_lack_of_fit_arcsec
from procedures.delivery.deliver import sensors_document, solve_run
from procedures.journal.header import make_header
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.plan.plan import Plan
from procedures.run.begin import begin
from procedures.solution.beliefs import beliefs_of
from procedures.solution.type_b import table_uncertainty
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig

ARCSEC = pi / 180.0 / 3600.0
V_PER_G = 2.5
NOISE_V = 2e-5
READING_ARCSEC = NOISE_V / V_PER_G / ARCSEC
DWELL_ARCSEC = READING_ARCSEC / sqrt(20.0)
USAGE_PITCH_DEG = (-60.0, 60.0)
LIMIT_ARCSEC = 1.0
TEETH_ARCSEC = 0.1
SOFT_ARCSEC = 1.0
DRIFT_ARCSEC = 0.05
LACK_OF_FIT_ARCSEC = 0.1
HARMONICS = {"pitch": ((1, 0.5, 40.0), (2, 0.35, 110.0)), "roll": ((1, 0.45, 200.0), (3, 0.3, 15.0))}
"""Times a turn, amplitude in arc seconds, phase in degrees: within the limit together with the teeth."""
OWN_NPLC = 10.0
"""Of the meter; a shorter integration scatters more by its square root, in the campaigns and not in the twin."""
BATCH = 250

_AXIS = """[axes.{name}]
driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 5.0
uncertainty_arcsec = {limit}
axis = {number}
[twin.axes.{name}]
index_error_arcsec = {teeth}
index_harmonics = {harmonics}
"""

_LEVEL = """[level]
instrument = "electronic level"
uncertainty_arcsec = 0.2
before = { about_pitch_arcsec = 0.0, about_roll_arcsec = 0.0 }
after = { about_pitch_arcsec = 0.0, about_roll_arcsec = 0.0 }"""


def rig_text(packages: int, seed: int) -> str:
    """Return the rig file."""
    serials = [f"SN{number:02d}" for number in range(1, packages + 1)]
    lines = ['[rig]\nname = "laboratory of the study of hours"\ngravity_mps2 = 9.79826', _LEVEL]
    for number, (name, harmonics) in enumerate(HARMONICS.items(), start=1):
        waves = [list(wave) for wave in harmonics]
        lines.append(_AXIS.format(name=name, number=number, limit=LIMIT_ARCSEC, teeth=TEETH_ARCSEC, harmonics=waves))
    channels = [f"{serial.lower()}{axis}" for serial in serials for axis in "xyz"]
    scanned = ", ".join(
        f"{name} = {{ scanner = {100 * (1 + place // 10) + place % 10}, range_v = 10.0 }}"
        for place, name in enumerate(channels)
    )
    lines.append(f'[readouts.dmm]\ndriver = "hp3458a"\nresource = "twin"\nnplc = 10\nchannels = {{ {scanned} }}')
    lines.append(f'[twin]\nseed = {seed}\ntime = "virtual"')
    for place, serial in enumerate(serials):
        wired = ", ".join(f'{axis} = "dmm.{serial.lower()}{axis}"' for axis in "xyz")
        lines.append(
            f'[sensors.{serial}]\nmodel = "three-axis package"\nchannels = {{ {wired} }}\n'
            f"nominal_sensitivity_v_per_g = {V_PER_G}"
        )
        lines += [_truth_text(serial, axis, place) for axis in "xyz"]
    return "\n".join(lines) + "\n"


def _truth_text(serial: str, axis: str, place: int) -> str:
    soft = [SOFT_ARCSEC * ARCSEC * V_PER_G * part for part in (0.6, -0.4, 0.5, 0.3, -0.5)]
    return (
        f"[twin.truth.{serial}.{axis}]\noffset_v = {0.005 + 0.001 * place}\nsensitivity_v_per_g = {V_PER_G}\n"
        f"coning_deg = 0.4\nazimuth_deg = {35.0 + 10.0 * place}\nnoise_v = {NOISE_V}\n"
        f"offset_drift_v_per_replication = {DRIFT_ARCSEC * ARCSEC * V_PER_G!r}\nq_v_per_g2 = {soft!r}"
    )


@dataclass(frozen=True)
class Measured:
    """A run of the engine and its solution: the worst axis, the worst sensor."""

    name: str
    packages: int
    plan: Plan
    table: TableUncertainty
    hours: float
    u95_arcsec: float
    """Of pitch, read at use by one dwell of twenty readings."""
    calibration_arcsec: float
    single_arcsec: float
    """The same, read at use once."""
    single_calibration_arcsec: float
    offset_uv: float
    """95 % half-width."""
    sensitivity_uv_per_g: float
    verdict: str
    sees_lack_of_fit_arcsec: float
    sees_drift_arcsec: float
    foreseen_h: float = 0.0
    foreseen_arcsec: float = 0.0
    chosen: Candidate | None = None


def measured(name: str, packages: int, procedure: str, folder: Path) -> Measured:
    """Run a procedure on the twins and solve it."""
    folder.mkdir()
    rig_file, procedure_file, run = folder / "rig.toml", folder / "procedure.toml", folder / "run"
    rig_file.write_text(rig_text(packages, 3), encoding="utf-8")
    procedure_file.write_text(procedure, encoding="utf-8")
    rig = read_rig(rig_file)
    plan = make_plan(rig, read_procedure(procedure_file))
    run.mkdir()
    header = make_header("run", plan, rig, rig_file, procedure_file, "study", datetime.now(UTC))
    with open_rig(rig) as opened:
        began_s = opened.clock.monotonic_s()
        begin(run, header, plan, opened)
        hours = (opened.clock.monotonic_s() - began_s) / 3600.0
    solved = solve_run(run)
    angles, halves = [], {"offset_v": 0.0, "sensitivity_v_per_g": 0.0}
    for sensor in solved.sensors.values():
        calibration = sensor.calibration
        assert calibration is not None
        assert calibration.package is not None
        pair = []
        for reading_arcsec in (DWELL_ARCSEC, READING_ARCSEC):
            known = [
                KnownAxis(
                    ExtendedPitchRoll(one.nominal_axis, one.centring), one.primary, reading_arcsec * ARCSEC * V_PER_G
                )
                for one in calibration.axes.values()
            ]
            low, high = np.deg2rad(USAGE_PITCH_DEG)
            pair.append(angle_uncertainties(known, calibration.package.components, UsageBox((low, high)))["pitch"])
        angles.append(pair)
        for one in calibration.axes.values():
            for item in one.parameters:
                if item.name in halves and item.interval_95 is not None:
                    half = 0.5 * (item.interval_95[1] - item.interval_95[0])
                    halves[item.name] = max(halves[item.name], half)
    dwell, single = max(angles, key=lambda pair: pair[0].u95_rad)
    belief = next(iter(beliefs_of(rig, plan.solve, 20, plan.replications, plan.sensors).values()))
    belief = belief.integrated((plan.dwell.nplc or OWN_NPLC) / OWN_NPLC)
    points, samples, n = len(plan.design.points), plan.dwell.samples, plan.replications
    table = table_uncertainty(rig)
    assert table is not None
    verdicts = {document["verdict"] for document in sensors_document(solved).values()}
    return Measured(
        name=name,
        packages=packages,
        plan=plan,
        table=table,
        hours=hours,
        u95_arcsec=dwell.u95_rad / ARCSEC,
        calibration_arcsec=dwell.calibration_rad / ARCSEC,
        single_arcsec=single.u95_rad / ARCSEC,
        single_calibration_arcsec=single.calibration_rad / ARCSEC,
        offset_uv=1e6 * halves["offset_v"],
        sensitivity_uv_per_g=1e6 * halves["sensitivity_v_per_g"],
        verdict=", ".join(sorted(verdicts)),
        sees_lack_of_fit_arcsec=sees_lack_of_fit_arcsec(belief, samples, points, n, 4 + len(TERM_NAMES)),
        sees_drift_arcsec=sees_drift_arcsec(belief, samples, points, n),
    )


@dataclass(frozen=True)
class Coverage:
    """Shares of 95 % intervals that hold the truth."""

    shares: tuple[float, float, float, float]
    """Offset, sensitivities, pitch at use, roll at use."""
    half_width_arcsec: float
    """Of pitch at use, root mean square."""


def coverage(run: Measured, campaigns: int, chance: np.random.Generator) -> Coverage:
    """Draw campaigns of the run's design and count what their intervals hold; a dwell of twenty readings at use."""
    held: list[tuple[float, float, float, float]] = []
    squares: list[float] = []
    for first in range(0, campaigns, BATCH):
        _batch(run, min(BATCH, campaigns - first), chance, held, squares)
    shares = np.nanmean(np.array(held), axis=0)
    return Coverage((shares[0], shares[1], shares[2], shares[3]), sqrt(float(np.mean(squares))))


def _batch(
    run: Measured, count: int, chance: np.random.Generator, held: list[tuple[float, ...]], squares: list[float]
) -> None:
    points, n = run.plan.design.points, run.plan.replications
    angles = np.deg2rad([[point.pitch_deg, point.roll_deg] for point in points])
    rows = Observations(
        replication=np.repeat(np.arange(1, n + 1), len(points)),
        point=np.tile(np.arange(1, len(points) + 1), n),
        pitch_rad=np.tile(angles[:, 0], n),
        roll_rad=np.tile(angles[:, 1], n),
        outputs={},
        source="campaign",
    )
    stood = [_curve(angles[:, place], count, chance) for place in range(2)]
    true = {axis: _truth(chance, count, place) for place, axis in enumerate("xyz")}
    outputs = {axis: _outputs(run, *stood, one, chance) for axis, one in true.items()}
    solved: dict[str, SolvedColumns] = {}
    for axis in "xyz":
        model = ExtendedPitchRoll(axis, centring_of(Attitude(*angles.T), len(points), axis))
        solved[axis] = solve_columns(rows, outputs[axis], [model] * count, table=run.table)
    pitch = np.deg2rad(chance.uniform(*USAGE_PITCH_DEG, count))
    roll = chance.uniform(-pi, pi, count)
    for row in range(count):
        at = Attitude(pitch[row : row + 1], roll[row : row + 1])
        held.append(_held(solved, true, row, at, chance, squares))


@dataclass(frozen=True)
class _True:
    """Sensors of one axis, one a campaign."""

    offset_v: FloatArray
    k_v_per_g: FloatArray
    """(m, 3)"""
    q_v_per_g2: FloatArray
    """(m, 3, 3) without trace."""

    def volts(self, force: FloatArray) -> FloatArray:
        """(…, m) from (…, m, 3)."""
        bent = np.einsum("...mi,mij,...mj->...m", force, self.q_v_per_g2, force)
        return np.asarray(self.offset_v + np.einsum("...mi,mi->...m", force, self.k_v_per_g) + bent)


def _truth(chance: np.random.Generator, count: int, place: int) -> _True:
    k = 0.01 * V_PER_G * chance.standard_normal((count, 3))
    k[:, place] += V_PER_G
    half = SOFT_ARCSEC * ARCSEC * V_PER_G * chance.standard_normal((count, 3, 3)) / 2.0
    q = half + np.swapaxes(half, 1, 2)
    q -= np.eye(3) * (np.trace(q, axis1=1, axis2=2) / 3.0)[:, None, None]
    return _True(0.01 * chance.standard_normal(count), k, q)


def _curve(angle_rad: FloatArray, count: int, chance: np.random.Generator) -> FloatArray:
    """(K, m) errors of the table: three harmonics as large as the certificate allows beside the teeth."""
    turn = np.linspace(0.0, 2.0 * pi, 361)
    weights, phases = chance.standard_normal((3, count)), chance.uniform(0.0, 2.0 * pi, (3, count))
    waves = lambda angle: sum(  # noqa: E731
        weights[place] * np.sin((place + 1) * angle[:, None] + phases[place]) for place in range(3)
    )
    scale = (LIMIT_ARCSEC - TEETH_ARCSEC) / np.abs(waves(turn)).max(axis=0)
    _, tooth = np.unique(np.round(np.mod(np.rad2deg(angle_rad), 360.0), 3), return_inverse=True)
    teeth = chance.uniform(-TEETH_ARCSEC, TEETH_ARCSEC, (tooth.max() + 1, count))[tooth]
    return np.asarray((scale * waves(angle_rad) + teeth) * ARCSEC + angle_rad[:, None])


def _outputs(
    run: Measured, pitch_rad: FloatArray, roll_rad: FloatArray, true: _True, chance: np.random.Generator
) -> FloatArray:
    """(N, m) volts."""
    count, n = pitch_rad.shape[1], run.plan.replications
    volt = ARCSEC * V_PER_G
    fixed = true.volts(_force(pitch_rad, roll_rad))
    fixed += LACK_OF_FIT_ARCSEC * volt * chance.standard_normal(fixed.shape)
    middle = np.arange(n) - (n - 1) / 2.0
    drift = DRIFT_ARCSEC * volt * chance.standard_normal(count) * middle[:, None]
    reading_v = NOISE_V / sqrt((run.plan.dwell.nplc or OWN_NPLC) / OWN_NPLC)
    noise = reading_v / sqrt(run.plan.dwell.samples) * chance.standard_normal((n, *fixed.shape))
    return np.asarray((fixed + drift[:, None, :] + noise).reshape(-1, count))


def _force(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    level = np.cos(pitch_rad)
    return np.stack([np.sin(pitch_rad), -level * np.sin(roll_rad), -level * np.cos(roll_rad)], axis=-1)


def _held(
    solved: dict[str, SolvedColumns],
    true: dict[str, _True],
    row: int,
    at: Attitude,
    chance: np.random.Generator,
    squares: list[float],
) -> tuple[float, float, float, float]:
    """Return whether the intervals of one campaign hold the truth; NaN for an angle that is not told."""
    reading_v = DWELL_ARCSEC * ARCSEC * V_PER_G
    known = [KnownAxis(one.problem.models[row], one.primary[row], reading_v) for one in solved.values()]
    package = package_covariance(
        [SolvedAxis(axis, one.problem.model.primary_names, one.components, row) for axis, one in solved.items()]
    )
    angles = inferred(known, at)
    assert angles is not None
    half = angles.half_widths_rad(package.components)[0]
    force = _force(at.pitch_rad, at.roll_rad)[:, None, :]
    off_v = []
    for axis, one in known_by_axis(solved, known).items():
        mine = true[axis]
        alone = _True(mine.offset_v[[row]], mine.k_v_per_g[[row]], mine.q_v_per_g2[[row]])
        read = alone.volts(force)[0, 0] + reading_v * chance.standard_normal()
        off_v.append(read - float(one.model.predict(one.primary, at)[0]))
    off = angles.estimator[0] @ np.array(off_v)
    told = [float(abs(off[place]) <= half[place]) if angles.is_told[0, place] else float("nan") for place in range(2)]
    if angles.is_told[0, 0]:
        squares.append((half[0] / ARCSEC) ** 2)
    return (*_parameters_held(solved, true, row), told[0], told[1])


def known_by_axis(solved: dict[str, SolvedColumns], known: list[KnownAxis]) -> dict[str, KnownAxis]:
    """Return the axes by name."""
    return dict(zip(solved, known, strict=True))


def _parameters_held(solved: dict[str, SolvedColumns], true: dict[str, _True], row: int) -> tuple[float, float]:
    """Shares over the axes: the offset without trace, and the sensitivities of the model as it is written."""
    offset, k = [], []
    for axis, one in solved.items():
        model, mine = one.problem.models[row], true[axis]
        best = np.linalg.lstsq(
            model.basis(one.problem.block),
            _True(mine.offset_v[[row]], mine.k_v_per_g[[row]], mine.q_v_per_g2[[row]]).volts(
                _force(one.problem.block.pitch_rad, one.problem.block.roll_rad)[:, None, :]
            )[:, 0],
            rcond=None,
        )[0]
        spread = np.sqrt(np.diag(one.primary_covariance[row])) * t_quantile(0.95, one.primary_dof[row])
        inside = np.abs(one.primary[row] - best) <= spread
        offset.append(inside[0])
        k += inside[1:4].tolist()
    return float(np.mean(offset)), float(np.mean(k))
