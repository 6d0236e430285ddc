"""What is connected to this machine: serial ports by their stable names, and VISA resources where there is a VISA."""

import warnings
from dataclasses import dataclass
from pathlib import Path

from rig.errors import RequestRefused

BY_ID = Path("/dev/serial/by-id")


@dataclass(frozen=True, slots=True)
class SerialPort:
    """One serial port. ``stable_path`` names the adapter, not the order of plugging; it is the one for a rig file."""

    path: str
    stable_path: str
    description: str
    hardware: str
    """USB vendor, product and serial number as the system prints them; empty where it knows none."""


def serial_ports(by_id: Path = BY_ID) -> list[SerialPort]:
    """All serial ports, in the order of their paths. Nothing is opened."""
    from serial.tools.list_ports import comports

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


def stable_paths(by_id: Path) -> dict[str, str]:
    """Device path to its link under ``by_id``; empty where the system keeps none."""
    if not by_id.is_dir():
        return {}
    return {str(link.resolve()): str(link) for link in sorted(by_id.iterdir())}


def visa_resources(library: str = "") -> list[str] | None:
    """Names of the instruments a VISA library knows; None when there is no VISA here. Nothing is opened."""
    from rig.link.visa import open_manager

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
