"""Ports of a rig file: whether they can be opened at all, and whether devices that share one can talk on it.

Asked of files alone: a run that was stored with such a port stays one.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from rig.description.device_settings import TWIN_PORT
from rig.description.rig_file import RigDescription
from rig.errors import DescriptionError, RequestRefused
from rig.link.gpib import is_on_a_bus, parse_resource, port_of
from rig.link.port_address import OVER_TCP, address_complaint, canonical_port
from rig.link.terminal_stream import TERMINAL
from rig.toml_file import TomlFile

LINE_KEYS: Final[Mapping[str, object]] = {
    "baud_rate": None, "data_bits": 8, "parity": "N", "stop_bits": 1, "rts_cts": False, "dtr_low": False,
    "rts_low": False, "dialect": None,
}  # fmt: skip
"""What all devices of one line must agree on, with what holds where a device has no such key."""


@dataclass(frozen=True)
class _User:
    """A device at a real port."""

    key: tuple[str, ...]
    port: str
    protocol: str
    device: object
    unit: int | None
    """On a Modbus line."""

    @property
    def name(self) -> str:
        return ".".join(self.key[:2])


def unusable_ports(file: TomlFile, rig: RigDescription) -> Iterator[str]:
    """Yield addresses by which nothing can be reached, and devices that cannot share the port of another one."""
    first: dict[str, _User] = {}
    for user in _users(rig):
        if user.port in (TWIN_PORT, TERMINAL):
            continue
        if complaint := address_complaint(user.port):
            yield file.complaint(user.key, complaint)
        else:
            other = first.setdefault(canonical_port(user.port), user)
            if difference := "" if other is user else _difference(user, other):
                yield file.complaint(user.key, f"{user.port} is already the port of {other.name}; {difference}")
    control = None if rig.twin is None else rig.twin.control
    if control is not None and (complaint := address_complaint(control)):
        yield file.complaint(("twin", "control"), complaint)


def _difference(user: _User, other: _User) -> str:
    """Return why two devices cannot be on one line; empty where they can."""
    if user.protocol != other.protocol:
        return (
            f"one line has one protocol: {other.protocol} there, {user.protocol} here; give each device the port that "
            "it is plugged into"
        )
    if user.unit is not None and user.unit == other.unit and user.key[0] != other.key[0]:
        return f"both are unit {user.unit} on it; give each device the number that is set at it"
    keys = ("dialect",) if user.port.startswith(OVER_TCP[0]) else tuple(LINE_KEYS)
    for key in keys:
        try:
            here, there = (getattr(each.device, key, LINE_KEYS[key]) for each in (user, other))
        except DescriptionError:
            return ""  # of a dialect that cannot be read, which is told already
        if here != there:
            return (
                f"one line has one setting: {key} = {there} there, {here} here; set both devices alike and correct the "
                "key, or give each its port"
            )
    return ""


def _users(rig: RigDescription) -> Iterator[_User]:
    tables: tuple[tuple[str, Mapping[str, object]], ...] = (
        ("axes", rig.axes), ("environment", rig.environment), ("streams", rig.streams), ("field", rig.field),
    )  # fmt: skip
    for table, devices in tables:
        for name, device in devices.items():
            yield _user((table, name, "port"), str(getattr(device, "port", TWIN_PORT)), device)
    for name, readout in rig.readouts.items():
        for key in ("resource", "scanner_resource"):
            resource = getattr(readout, key, None)
            if resource is not None:
                yield from _user_of_resource((key, name), resource, readout)


def _user_of_resource(where: tuple[str, str], resource: str, readout: object) -> Iterator[_User]:
    """Yield the adapter behind an instrument's address, or the instrument; a board that VISA knows is no port."""
    key, name = where
    try:
        is_on_bus = is_on_a_bus(resource)
        if is_on_bus and parse_resource(resource, 0).carrier == "visa":
            return
        port = port_of(resource)
    except RequestRefused:
        return  # told already
    if is_on_bus:
        yield _User(("readouts", name, key), port, "a Prologix adapter", None, None)
    elif "scanner_resource" not in type(readout).model_fields:  # type: ignore[attr-defined]
        yield _user(("readouts", name, key), port, readout)


def _user(key: tuple[str, ...], port: str, device: object) -> _User:
    transport, unit = getattr(device, "modbus", (None, None))
    protocol = f"driver {getattr(device, 'driver', '')!r}" if transport is None else f"Modbus {transport.upper()}"
    return _User(key, port, protocol, device, unit)
