"""``calrig console``: the pages for a browser of this machine."""

from typing import Annotated

from cyclopts import Parameter

from procedures.cli.options import RUNS, Archive, RunsFolder, require_folder
from procedures.cli.output import note
from procedures.cli.places import default_archive_url
from procedures.console.app import Console
from procedures.console.serve import DEFAULT_LISTEN, bound, serve
from procedures.console.sessions import Sessions
from procedures.errors import ExitStatus
from procedures.journal.run_list import RunList
from rig.clock import SystemClock


def console(
    *,
    listen: Annotated[
        str, Parameter(help="HOST:PORT of this machine, such as 127.0.0.1:8600; port 0 takes a free one.")
    ] = DEFAULT_LISTEN,
    out: RunsFolder = RUNS,
    archive: Archive = None,
) -> int:
    """Show runs, the night and the archive in a browser of this machine, until Ctrl-C. Nothing is steered there.

    Each link that it prints opens one browser, for twelve hours.
    """
    require_folder(out, "--out")
    clock = SystemClock()
    listening = bound(listen)
    note("calrig console: open the link; each works once and the next one is told then; Ctrl-C ends it")
    shown = Console(RunList(out, clock), archive or default_archive_url(), clock, Sessions(clock))
    serve(listening, shown, note)
    return ExitStatus.DONE
