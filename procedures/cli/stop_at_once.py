"""``calrig abort`` and ``calrig jog --stop`` by the stop guard of a rig, looked at before anything else is imported.

The guard sends the stops within the time that Python itself takes to start. What it does not know goes the long way.
"""

import os
import sys

from rig.guard.ask import of_rig, of_run, stop


def stop_at_once(arguments: list[str]) -> int | None:
    """Have a stop guard stop axes where that is what the command asks for; its exit status, None for the long way."""
    if arguments[:1] == ["abort"]:
        options = _options(arguments[1:], {"--out", "--runs", "--operator"}, set())
        return None if options is None else _abort(options)
    if arguments[:1] == ["jog"] and "--stop" in arguments:
        options = _options(arguments[1:], {"--rig", "--axis"}, {"--stop", "--json"})
        return None if options is None or "" in options else _stop(options)
    return None


def _options(arguments: list[str], valued: set[str], flags: set[str]) -> dict[str, str] | None:
    """Return the options by name and what stands alone under an empty one; None for anything else than these."""
    found: dict[str, str] = {}
    left = list(arguments)
    while left:
        name, mark, value = left.pop(0).partition("=")
        if name in valued and (mark or left):
            found[name] = value if mark else left.pop(0)
        elif name in flags and not mark:
            found[name] = ""
        elif not name.startswith("-") and not mark and "" not in found:
            found[""] = name
        else:
            return None
    return found


def _abort(options: dict[str, str]) -> int | None:
    if {"--out", "--runs"} <= options.keys():
        return None  # two names of one option: the long way says so
    guards = of_run(options.get(""), _runs(options))
    if len(guards) != 1:
        return None
    by = options.get("--operator") or _login_name()
    outcomes = stop(guards[0], None, by)
    if outcomes is None:
        return None
    _request_abort(guards[0]["run"], by)
    folder = _as_named(guards[0]["run"], options)
    sentence = f"{folder}: asked to abort; `calrig status {folder}` shows when it did"
    return _tell(outcomes, [sentence, *_queues_disarmed("abort", guards[0]["rig_file"])])


def _runs(options: dict[str, str]) -> str:
    return options.get("--out") or options.get("--runs") or "runs"


def _as_named(folder: str, options: dict[str, str]) -> str:
    """Return a run's folder as the other commands tell it: as it was named, or below the folder of runs."""
    named, runs = options.get(""), _runs(options)
    ways = (
        *(() if named is None else (named, os.path.dirname(named), os.path.join(runs, named))),
        os.path.join(runs, os.path.basename(folder)),
    )
    here = (os.path.normpath(way) for way in ways if os.path.realpath(way) == os.path.realpath(folder))
    return next(here, folder)


def _request_abort(run: str, by: str) -> None:
    """Put the abort into the run's folder too. The engine has heard it from the guard, with the name of who asked.

    So a folder that takes nothing, as that of another account, is no failure.
    """
    from pathlib import Path

    from procedures.errors import StorageFailed
    from procedures.journal.requests.spool import Request, Spool
    from rig.clock import SystemClock
    from rig.plain_text import one_line

    try:
        Spool(Path(run)).submit(Request("abort", one_line(by), SystemClock().now_utc().isoformat()))
    except StorageFailed:
        return


def _queues_disarmed(what: str, rig_file: str) -> list[str]:
    """Have the queues that wait for the rig disarmed; what each says. The stops have been sent."""
    from pathlib import Path

    from procedures.cli.queues_disarmed import disarmed_by

    return disarmed_by(what, rig=Path(rig_file) if rig_file else None)


def _stop(options: dict[str, str]) -> int | None:
    axes = [options["--axis"]] if "--axis" in options else None
    outcomes: dict[str, str] = {}
    engines = []
    for guard in of_rig(options.get("--rig", "")):
        answer = stop(guard, axes, _login_name())
        if answer:
            outcomes |= answer
            engines.append(guard["pid"])
    if not outcomes:
        return None
    queues = _queues_disarmed("jog --stop", options["--rig"])
    if "--json" in options:
        import json

        document = {"stopped": sorted(outcomes), "stopped_by_guard_of": engines, "told": outcomes, "queues": queues}
        print(json.dumps(document))  # noqa: T201
        return _status(outcomes)
    guards = [f"by the stop guard of process {pid}, which ends what it was doing" for pid in engines]
    return _tell(outcomes, [*guards, *queues])


def _tell(outcomes: dict[str, str], lines: list[str]) -> int:
    for axis, outcome in sorted(outcomes.items()):
        print(f"{axis}: {outcome}")  # noqa: T201
    for line in lines:
        print(line)  # noqa: T201
    return _status(outcomes)


def _status(outcomes: dict[str, str]) -> int:
    return 1 if any(outcome.startswith("NOT") for outcome in outcomes.values()) else 0


def _login_name() -> str:
    """As ``getpass`` tells it, which takes long to import."""
    named = (os.environ.get(name) for name in ("LOGNAME", "USER", "LNAME", "USERNAME"))
    return next(filter(None, named), None) or _account_name()


def _account_name() -> str:
    """Where no variable tells it, as under systemd or cron: only systems with accounts have a stop guard."""
    if sys.platform == "win32":
        return "unknown"
    else:
        import pwd

        try:
            return pwd.getpwuid(os.getuid()).pw_name
        except KeyError:
            return f"uid {os.getuid()}"
