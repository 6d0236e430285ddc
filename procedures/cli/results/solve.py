"""``calrig solve``: from a run's journal to coefficients, again."""

from collections.abc import Iterator
from dataclasses import replace

from procedures.cli.options import RUNS, AnyRun, Archive, Json, RunsFolder
from procedures.cli.output import note, print_json, say, telling_what_is_done
from procedures.cli.results.findings_text import check_trials, findings_lines
from procedures.cli.run.run import tell, tell_failures
from procedures.cli.run.stopping import ending_with_a_word
from procedures.cli.run.working import working
from procedures.cli.steer.archive_url import url_of_run
from procedures.cli.steer.choose_run import alive_or_latest
from procedures.delivery.deliver import SolvedRun, deliver, sensors_document, solve_run
from procedures.delivery.unsolved import page_of_unsolved
from procedures.errors import ExitStatus
from procedures.journal.sidecar.delivering import delivering
from procedures.report.summary import MOST_IN_FULL
from procedures.solution.by_model import checked_by_monte_carlo


def solve(
    run: AnyRun = None,
    /,
    *,
    out: RunsFolder = RUNS,
    archive: Archive = None,
    monte_carlo: int = 0,
    json: Json = False,
) -> int:
    """Solve a run again from its journal, and write its coefficient sets, report and exports anew.

    It is refused while another process delivers the run, as after its last dwell.

    Parameters
    ----------
    monte_carlo
        So many trials of a Monte Carlo check beside each uncertainty budget.
    """
    check_trials(monte_carlo, is_possible=True)
    folder = alive_or_latest(run, out)
    with ending_with_a_word(), delivering(folder):
        with working() as progress_line, page_of_unsolved(folder):
            solved = solve_run(folder, progress_line)
        if monte_carlo:
            plan = solved.record.plan
            checked = {
                name: checked_by_monte_carlo(sensor, solved.record.rig, plan.sensors[name], plan.solve, monte_carlo)
                for name, sensor in solved.sensors.items()
            }
            solved = replace(solved, sensors=checked)
        for failure in solved.failures:
            note(failure)
        with working() as progress_line:
            url = url_of_run(folder, archive, is_simulated=solved.record.is_simulated)
            delivery = deliver(solved, url, progress_line)
    with telling_what_is_done(folder):
        if json:
            print_json({"sensors": sensors_document(solved)})
        else:
            for line in _findings(solved):
                say(line)
            tell(delivery)
    tell_failures(delivery)
    return ExitStatus.FAILED if solved.failures or delivery.failures else ExitStatus.DONE


def _findings(run: SolvedRun) -> Iterator[str]:
    """Yield advice and budget of every axis, under its name; of many sensors where they stand."""
    if len(run.sensors) > MOST_IN_FULL:
        yield f"advice and budgets of {len(run.sensors)} sensors stand in the report and in calrig solve --json"
        return
    for name, document in sensors_document(run).items():
        for axis, section in document["axes"].items():
            if lines := list(findings_lines(section)):
                yield from ("", f"{name} {axis}", *(f"  {line}" for line in lines))
