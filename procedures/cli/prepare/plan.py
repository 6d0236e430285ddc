"""``calrig plan``: from an accuracy, or from the hours there are, to the shortest procedure. Opens no port."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from ams.whole_file import write_whole
from procedures.check.candidate import Comparison, SearchRange, SearchRequest, Target
from procedures.check.candidate_file import chosen_procedure
from procedures.check.candidates import compare
from procedures.check.candidates_picture import plot_comparison
from procedures.check.candidates_text import comparison_document, render_comparison
from procedures.check.check_report import check
from procedures.cli.locations import archive_of
from procedures.cli.options import RUNS, Archive, Json, PilotRun, Rig, RunsFolder, require_folder_of
from procedures.cli.output import print_json, say
from procedures.cli.prepare.pilot import pilot_named
from procedures.delivery.lessons import learned
from procedures.errors import RequestError
from procedures.kinds.read import procedure_of
from procedures.plan.gravity_of_site import read_rig_of_site
from procedures.solution.expected import Usage
from rig.toml_file import TomlFile

DEFAULT_USAGE = "-60:60"
SEARCH_RANGE = SearchRange()


def plan(
    *,
    rig: Rig,
    half_width_deg: float | None = None,
    hours: float | None = None,
    parameter: str | None = None,
    usage_pitch: Annotated[str, Parameter(allow_leading_hyphen=True)] = DEFAULT_USAGE,
    usage_noise_arcsec: float | None = None,
    pilot: PilotRun = None,
    out: Path | None = None,
    plot: Path | None = None,
    runs: RunsFolder = RUNS,
    archive: Archive = None,
    json: Json = False,
) -> None:
    """Compare the calibrations that a rig could make and write the procedure that serves best. Opens no port.

    Give one target: a half-width, a parameter or hours. The archive is read for the past runs of this rig, which teach
    how long each candidate takes (of twins the one beside the runs, by default); nothing is written to it.

    Parameters
    ----------
    half_width_deg
        The shortest procedure whose U95 of any angle at use is at most so much.
    hours
        The best procedure that takes at most so long (p50).
    parameter
        NAME=HALF-WIDTH, such as offset_v=2e-6: the shortest whose 95 % half-width of it is at most so much.
    usage_pitch
        from:to, the pitch range of later use in degrees, such as --usage-pitch=-30:30.
    usage_noise_arcsec
        Standard deviation of one reading at use; by default that of a dwell of twenty readings.
    out
        Write the procedure into this file; without it nothing is written.
    plot
        Draw hours against U95, or against the half-width of the parameter, into this file (.svg, .png or .pdf).
    """
    require_folder_of(out, "--out")
    require_folder_of(plot, "--plot")
    if out is not None and out.exists():
        raise RequestError(f"plan: --out {out}: is there already; nothing was written; give another name")
    described = read_rig_of_site(rig)
    target = _target(half_width_deg, hours, parameter)
    usage = Usage(_range(usage_pitch), usage_noise_arcsec)
    times = learned(archive_of(runs, archive, is_simulated=described.is_simulated), described).times
    comparison = compare(
        SearchRequest(described, target, usage, pilot_named(pilot, runs, described), SEARCH_RANGE, times)
    )
    text = chosen_procedure(comparison)
    written = procedure_of(TomlFile(out or Path("procedure.toml"), text))
    check(described, written, pilot=comparison.request.pilot, learned=times)
    if plot is not None:
        plot_comparison(comparison, plot)
    if out is not None:
        write_whole(out, text.encode("utf-8"))
    _tell(comparison, out, rig, json)


def _tell(comparison: Comparison, out: Path | None, rig: Path, json: bool) -> None:
    if json:
        print_json(comparison_document(comparison) | {"procedure": None if out is None else str(out)})
        return
    Console().print(render_comparison(comparison))
    say(
        "nothing was written; --out FILE writes the procedure"
        if out is None
        else f"{out}: calrig run {out} --rig {rig}"
    )


def _target(half_width_deg: float | None, hours: float | None, parameter: str | None) -> Target:
    if sum(value is not None for value in (half_width_deg, hours, parameter)) != 1:
        raise RequestError("plan: give one of --half-width-deg, --hours and --parameter; nothing was planned")
    for option, value in (("--half-width-deg", half_width_deg), ("--hours", hours)):
        if value is not None and not 0.0 < value < float("inf"):
            raise RequestError(f"plan: {option}: got {value:g}, allowed a number above 0; nothing was planned")
    if parameter is None:
        return Target(half_width_deg=half_width_deg, hours=hours)
    name, _, half = parameter.partition("=")
    try:
        value = float(half)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise RequestError(f"plan: --parameter: got {parameter!r}, allowed NAME=HALF-WIDTH such as offset_v=2e-6")
    return Target(parameter=(name, value))


def _range(text: str) -> tuple[float, float]:
    low, _, high = text.partition(":")
    try:
        return float(low), float(high)
    except ValueError:
        raise RequestError(
            f"plan: --usage-pitch: got {text!r}, allowed from:to in degrees such as -30:30; nothing was planned"
        ) from None
