"""``calrig fit`` and ``calrig solve``: from observations, or from a run's journal, to coefficients."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from procedures.cli.output import note, print_json, say
from procedures.cli.places import find_run
from procedures.errors import ExitStatus, RequestError

Json = Annotated[bool, Parameter(negative=())]


def fit(
    file: Path,
    /,
    *,
    model: str = "pitch-roll",
    axis: Annotated[list[str] | None, Parameter(negative=())] = None,
    temperature: Literal["none", "estimate"] = "none",
    extended: Literal["no", "test", "yes"] = "no",
    rig: Path | None = None,
    json: Json = False,
) -> None:
    """Solve observations from a CSV file; no rig needed.

    The file has the columns replication, point, pitch_deg, roll_deg, optionally temperature_degc and time_s, and one
    column in volts for each sensor axis.

    Parameters
    ----------
    file
        The observations.
    model
        pitch-roll, or pitch-only where roll stays zero.
    axis
        AXIS=COLUMN for each sensor axis, such as --axis x=sx_v --axis y=sy_v.
    temperature
        none, or estimate temperature terms from the column temperature_degc.
    extended
        Whether the extended model is tried (test) or taken (yes).
    rig
        A rig file whose table uncertainty is carried into the result.
    json
        Print one JSON document.
    """
    from ams.document import to_document
    from ams.errors import DesignError
    from ams.observations_csv import read_csv, unit_warnings
    from ams.request import CalibrationRequest
    from procedures.cli.coefficients_text import axes_lines
    from procedures.solving import solve_observations, table_uncertainty
    from rig.description import read_rig

    columns = _columns(axis)
    table = None if rig is None else table_uncertainty(read_rig(rig))
    observations = read_csv(file, columns, ("pitch",) if model == "pitch-only" else ("pitch", "roll"))
    request = CalibrationRequest(
        model=model,
        nominal_axes={name: name for name in columns},
        temperature=temperature,
        extended=extended,
        table=table,
    )
    try:
        calibration = solve_observations(observations, request)
    except DesignError as error:
        raise DesignError(f"{file}: {error}") from None
    document = to_document(replace(calibration, warnings=(*unit_warnings(observations), *calibration.warnings)))
    if json:
        print_json(document)
        return
    for line in axes_lines(document["axes"]):  # type: ignore[arg-type]
        say(line)


def solve(run: str, /, *, archive: str | None = None, json: Json = False) -> int:
    """Solve a run again from its journal, and write its coefficient sets, report and exports anew.

    Parameters
    ----------
    run
        A run folder, its journal, its name under ./runs, or a folder that holds exactly one run.
    archive
        URL of the archive, as for `calrig run`.
    json
        Print one JSON document.
    """
    from procedures.cli.run import archive_of, tell
    from procedures.delivery import deliver, sensors_document, solve_run

    folder = find_run(run)
    solved = solve_run(folder)
    for failure in solved.failures:
        note(failure)
    delivery = deliver(solved, archive_of(folder, archive, is_simulated=solved.record.is_simulated))
    if json:
        print_json({"sensors": sensors_document(solved)})
    else:
        tell(delivery)
    return ExitStatus.FAILED if solved.failures else ExitStatus.DONE


def _columns(pairs: list[str] | None) -> Mapping[str, str]:
    """``["x=sx_v"]`` as ``{"x": "sx_v"}``."""
    if not pairs:
        raise RequestError("--axis is missing: give AXIS=COLUMN for each sensor axis, such as --axis x=sx_v")
    columns: dict[str, str] = {}
    for pair in pairs:
        name, separator, column = pair.partition("=")
        if not separator or name not in ("x", "y", "z") or not column:
            raise RequestError(f"--axis {pair}: allowed is x=COLUMN, y=COLUMN or z=COLUMN, such as x=sx_v")
        if name in columns:
            raise RequestError(f"--axis {pair}: axis {name} is given twice; each axis is one column")
        columns[name] = column
    return columns
