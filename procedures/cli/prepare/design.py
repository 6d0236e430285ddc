"""``calrig design``: which attitudes, and how well they would determine the sensor."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from procedures.check.design_map import plot_design
from procedures.check.evaluation import design_document, design_text, judge, write_design
from procedures.check.request import DesignRequest, kinds
from procedures.cli.options import Flag, Json, require_folder_of
from procedures.cli.output import print_json, say


def design(
    *,
    kind: Annotated[str | None, Parameter(help=f"One of {', '.join(kinds())}.")] = None,
    pitch: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    pitch_list: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    roll: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    repeat_roll: Flag = False,
    fractional: str | None = None,
    usage: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    file: Path | None = None,
    plot: Path | None = None,
    csv: Path | None = None,
    json: Json = False,
) -> None:
    """Evaluate an experimental design: figure of merit, usage figure of merit, largest variance.

    Parameters
    ----------
    pitch
        from:to:count or from/to/step in degrees, such as --pitch=-45:45:33.
    pitch_list
        Pitch angles in degrees, such as --pitch-list=-30,0,30; a value may stand more than once.
    roll
        A count, uniform from -180 degrees, or a range as for --pitch; none: without roll.
    repeat_roll
        Add +180 degrees.
    fractional
        Ka,KR: decimate interior columns and rows.
    usage
        from:to, the pitch range of later use in degrees.
    file
        A CSV with the columns pitch_deg and roll_deg.
    plot
        Draw the design and its variance into this file (.svg, .png or .pdf).
    csv
        Write the points into this file.
    """
    require_folder_of(plot, "--plot")
    require_folder_of(csv, "--csv")
    judged = judge(DesignRequest(kind, pitch, pitch_list, roll, repeat_roll, fractional, usage, file))
    if plot is not None:
        plot_design(judged, plot)
    if csv is not None:
        write_design(judged, csv)
    if json:
        print_json(design_document(judged))
    else:
        say(design_text(judged))
