"""``calrig solve``: from a run's journal to coefficients, again."""

from typing import Annotated

from cyclopts import Parameter

from procedures.cli.output import note, print_json
from procedures.cli.places import find_run
from procedures.errors import ExitStatus

Json = Annotated[bool, Parameter(negative=())]


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
