"""``calrig alerts``: who is told, whether that can work, and a trial of it while somebody is there to look."""

from pathlib import Path

from procedures.alerts.addresses import try_ways, usable_alerts, ways_of
from procedures.alerts.channels import Message
from procedures.alerts.dispatcher import bench_sentence
from procedures.alerts.settings import alerts_file
from procedures.cli.options import Flag, Json
from procedures.cli.output import print_json, say
from procedures.errors import ExitStatus, RequestError

TRIAL = Message(
    "calrig: a trial of the alerts",
    f"This is a trial: nothing happened, and nothing has to be done.\n{bench_sentence('')}",
)
NOT_TRIED = "not tried, since whoever waits for it would miss the next; a run sends it from its beginning on"


def alerts(file: Path | None = None, /, *, test: Flag = False, json: Json = False) -> int:
    """Check a file of alerts and show who is told, without what may be secret; with --test tell all of them once.

    The status is 1 where a message of the trial did not get out, and 2 where the file is wrong or names a service or
    a program that is not there: a run is refused then as well.

    Parameters
    ----------
    file
        The file of alerts; by default alerts.toml in the user's configuration.
    test
        Send one message by every command and address, those of [escalate] too. Taken means that program or server took
        it: look whether it arrived.
    """
    named = alerts_file(file)
    if named is None or (settings := usable_alerts(named)) is None:
        raise RequestError("alerts: no file is named, and the user's own is not there; nobody is told; give FILE")
    tried = try_ways(settings, TRIAL) if test else [(way, "") for way in ways_of(settings)]
    has_failed = any(failure for _, failure in tried)
    if json:
        ways = [
            {"key": ".".join(way.key), "name": way.name} | ({"failed": failure} if test else {})
            for way, failure in tried
        ]
        print_json({"file": str(named), "ways": ways, "heartbeat": settings.heartbeat is not None})
        return ExitStatus.FAILED if has_failed else ExitStatus.DONE
    say(f"{named}: {len(tried)} ways{'' if tried else ': nobody is told'}")
    for way, failure in tried:
        outcome = f": not delivered: {failure}" if failure else ": taken; look whether it arrived" if test else ""
        say(f"{'.'.join(way.key)}: {way.name}{outcome}")
    if settings.heartbeat is not None:
        say(f"heartbeat: {NOT_TRIED}" if test else "heartbeat: goes out while a run lives")
    return ExitStatus.FAILED if has_failed else ExitStatus.DONE
