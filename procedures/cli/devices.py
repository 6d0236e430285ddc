"""``calrig devices``: what is plugged in here, by the names a rig file should use."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from procedures.cli.output import print_json, say


def devices(*, rig: Path | None = None, json: Annotated[bool, Parameter(negative=())] = False) -> None:
    """Serial ports and VISA resources found here; with --rig, who the devices of that rig say they are.

    Parameters
    ----------
    rig
        A rig file: its devices are opened, asked who they are, and closed. Nothing moves.
    json
        Print one JSON document.
    """
    from rig.discovery import serial_ports, visa_resources

    ports, resources = serial_ports(), visa_resources()
    identities = {} if rig is None else _identities(rig)
    if json:
        print_json({"serial": [asdict(port) for port in ports], "visa": resources, "identities": identities})
        return
    say(f"serial ports: {len(ports) or 'none found'}")
    for port in ports:
        say(f"  {port.stable_path}   {port.description} {port.hardware}".rstrip())
    if resources is None:
        say("VISA resources: no VISA here (install calrig with the extra visa)")
    else:
        say(f"VISA resources: {', '.join(resources) or 'none found'}")
    for name, identity in identities.items():
        say(f"{name}: {identity}")


def _identities(path: Path) -> dict[str, str]:
    from rig.assembly import open_rig
    from rig.description import read_rig

    with open_rig(read_rig(path), rig_file=path, purpose="devices") as opened:
        return opened.identities()
