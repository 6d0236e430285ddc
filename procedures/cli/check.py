"""``calrig check``: is the rig file right, can the procedure be done, how long and how well. Opens no port."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console, Group

from procedures.check import motion_check
from procedures.check.check_text import render
from procedures.check.grid_check import check as check_plan
from procedures.check.grid_check import to_document
from procedures.cli.options import RUNS, Json, Rig, RunsFolder
from procedures.cli.output import print_json, say
from procedures.description.procedure_file import ProcedureDescription, read_procedure
from procedures.errors import ExitStatus
from procedures.plan.plan import Plan
from procedures.plan.planner import make_plan
from procedures.run.preflight import Beforehand, beforehand
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription


def check(procedure: Path | None = None, /, *, rig: Rig, out: RunsFolder = RUNS, json: Json = False) -> int:
    """Validate a rig and a procedure; print the plan, its duration and the uncertainty to expect. Opens no port.

    Disk and place of the folder of runs are looked at, as `calrig run` would.

    Parameters
    ----------
    procedure
        The procedure file; without it only the rig file is checked.
    """
    described = read_rig(rig)
    if procedure is None:
        before = _beforehand(rig, described, None, out)
        _tell_rig(rig, described, before, json)
        return _tell(before, json)

    asked = read_procedure(procedure)
    document, page = (
        _motion_told(described, asked) if asked.moves or asked.design.kind == "up-down" else _told(described, asked)
    )

    before = _beforehand(rig, described, make_plan(described, asked), out)
    if json:
        print_json(document | _document_of(before))
        return _tell(before, json)

    Console().print(page)
    return _tell(before, json)


def _told(described: RigDescription, asked: ProcedureDescription) -> tuple[dict[str, Any], Group]:
    report = check_plan(described, asked)
    return to_document(report), render(report)


def _motion_told(described: RigDescription, asked: ProcedureDescription) -> tuple[dict[str, Any], Group]:
    report = motion_check.check_motion(described, asked)
    return motion_check.to_document(report), motion_check.render(report)


def _tell_rig(path: Path, described: RigDescription, before: Beforehand, json: bool) -> None:
    document: dict[str, Any] = {
        "rig": described.rig.name,
        "axes": {name: list(axis.limits_deg) for name, axis in described.axes.items()},
        "channels": [
            *(f"{name}.{channel}" for name, item in described.readouts.items() for channel in item.channel_names()),
            *(f"{name}.{channel}" for name, item in described.streams.items() for channel in item.channel_names()),
        ],
        "sensors": {name: sensor.model for name, sensor in described.sensors.items()},
        "simulated": described.is_simulated,
        "remarks": {name: list(axis.remarks()) for name, axis in described.axes.items() if axis.remarks()},
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


def _beforehand(rig: Path, described: RigDescription, plan: Plan | None, out: Path) -> Beforehand:
    return beforehand(rig, described, plan, out, datetime.now(UTC).date())


def _document_of(before: Beforehand) -> dict[str, Any]:
    return {"refusals": list(before.refusals), "engineering": list(before.engineering)}


def _tell(before: Beforehand, json: bool) -> int:
    """What a run would meet now; a refusal leaves with the status that the run would have."""
    if not json:
        for sentence in before.engineering:
            say(f"engineering result: {sentence}")
        for sentence in before.refusals:
            say(f"a run would be refused now: {sentence}")
    return ExitStatus.WRONG_REQUEST if before.refusals else ExitStatus.DONE
