"""What a calibration needs in hours: the reports' 481 × 6 beside the planner's choices, written as Markdown.

    python docs/studies/hours.py OUTPUT_FILE [CAMPAIGNS]

Every line is a run of the engine on twins in virtual time, solved as a user's run is; the choices are `calrig plan`'s.
Coverage is of simulated campaigns with the same design, drawn anew in everything that the laboratory has
(:mod:`hours_laboratory`), at attitudes all over the usage range. Some minutes.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hours_laboratory import DWELL_ARCSEC, READING_ARCSEC, USAGE_PITCH_DEG, Measured, coverage, measured, rig_text
from threadpoolctl import threadpool_limits

from procedures.check.candidate import Asked, Candidate, Space, Target
from procedures.check.candidate_file import chosen_procedure
from procedures.check.candidates import compare
from procedures.solution.expected import Usage
from rig.description.read import read_rig

CAMPAIGNS = 4000
SEED = 15
BASELINE = """[procedure]
title = "481 points, 6 replications, 20 readings"
kind = "grid"
replications = 6
[design]
kind = "D"
pitch_deg = { from = -90.0, to = 90.0, step = 5.0 }
roll_deg = { from = -180.0, to = 180.0, step = 30.0 }
usage_pitch_deg = [-60.0, 60.0]
"""
ORDERS = Space(orders=("there-and-back", "neighbours"))


def lines(folder: Path) -> Iterator[Measured]:
    """Measure the baseline, then what the planner chooses; the targets are fractions of the baseline's hours."""
    baseline = measured("481 × 6 × 20, as the reports", 1, BASELINE, folder / "baseline")
    yield baseline
    third_h, eleventh_h = baseline.hours / 3.0, 8.0 * baseline.hours / 11.0
    yield _planned("a third of the hours", 1, Target(hours=third_h), folder / "third")
    yield _planned("a sixth", 1, Target(hours=baseline.hours / 6.0), folder / "sixth")
    yield _planned("eight packages, an eleventh each", 8, Target(hours=eleventh_h), folder / "eight")


def _planned(name: str, packages: int, target: Target, folder: Path) -> Measured:
    folder.mkdir()
    rig_file = folder / "asked.toml"
    rig_file.write_text(rig_text(packages, 1), encoding="utf-8")
    asked = Asked(read_rig(rig_file), target, Usage(USAGE_PITCH_DEG), space=ORDERS)
    comparison = compare(asked)
    chosen = comparison.candidates[comparison.chosen]
    run = measured(_words(name, chosen), packages, chosen_procedure(comparison), folder / "run")
    return replace(run, foreseen_h=chosen.hours, foreseen_arcsec=3600.0 * chosen.half_width_deg, chosen=chosen)


def _words(name: str, chosen: Candidate) -> str:
    reading = f"{chosen.samples}" if chosen.nplc is None else f"{chosen.samples} at NPLC {chosen.nplc:g}"
    return f"{name}: {chosen.points} × {chosen.replications} × {reading}, {chosen.order}"


HEAD = """# Hours: what the reports' calibration takes, and what is enough

Made by `python docs/studies/hours.py docs/studies/hours.md`. Each line is a run of the engine on twins in virtual time
and its solution; the choices are those of `calrig plan --hours`, at a third, a sixth and, for eight packages, an
eleventh each of the hours that the baseline took. **The laboratory**: a table whose certificate says 1″, truly a smooth
curve with teeth of 0.1″; a soft mount of 1″ in each package; an offset that drifts by 0.05″ a replication, however
short it is; a level of 0.2″; 20 µV (1.65″) a reading, NPLC 10; one meter with a scanner. **U95** is the rms of the
95 % half-width of one future angle over pitch ±60° and every roll, of pitch, the worse angle, in arc seconds; *of it
calibration* is what stays with readings that do not scatter. The reading at use is as declared: by default one dwell of
twenty readings ({dwell:.2f}″), beside it one single reading ({reading:.2f}″).

{columns}
|---|---|---|---|---|---|---|---|---|---|---|
"""
COLUMNS = (
    "run",
    "hours",
    "hours a package",
    "U95, read by a dwell",
    "ratio",
    "of it calibration",
    "U95, read once",
    "of it calibration",
    "± offset, µV",
    "± sensitivity, µV/g",
    "verdict",
)
COVERAGE = """
## Whether the intervals hold

{campaigns} simulated campaigns of each design, solved by the same solver, the level apart; table, mount, drift, lack of
fit (0.1″ a point) and noise drawn anew, the table's curve as large as its certificate allows. Shares of 95 % intervals
that hold the truth; the angle is read by one dwell, at one attitude of the usage range in each campaign.

| run | offset | sensitivities | pitch at use | roll at use | half-width of pitch at use, ″ |
|---|---|---|---|---|---|
"""
LOST = """
## What is lost

From which size on lack of fit (″ a point) and a drift of the offset (″ between replications) are found in half of the
runs, and what the intervals rest on.

| run | lack of fit | drift | degrees of freedom between replications | attitudes | readings of a dwell |
|---|---|---|---|---|---|
"""


def page(runs: list[Measured], campaigns: int) -> Iterator[str]:
    """The page, piece by piece."""
    base = runs[0]
    yield HEAD.format(dwell=DWELL_ARCSEC, reading=READING_ARCSEC, columns=f"| {' | '.join(COLUMNS)} |")
    for run in runs:
        cells = (
            run.name,
            f"{run.hours:.1f}",
            f"{run.hours / run.packages:.2f}",
            f"{run.u95_arcsec:.2f}″",
            f"{run.u95_arcsec / base.u95_arcsec:.2f}",
            f"{run.calibration_arcsec:.2f}″",
            f"{run.single_arcsec:.2f}″",
            f"{run.single_calibration_arcsec:.2f}″",
            f"{run.offset_uv:.2f}",
            f"{run.sensitivity_uv_per_g:.2f}",
            run.verdict,
        )
        yield f"| {' | '.join(cells)} |\n"
    yield "\n*usable*: the drift and the soft mount are there, and each of these runs names them.\n"
    yield COVERAGE.format(campaigns=campaigns)
    for run in runs:
        found = coverage(run, campaigns, np.random.default_rng(SEED))
        shares = " | ".join(f"{100.0 * share:.1f} %" for share in found.shares)
        yield f"| {run.name} | {shares} | {found.half_width_arcsec:.2f} |\n"
    yield LOST
    for run in runs:
        yield (
            f"| {run.name} | {run.sees_lack_of_fit_arcsec:.2f} | {run.sees_drift_arcsec:.3f} | "
            f"{run.plan.replications - 1} | {len(run.plan.design.points)} | {run.plan.dwell.samples} |\n"
        )
    yield from _verdict(runs)


def _verdict(runs: list[Measured]) -> Iterator[str]:
    base = runs[0]
    yield "\n## Against the target\n\n"
    for run in runs[1:]:
        allowed_h = base.hours / 3.0 if run.packages == 1 else 8.0 * base.hours / 11.0
        yield (
            f"- {run.name}: {run.hours:.1f} h of {allowed_h:.1f} h allowed, foreseen {run.foreseen_h:.1f} h; U95 "
            f"{run.u95_arcsec / base.u95_arcsec:.2f} × the baseline's, at most 1.10 asked for, foreseen "
            f"{run.foreseen_arcsec / base.u95_arcsec:.2f} ×; its calibration part "
            f"{run.calibration_arcsec / run.u95_arcsec:.0%} of it, "
            f"at most 50 % asked for, where one dwell is read at use, and "
            f"{run.single_calibration_arcsec / run.single_arcsec:.0%} where one reading is.\n"
        )
    yield (
        "\nThe twin's meter scatters alike at any integration; the planner and the campaigns reckon with √10 times as "
        "much at NPLC 1, so what is\nforeseen is what a real meter would give there.\n"
    )
    yield (
        f"\nRead by a dwell, the calibration part is {base.calibration_arcsec / base.u95_arcsec:.0%} of U95 in the "
        "baseline itself: it is the table's, of which the certificate says a\nlimit and no shape, and no hours make it "
        "smaller. Read once, it is less than half. What makes it smaller is a table whose errors are listed "
        "(`index_table`).\n"
    )


def main(output: Path, campaigns: int) -> None:
    """Write the page."""
    with threadpool_limits(limits=1, user_api="blas"), TemporaryDirectory() as scratch:
        runs = list(lines(Path(scratch)))
        output.write_text("".join(page(runs, campaigns)), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else CAMPAIGNS)
