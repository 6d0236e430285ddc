"""``calrig devices``: what is plugged in here, by the names a rig file should use."""

from dataclasses import asdict
from pathlib import Path

from procedures.cli.locations import shared_archive_url
from procedures.cli.options import Json
from procedures.cli.output import note, print_json, say
from procedures.errors import ExitStatus
from procedures.lease.keeper import leased
from rig.assembly.discovery import DeviceAnswer, SerialPort, identify_each, serial_ports, visa_resources
from rig.description.read import read_rig


def devices(*, rig: Path | None = None, json: Json = False) -> ExitStatus:
    """List the serial ports and VISA resources found here; with --rig, who the devices of that rig say they are.

    Each device is asked by itself, so that one that is silent keeps no other from being seen; the status is 1 where one
    is silent, or is not the one that the rig file means.

    Parameters
    ----------
    rig
        A rig file: its devices are opened, asked who they are, and closed. Nothing moves.
    """
    ports, resources = serial_ports(), visa_resources()
    answers = [] if rig is None else _answers(rig)
    if json:
        troubles = {device.key: device.trouble for device in answers if device.trouble}
        identities = {device.key: device.identity for device in answers if device.identity}
        found = {"serial": [asdict(port) for port in ports], "visa": resources}
        remarks = {device.key: device.remark for device in answers if device.remark}
        print_json({**found, "identities": identities, "troubles": troubles, "remarks": remarks})
    else:
        _tell(ports, resources, answers)
    return ExitStatus.FAILED if any(device.trouble for device in answers) else ExitStatus.DONE


def _tell(ports: list[SerialPort], resources: list[str] | None, answers: list[DeviceAnswer]) -> None:
    say(f"serial ports: {len(ports) or 'none found'}")
    for port in ports:
        say(f"  {port.stable_path}   {port.description} {port.hardware}".rstrip())
    if resources is None:
        say("VISA resources: no VISA here (install calrig with the extra visa)")
    else:
        say(f"VISA resources: {', '.join(resources) or 'none found'}")
    for device in answers:
        say(f"{device.key}: {device.identity or 'no identity'}")
        if device.remark:
            say(device.remark)
    for trouble in dict.fromkeys(device.trouble for device in answers if device.trouble):
        note(f"calrig: {trouble}")


def _answers(path: Path) -> list[DeviceAnswer]:
    with leased(shared_archive_url(), "devices", note) as lease:
        return identify_each(read_rig(path), path, lease.claim)
