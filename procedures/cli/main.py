"""``calrig``: the command. Commands are loaded when they are called, so that ``--help`` stays quick."""

import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from cyclopts import App, CycloptsError, Group

from procedures.cli.failure import status_of, tell
from procedures.cli.program_log import logged
from procedures.cli.program_log import tell as log
from procedures.cli.standard_streams import open_closed_streams
from procedures.cli.stop_at_once import stop_at_once
from procedures.errors import ExitStatus, ProcedureError, RequestError
from rig.plain_text import LONGEST_NAME, LONGEST_OF_FILE, LONGEST_TEXT, PARAGRAPHS, one_line, text_complaint
from rig.threads import begun

PLACEHOLDERS = frozenset({"NAME", "TEXT", "REASON"})
"""What stands in printed commands for the words of a person; nobody is called so, and nothing is reason by it."""
OF_A_PERSON = {
    "--operator": "the name of whoever answers for it",
    "--reason": "the reason in words",
    "--override": "the reason in words",
    "--supersede": "the reason in words",
}
"""The options that say who and why, with what belongs there."""

HELP = """Calibrate attitude sensors: drive the rig, record every dwell, solve with honest uncertainty, archive, export.

Start with `calrig demo`. Exit status: 0 done, 1 failed, 2 the request or a file is wrong, 3 held or waiting for a
person, 4 aborted by the operator."""

GROUPS = {
    "Prepare": (
        ("demo", "prepare.demo:demo", "The whole job on the twin: run, solve, archive, report, export."),
        ("new", "prepare.new:new", "The first rig file and procedure file, from a few answers."),
        ("design", "prepare.design:design", "Evaluate an experimental design."),
        ("plan", "prepare.plan:plan", "From an accuracy or the hours there are to the shortest procedure."),
        (
            "check",
            "prepare.check:check",
            "Validate a rig and a procedure; print plan, duration and expected uncertainty.",
        ),
        ("alerts", "prepare.alerts:alerts", "Check who is told of a hold, a trip and the end; try it."),
    ),
    "Run": (
        ("run", "run.run:run", "Run a procedure on a rig, then solve, archive, report and export."),
        ("resume", "run.run:resume", "Continue a run after a crash, a stop, an abort or a trip."),
        ("queue", "run.queue:app", "What runs tonight: add, arm, attest, decide; and the runner that starts it."),
        ("void", "steer.people:void", "Take back a dwell and everything after it; a resume measures it again."),
        ("redo", "steer.people:redo", "Take back one replication; a resume measures it again."),
        ("close", "steer.steer:close", "Close a run that is never to be resumed."),
        ("salvage", "steer.people:salvage", "Take what is intact out of a damaged journal, into a new folder."),
    ),
    "Steer": (
        ("status", "steer.steer:status", "Look at a run, also from another process, or list all runs."),
        ("attach", "steer.steer:attach", "Show a running run again, with its keys."),
        (
            "console",
            "steer.console:app",
            "Runs, the night and the archive as pages for a browser; and who may steer there.",
        ),
        ("handover", "steer.people:handover", "The whole state of a run on one page."),
        ("pause", "steer.steer:pause", "Pause a run after the dwell in progress."),
        ("continue", "steer.steer:continue_", "Continue a paused or held run."),
        ("stop", "steer.steer:stop", "Stop a run after the dwell in progress."),
        ("abort", "steer.steer:abort", "Abort a run: axes stop now; it can be resumed."),
        ("note", "steer.people:note", "Write a note into the journal of a run."),
        ("ack", "steer.people:ack", "Acknowledge the alarm of a run: repeats and escalation end."),
    ),
    "Results": (
        ("solve", "results.solve:solve", "Solve a run again from its journal."),
        ("data", "results.data:data", "A run as tables: dwells, readings, events and samples, for other software."),
        ("fit", "fit.fit:fit", "Solve observations from a CSV file; no rig needed."),
        (
            "attitude",
            "attitude.attitude:attitude",
            "Outputs of a calibrated package to angles with standard deviations.",
        ),
        ("export", "results.export:export", "Write a coefficient set for another system."),
        ("verify", "results.export:verify", "Read an exported file back and recompute its test vectors."),
    ),
    "Archive": (
        (
            "archive",
            "archive.archive:app",
            "The archive: search, due, list, show, compare, history, sign, verify and more.",
        ),
        ("certificate", "archive.certificate:certificate", "Issue the certificate of an approved set."),
        ("resolve", "archive.resolve:resolve", "Solve archived runs again, in parallel; tell what changed."),
    ),
    "Bench": (
        ("jog", "bench.jog:jog", "The jog screen; or one motion or look by hand, under the limits of the rig."),
        ("devices", "bench.devices:devices", "Serial ports and VISA resources found here, with their identities."),
        ("prove", "bench.prove:prove", "First contact: what real devices say beside what their twins would say."),
        ("simulate", "bench.simulate:simulate", "The twins of a rig on real ports, until stopped."),
        ("service", "bench.service:service", "Write the systemd unit that resumes runs after a crash or a reboot."),
    ),
}
"""Heading to its commands, in the order in which `calrig --help` lists them: name, where it is, summary."""
OF_PROGRAMS = {"ring": "run.ring:ring"}
"""Commands that no person gives and no help lists: name and where it is."""


def make_app(called: str = "") -> App:
    """Make the command tree. Function names are import paths: nothing is imported before it is called.

    ``called``: the command that is called; its help is the whole text of its function, not the summary of the list.
    """
    app = App(
        name="calrig",
        help=HELP,
        version=_version,
        version_flags=["--version"],
        suppress_keyboard_interrupt=False,
        group_commands=Group("Options", sort_key=len(GROUPS)),
    )
    app.register_install_completion_command(
        help="Completion of commands and options for bash, zsh, fish or PowerShell."
    )
    for index, (heading, commands) in enumerate(GROUPS.items()):
        group = Group(heading, sort_key=index)
        for rank, (name, target, summary) in enumerate(commands):
            text = None if name == called else summary
            app.command(f"procedures.cli.{target}", name=name, help=text, group=group, sort_key=rank)
    for name, target in OF_PROGRAMS.items():
        app.command(f"procedures.cli.{target}", name=name, show=False)
    return app


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and leave with the exit status of the table in ``procedures.errors``.

    Without ``arguments`` it was called as a module, past the entry point: what stops axes goes the same way.
    """
    if arguments is not None:
        sys.exit(run_command(arguments))
    open_closed_streams()
    status = stop_at_once(sys.argv[1:])
    sys.exit(run_command(sys.argv[1:]) if status is None else status)


def run_command(arguments: Sequence[str]) -> int:
    """Run one command; every error becomes a sentence on standard error and a status."""
    _speak_utf8()
    _spare_threads()
    try:
        with logged(arguments):
            status = _run_command(arguments)
            log("command", f"ended with status {int(status)}")
            return status
    except ProcedureError as error:  # a setting of the log itself
        tell(error)
        return status_of(error)


def _spare_threads() -> None:
    """Where no thread can be had, have the linear algebra begin none: it would interrupt this process when loaded."""
    try:
        begun(lambda: None, "the linear algebra")
    except MemoryError:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _run_command(arguments: Sequence[str]) -> int:
    try:
        _require_seen(arguments)
        _require_filled_in(arguments)
        if sorted(arguments) == ["--json", "--version"]:
            import_module("procedures.cli.support").tell_support()
            return ExitStatus.DONE
        app = make_app(arguments[0] if arguments else "")
        result = app(list(arguments), exit_on_error=False, print_error=False, result_action="return_value")
        sys.stdout.flush()
    except CycloptsError as error:
        log("error", str(error), "error")
        print(f"calrig: {error}", file=sys.stderr)  # noqa: T201
        print("calrig: `calrig --help` and `calrig COMMAND --help` tell what is allowed", file=sys.stderr)  # noqa: T201
        return ExitStatus.WRONG_REQUEST
    except BaseException as error:  # noqa: BLE001  the rim of the program: no traceback ever reaches a user
        tell(error)
        return status_of(error)
    return int(result) if isinstance(result, int) else ExitStatus.DONE


def _require_seen(arguments: Sequence[str]) -> None:
    """Refuse what hides something in what is typed, behind any option; a file that is there may be named anyhow.

    The words of a note may have several lines.
    Raises: RequestError for what is not seen, acts on a screen, or breaks a line.
    """
    has_words = arguments[:1] in (["note"], ["ack"])
    for before, argument in zip(["", *arguments], arguments, strict=False):
        is_words = has_words and not argument.startswith("-") and not before.startswith("-")
        option, mark, _ = argument.partition("=")
        longest = _longest(option if mark else before, is_words=is_words)
        complaint = text_complaint(argument, PARAGRAPHS if is_words else "", longest)
        if complaint and not os.path.lexists(argument):
            raise RequestError(f"{one_line(argument)[:80]}: {complaint}; nothing was done")


def _longest(option: str, *, is_words: bool) -> int:
    """Return how many letters may be typed: of a path, a setting or anything else, as many as in a file."""
    if option == "--operator":
        return LONGEST_NAME
    return LONGEST_TEXT if is_words or option in OF_A_PERSON else LONGEST_OF_FILE


def _require_filled_in(arguments: Sequence[str]) -> None:
    """Refuse what stands for a name or a reason in printed commands: the record would have it as somebody's word.

    What only stops asks for nobody, and is not refused.
    Raises: RequestError for NAME, TEXT or REASON behind an option that tells who or why.
    """
    if arguments[:1] in (["stop"], ["abort"]) or arguments[:2] == ["queue", "disarm"]:
        return
    for before, argument in zip(["", *arguments], arguments, strict=False):
        option, mark, value = argument.partition("=")
        option, value = (option, value) if mark else (before, argument)
        if option in OF_A_PERSON and value.strip() in PLACEHOLDERS:
            raise RequestError(
                f"{option}: got {value.strip()}, which only stands for what is to be written there; nothing was done; "
                f"give {OF_A_PERSON[option]}"
            )


def _speak_utf8() -> None:
    """Degrees and Greek letters on any terminal, and UTF-8 in any pipe, whatever the locale says."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding="utf-8", errors="backslashreplace")


def _version() -> str:
    from importlib.metadata import version

    return version("calrig")


if __name__ == "__main__":
    main()
