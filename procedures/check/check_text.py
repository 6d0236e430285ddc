"""A check report for a person, drawn by rich."""

from datetime import timedelta

from rich.console import Group
from rich.table import Table
from rich.text import Text

from ams.units import ARCSEC_PER_DEG, label_and_unit
from procedures.check.grid_check import CheckReport

IN_SMALL = {
    "V": (1e6, "µV"), "V/g": (1e6, "µV/g"), "°": (ARCSEC_PER_DEG, "″"), "g": (1e6, "µg"), "g/V": (1e6, "µg/V"),
}  # fmt: skip


def render(report: CheckReport) -> Group:
    """Everything of the report, to be printed on a rich console."""
    advice = [Text(f"! {line}", style="yellow") for line in report.advice]
    return Group(_facts(report), "", _axes(report), "", _expected(report), _noise(report), *advice)


def _facts(report: CheckReport) -> Table:
    plan = report.plan
    table = _bare_table()
    roll = f" × {len(plan.design.roll_values_deg)} roll" if plan.design.has_roll else ", without roll"
    yaw = f" × {len(plan.design.yaw_values_deg)} yaw" if len(plan.design.yaw_values_deg) > 1 else ""
    counts = f"{len(plan.design.points)} points ({len(plan.design.pitch_values_deg)} pitch{yaw}{roll})"
    seed = "" if plan.seed is None else f", seed {plan.seed}"
    others = len(plan.dwells) - len(plan.design_dwells)
    usage = report.usage_figure_of_merit_sqrt
    table.add_row("rig", report.rig)
    table.add_row("procedure", plan.title)
    table.add_row("design", f"{plan.design.kind}: {counts}, order {plan.order}{seed}")
    table.add_row("dwells", f"{len(plan.design_dwells)} in {plan.replications} replications, {others} for checks")
    if plan.environment is not None:
        plateaus = ", ".join(f"{value:g}" for value in plan.environment.plateaus_degc)
        table.add_row("plateaus", f"{plateaus} °C by {plan.environment.name}")
    table.add_row("duration", f"{_time(plan.expected.p50_s)} (p50), {_time(plan.expected.p90_s)} (p90)")
    table.add_row("model", f"{plan.solve.model}: {', '.join(report.parameters)}")
    table.add_row("rank", f"{report.rank} of {len(report.parameters)}, {report.degrees_of_freedom} degrees of freedom")
    merit = f"V^½ = {report.figure_of_merit_sqrt:.3f}"
    table.add_row("figure of merit", merit if usage is None else f"{merit}, over the usage range {usage:.3f}")
    table.add_row("time and model", f"correlated by {report.time_correlation:.2f} within a replication")
    table.add_row("journal", f"about {report.journal_bytes / 1e6:.1f} MB")
    return table


def _axes(report: CheckReport) -> Table:
    table = Table("axis", "limits (°)", "reached (°)", "travel (°)", box=None, title_justify="left")
    for name, use in report.axes.items():
        limits, reached = (f"{low:g} to {high:g}" for low, high in (use.limits_deg, use.reached_deg))
        table.add_row(name, limits, reached, f"{use.travel_deg:g}")
    return table


def _expected(report: CheckReport) -> Table:
    names = list(report.expected[0].standard_uncertainty)
    headings = [f"u({_word(name)})\n({_small(name)[1]})" for name in names]
    table = Table("sensor", *headings, "noise of a\ndwell (µV)", box=None)
    for axis in report.expected:
        values = [_scaled(name, axis.standard_uncertainty[name]) for name in names]
        table.add_row(f"{axis.sensor} {axis.axis}", *values, f"{axis.noise_v * 1e6:.3g}")
    return table


def _noise(report: CheckReport) -> str:
    sources = ", ".join(dict.fromkeys(axis.noise_source for axis in report.expected))
    conings = ", ".join(dict.fromkeys(f"{axis.coning_deg:g}°" for axis in report.expected))
    has_azimuth = report.plan.design.has_roll and report.plan.solve.model != "linear"
    azimuth = f"; the azimuth's holds for a coning angle of {conings}" if has_azimuth else ""
    return f"u: expected standard uncertainty from noise ({sources}) and table alone{azimuth}"


def _bare_table() -> Table:
    table = Table(box=None, show_header=False)
    table.add_column(style="bold")
    table.add_column()
    return table


def _time(duration_s: float) -> str:
    return str(timedelta(seconds=round(duration_s)))


def _unit(name: str) -> str:
    return label_and_unit(name)[1]


def _small(name: str) -> tuple[float, str]:
    return IN_SMALL[_unit(name)]


def _word(name: str) -> str:
    return label_and_unit(name)[0]


def _scaled(name: str, value: float | None) -> str:
    return "not determined" if value is None else f"{value * _small(name)[0]:.3g}"
