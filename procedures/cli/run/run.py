"""``calrig run`` and ``calrig resume``: measure, then solve, archive, report and export."""

import shlex
import sys
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TextIO, cast

from rich.console import Console

from ams.archive.refusals import without_password
from ams.whole_file import replace_file
from procedures.alerts.addresses import usable_alerts
from procedures.cli.locations import (
    archive_of,
    left_out_where_empty,
    login_name,
    new_run_folder,
    person_named,
    shared_archive_url,
)
from procedures.cli.options import (
    RUNS,
    Alerts,
    AllowNetworkFolder,
    Archive,
    Detach,
    Flag,
    Json,
    OnlyRun,
    Operator,
    Reason,
    Rig,
    RunsFolder,
)
from procedures.cli.output import note, note_paragraph, print_json, say, telling_what_is_done
from procedures.cli.program_log import tell as log
from procedures.cli.queues_disarmed import disarmed_by, note_disarmed
from procedures.cli.run.attend import Attendance, attended
from procedures.cli.run.detach import detached
from procedures.cli.run.last_word import last_word
from procedures.cli.run.opening import Opening, opening
from procedures.cli.run.stopping import ending_with_a_word
from procedures.cli.run.terminal import outlived
from procedures.cli.run.working import working
from procedures.cli.steer.archive_url import archive_of_run, as_kept, require_archive_url, url_of_run
from procedures.cli.steer.choose_run import run_in_state
from procedures.cli.steer.dropped import tell_dropped
from procedures.delivery.deliver import Delivery, deliver, run_document, solve_run
from procedures.delivery.lessons import UNTAUGHT, learned
from procedures.delivery.parts import DONE, NOT_MADE
from procedures.delivery.publish import history_findings
from procedures.delivery.unsolved import DEFECTS_FILE, page_of_unsolved
from procedures.description.named_files import files_named_by
from procedures.errors import ExitStatus, NotSolved, ProcedureError, RequestError
from procedures.journal.header import RunHeader, make_header
from procedures.journal.journal_reader import JournalReader
from procedures.journal.location import require_local
from procedures.journal.sidecar.delivering import delivering
from procedures.journal.sidecar.second_folder import second_folder
from procedures.journal.sidecar.unwritten import unwritten_sentence
from procedures.journal.status.status import status
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.lease.keeper import leased
from procedures.plan.gravity_of_site import read_rig_of_site
from procedures.plan.plan import Plan
from procedures.queue.hands import RESUME
from procedures.records.states import ANSWERED_FOR, RESUMABLE, State
from procedures.report.summary import print_summary, print_verdict
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from procedures.run.handover import left_elsewhere, unfinished
from procedures.run.resume import resume as resume_run
from procedures.run.unhindered import Unbreakable
from rig.assembly.open_rig import choose_clock, open_rig
from rig.assembly.unguarded import unguarded_sentences
from rig.clock import SystemClock, VirtualClock
from rig.description.read import rig_from_json
from rig.description.rig_file import RigDescription

MOST_FILES = 3
"""Of one kind, each named; of more their folder is."""


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
    detach: Detach = False,
    json: Json = False,
) -> int:
    """Run a procedure on a rig, then solve, archive, report and export.

    Ctrl-C stops after the dwell in progress, a second one aborts. A terminal that is closed ends nothing. The run's
    folder is told first, on standard error. A simulated run is archived beside itself unless --archive is given.

    Parameters
    ----------
    procedure
        The procedure file.
    rehearse
        Do all of it on twins of that very rig, in virtual time; no port is opened.
    """
    with opening(procedure.stem, alerts, is_virtual=rehearse) as begins:
        described = read_rig_of_site(rig)
        begins.rig = described.rig.name
        procedure_description, who = read_procedure(procedure), person_named(operator)
        performed = described.all_on_twins() if rehearse else described
        begins.is_virtual = isinstance(choose_clock(performed), VirtualClock)
        past = archive_of(out, archive, is_simulated=performed.is_simulated)
        plan = make_plan(described, procedure_description, learned=learned(past, performed).times)
        named_files = files_named_by(performed, rig, procedure_description)
        begins.title = plan.title
        if not allow_network_folder:
            require_local(out)
        kept = past if archive or not performed.is_simulated else None
        _require_what_the_end_needs(kept, alerts, is_virtual=begins.is_virtual)
        if detach:
            options = {"--rig": rig, "--out": out, "--operator": operator, "--archive": archive, "--alerts": alerts}
            flags = {"--rehearse": rehearse, "--allow-network-folder": allow_network_folder}
            return detached("run", [str(procedure)], options, flags, out, json=json)

        def header_of(run_id: str, now: datetime) -> RunHeader:
            return make_header(
                run_id, plan, performed, rig, procedure, who, now, is_rehearsal=rehearse, named_files=named_files
            )

        rig_file = None if rehearse else rig
        return _perform(begins, header_of, plan, performed, rig_file, out, archive, alerts, json=json)


def _perform(
    begins: Opening,
    header_of: Callable[[str, datetime], RunHeader],
    plan: Plan,
    performed: RigDescription,
    rig_file: Path | None,
    out: Path,
    archive: str | None,
    alerts: Path | None,
    *,
    json: bool,
) -> int:
    with outlived(), ExitStack() as at_last:
        with (
            leased(shared_archive_url(archive), f"run of {plan.title!r}", note) as lease,
            open_rig(
                performed,
                rig_file=rig_file,
                purpose="run",
                write=replace_file,
                claim=lease.claim,
            ) as opened,
        ):
            note_disarmed()
            tell_unguarded(performed)
            opened.identities()  # a device that is silent is told before anything is written
            now = SystemClock().now_utc()
            folder = new_run_folder(out, plan.title, now)
            lease.belongs_to(f"run {folder.name}")
            header = header_of(folder.name, now)
            with left_out_where_empty(folder), attended(begins, alerts, folder) as attendance:
                at_last.callback(attendance.ring_out, folder)
                kept = as_kept(archive, is_simulated=performed.is_simulated)
                ended = opened.belongs_to(folder, attendance.services.ring)
                services = replace(attendance.services, lease_news=lease.news, archive=kept, ended=ended)
                outcome = begin(folder, header, plan, opened, attendance.observer, services=services)
        return conclude(folder, outcome, archive, attendance, json=json)


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
    detach: Detach = False,
    json: Json = False,
) -> int:
    """Continue a run after a crash, a stop, an abort or a trip: home, measure the check set again, compare, go on.

    After a trip and after an abort --operator and --reason are needed.

    Parameters
    ----------
    accept_changes
        Go on though addresses or interlocks of the rig file, the software or the folder changed, or over another
        device that the run has stopped at; needs operator and reason, which the record keeps. Ports, [twin] control
        and interlocks are taken over; every other key that changed is refused by its name, since the run keeps its
        own plan and rig.
    """
    folder = run_in_state(run, out, RESUMABLE, "resumed")
    with opening(folder.name, alerts, folder) as begins:
        begins.title, begins.rig, begins.is_virtual = title_rig_and_time(folder)
        state = status(folder).state
        by = None if operator is None else person_named(operator)
        if by is None and state in ANSWERED_FOR:
            raise RequestError(
                f"{folder}: the run is {state}: a person must answer for it; give --operator and --reason"
            )
        if not allow_network_folder:
            require_local(folder)
        named_archive, archive = archive, archive_of_run(folder, archive)
        _require_what_the_end_needs(archive, alerts, is_virtual=begins.is_virtual)
        if detach:
            options = {"--operator": operator, "--reason": reason, "--archive": named_archive, "--alerts": alerts}
            flags = {"--accept-changes": accept_changes, "--allow-network-folder": allow_network_folder}
            return detached("resume", [str(folder)], options, flags, folder, json=json)
        with JournalReader.open(folder) as reader:
            tell_unguarded(rig_from_json(reader.header.rig_json))
            kept = as_kept(archive, is_simulated=reader.header.is_simulated)
        tell_dropped(folder)
        with outlived(), ExitStack() as at_last:
            with (
                leased(shared_archive_url(archive), f"run {folder.name}", note) as lease,
                attended(begins, alerts, folder) as attendance,
            ):
                at_last.callback(attendance.ring_out, folder)
                for sentence in disarmed_by(RESUME, run=folder):
                    note(sentence)
                outcome = resume_run(
                    folder,
                    by or ("" if accept_changes else login_name()),
                    reason or "",
                    attendance.observer,
                    services=replace(attendance.services, claim=lease.claim, lease_news=lease.news, archive=kept),
                    accepts_changes=accept_changes,
                )
            return conclude(folder, outcome, archive, attendance, json=json)


def tell_unguarded(rig: RigDescription) -> None:
    """Say where nobody stops the axes when this program dies."""
    for sentence in unguarded_sentences(rig):
        note(sentence)


def _require_what_the_end_needs(archive: str | None, alerts: Path | None, *, is_virtual: bool) -> None:
    """Check archive and alerts before anything moves, the user's own alerts too where time is no virtual one.

    Raises: RequestError, DescriptionError.
    """
    if archive is not None:
        require_archive_url(archive)
    if alerts is not None or not is_virtual:
        usable_alerts(alerts)


def title_rig_and_time(folder: Path) -> tuple[str, str, bool]:
    """Return the title of a run, name of its rig, and whether it runs in virtual time. Raises: JournalError."""
    with JournalReader.open(folder) as reader:
        described = rig_from_json(reader.header.rig_json)
        return reader.header.title, described.rig.name, isinstance(choose_clock(described), VirtualClock)


def conclude(folder: Path, outcome: Outcome, archive: str | None, attendance: Attendance, *, json: bool) -> int:
    """Deliver what there is to deliver, tell it, and return the exit status of the run."""
    if outcome.reason:
        note_paragraph(f"run {folder.name}: {outcome.state}: {outcome.reason}")
    if outcome.is_journal_away:  # what stands in its place may be of another run
        for line in left_elsewhere(folder, second_folder(), outcome):
            note_paragraph(line)
        return outcome.exit_status
    try:
        with ending_with_a_word(), delivering(folder), working() as progress_line:
            with page_of_unsolved(folder):
                solved = solve_run(folder, progress_line)
            url = url_of_run(folder, archive, is_simulated=solved.record.is_simulated)
            delivery = deliver(solved, url, progress_line)
    except BaseException as error:
        attendance.tell_end(f"{outcome.state}, and nothing delivered", _what_next(folder, error))
        if missing := unwritten_sentence(folder, outcome.state) or _cut_short(folder, outcome, error):
            note_paragraph(f"run {folder.name}: {missing}")
        _tell_unfinished(folder, outcome)
        raise
    if outcome.state is State.FINISHED:
        attendance.tell_end(*last_word(delivery))
    for failure in solved.failures if solved.is_finished else ():
        note(failure)
    if delivery.archived is not None and delivery.archive_url is not None:
        for finding in history_findings(delivery.archive_url, delivery.archived.publications, SystemClock().now_utc()):
            note_paragraph(f"look at this: {finding}")
    with telling_what_is_done(folder):
        if json:
            print_json(run_document(delivery))
        else:
            tell(delivery)
    tell_failures(delivery)
    _tell_unfinished(folder, outcome)
    failed = delivery.failures or (solved.is_finished and solved.failures)
    return ExitStatus.FAILED if failed else outcome.exit_status


def _cut_short(folder: Path, outcome: Outcome, error: BaseException) -> str:
    """Say what makes the rest of a finished run's results that a signal cut short behind the verdict; else nothing."""
    if outcome.state is not State.FINISHED or not isinstance(error, KeyboardInterrupt):
        return ""
    return f"not all of its results are written; calrig solve {shlex.quote(str(folder))} makes what is missing"


def _tell_unfinished(folder: Path, outcome: Outcome) -> None:
    """Tell last of a run that did not finish how it stands: a page of results rolls what was told before away."""
    if outcome.state is not State.FINISHED:
        with suppress(ProcedureError):  # whose journal cannot be read told it already
            for line in unfinished(folder, second_folder()):
                note_paragraph(line)


def _what_next(folder: Path, error: BaseException) -> str:
    """Say what kept a run from being solved, and what to do; an error that a person can mend says it itself."""
    return str(error) if isinstance(error, NotSolved) else f"{error}\ncalrig handover {folder} says what comes next."


def tell_failures(delivery: Delivery) -> None:
    """Tell what of the run's results is missing, a line each, and how it is made; tracebacks go to the log."""
    for name, text in delivery.defects.items():
        log("defect", f"{delivery.run.folder}: {name}: {text}", "error")
    for part, failure in delivery.failures.items():
        note(f"{part}: {failure}")
    if delivery.defects:
        note(f"the traceback for whoever mends it is in {delivery.run.folder / DEFECTS_FILE}")
    is_mended_by_solve = any(
        part not in delivery.defects and not word.startswith(NOT_MADE) for part, word in delivery.failures.items()
    )
    if delivery.failures.keys() == {"lessons"}:
        note(UNTAUGHT)
    if delivery.failures.keys() == {"archive"}:
        is_later = "archive" not in delivery.defects
        later = f"; calrig archive publish {delivery.run.folder} does it later" if is_later else ""
        note(f"not archived; everything else is written{later}")
    elif is_mended_by_solve:
        note(
            f"everything else is written; calrig solve {delivery.run.folder} makes what is missing{_lacking(delivery)}"
        )


def _lacking(delivery: Delivery) -> str:
    """Say what solving again does not make: dwells that a run which did not finish has not measured."""
    run = delivery.run
    lacking = len(run.record.plan.design_dwells) - run.dwells_done
    if run.is_finished or lacking <= 0:
        return ""
    if run.record.state in RESUMABLE:
        return f" of page and paper; its {lacking} dwells that are missing are measured by calrig resume {run.folder}"
    return f" of page and paper; its {lacking} dwells that are missing are measured by a new run"


def tell(delivery: Delivery) -> None:
    """Tell the outcome to a person: coefficients, verdict, and where everything is."""
    console = Console(file=cast(TextIO, Unbreakable(sys.stdout)))  # rich itself ends a program with status 1
    if delivery.view is not None:
        print_summary(delivery.view, console)
        say()
    if delivery.parts["html"] == DONE:
        say(f"report       {delivery.report}")
    if delivery.parts["pdf"] == DONE:
        say(f"on paper     {delivery.report.with_suffix('.pdf')}")
    for heading, paths in (("coefficients", list(delivery.sets.values())), ("export", list(delivery.exports))):
        if len(paths) > MOST_FILES:
            say(f"{heading:<12} {paths[0].parent}   ({len(paths)} files)")
        else:
            for path in paths:
                say(f"{heading:<12} {path}")
    if delivery.archive_url is not None:
        say(f"archive      {without_password(delivery.archive_url)}")
    if delivery.view is not None:
        say()
        print_verdict(delivery.view, console)
