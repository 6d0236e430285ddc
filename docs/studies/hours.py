"""What a calibration needs in hours: the reports' 481 × 6 beside the planner's choices, written as Markdown.

    python docs/studies/hours.py OUTPUT_FILE [CAMPAIGNS]

Every line is a run of the engine on twins in virtual time, solved as a user's run is; the choices are `calrig plan`'s.
Coverage is of simulated campaigns with the same design, drawn anew in everything that the laboratory has
(:mod:`hours_coverage`), at attitudes all over the usage range. Some minutes.
"""

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import copysign, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hours_coverage import coverage
from hours_laboratory import (
    ARCSEC,
    DWELL_ARCSEC,
    LIMIT_ARCSEC,
    READING_ARCSEC,
    USAGE_PITCH_DEG,
    Measured,
    measured,
    rig_file,
)
from hours_two_mountings import REVERSED_TOO, ROLLED_TOO
from hours_two_mountings import lowered as two_mountings
from threadpoolctl import threadpool_limits

from ams.analysis.angle_uncertainty import ADDED, AngleUncertainty
from procedures.check.candidate import Candidate, SearchRange, SearchRequest, Target
from procedures.check.candidate_file import chosen_procedure
from procedures.check.candidates import compare
from procedures.check.check_report import check
from procedures.kinds.read import read_procedure
from procedures.solution.expected import PARTS, Usage
from rig.description.read import read_rig

CAMPAIGNS = 4000
SEED = 15
MOST_RATIO, HALF = 1.1, 0.5
"""What is asked for of U95, and of its calibration part."""
SIXTH = "a sixth"
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
ORDERS = SearchRange(orders=("there-and-back", "neighbours"))


def lines(folder: Path) -> Iterator[Measured]:
    """Measure the baseline, then what the planner chooses; the targets are fractions of the baseline's hours.

    First on the table whose certificate states a limit, then on the same table where it lists the errors too.
    """
    for is_listed in (False, True):
        parent = folder / ("listed" if is_listed else "limit")
        parent.mkdir()
        baseline = measured("481 × 6 × 20, as the reports", 1, BASELINE, parent / "baseline", is_listed=is_listed)
        yield baseline
        third_h, eleventh_h = baseline.hours / 3.0, 8.0 * baseline.hours / 11.0
        yield _planned("a third of the hours", 1, third_h, parent / "third", is_listed)
        if not is_listed:
            yield _planned(SIXTH, 1, baseline.hours / 6.0, parent / "sixth", is_listed)
        yield _planned("eight packages, an eleventh each", 8, eleventh_h, parent / "eight", is_listed)


def _planned(name: str, packages: int, hours: float, folder: Path, is_listed: bool) -> Measured:
    folder.mkdir()
    request = SearchRequest(
        read_rig(rig_file(folder, packages, 1, is_listed=is_listed)),
        Target(hours=hours),
        Usage(USAGE_PITCH_DEG),
        space=ORDERS,
    )
    comparison = compare(request)
    chosen = comparison.candidates[comparison.chosen]
    procedure = chosen_procedure(comparison)
    run = measured(_words(name, chosen), packages, procedure, folder / "run", is_listed=is_listed)
    return replace(run, foreseen_h=chosen.hours, foreseen_arcsec=3600.0 * chosen.half_width_deg, chosen=chosen)


def _words(name: str, chosen: Candidate) -> str:
    reading = f"{chosen.samples}" if chosen.nplc is None else f"{chosen.samples} at NPLC {chosen.nplc:g}"
    return f"{name}: {chosen.points} × {chosen.replications} × {reading}, {chosen.order}"


HEAD = """# Hours: what the reports' calibration takes, and what is enough

{short}
Parts are those of the angle where they are larger; the baseline's is what its own hours leave.

Made by `python docs/studies/hours.py docs/studies/hours.md`. Each line is a run of the engine on twins in virtual time
and its solution; the choices are those of `calrig plan --hours`, at a third, a sixth and, for eight packages, an
eleventh each of the hours that the baseline took. **The laboratory**: a table whose certificate says 1″, truly a smooth
curve with teeth of 0.1″; a soft mount of 1″ in each package; an offset that drifts by 0.05″ a replication, however
short it is; a level of 0.2″; 20 µV (1.65″) a reading, NPLC 10; one meter with a scanner. **U95** is the rms of the
95 % half-width of one future angle over pitch ±60° and every roll, of the worse of pitch and roll; *of it
calibration* is the part that stays with readings that do not scatter, of pitch and of roll. The reading at use is as
declared: by default one dwell of twenty readings ({dwell:.2f}″), beside it one single reading ({reading:.2f}″).
"""
CERTIFICATES = {
    False: "The certificate states a limit: 1″, of no shape",
    True: "The certificate lists the errors at every fifth degree as well, each within 0.2″ (`index_table`)",
}
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
SOURCES = ("low-order terms", "table", "level", "noise and drift", "lack of fit", "reading at use")
MADE_OF = """
## What U95 is made of

Arc seconds, of the worse angle, read by a dwell; squares add up. *Low-order terms*: what the terms of second and third
order add, since a table that is off once or twice a turn and a sensor that bends look alike, and neither is believed to
be absent.

"""
LOWERED = """
## What would lower the calibration's part

Where the certificate states a limit and no shape, a table that is off once a turn and a sensor that bends look alike in
every attitude, and in whichever order they are visited: the calibration hands the table's own uncertainty on, and
neither hours nor readings make it smaller. What `calrig check` foresees for the reports' replications and readings at
{points} attitudes, read at use by a dwell of twenty: U95 and of it the calibration, pitch and roll.

| the laboratory | U95 of pitch | calibration | U95 of roll | calibration |
|---|---|---|---|---|
"""
LOWERED_ENDS = """
Over the top, pitch from −180° to 180°, the table reaches each attitude at two of its angles: that parts its second
harmonic from the sensor, and not its first. **Two mountings part the first**: the package is measured as it is, then
turned half round about the vertical axis of its seat, and both calibrations are solved together (`calrig fit --joint
--mount COLUMN`). In package axes the errors p cos α of pitch and p cos R of roll change their sign by that, and the
sensor's terms do not. A turn about the table's roll axis is what rolling does already, and parts nothing of pitch. The
last two lines are {campaigns} simulated campaigns of 13 × 13 attitudes in three replications a mounting, table, level
(0.2″), seat (10″ about each axis), sensors, drift and noise drawn anew; with the reversed mounting 95 % intervals hold
the offset in {offset:.1%} of them, sensitivities in {sensitivities:.1%}, pitch at use in {pitch:.1%} and roll at use in
{roll:.1%}. So the calibration leaves less than half of U95 also where the certificate states a limit alone and a whole
dwell is read at use. A run of the engine has one mounting: these are two runs, and their dwells one file.

The default, 0.9 × the limit spread over teeth, first and second harmonic ([mathematics](../mathematics.md)), is as wide
as a curve that lies in one of them alone needs; for curves of three harmonics at once, as drawn below, it is a little
too wide: pitch at use is held in up to 99 %.
"""
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
    groups = [[run for run in runs if run.is_listed is is_listed] for is_listed in CERTIFICATES]
    short = "".join(_in_short(*groups))
    yield HEAD.format(dwell=DWELL_ARCSEC, reading=READING_ARCSEC, short=short)
    for title, group in zip(CERTIFICATES.values(), groups, strict=True):
        if group:
            yield f"\n## {title}\n\n{_row(COLUMNS)}{_rule(len(COLUMNS))}"
            yield from (_row(_measured_cells(run, group[0])) for run in group)
    yield "\n*usable*: the drift and the soft mount are there, and each of these runs names them.\n"
    yield f"{MADE_OF}{_row(('run', 'angle', *SOURCES))}{_rule(len(SOURCES) + 2)}"
    for run in runs:
        yield _row((_named(run), run.angle, *(f"{_share(run, source):.2f}" for source in SOURCES)))
    yield from lowered(campaigns)
    yield COVERAGE.format(campaigns=campaigns)
    for run in runs:
        found = coverage(run, campaigns, np.random.default_rng(SEED))
        shares = (f"{100.0 * share:.1f} %" for share in found.shares)
        yield _row((_named(run), *shares, f"{found.half_width_arcsec:.2f}"))
    yield LOST
    for run in runs:
        sees = (f"{run.sees_lack_of_fit_arcsec:.2f}", f"{run.sees_drift_arcsec:.3f}")
        counts = (run.plan.replications - 1, len(run.plan.design.points), run.plan.dwell.samples)
        yield _row((_named(run), *sees, *map(str, counts)))
    yield "\n## Against the target\n\n"
    for group in groups:
        yield from (_against(run, group[0]) for run in group[1:])
    yield (
        "\nThe twin's meter scatters alike at any integration; the planner and the campaigns reckon with √10 times as "
        "much at NPLC 1, so what is\nforeseen is what a real meter would give there.\n"
    )


ZERO = "index_zero_deg = 0.0\nindex_zero_uncertainty_arcsec = 0.1"
PITCHES = "{ from = -90.0, to = 90.0, step = 15.0 }"
OVER_THE_TOP = "{ from = -180.0, to = 165.0, step = 15.0 }"
LABORATORIES: Mapping[str, tuple[str, str, str]] = {
    "certificate: a limit of 1″": ("", "", PITCHES),
    "the same, pitch over the whole turn": ("", "", OVER_THE_TOP),
    "the zero of pitch set and declared, ± 0.1″ (`index_zero_deg`)": (ZERO, "", PITCHES),
    "both": (ZERO, "", OVER_THE_TOP),
    'certificate: teeth independent of each other (`index_errors = "independent"`)': (
        'index_errors = "independent"',
        'index_errors = "independent"',
        PITCHES,
    ),
}
"""What is declared of pitch and of roll beside their limit, and the pitch values."""


IN_TWO_MOUNTINGS = {
    "two mountings, the second turned about the vertical of the seat, package and table solved together": REVERSED_TOO,
    "the same, turned about the roll axis instead": ROLLED_TOO,
}
MOST_REMOUNTED = 1000


def lowered(campaigns: int) -> Iterator[str]:
    """Yield what other declarations and attitudes than the baseline's would do, as check foresees it.

    What a second mounting would do is simulated.
    """
    baseline = BASELINE.replace("step = 5.0", "step = 15.0")
    assert PITCHES in baseline
    yield LOWERED.format(points="13 × 13 or 24 × 13")
    for name, (of_pitch, of_roll, pitches) in LABORATORIES.items():
        with TemporaryDirectory() as folder:
            rig_path = rig_file(Path(folder), 1, 1, is_listed=False)
            of_axis = iter((of_pitch, of_roll))
            lines = (
                f"{line}\n{next(of_axis)}" if line == f"uncertainty_arcsec = {LIMIT_ARCSEC}" else line
                for line in rig_path.read_text(encoding="utf-8").splitlines()
            )
            rig_path.write_text("\n".join(lines) + "\n", encoding="utf-8")
            procedure_path = Path(folder) / "procedure.toml"
            procedure_path.write_text(baseline.replace(PITCHES, pitches), encoding="utf-8")
            foreseen = check(read_rig(rig_path), read_procedure(procedure_path)).forecast.angles
        (angles,) = foreseen.values()
        cells = (
            cell
            for angle in (angles["pitch"], angles["roll"])
            for cell in (
                f"{angle.u95_deg * 3600.0:.2f}″",
                f"{angle.calibration_deg / angle.u95_deg:.0%}".replace("%", " %"),
            )
        )
        yield _row((name, *cells))
    remounted, count = {}, min(campaigns, MOST_REMOUNTED)
    for name, turns in IN_TWO_MOUNTINGS.items():
        found = remounted[turns] = two_mountings(turns, count, np.random.default_rng(SEED))
        pairs = zip(found.u95_arcsec, found.calibration, strict=True)
        yield _row((name, *(cell for u95, part in pairs for cell in (f"{u95:.2f}″", f"{100.0 * part:.0f} %"))))
    names = ("offset", "sensitivities", "pitch", "roll")
    shares = dict(zip(names, remounted[REVERSED_TOO].shares, strict=True))
    yield LOWERED_ENDS.format(campaigns=count, **shares).replace("%", " %").replace("  %", " %")


def _row(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |\n"


def _rule(columns: int) -> str:
    return f"|{'---|' * columns}\n"


def _named(run: Measured) -> str:
    return f"{run.name}, listed errors" if run.is_listed else run.name


def _measured_cells(run: Measured, base: Measured) -> tuple[str, ...]:
    return (
        run.name,
        f"{run.hours:.1f}",
        f"{run.hours / run.packages:.2f}",
        f"{run.u95_arcsec:.2f}″",
        f"{run.u95_arcsec / base.u95_arcsec:.2f}",
        ", ".join(_parts(run.dwell)),
        f"{run.once_arcsec:.2f}″",
        ", ".join(_parts(run.once)),
        f"{run.offset_uv:.2f}",
        f"{run.sensitivity_uv_per_g:.2f}",
        run.verdict,
    )


def _parts(angles: Mapping[str, AngleUncertainty]) -> list[str]:
    """Return the calibration's part of U95 of each angle."""
    return [f"{angle.calibration_rad / angle.u95_rad:.0%}".replace("%", " %") for angle in angles.values()]


def _part(angles: Mapping[str, AngleUncertainty]) -> float:
    """Return the larger of them, as a number."""
    return max(angle.calibration_rad / angle.u95_rad for angle in angles.values())


def _share(run: Measured, source: str) -> float:
    """Return what a source takes of U95 by its name on the page."""
    shares = run.dwell[run.angle].shares_rad
    squares = [share * abs(share) for part, share in shares.items() if _source_of(part) == source]
    return copysign(sqrt(abs(sum(squares))), sum(squares)) / ARCSEC


def _source_of(part: str) -> str:
    found = "level" if part.startswith("level of the base") else {ADDED: SOURCES[0], **PARTS}.get(part, part)
    assert found in SOURCES, part
    return found


def _allowed_h(run: Measured, base: Measured) -> float:
    return base.hours / 3.0 if run.packages == 1 else 8.0 * base.hours / 11.0


def _in_short(stated: Sequence[Measured], listed: Sequence[Measured]) -> Iterator[str]:
    """Yield what the page comes to: how long it takes, and under which conditions the calibration's part is half."""
    base = stated[0]
    yield (
        f"The reports' calibration, 481 attitudes × 6 replications × 20 readings, takes {base.hours:.1f} h. **Asked "
        f"for**: U95 of a future angle at most {MOST_RATIO:.2f} × what that gives, and of it at most half left by the "
        "calibration, the rest being the reading at use; in a third of the hours for one package, in an eleventh for "
        "each of eight. Everything that a laboratory has is there: noise, drift, a soft mount in the package, the "
        "table's errors, the level.\n\nHours and U95 hold in all four conditions below. **At most half holds in three "
        "of them: wherever the package is read once at use, and where the table's certificate lists its errors. It "
        "does not hold where the certificate states a limit alone and a whole dwell is read at use**, neither here nor "
        "in the reports' own hours, as long as the package has one mounting; what lowers it there, a second mounting "
        "among it, stands [below](#what-would-lower-the-calibrations-part)."
        f"\n\n{_row(('certificate', 'read at use', 'run', 'hours a package', 'U95, ×', 'of it calibration', 'holds'))}"
        f"{_rule(7)}"
    )
    for certificate, group in (("a limit of 1″", stated), ("lists the errors", listed)):
        for reading in ("once", "by a dwell of twenty"):
            yield from (
                _condition(certificate, reading, run, group[0]) for run in group if not run.name.startswith(SIXTH)
            )


def _condition(certificate: str, reading: str, run: Measured, base: Measured) -> str:
    """Return a row of the first table; the baseline has nothing to hold."""
    is_once = reading == "once"
    ratio = run.once_arcsec / base.once_arcsec if is_once else run.u95_arcsec / base.u95_arcsec
    part = _part(run.once if is_once else run.dwell)
    is_met = ratio <= MOST_RATIO and run.hours <= _allowed_h(run, base) and part <= HALF
    name = run.name.partition(":")[0]
    held = "–" if run is base else "yes" if is_met else "**no**: the part is larger than half"
    cells = (certificate, reading, name, f"{run.hours / run.packages:.1f}", f"{ratio:.2f}", f"{part:.0%}", held)
    return _row(cells).replace("%", " %")


def _against(run: Measured, base: Measured) -> str:
    return (
        f"- {_named(run)}: {run.hours:.1f} h of {_allowed_h(run, base):.1f} h allowed, foreseen {run.foreseen_h:.1f} h;"
        f" U95 {run.u95_arcsec / base.u95_arcsec:.2f} × the baseline's, at most {MOST_RATIO:.2f} asked for, foreseen "
        f"{run.foreseen_arcsec / base.u95_arcsec:.2f} ×; its calibration part {_part(run.dwell):.0%} of it, at most "
        f"{HALF:.0%} asked for, where one dwell is read at use, and {_part(run.once):.0%} where one reading is.\n"
    ).replace("%", " %")


def main(output: Path, campaigns: int) -> None:
    """Write the page."""
    with threadpool_limits(limits=1, user_api="blas"), TemporaryDirectory() as scratch:
        runs = list(lines(Path(scratch)))
        output.write_text("".join(page(runs, campaigns)), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else CAMPAIGNS)
