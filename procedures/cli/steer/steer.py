"""``calrig status``, ``pause``, ``continue``, ``stop``, ``abort``: look at or steer a run in another process."""

import shlex
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from procedures.cli.locations import login_name, person_named
from procedures.cli.options import RUNS, AnyRun, Json, NeededReason, OnlyRun, Operator, RunsFolder
from procedures.cli.output import print_json, say, say_lines
from procedures.cli.queues_disarmed import disarmed_by
from procedures.cli.steer.choose_run import alive_or_latest, run_in_state
from procedures.cli.steer.follow import attach_to, shown_until_left
from procedures.errors import ExitStatus, RequestError
from procedures.journal.audit.audit_trail import clock_sentence
from procedures.journal.audit.line_figures import lines_in_words
from procedures.journal.journal_reader import JournalReader
from procedures.journal.plan_file import changed_plan_sentence
from procedures.journal.requests.corrections import Authorisation, close_run
from procedures.journal.requests.spool import ask
from procedures.journal.sidecar.alert_record import Outcome, outcome_sentence, read_outcomes
from procedures.journal.sidecar.delivering import delivered_by
from procedures.journal.sidecar.guard_record import guard_sentence, read_guard_record
from procedures.journal.sidecar.last_words import read_last_words
from procedures.journal.sidecar.live import Live, live_document, read_live
from procedures.journal.sidecar.second_folder import second_folder
from procedures.journal.sidecar.unwritten import unwritten_sentence
from procedures.journal.sidecar.verdict_file import read_verdict
from procedures.journal.status.metrics import figures_of, metrics_text
from procedures.journal.status.run_list import ListedRun, RunList
from procedures.journal.status.standing import RunStatus, progress_of
from procedures.journal.status.standing_words import rows_of
from procedures.journal.status.status import status as look
from procedures.journal.status.stop_advice import of_damage
from procedures.records.states import RESUMABLE, State
from procedures.run.progress import PlainLines
from rig.clock import SystemClock
from rig.local_time import at_both
from rig.plain_text import one_line


def status(
    run: AnyRun = None,
    /,
    *,
    all_: Annotated[
        bool, Parameter(name="--all", negative=(), help="List every run of the folder of runs, the latest first.")
    ] = False,
    follow: Annotated[bool, Parameter(negative=(), help="Go on telling until the run ends; Ctrl-C leaves it.")] = False,
    metrics: Annotated[
        bool, Parameter(negative=(), help="Print every run of the folder as Prometheus text, for monitoring.")
    ] = False,
    out: RunsFolder = RUNS,
    json: Json = False,
) -> int:
    """Look at a run: state, dwells done, when it should end; or list all of them."""
    _refuse_beside_each_other(run, all_=all_, metrics=metrics, follow=follow, json=json)
    if all_:
        return _list(out, json=json)
    if metrics:
        say(metrics_text(figures_of(RunList(out, verifies=True).read())).rstrip("\n"))
        return ExitStatus.DONE
    folder = alive_or_latest(run, out)
    found, live = _with_last_words(look(folder), folder), read_live(folder)
    outcomes, verdict = read_outcomes(folder, second_folder()), _verdict(folder, found.state)
    with JournalReader.open(folder) as reader:
        damage, journal, plan = reader.damage(), reader.path, changed_plan_sentence(folder, reader.header)
    answer = ExitStatus.WRONG_REQUEST if damage.names else ExitStatus.DONE
    if json:
        doing = {} if live is None else {"live": live_document(live)}
        came_to = ({"verdict": verdict} if verdict else {}) | ({"plan": plan} if plan else {})
        unread = {"damaged": damage.names} if damage.names else {}
        print_json({**found.to_document(), **unread, **came_to, **doing, **({"alerts": outcomes} if outcomes else {})})
        return answer
    by = ", by a journal that is damaged" if damage.names else ""
    say_lines(
        _standing_lines(found, folder, by, [f"{journal}: {what}" for what in damage.in_words], verdict, live, outcomes)
    )
    say_lines([f"plan: {plan}"] if plan else [])
    if not follow:
        return answer
    observer = PlainLines(say, parts=None)
    return shown_until_left(folder, observer, lambda: False, SystemClock()) or answer


def _standing_lines(
    found: RunStatus,
    folder: Path,
    by: str,
    damage: Sequence[str],
    verdict: str,
    live: Live | None,
    outcomes: Sequence[Outcome],
) -> Iterator[str]:
    """Tell where a run stands, line by line: its state first, what only a long look needs last."""
    yield f"{found.run}: {found.state}, {found.dwells_done} of {found.dwells_planned} dwells{by}"
    if found.held_by is not None:
        yield f"held by: {one_line(found.held_by)}"
    elif found.why:
        yield f"because: {one_line(found.why)}"
    for what in damage:
        yield f"damaged: {what} is not as it was written; {of_damage(folder)}"
    if deliverer := delivered_by(folder):
        yield f"results: being delivered by {deliverer}"
    if verdict:
        yield f"verdict: {one_line(verdict)}"
    if unwritten := unwritten_sentence(folder, found.state):
        yield f"results: {one_line(unwritten)}"
    for name, how in rows_of(progress_of("state", found), "", live, SystemClock().now_utc())[1:]:
        yield f"{name}: {how}"
    if found.clock_set_by_s:
        yield f"clock: {clock_sentence(found.clock_set_by_s)}"
    if (guarded := read_guard_record(folder)) is not None and (sentence := guard_sentence(guarded)) != found.reason:
        yield one_line(sentence)
    for outcome in outcomes:
        yield f"alert: {one_line(outcome_sentence(outcome))}"
    yield from lines_in_words(found.lines)


def _refuse_beside_each_other(run: str | None, *, all_: bool, metrics: bool, follow: bool, json: bool) -> None:
    """Refuse what would be left out beside another form of the answer. Raises: RequestError."""
    if all_ and run is not None:
        raise RequestError(f"status: --all lists every run: got {run!r} as well; give one of the two")
    if metrics and run is not None:
        raise RequestError(f"status: --metrics prints every run: got {run!r} as well; give one of the two")
    forms = [name for name, is_given in (("--all", all_), ("--metrics", metrics), ("--json", json)) if is_given]
    if follow and forms:
        raise RequestError(f"status: --follow belongs to the lines of one run, not to {forms[0]}; leave one out")
    if metrics and len(forms) > 1:
        other = next(form for form in forms if form != "--metrics")
        raise RequestError(f"status: --metrics prints every run as Prometheus text: got {other} as well; leave one out")


def _verdict(folder: Path, state: State) -> str:
    """Return what a finished run came to, as its report has it; empty where there is none."""
    sentence = (read_verdict(folder, state) or {}).get("sentence", "")
    return str(sentence) if state is State.FINISHED else ""


def _with_last_words(found: RunStatus, folder: Path) -> RunStatus:
    """Return where an interrupted run stands with what was said last, which its journal does not hold yet."""
    if found.state is not State.INTERRUPTED or (words := read_last_words(folder, second_folder())) is None:
        return found
    return replace(found, reason=str(words))


def attach(run: AnyRun = None, /, *, out: RunsFolder = RUNS, operator: Operator = None) -> int:
    """Show a run that another process runs, with its keys; leaving the screen ends nothing."""
    return attach_to(alive_or_latest(run, out), person_named(operator))


def pause(run: AnyRun = None, /, *, out: RunsFolder = RUNS, operator: Operator = None) -> None:
    """Pause a run after the dwell in progress; `calrig continue` goes on."""
    _ask(run, out, "pause", operator)


def continue_(run: AnyRun = None, /, *, out: RunsFolder = RUNS, operator: Operator = None) -> None:
    """Continue a paused or held run."""
    _ask(run, out, "continue", operator)


def stop(run: AnyRun = None, /, *, out: RunsFolder = RUNS, operator: Operator = None) -> None:
    """Stop a run after the dwell in progress; `calrig resume` goes on later."""
    _ask(run, out, "stop", operator)


def abort(run: AnyRun = None, /, *, out: RunsFolder = RUNS, operator: Operator = None) -> None:
    """Abort a run: axes stop now; `calrig resume` goes on with a name and a reason."""
    _ask(run, out, "abort", operator)


def close(
    run: OnlyRun = None,
    /,
    *,
    reason: NeededReason,
    operator: Operator = None,
    out: RunsFolder = RUNS,
) -> None:
    """Close a run that is not to be resumed, ever. What was measured stays, and its report can be made."""
    folder = run_in_state(run, out, RESUMABLE, "closed")
    close_run(folder, Authorisation(person_named(operator), reason))
    say(f"{folder}: closed; nothing resumes it")


def _ask(
    run: str | None, runs: Path, kind: Literal["pause", "continue", "stop", "abort"], operator: str | None
) -> None:
    # A name is no reason not to stop.
    by = operator or login_name() if kind in ("stop", "abort") else person_named(operator)
    folder = alive_or_latest(run, runs)
    ask(folder, kind, by, datetime.now(UTC))
    say(f"{folder}: asked to {kind}; `calrig status {folder}` shows when it did")
    for sentence in disarmed_by(kind, run=folder) if kind in ("stop", "abort") else ():
        say(sentence)


def _list(runs: Path, *, json: bool) -> ExitStatus:
    """Print every run; return the highest status that ``calrig status`` of any of them ends with."""
    listed = RunList(runs, verifies=True).read()
    answer = max((run.exit_status for run in listed), default=ExitStatus.DONE)
    if json:
        print_json({"runs": [run.to_document() for run in listed]})
        return answer
    say(f"{len(listed)} {'run' if len(listed) == 1 else 'runs'} in {runs}")
    for line in _lines(listed):
        say(line)
    return answer


def _lines(listed: Iterable[ListedRun]) -> Iterable[str]:
    for run in listed:
        if run.trouble:
            yield f"{'unreadable':<12} {run.path.name}: {run.trouble}"
            continue
        started = "" if run.started_utc is None else at_both(run.started_utc)
        title = one_line(run.title)
        yield f"{run.state:<12} {run.dwells_done:>5} of {run.dwells_planned:<5} {started}  {run.path.name}  {title}"
        if run.damaged:
            more = f" and {len(run.damaged) - 1} more" if len(run.damaged) > 1 else ""
            yield (
                f"{'':<12} by a journal that is damaged: {run.damaged[0]}{more} not as written; "
                f"calrig status {shlex.quote(str(run.path))} names what is"
            )
