"""Everything that the study computes, once: campaigns, solutions, table 2 from the twin, the extended model."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tp_study.campaigns import campaigns, reduced_designs, taken_out
from tp_study.judged import (
    Inferred,
    Statistics,
    elsewhere,
    inferred_attitude,
    inferred_pitch,
    share_inside,
    solve,
    statistics,
)
from tp_study.laboratory import VOLTS, Campaign, from_world, prepare, through_engine
from tp_study.soft_mount import accepted

from ams.calibration_result import AxisCalibration, Calibration
from ams.observations import Observations
from ams.solve.extension import Extension, judge_extension

THROUGH_ENGINE = ("22", "24", "26", "44")
"""Campaigns that are whole runs on twins in memory, journal included; the others are read from the twins' world."""


@dataclass(frozen=True)
class Setting:
    """How much is computed."""

    replications: int | None = None
    """None: as many as TP."""
    through_engine: tuple[str, ...] = THROUGH_ENGINE
    test_runs: int = 2000
    blind_runs: int = 200
    """F-tests on tables of ±1″ without a soft mount: with the table's uncertainty known, and without."""
    repeats: int = 20
    """Of figure 47 with other seeds, for what a tumble taken out of it may find."""


FULL = Setting()
REDUCED = Setting(replications=2, through_engine=("26",), test_runs=20, blind_runs=5, repeats=2)


@dataclass(frozen=True)
class Solved:
    """One sensor's rows and solution."""

    observations: Observations
    axes: Mapping[str, AxisCalibration]
    whole: Calibration | None = None
    """With what the axes have in common; None where a solution is held against other rows."""

    @property
    def x(self) -> AxisCalibration:
        return self.axes["x"]


@dataclass(frozen=True)
class Tumbled:
    """The tumble of one axis in every repeat."""

    t_bias: tuple[float, ...]
    t_s: tuple[float, ...]
    inside: tuple[float, ...]
    """Share of the full data inside the tumble's prediction interval."""


@dataclass(frozen=True)
class Evidence:
    """What the pictures and the page are made from."""

    setting: Setting
    truths: Mapping[str, Campaign]
    solved: Mapping[str, Solved]
    """By figure: 22, 24, 26, 28(a), 28(b), 34, 35, 37, 37 extended, 42, 44, 47, 50, 53."""
    held: Mapping[str, Solved]
    """Reduced solutions against the full data: figures 36, 52, 54."""
    held_sigma_e: Mapping[str, float]
    """1e-4 degrees, keyed ``36``, ``52 x`` …"""
    pitch: Mapping[str, Inferred]
    roll: Mapping[str, Inferred]
    table_2: Mapping[str, Statistics]
    engine_against_world_v: float
    """Largest difference of a dwell between the run of figure 22 (or 26) and the world."""
    coarse_22: Statistics
    """Figure 22 on a table of ±1″."""
    tumbles: Mapping[str, Tumbled]
    extension: Extension
    false_alarms: tuple[int, int]
    """Of ``test_runs`` and of ``blind_runs``."""


def gather(setting: Setting, folder: Path) -> Evidence:
    made = {name: _resized(campaign, setting) for name, campaign in campaigns().items()}
    benches = {name: prepare(campaign, folder) for name, campaign in made.items()}
    rows = {
        name: through_engine(bench, folder) if name in setting.through_engine else from_world(bench)
        for name, bench in benches.items()
    }
    solved = _solve_all(rows, made)
    held, held_sigma = _hold(solved)
    pitch, roll = _infer(solved, made)
    proof = setting.through_engine[0]
    read = from_world(benches[proof])["S0"].outputs["x"]
    coarse = prepare(replace(made["22"], name="22-coarse", teeth_arcsec=1.0), folder)
    return Evidence(
        setting=setting,
        truths=made,
        solved=solved,
        held=held,
        held_sigma_e=held_sigma,
        pitch=pitch,
        roll=roll,
        table_2=_table_2(solved),
        engine_against_world_v=float(np.max(np.abs(rows[proof]["S0"].outputs["x"] - read))),
        coarse_22=statistics(solve(from_world(coarse)["S0"], with_roll=False).axes["x"]),
        tumbles=_tumbles(made["47"], setting.repeats, folder),
        extension=judge_extension(rows["37"]["S1"], "x"),
        false_alarms=(
            accepted(setting.test_runs, 1.0, seed=37),
            accepted(setting.blind_runs, 1.0, seed=37, knows_table=False),
        ),
    )


def _resized(campaign: Campaign, setting: Setting) -> Campaign:
    return campaign if setting.replications is None else replace(campaign, replications=setting.replications)


def _solve_all(rows: Mapping[str, Mapping[str, Observations]], made: Mapping[str, Campaign]) -> dict[str, Solved]:
    solved = {name: _solved(rows[name]["S0"], solve(rows[name]["S0"], with_roll=False)) for name in ("22", "24", "26")}
    warm = (made["28"].temperature or {})["S1"]
    narrow, second, wide = rows["28"]["S1"], rows["28"]["S2"], rows["37"]
    solved["28(a)"] = _solved(narrow, solve(narrow))
    solved["28(b)"] = _solved(narrow, solve(narrow, temperature=warm))
    solved["34"] = _solved(second, solve(second))
    solved["37"] = _solved(wide["S1"], solve(wide["S1"]))
    solved["37 extended"] = _solved(wide["S1"], solve(wide["S1"], extended="yes"))
    solved["42"] = _solved(wide["S2"], solve(wide["S2"]))
    for name in ("44", "47"):
        solved[name] = _solved(rows[name]["P"], solve(rows[name]["P"]))
    designs = reduced_designs()
    part = taken_out(narrow, designs["35"])
    solved["35"] = _solved(part, solve(part, temperature=warm))
    for name in ("50", "53"):
        part = taken_out(solved["47"].observations, designs[name])
        solved[name] = _solved(part, solve(part))
    return solved


def _solved(rows: Observations, found: Calibration) -> Solved:
    return Solved(rows, found.axes, found)


def _hold(solved: Mapping[str, Solved]) -> tuple[dict[str, Solved], dict[str, float]]:
    held: dict[str, Solved] = {}
    sigma: dict[str, float] = {}
    for name, reduced, full in (("36", "35", "28(b)"), ("52", "50", "47"), ("54", "53", "47")):
        everything = solved[full].observations
        moved = {label: elsewhere(axis, everything) for label, axis in solved[reduced].axes.items()}
        held[name] = Solved(everything, {label: axis for label, (axis, _) in moved.items()})
        sigma |= {name if len(moved) == 1 else f"{name} {label}": value for label, (_, value) in moved.items()}
    return held, sigma


def _infer(
    solved: Mapping[str, Solved], made: Mapping[str, Campaign]
) -> tuple[dict[str, Inferred], dict[str, Inferred]]:
    warm = (made["28"].temperature or {})["S1"]
    pitch = {
        name: inferred_pitch(solved[name].x, solved[name].observations, warm if name == "28(b)" else None)
        for name in ("22", "24", "26", "28(b)", "37", "42")
    }
    roll = {}
    for name in ("44", "47", "50"):
        whole = solved[name].whole
        assert whole is not None
        pitch[name], roll[name] = inferred_attitude(whole, solved[name].observations)
    return pitch, roll


def _table_2(solved: Mapping[str, Solved]) -> dict[str, Statistics]:
    single = ("22", "24", "26", "28(a)", "28(b)", "34", "35", "37", "42")
    found = {name: statistics(solved[name].x) for name in single}
    for name in ("44", "47"):
        found |= {
            f"{name}({letter})": statistics(solved[name].axes[axis]) for axis, letter in zip("xyz", "abc", strict=True)
        }
    for name in ("50", "53"):
        found |= {f"{name} {axis}": statistics(solved[name].axes[axis]) for axis in "xyz"}
    return found


def _tumbles(campaign: Campaign, repeats: int, folder: Path) -> dict[str, Tumbled]:
    found: dict[str, list[tuple[float, float, float]]] = {label: [] for label in "xyz"}
    for seed in range(1, repeats + 1):
        full = from_world(prepare(replace(campaign, name=f"47-seed-{seed}", seed=seed), folder))["P"]
        for label, axis in solve(taken_out(full, reduced_designs()["50"])).axes.items():
            judged = statistics(axis)
            found[label].append((judged.t_bias, judged.t_s, share_inside(elsewhere(axis, full)[0], full)))
    return {label: Tumbled(*zip(*rows, strict=True)) for label, rows in found.items()}


def rms(values: object) -> float:
    """Root mean square of what is a number."""
    array = np.asarray(values, dtype=float)
    return float(np.sqrt(np.nanmean(array**2)))


def extended_sigma_e(evidence: Evidence) -> tuple[float, float]:
    """Standard error of figure 37 without and with the extended model, 1e-4 degrees."""
    before, after = (evidence.solved[name].x.standard_error_v / VOLTS for name in ("37", "37 extended"))
    return before, after
