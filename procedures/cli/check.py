"""``calrig check``: is the rig file right, can the procedure be done, how long and how well. Opens no port."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from procedures.cli.output import print_json, say
from rig.description import RigDescription


def check(
    rig: Path, procedure: Path | None = None, /, *, json: Annotated[bool, Parameter(negative=())] = False
) -> None:
    """Validate a rig and a procedure; print the plan, its duration and the uncertainty to expect. Opens no port.

    Parameters
    ----------
    rig
        The rig file.
    procedure
        The procedure file; without it only the rig file is checked.
    json
        Print one JSON document.
    """
    from rig.description import read_rig

    described = read_rig(rig)
    if procedure is None:
        _tell_rig(rig, described, json)
        return
    from procedures.description import read_procedure
    from procedures.plan.check import check as check_plan
    from procedures.plan.check import to_document
    from procedures.plan.check_text import render

    report = check_plan(described, read_procedure(procedure))
    if json:
        print_json(to_document(report))
        return
    from rich.console import Console

    Console().print(render(report))


def _tell_rig(path: Path, described: RigDescription, json: bool) -> None:
    document: dict[str, Any] = {
        "rig": described.rig.name,
        "axes": {name: list(axis.limits_deg) for name, axis in described.axes.items()},
        "channels": [
            f"{name}.{channel}" for name, item in described.readouts.items() for channel in item.channel_names()
        ],
        "sensors": {name: sensor.model for name, sensor in described.sensors.items()},
        "simulated": described.is_simulated,
    }
    if json:
        print_json(document)
        return
    say(f"{path}: {described.rig.name}: nothing wrong found{', twins' if described.is_simulated else ''}")
    for name, limits in document["axes"].items():
        say(f"axis {name}: {limits[0]:g}° to {limits[1]:g}°")
    say(f"channels: {', '.join(document['channels'])}")
    for name, model in document["sensors"].items():
        say(f"sensor {name}: {model}")
