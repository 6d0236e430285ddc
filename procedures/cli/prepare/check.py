"""``calrig check``: is the rig file right, can the procedure be done, how long and how well. Opens no port."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console

from ams.archive.dated_ahead import archived_ahead
from ams.errors import ArchiveError
from procedures.alerts.addresses import usable_alerts
from procedures.check.check_report import check as check_plan
from procedures.check.check_report import to_document
from procedures.check.check_text import render
from procedures.cli.locations import archive_of, shared_archive_url
from procedures.cli.options import RUNS, Alerts, Archive, Json, PilotRun, Rig, RunsFolder
from procedures.cli.output import print_json, say, say_paragraph
from procedures.cli.prepare.pilot import pilot_named
from procedures.delivery.lessons import learned
from procedures.errors import ExitStatus
from procedures.kinds.read import read_procedure
from procedures.plan.gravity_of_site import read_rig_of_site
from procedures.plan.plan import Plan
from procedures.run.preflight import Preflight, preflight
from rig.assembly.open_rig import choose_clock
from rig.clock import VirtualClock
from rig.description.rig_file import RigDescription
from rig.errors import DescriptionError


def check(
    procedure: Path | None = None,
    /,
    *,
    rig: Rig,
    pilot: PilotRun = None,
    out: RunsFolder = RUNS,
    archive: Archive = None,
    alerts: Alerts = None,
    json: Json = False,
) -> int:
    """Validate a rig and a procedure; print the plan, its duration and the uncertainty to expect. Opens no port.

    Disk and place of the folder of runs are looked at, as `calrig run` would, who has the lease of a device that other
    computers reach, and whether every address of the file of alerts can be used. The archive is read for the past runs
    of this rig, which teach durations, noise and drift (of twins the one beside the runs, by default), and for leases
    where it is named; nothing is written to it.

    Parameters
    ----------
    procedure
        The procedure file; without it only the rig file is checked.
    """
    described = read_rig_of_site(rig)
    if procedure is None:
        before = _preflight(rig, described, None, out, archive, alerts)
        _tell_rig(rig, described, before, json)
        return _tell(before, json)

    procedure_description = read_procedure(procedure)
    past = learned(archive_of(out, archive, is_simulated=described.is_simulated), described)
    report = check_plan(
        described,
        procedure_description,
        pilot=pilot_named(pilot, out, described),
        learned=past.times,
        past=past.pilot,
    )
    before = _preflight(rig, described, report.plan, out, archive, alerts)
    if json:
        print_json(to_document(report) | {"machines": _remarks(described)} | _document_of(before))
        return _tell(before, json)

    Console().print(render(report, datetime.now(UTC)))
    for name, remarks in _remarks(described).items():
        for remark in remarks:
            say_paragraph(f"axis {name}: {remark}")
    return _tell(before, json)


def _remarks(described: RigDescription) -> dict[str, list[str]]:
    """Return what a person should know of the machines before a run, such as that one has no stop."""
    return {name: list(axis.remarks()) for name, axis in described.axes.items() if axis.remarks()}


def _tell_rig(path: Path, described: RigDescription, before: Preflight, json: bool) -> None:
    document: dict[str, Any] = {
        "rig": described.rig.name,
        "axes": {name: list(axis.limits_deg) for name, axis in described.axes.items()},
        "channels": [
            *(f"{name}.{channel}" for name, item in described.readouts.items() for channel in item.channel_names()),
            *(f"{name}.{channel}" for name, item in described.streams.items() for channel in item.channel_names()),
        ],
        "sensors": {name: sensor.model for name, sensor in described.sensors.items()},
        "simulated": described.is_simulated,
        "remarks": _remarks(described),
        **_document_of(before),
    }
    if json:
        print_json(document)
        return
    say(f"{path}: {described.rig.name}: nothing wrong found{', twins' if described.is_simulated else ''}")
    for name, limits in document["axes"].items():
        say(f"axis {name}: {limits[0]:g}° to {limits[1]:g}°")
        for remark in document["remarks"].get(name, ()):
            say(f"axis {name}: {remark}")
    say(f"channels: {', '.join(document['channels'])}")
    for name, model in document["sensors"].items():
        say(f"sensor {name}: {model}")


def _preflight(
    rig: Path, described: RigDescription, plan: Plan | None, out: Path, archive: str | None, alerts: Path | None
) -> Preflight:
    now_utc = datetime.now(UTC)
    before = preflight(rig, described, plan, out, now_utc, archive_url=shared_archive_url(archive))
    if alerts is not None or not isinstance(choose_clock(described), VirtualClock):
        try:
            usable_alerts(alerts)
        except DescriptionError as error:
            before = replace(before, refusals=(*before.refusals, *str(error).splitlines()))
    if described.is_simulated:
        return before
    try:
        ahead = archived_ahead(archive_of(out, archive, is_simulated=False), described.sensors, now_utc)
    except ArchiveError as error:
        ahead = (str(error),)
    return replace(before, dated_ahead=ahead)


def _document_of(before: Preflight) -> dict[str, Any]:
    return {
        "refusals": list(before.refusals),
        "engineering": list(before.engineering),
        "unguarded": list(before.unguarded),
        "guarded": list(before.guarded),
        "undelivered": list(before.undelivered),
        "dated_ahead": list(before.dated_ahead),
        "certificate_gaps": list(before.certificate),
    }


def _tell(before: Preflight, json: bool) -> int:
    """Tell what a run would meet now and return the status that the command ends with: a refused run's own."""
    if not json:
        for sentence in before.engineering:
            say_paragraph(f"engineering result: {sentence}")
        for sentence in (*before.unguarded, *before.guarded, *before.dated_ahead):
            say_paragraph(sentence)
        for sentence in before.undelivered:
            say_paragraph(f"will not be delivered: {sentence}")
        if before.certificate:
            say_paragraph("no certificate could be issued, since")
            for gap in before.certificate:
                say_paragraph(f"- {gap}")
        for sentence in before.refusals:
            say_paragraph(f"a run would be refused now: {sentence}")
    return ExitStatus.WRONG_REQUEST if before.refusals else ExitStatus.DONE
