"""``calrig data``: a run as tables for other people's software."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from procedures.cli.locations import archive_url
from procedures.cli.options import RUNS, AnyRun, Archive, Flag, Json, RunsFolder
from procedures.cli.output import print_json, say
from procedures.cli.steer.choose_run import alive_or_latest
from procedures.data.columns import DATA_VERSION
from procedures.data.run_data import read_run
from procedures.data.write import write_tables
from procedures.errors import RequestError

FOLDER = "data"


def data(
    run: AnyRun = None,
    /,
    *,
    to: Literal["csv", "parquet", "hdf5", "xarray"] = "csv",
    samples: Flag = False,
    out: Annotated[Path | None, Parameter(help="Where the files go; by default the folder data of the run.")] = None,
    runs: RunsFolder = RUNS,
    archived: Flag = False,
    archive: Archive = None,
    json: Json = False,
) -> None:
    """Write the dwells, readings and events of a run as tables; the columns are a contract, listed in docs/data.md.

    Parameters
    ----------
    to
        csv: a file a table, and columns.json; parquet: a file a table; hdf5: run.h5; xarray: run.nc (NetCDF).
    samples
        Also write every single sample.
    archived
        RUN is the identity of a run in the archive, whose journal lies where it was published from.
    """
    if out is not None and (not out.parent.is_dir() or (out.exists() and not out.is_dir())):
        raise RequestError(
            f"--out {out}: is no folder and none can be made there; nothing was written; make the folder or give "
            "another"
        )
    if archive is not None and not archived:
        raise RequestError("--archive: belongs to --archived, which is missing; nothing was written")
    if archived and run is None:
        raise RequestError("--archived: RUN is missing; nothing was written; calrig archive list names the runs")
    url = archive_url(archive) if archived else None
    read = read_run(str(run), archive=url) if archived else read_run(alive_or_latest(run, runs))
    target = read.path / FOLDER if out is None else out
    try:
        target.mkdir(exist_ok=True)
    except OSError as error:
        raise RequestError(
            f"{target}: cannot be made: {error.strerror}; nothing was written; give --out with a folder that can be "
            "written"
        ) from error
    files = write_tables(read, to, target, with_samples=samples)
    if json:
        rows = {"dwells": len(read.dwells), "readings": len(read.readings), "events": len(read.events)}
        print_json(
            {"run": str(read.path), "version": DATA_VERSION, "files": [str(file) for file in files], "rows": rows}
        )
        return
    for file in files:
        say(str(file))
