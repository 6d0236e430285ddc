"""A check report for a person, drawn by rich."""

from datetime import datetime, timedelta

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from ams.models.extended import TERM_NAMES, TRACELESS_NAME
from ams.parameter_words import words_of
from ams.units import ARCSEC_PER_DEG, dof_words, small_unit
from procedures.check.check_report import CheckReport, steps_in_words
from procedures.check.shares import explained, large_and_others, with_others
from procedures.description.dwell_settings import AdaptiveDwell
from procedures.kinds.kind import DesignFigures
from procedures.numbers import duration
from procedures.plan.order import TWICE
from procedures.plan.plan import Expectation
from procedures.report.overview import stated_once
from rig.local_time import at_both

_NOTHING = 1e-9
"""Of a share: what rounding leaves."""
_WHOLE_S = 100.0


def render(report: CheckReport, now: datetime | None = None) -> "Group":
    """Return everything of the report, to be printed on a rich console; with ``now``, when such a run would end."""
    advice = [Text(f"! {line}", style="yellow") for line in report.advice]
    advice += [Text(f"reservation: {line}", style="yellow") for line in report.forecast.reservations]
    advice += [Text(f"remark: {line}") for line in report.forecast.remarks]
    expected = _expected(report)
    expected += _recommendations(report)
    steps: list[RenderableType] = [] if report.forecast.design else [_steps(report), ""]
    return Group(_facts(report, now), "", _axes(report), "", _durations(report), "", *steps, *expected, *advice)


def _recommendations(report: CheckReport) -> list[RenderableType]:
    """Return TP's ten recommendations: whether each is followed, and why it matters."""
    if not report.forecast.recommendations:
        return []
    table = Table("TP", "followed", "recommendation, and why", box=None)
    for recommendation in report.forecast.recommendations:
        followed = (
            "not asked here" if recommendation.is_followed is None else "yes" if recommendation.is_followed else "no"
        )
        table.add_row(str(recommendation.number), followed, Text(f"{recommendation.text}: {recommendation.reason}"))
    return ["", table, ""]


def _facts(report: CheckReport, now: datetime | None) -> "Table":
    plan = report.plan
    table = _bare_table()
    table.add_row("rig", report.rig)
    table.add_row("procedure", plan.title)
    table.add_row("kind", f"{plan.kind}, model {plan.solve.model}")
    table.add_row("sensors", ", ".join(plan.sensors))
    if report.forecast.design is not None:
        roll = f" × {len(plan.design.roll_values_deg)} roll" if plan.design.has_roll else ", without roll"
        yaw = f" × {len(plan.design.yaw_values_deg)} yaw" if len(plan.design.yaw_values_deg) > 1 else ""
        each = ", each attitude visited twice" if plan.order == TWICE else ""
        counts = f"{len(plan.design.points)} points ({len(plan.design.pitch_values_deg)} pitch{yaw}{roll}{each})"
        seed = "" if plan.seed is None else f", seed {plan.seed}"
        table.add_row("design", f"{plan.design.kind}: {counts}, order {plan.order}{seed}")
    others = len(plan.dwells) - len(plan.design_dwells)
    table.add_row("dwells", f"{len(plan.design_dwells)} in {plan.replications} replications, {others} for checks")
    if plan.environment is not None:
        plateaus = ", ".join(f"{value:g}" for value in plan.environment.plateaus_degc)
        table.add_row("plateaus", f"{plateaus} °C by {plan.environment.name}")
    at_once = [
        f"{', '.join(names)} {what}"
        for names, what in ((plan.moving_together, "move"), (plan.reading_together, "read"))
        if len(names) > 1
    ]
    if at_once:
        table.add_row("at the same time", "; ".join(at_once))
    expected = plan.expected
    source = f"{expected.learned_from} past runs of this rig" if expected.learned_from else "the files alone"
    table.add_row(
        "duration",
        f"{duration(expected.p50_s)} (p50: half of such runs take longer), {duration(expected.p90_s)} (p90: one in ten "
        f"does), by {source}",
    )
    if (limits := plan.dwell.adaptive) is not None and report.longest is not None:
        table.add_row("adaptive dwells", Text(_adaptive(limits, report.longest)))
    if now is not None:
        middle, late = (now + timedelta(seconds=seconds) for seconds in (expected.p50_s, expected.p90_s))
        table.add_row("begun now", f"it ends {at_both(middle)} (p50), {at_both(late)} (p90)")
    if (rule := plan.sequential) is not None and (earliest := report.earliest) is not None:
        table.add_row(
            "may end early",
            Text(
                f"from {rule.least_replications} of {plan.replications} replications on (after about "
                f"{duration(earliest.p50_s)}, p50), when U95 of every angle is at most "
                f"{rule.half_width_deg * ARCSEC_PER_DEG:.3g}″ ([stop])"
            ),
        )
    if report.forecast.design is not None:
        _add_figures(table, report, report.forecast.design)
    table.add_row("journal", f"about {report.journal_bytes / 1e6:.1f} MB")
    return table


def _adaptive(limits: AdaptiveDwell, longest: Expectation) -> str:
    return (
        f"read until the mean of a channel is known to {limits.noise_arcsec:g}″, {limits.least_samples} to "
        f"{limits.most_samples} readings ([dwell.adaptive]); at worst, where all take {limits.most_samples}: "
        f"{duration(longest.p50_s)} (p50), {duration(longest.p90_s)} (p90)"
    )


def _add_figures(table: "Table", report: CheckReport, figures: DesignFigures) -> None:
    usage = figures.usage_figure_of_merit_sqrt
    merit = f"V^½ = {figures.figure_of_merit_sqrt:.3f}"
    table.add_row("model", f"{report.plan.solve.model}: {', '.join(figures.parameters)}")
    table.add_row("rank", f"{figures.rank} of {len(figures.parameters)}, {dof_words(figures.degrees_of_freedom)}")
    table.add_row("figure of merit", merit if usage is None else f"{merit}, over the usage range {usage:.3f}")
    table.add_row("time and model", f"correlated by {figures.time_correlation:.2f} within a replication")
    largest = {order: max(map(abs, bias.values()), default=0.0) for order, bias in figures.drift_bias.items()}
    shares = ", ".join(f"{order} {share:.2g}" if share > _NOTHING else f"{order} 0" for order, share in largest.items())
    table.add_row("bias by drift", f"share of a linear drift over a replication that one parameter takes: {shares}")
    alike = figures.roll_errors_alike_every_deg
    if alike is not None:
        table.add_row(
            "unseen of roll",
            f"errors of the axis that repeat every {alike:g}° ({360.0 / alike:g} waves a turn and multiples): alike at "
            "every point, they pass for a turned package, and no residual holds them against what is declared; a few "
            "rolls off the even steps do",
        )


def _steps(report: CheckReport) -> "Table":
    table = Table("point", "what", box=None)
    for point, words in steps_in_words(report.plan):
        table.add_row(str(point), Text(words))
    return table


def _axes(report: CheckReport) -> "Table":
    table = Table("axis", "limits (°)", "reached (°)", "travel (°)", box=None, title_justify="left")
    for name, use in report.axes.items():
        limits, reached = (f"{low:g} to {high:g}" for low, high in (use.limits_deg, use.reached_deg))
        table.add_row(name, limits, reached, f"{use.travel_deg:g}")
    return table


def _durations(report: CheckReport) -> "Table":
    """Return what takes how long, the longest first; what takes less than a thousandth of it all is left out."""
    expected = report.plan.expected
    table = Table("what", "times", "p50", "p90", "each\np50", "each\np90", box=None)
    for name, part in sorted(expected.parts.items(), key=lambda item: -item[1].p50_s):
        if part.p50_s > 0.001 * expected.p50_s:
            late, late_each = (duration(part.p90_s), _seconds(part.each_p90_s)) if expected.learned_from else ("", "")
            what = f"{name.removesuffix(' deg')}°" if name.endswith(" deg") else name  # the archive keeps it in ASCII
            table.add_row(what, str(part.count), duration(part.p50_s), late, _seconds(part.each_p50_s), late_each)
    return table


def _expected(report: CheckReport) -> "list[RenderableType]":
    """Return what is to be expected: a row a sensor axis where their units are known, else a row a parameter."""
    if not report.forecast.expected:
        return []
    if report.forecast.design is not None:
        return [*_expected_of_design(report), _noise(report), "", *_angles(report)]

    table = Table("sensor", "parameter", "u", box=None)
    for axis in report.forecast.expected:
        for parameter, value in axis.standard_uncertainty.items():
            label, _, unit = words_of(parameter)
            deviation = "not determined" if value is None else f"{value:.2g} {unit}"
            table.add_row(Text(f"{axis.sensor} {axis.axis}"), label, deviation)
    return [table, _noise(report), ""]


def _expected_of_design(report: CheckReport) -> "list[RenderableType]":
    """Return a row a sensor axis; what goes with temperature below the others, for a terminal of 80 columns."""
    names = [
        name for name in report.forecast.expected[0].standard_uncertainty if name not in (*TERM_NAMES, TRACELESS_NAME)
    ]
    over_temperature = [name for name in names if "temperature" in words_of(name).label]
    tables: list[RenderableType] = []
    for columns in ([name for name in names if name not in over_temperature], over_temperature):
        if not columns:
            continue
        headings = [f"u({words_of(name).label})\n({_small(name)[0]})" for name in columns]
        is_first = not tables
        noise = ["noise of a\ndwell (µV)"] if is_first else []
        table = Table("sensor", *headings, *noise, box=None)
        for axis in report.forecast.expected:
            values = [_scaled(name, axis.standard_uncertainty[name]) for name in columns]
            table.add_row(f"{axis.sensor} {axis.axis}", *values, *([f"{axis.noise_v * 1e6:.3g}"] if is_first else []))
        tables += [table] if is_first else ["", table]
    return tables


def _angles(report: CheckReport) -> "list[RenderableType]":
    """Return the angles at use: U95 and what each source takes of it, sensors that are alike in one row."""
    usage = report.forecast.usage_pitch_deg
    if usage is None or not report.forecast.angles:
        return []
    table = Table("sensor", "angle", "U95 (″)", "of the\ncalibration (″)", "shares (″)", box=None)
    alike: dict[tuple[str, ...], list[str]] = {}
    others: dict[tuple[str, ...], float] = {}
    for serial, angles in report.forecast.angles.items():
        for name, angle in angles.items():
            figures = (f"{value * ARCSEC_PER_DEG:.2g}" for value in (angle.u95_deg, angle.calibration_deg))
            large, others_deg = large_and_others(angle.shares_deg)
            row = (name, *figures, large)
            alike.setdefault(row, []).append(serial)
            others[row] = max(others.get(row, 0.0), others_deg)
    for row, serials in alike.items():
        is_of_all = len(serials) == len(report.forecast.angles) > 1
        who = f"all {len(serials)}" if is_of_all else ", ".join(serials)
        table.add_row(Text(who), *row[:-1], with_others(row[-1], others[row]))
    every = {
        source: share
        for angles in report.forecast.angles.values()
        for angle in angles.values()
        for source, share in angle.shares_deg.items()
    }
    return [
        table,
        f"U95: rms of the 95 % half-width of one future angle over pitch {usage[0]:g}° to {usage[1]:g}° and every roll "
        "where the angle is told; squares of the shares add up",
        *explained(every),
    ]


def _noise(report: CheckReport) -> str:
    """Say where the noise comes from, of each axis where they differ, and for which coning angles u(azimuth) holds."""
    expected = report.forecast.expected
    sources = dict.fromkeys(axis.noise_source for axis in expected)
    of_each = stated_once(((axis.sensor, axis.axis, axis.noise_source) for axis in expected), list(report.plan.sensors))
    lines = [f"u: standard uncertainty as the solution will state it (noise: {', '.join(sources)})"]
    if len(sources) > 1:
        lines = ["u: standard uncertainty as the solution will state it; noise:", *(f"  {text}" for text in of_each)]
    by_coning = sorted(expected, key=lambda axis: axis.coning_deg)
    if any("azimuth_deg" in axis.standard_uncertainty for axis in expected):
        least, most = by_coning[0], by_coning[-1]
        span = f"the coning angle of {least.coning_deg:g}°"
        if least.coning_deg < most.coning_deg:
            span = (
                f"the coning angle of each axis, from {least.coning_deg:g}° ({least.sensor} {least.axis}) to "
                f"{most.coning_deg:g}° ({most.sensor} {most.axis})"
            )
        lines.append(f"u(azimuth) holds for {span}, and goes as its inverse")
    return "\n".join(lines)


def _bare_table() -> "Table":
    table = Table(box=None, show_header=False)
    table.add_column(style="bold")
    table.add_column()
    return table


def _seconds(duration_s: float) -> str:
    return duration(duration_s) if duration_s >= _WHOLE_S else f"{duration_s:.3g} s"


def _small(name: str) -> tuple[str, float]:
    return small_unit(words_of(name).unit)


def _scaled(name: str, value: float | None) -> str:
    return "not determined" if value is None else f"{value * _small(name)[1]:.3g}"
