"""The laboratory of the study of hours: one package or eight on a table whose errors are smooth, everything on twins.

What is there to be found: a table within its certificate's limit of one arc second but smooth, with teeth of a tenth;
a soft mount of one arc second in every package; an offset that drifts by a twentieth of an arc second a replication,
however short the replication is; readings of 20 µV (1.65 arc seconds). Its certificate states the limit alone, or lists
the errors at every fifth degree as well, each within two tenths of an arc second.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from math import pi, radians, sin, sqrt
from pathlib import Path

import numpy as np

from ams.analysis.angle_uncertainty import AngleUncertainty, KnownAxis, UsageBox, angle_uncertainties
from ams.arrays import FloatArray
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.extended import TERM_NAMES, ExtendedPitchRoll
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
READOUT_NPLC = 10.0
"""Of the meter; a shorter integration scatters more by its square root, in the campaigns and not in the twin."""
LISTED_EVERY_DEG = 5
LIST_LIMIT_ARCSEC = 0.2

_AXIS = """[axes.{name}]
driver = "indexing-table"
port = "twin"
increment_deg = 1.0
limits_deg = [-180.0, 180.0]
speed_dps = 5.0
uncertainty_arcsec = {limit}
axis = {number}
{listed}
[twin.axes.{name}]
index_harmonics = {harmonics}
index_list = {teeth}
"""

_LEVEL = """[level]
instrument = "electronic level"
uncertainty_arcsec = 0.2
before = { about_pitch_arcsec = 0.0, about_roll_arcsec = 0.0 }
after = { about_pitch_arcsec = 0.0, about_roll_arcsec = 0.0 }"""


def rig_file(folder: Path, packages: int, seed: int, *, is_listed: bool) -> Path:
    """Write the rig file, and beside it what the certificate lists; return its path."""
    serials = [f"SN{number:02d}" for number in range(1, packages + 1)]
    lines = ['[rig]\nname = "laboratory of the study of hours"\ngravity_mps2 = 9.79826', _LEVEL]
    for number, name in enumerate(HARMONICS, start=1):
        lines.append(
            _AXIS.format(
                name=name,
                number=number,
                limit=LIMIT_ARCSEC,
                listed=f'index_table = "{name}.csv"' if is_listed else "",
                harmonics=[list(wave) for wave in HARMONICS[name]],
                teeth=[[float(angle), error] for angle, error in _teeth(name).items()],
            )
        )
        if is_listed:
            (folder / f"{name}.csv").write_text(_certificate(name), encoding="utf-8")
    channels = [f"{serial.lower()}{axis}" for serial in serials for axis in "xyz"]
    scanned = ", ".join(
        f"{name} = {{ scanner = {100 * (1 + index // 10) + index % 10}, range_v = 10.0 }}"
        for index, name in enumerate(channels)
    )
    lines.append(f'[readouts.dmm]\ndriver = "hp3458a"\nresource = "twin"\nnplc = 10\nchannels = {{ {scanned} }}')
    lines.append(f'[twin]\nseed = {seed}\ntime = "virtual"')
    for index, serial in enumerate(serials):
        wired = ", ".join(f'{axis} = "dmm.{serial.lower()}{axis}"' for axis in "xyz")
        lines.append(
            f'[sensors.{serial}]\nmodel = "three-axis package"\nchannels = {{ {wired} }}\n'
            f"nominal_sensitivity_v_per_g = {V_PER_G}"
        )
        lines += [_truth_text(serial, axis, index) for axis in "xyz"]
    path = folder / "rig.toml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _teeth(name: str) -> dict[int, float]:
    """Return what each tooth of an axis is off by beside its curve, arc seconds; degrees to error."""
    chance = np.random.default_rng([1, tuple(HARMONICS).index(name)])
    errors = chance.uniform(-TEETH_ARCSEC, TEETH_ARCSEC, 360).round(4).tolist()
    return dict(zip(range(-180, 180), errors, strict=True))


def _certificate(name: str) -> str:
    """Return the list of an axis: what it is off by, wrong by what the list's own limit allows."""
    angles, teeth = range(-180, 180, LISTED_EVERY_DEG), _teeth(name)
    chance = np.random.default_rng([2, tuple(HARMONICS).index(name)])
    wrong = curves(np.deg2rad(np.array(angles)), 1, chance, LIST_LIMIT_ARCSEC)[:, 0] / ARCSEC
    rows = ["angle_deg,error_arcsec,uncertainty_arcsec"]
    for angle, off in zip(angles, wrong, strict=True):
        waves = sum(size * sin(radians(times * angle + phase)) for times, size, phase in HARMONICS[name])
        rows.append(f"{angle},{waves + teeth[angle] + off:.3f},{LIST_LIMIT_ARCSEC}")
    return "\n".join(rows) + "\n"


def curves(angle_rad: FloatArray, count: int, chance: np.random.Generator, limit_arcsec: float) -> FloatArray:
    """Return (K, m) errors that reach a limit: three harmonics, and a tenth of it from tooth to tooth; radians."""
    turn = np.linspace(0.0, 2.0 * pi, 361)
    weights, phases = chance.standard_normal((3, count)), chance.uniform(0.0, 2.0 * pi, (3, count))
    waves = lambda angle: sum(  # noqa: E731
        weights[index] * np.sin((index + 1) * angle[:, None] + phases[index]) for index in range(3)
    )
    scale = 0.9 * limit_arcsec / np.abs(waves(turn)).max(axis=0)
    _, tooth = np.unique(np.round(np.mod(np.rad2deg(angle_rad), 360.0), 3), return_inverse=True)
    teeth = chance.uniform(-0.1 * limit_arcsec, 0.1 * limit_arcsec, (tooth.max() + 1, count))[tooth]
    return np.asarray((scale * waves(angle_rad) + teeth) * ARCSEC)


def _truth_text(serial: str, axis: str, index: int) -> str:
    soft = [SOFT_ARCSEC * ARCSEC * V_PER_G * part for part in (0.6, -0.4, 0.5, 0.3, -0.5)]
    return (
        f"[twin.truth.{serial}.{axis}]\noffset_v = {0.005 + 0.001 * index}\nsensitivity_v_per_g = {V_PER_G}\n"
        f"coning_deg = 0.4\nazimuth_deg = {35.0 + 10.0 * index}\nnoise_v = {NOISE_V}\n"
        f"offset_drift_v_per_replication = {DRIFT_ARCSEC * ARCSEC * V_PER_G!r}\nq_v_per_g2 = {soft!r}"
    )


@dataclass(frozen=True)
class Measured:
    """A run of the engine and its solution: the worst sensor, its worst axis."""

    name: str
    packages: int
    is_listed: bool
    """Whether the certificate lists the table's errors."""
    plan: Plan
    table: TableUncertainty
    hours: float
    dwell: Mapping[str, AngleUncertainty]
    """Of pitch and roll, read at use by one dwell of twenty readings."""
    once: Mapping[str, AngleUncertainty]
    """The same, read at use once."""
    offset_uv: float
    """95 % half-width."""
    sensitivity_uv_per_g: float
    verdict: str
    sees_lack_of_fit_arcsec: float
    sees_drift_arcsec: float
    foreseen_h: float = 0.0
    foreseen_arcsec: float = 0.0
    chosen: Candidate | None = None

    @property
    def angle(self) -> str:
        """Return the worse angle, read by a dwell."""
        return max(self.dwell, key=lambda name: self.dwell[name].u95_rad)

    @property
    def u95_arcsec(self) -> float:
        """Return U95 of the worse angle, read by a dwell."""
        return self.dwell[self.angle].u95_rad / ARCSEC

    @property
    def once_arcsec(self) -> float:
        """Return U95 of the worse angle, read once."""
        return max(angle.u95_rad for angle in self.once.values()) / ARCSEC


def measured(name: str, packages: int, procedure: str, folder: Path, *, is_listed: bool = False) -> Measured:
    """Run a procedure on the twins and solve it."""
    folder.mkdir()
    procedure_file, run = folder / "procedure.toml", folder / "run"
    described = rig_file(folder, packages, 3, is_listed=is_listed)
    procedure_file.write_text(procedure, encoding="utf-8")
    rig = read_rig(described)
    plan = make_plan(rig, read_procedure(procedure_file))
    run.mkdir()
    header = make_header("run", plan, rig, described, procedure_file, "study", datetime.now(UTC))
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
                    ExtendedPitchRoll(axis.nominal_axis, axis.centring),
                    axis.primary,
                    reading_arcsec * ARCSEC * V_PER_G,
                    TERM_NAMES,
                )
                for axis in calibration.axes.values()
            ]
            low, high = np.deg2rad(USAGE_PITCH_DEG)
            foreseen = angle_uncertainties(known, calibration.package.components, UsageBox((low, high)))
            pair.append(foreseen)
        angles.append(pair)
        for axis in calibration.axes.values():
            for item in axis.parameters:
                if item.name in halves and item.interval_95 is not None:
                    half = 0.5 * (item.interval_95[1] - item.interval_95[0])
                    halves[item.name] = max(halves[item.name], half)
    dwell, once = max(angles, key=lambda pair: max(angle.u95_rad for angle in pair[0].values()))
    belief = next(iter(beliefs_of(rig, plan.solve, 20, plan.replications, plan.sensors).values()))
    belief = belief.integrated((plan.dwell.nplc or READOUT_NPLC) / READOUT_NPLC)
    points, samples, n = len(plan.design.points), plan.dwell.samples, plan.replications
    table = table_uncertainty(rig)
    assert table is not None
    verdicts = {document["verdict"] for document in sensors_document(solved).values()}
    return Measured(
        name=name,
        packages=packages,
        is_listed=is_listed,
        plan=plan,
        table=table,
        hours=hours,
        dwell=dwell,
        once=once,
        offset_uv=1e6 * halves["offset_v"],
        sensitivity_uv_per_g=1e6 * halves["sensitivity_v_per_g"],
        verdict=", ".join(sorted(verdicts)),
        sees_lack_of_fit_arcsec=sees_lack_of_fit_arcsec(belief, samples, points, n, 4 + len(TERM_NAMES)),
        sees_drift_arcsec=sees_drift_arcsec(belief, samples, points, n),
    )
