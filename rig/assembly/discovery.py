"""What is connected to this machine: serial ports by their stable names, and VISA resources where there is a VISA."""

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from serial.tools.list_ports import comports

from rig.abilities.unstoppable import why_unstoppable
from rig.assembly.faulty_lines import drivers_of
from rig.assembly.identity import Identifiable, expected, require_expected
from rig.assembly.open_rig import Claim, claimed_by_nobody_else, open_rig
from rig.description.rig_file import RigDescription
from rig.drivers.twin_lines import axis_lines
from rig.errors import RequestRefused, RigBusy, RigError
from rig.lines.lock import acquire
from rig.link.visa import open_manager

BY_ID = Path("/dev/serial/by-id")


@dataclass(frozen=True, slots=True)
class SerialPort:
    """One serial port. ``stable_path`` names the adapter, not the order of plugging; it is the one for a rig file."""

    path: str
    stable_path: str
    description: str
    hardware: str
    """USB vendor, product and serial number as the system prints them; empty where it knows none."""


@dataclass(frozen=True, slots=True)
class DeviceAnswer:
    """A device that was asked who it is, by its table in the rig file."""

    key: str
    identity: str = ""
    trouble: str = ""
    """Why there is no answer, or why it is the wrong one."""
    remark: str = ""
    """What to know of it before it moves."""


def serial_ports(by_id: Path = BY_ID) -> list[SerialPort]:
    """Return all serial ports, in the order of their paths. Nothing is opened."""
    stable = stable_paths(by_id)
    return [
        SerialPort(
            path=port.device,
            stable_path=stable.get(port.device, port.device),
            description=_known(port.description),
            hardware=_known(port.hwid),
        )
        for port in sorted(comports(), key=lambda port: port.device)
    ]


def identify_each(
    description: RigDescription, rig_file: Path, claim: Claim = claimed_by_nobody_else
) -> list[DeviceAnswer]:
    """Ask every device of a rig who it is, line by line: one that does not answer keeps no other from being asked.

    Nothing moves. Raises: RigBusy where somebody owns the rig.
    """
    with acquire([str(rig_file)], "devices"):
        found = [answer for line in _lines(description) for answer in _ask_line(line, claim)]
    return [_judged(answer, expected(description)) for answer in found]


def _lines(description: RigDescription) -> Iterator[RigDescription]:
    """Yield the rig with the devices of one line only, for every line."""
    for names in axis_lines(description.axes):
        yield with_only(description, "axes", {name: description.axes[name] for name in names})
    for table in ("readouts", "environment", "streams", "field"):
        for name, device in getattr(description, table).items():
            yield with_only(description, table, {name: device})


def with_only(description: RigDescription, table: str, devices: Mapping[str, object]) -> RigDescription:
    """Return the rig with some devices of one table and no others, so that no other line is opened."""
    nothing: dict[str, object] = {"axes": {}, "readouts": {}, "environment": {}, "streams": {}, "field": {}}
    return description.model_copy(update=nothing | {table: dict(devices)})


def _ask_line(line: RigDescription, claim: Claim) -> list[DeviceAnswer]:
    """Ask the devices of one line; where it cannot be opened, that is what each of them has to say."""
    try:
        with open_rig(line, claim=claim) as rig:
            return [_answer(key, device) for key, device in rig.by_table().items()]
    except RigBusy:
        raise
    except RigError as error:
        return [DeviceAnswer(key, trouble=str(error)) for key in drivers_of(line)]


def _answer(key: str, device: Identifiable) -> DeviceAnswer:
    remark = why_unstoppable(device, key.removeprefix("axes.")) if key.startswith("axes.") else ""
    try:
        return DeviceAnswer(key, device.identify(), remark=remark)
    except RigError as error:
        return DeviceAnswer(key, trouble=str(error))


def _judged(answer: DeviceAnswer, expected_of: dict[str, str]) -> DeviceAnswer:
    try:
        require_expected(expected_of, {answer.key: answer.identity} if answer.identity else {})
    except RequestRefused as stranger:
        return replace(answer, trouble=str(stranger))
    return answer


def stable_paths(by_id: Path) -> dict[str, str]:
    """Return the link under ``by_id`` of each device path; empty where the system keeps none."""
    if not by_id.is_dir():
        return {}
    return {str(link.resolve()): str(link) for link in sorted(by_id.iterdir())}


def visa_resources(library: str = "") -> list[str] | None:
    """Return the names of the instruments a VISA library knows; None when there is no VISA here.

    Nothing is opened.
    """
    try:
        manager = open_manager(library, "visa")
    except RequestRefused:
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # pyvisa-py warns of each optional package that it would also search with
            return sorted(manager.list_resources("?*"))
    finally:
        manager.close()


def _known(text: str | None) -> str:
    return "" if text in (None, "n/a") else str(text)
