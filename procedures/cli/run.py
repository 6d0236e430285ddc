"""``calrig run`` and ``calrig resume``: measure, then solve, archive, report and export."""

from pathlib import Path

from rich.console import Console

from ams.archive.refusals import without_password
from ams.whole_file import replace_file
from procedures.alerts.settings import read_alerts
from procedures.cli.archive_url import require_archive_url
from procedures.cli.attend import attended
from procedures.cli.choose_run import only_one
from procedures.cli.options import (
    RUNS,
    Alerts,
    AllowNetworkFolder,
    Archive,
    Flag,
    Json,
    OnlyRun,
    Operator,
    Reason,
    Rig,
    RunsFolder,
)
from procedures.cli.output import note, print_json, say
from procedures.cli.places import (
    default_archive_url,
    left_out_where_empty,
    login_name,
    new_run_folder,
)
from procedures.delivery.deliver import Delivery, deliver, run_document, solve_run
from procedures.delivery.publish import history_findings
from procedures.errors import ExitStatus, RequestError
from procedures.journal.header import make_header
from procedures.journal.journal_reader import JournalReader
from procedures.journal.location import require_local
from procedures.journal.status import status
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.records.states import RESUMABLE, State
from procedures.report.summary import print_summary
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from procedures.run.resume import resume as resume_run
from rig.assembly.open_rig import choose_clock, open_rig
from rig.clock import SystemClock, VirtualClock
from rig.description.read import read_rig, rig_from_json


def run(
    procedure: Path,
    /,
    *,
    rig: Rig,
    out: RunsFolder = RUNS,
    operator: Operator = None,
    rehearse: Flag = False,
    archive: Archive = None,
    alerts: Alerts = None,
    allow_network_folder: AllowNetworkFolder = False,
    json: Json = False,
) -> int:
    """Run a procedure on a rig, then solve, archive, report and export.

    Ctrl-C stops after the dwell in progress, a second one aborts. The run's folder is told first, on standard error.
    A simulated run is archived beside itself unless --archive is given.

    Parameters
    ----------
    procedure
        The procedure file.
    rehearse
        Do all of it on twins of that very rig, in virtual time; no port is opened.
    """
    described, asked = read_rig(rig), read_procedure(procedure)
    plan = make_plan(described, asked)
    performed = described.all_on_twins() if rehearse else described
    if not allow_network_folder:
        require_local(out)
    asked_archive = archive if archive is not None or performed.is_simulated else default_archive_url()
    _require_what_the_end_needs(asked_archive, alerts)
    with open_rig(performed, rig_file=None if rehearse else rig, purpose="run", write=replace_file) as opened:
        opened.identities()  # a device that is silent is told before anything is written
        now = SystemClock().now_utc()
        folder = new_run_folder(out, plan.title, now)
        opened.belongs_to(folder)
        header = make_header(
            folder.name, plan, performed, rig, procedure, operator or login_name(), now, is_rehearsal=rehearse
        )
        is_virtual = isinstance(opened.clock, VirtualClock)
        with (
            left_out_where_empty(folder),
            attended(plan.title, alerts, folder, is_virtual=is_virtual) as attendance,
        ):
            outcome = begin(folder, header, plan, opened, attendance.observer, care=attendance.care)
    exit_status = conclude(folder, outcome, archive, json=json)
    attendance.ring_out(folder)
    return exit_status


def resume(
    run: OnlyRun = None,
    /,
    *,
    out: RunsFolder = RUNS,
    operator: Operator = None,
    reason: Reason = None,
    accept_changes: Flag = False,
    archive: Archive = None,
    alerts: Alerts = None,
    allow_network_folder: AllowNetworkFolder = False,
    json: Json = False,
) -> int:
    """Continue a run after a crash, a stop or a trip: home, measure the check set again, compare, go on.

    After a trip --operator and --reason are needed.

    Parameters
    ----------
    accept_changes
        Go on though rig file, procedure file or software changed; needs operator and reason, which the record keeps.
        The run keeps its own plan; of the rig file only ports and interlocks are taken over.
    """
    folder = only_one(run, out, RESUMABLE, "resumed")
    if operator is None and status(folder).state is State.TRIPPED:
        raise RequestError(f"{folder}: the run is tripped: a person must answer for it; give --operator and --reason")
    if not allow_network_folder:
        require_local(folder)
    _require_what_the_end_needs(archive, alerts)
    title, is_virtual = title_and_time(folder)
    with attended(title, alerts, folder, is_virtual=is_virtual) as attendance:
        outcome = resume_run(
            folder,
            operator or ("" if accept_changes else login_name()),
            reason or "",
            attendance.observer,
            care=attendance.care,
            accepts_changes=accept_changes,
        )
    exit_status = conclude(folder, outcome, archive, json=json)
    attendance.ring_out(folder)
    return exit_status


def _require_what_the_end_needs(archive: str | None, alerts: Path | None) -> None:
    """Looked at before anything moves. Raises: RequestError, DescriptionError."""
    if archive is not None:
        require_archive_url(archive)
    if alerts is not None:
        read_alerts(alerts)


def title_and_time(folder: Path) -> tuple[str, bool]:
    """Title of a run, and whether it runs in virtual time. Raises: JournalError."""
    with JournalReader.open(folder) as reader:
        clock = choose_clock(rig_from_json(reader.header.rig_json))
        return reader.header.title, isinstance(clock, VirtualClock)


def conclude(folder: Path, outcome: Outcome, archive: str | None, *, json: bool) -> int:
    """Deliver what there is to deliver, tell it, and return the exit status of the run."""
    solved = solve_run(folder)
    delivery = deliver(solved, archive_of(folder, archive, is_simulated=solved.record.is_simulated))
    if outcome.reason:
        note(f"run {folder.name}: {outcome.state}: {outcome.reason}")
    for failure in solved.failures if solved.is_finished else ():
        note(failure)
    if delivery.archived is not None and delivery.archive_url is not None:
        for finding in history_findings(delivery.archive_url, delivery.archived):
            note(f"look at this: {finding}")
    if json:
        print_json(run_document(delivery))
    else:
        tell(delivery)
    require_archived(delivery)
    failed = solved.is_finished and solved.failures
    return ExitStatus.FAILED if failed else outcome.exit_status


def archive_of(folder: Path, archive: str | None, *, is_simulated: bool) -> str:
    """The archive that is asked for; a simulated run's is beside it, never the laboratory's own."""
    if archive is not None:
        return archive
    return f"sqlite:///{folder.parent / 'archive.sqlite'}" if is_simulated else default_archive_url()


def require_archived(delivery: Delivery) -> None:
    """Asked when everything else is told. Raises: ArchiveError as the archive refused the run."""
    if delivery.refusal is not None:
        note(f"not archived; everything else is written; calrig archive publish {delivery.run.folder} does it later")
        raise delivery.refusal


def tell(delivery: Delivery) -> None:
    """The outcome for a person: coefficients, verdict, and where everything is."""
    print_summary(delivery.view, Console())
    say()
    say(f"report       {delivery.report}")
    say(f"on paper     {delivery.report.with_suffix('.pdf')}")
    for name, path in delivery.sets.items():
        say(f"coefficients {path}   ({name})")
    for path in delivery.exports:
        say(f"export       {path}")
    if delivery.archive_url is not None:
        say(f"archive      {without_password(delivery.archive_url)}")
