"""A rig's twins on real ports: what ``calrig simulate`` serves and how a rig file names it."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType

from rig.abilities.abilities import WriteFile
from rig.assembly.faulty_lines import with_faults
from rig.clock import WAIT_SLICE_S, Clock
from rig.description.drivers import TABLES
from rig.description.fault_plan import FaultPlan
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.description.twin_truth import TwinSection
from rig.drivers.twin_lines import twin_lines
from rig.errors import DescriptionError
from rig.twins.physics.world import World
from rig.twins.serving.control import ControlTwin
from rig.twins.serving.ports import Port, PtyPort, TcpPort
from rig.twins.serving.servers import TwinServer

CONTROL = "twin"
"""The key of the control address."""


class SimulatedRig:
    """Twins that are being served. A context manager."""

    def __init__(self, addresses: Mapping[str, str], world: World, server: TwinServer) -> None:
        self.addresses = dict(addresses)
        """By table of the rig file (``axes.pitch``), and ``twin`` for the control address."""
        self.world = world
        self._server = server

    @property
    def is_serving(self) -> bool:
        return self._server.is_serving

    def close(self) -> None:
        """Stop serving. Raises what a twin raised while it served."""
        self._server.close()

    def __enter__(self) -> "SimulatedRig":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def serve_rig(
    description: RigDescription,
    clock: Clock,
    *,
    pty: bool = False,
    links: Path | None = None,
    faults: FaultPlan | None = None,
    tell: Callable[[str], None] = lambda _sentence: None,
) -> SimulatedRig:
    """Serve the twin of every device of the description, wherever the file says it is.

    ``clock`` is the twins' own; ``pty`` takes pseudo-terminals for the devices (the control address is always TCP),
    and ``links`` a folder of stable names for them, as ``/dev/serial/by-id`` is. ``faults`` go wrong; ``tell`` hears
    of each.
    """
    world = World(description.all_on_twins())
    addresses: dict[str, str] = {}
    ports: list[Port] = []
    lines = twin_lines(description.all_on_twins(), world, clock.slice_s / WAIT_SLICE_S)
    for line in lines if faults is None else with_faults(lines, faults, world, clock.monotonic_s(), tell):
        link = None if links is None else links / line.keys[0]
        port: Port = PtyPort(line.twin, link) if pty else TcpPort(line.twin)
        ports.append(port)
        addresses |= dict.fromkeys(line.keys, line.address.format(port=port.address))
    ports.append(TcpPort(ControlTwin(world)))
    addresses[CONTROL] = ports[-1].address
    return SimulatedRig(addresses, world, TwinServer(ports, clock))


def at_addresses(description: RigDescription, addresses: Mapping[str, str], time: float) -> RigDescription:
    """Return the rig with the twins at ``addresses`` in place of its ports; ``time``: rig seconds in a second there."""
    changed: dict[str, dict[str, object]] = {table: dict(getattr(description, table)) for table in TABLES}
    for key, address in addresses.items():
        if key == CONTROL:
            continue
        table, _, name = key.partition(".")
        device = getattr(description, table)[name]
        keys_of_address = {"port": address, "resource": address, "scanner_resource": None}
        keys = {key: value for key, value in keys_of_address.items() if key in type(device).model_fields}
        changed[table][name] = device.model_copy(update=keys)
    twin = (description.twin or TwinSection()).model_copy(update={"control": addresses[CONTROL], "time": time})
    return description.model_copy(update={**changed, "twin": twin})


def write_rig(
    original: Path,
    addresses: Mapping[str, str],
    time: float | str,
    target: Path,
    write: WriteFile = Path.write_bytes,
) -> RigDescription:
    """Write the rig file with ``addresses`` in place of its ports and ``time`` (``real`` or a factor) in ``[twin]``.

    Everything else stays as its author wrote it. Returns the written file, read again.
    Raises: DescriptionError where the file is wrong or writes its ports in a way that cannot be edited line by line.
    """
    description = read_rig(original)
    text = original.read_text(encoding="utf-8-sig")
    for key, address in addresses.items():
        if key != CONTROL:
            text = _with_address(text, key, address, original)
    if any("scanner_resource" in getattr(readout, "model_fields_set", ()) for readout in description.readouts.values()):
        text = re.sub(r"(?m)^\s*scanner_resource\s*=.*\n", "", text)
    text = _with_twin(text, addresses[CONTROL], time)
    write(target, text.encode("utf-8"))
    return read_rig(target)


def _with_address(text: str, key: str, address: str, original: Path) -> str:
    """Return the text with ``port`` or ``resource`` of the table ``key`` replaced."""
    found = _table(text, key)
    if found is not None:
        body, count = re.subn(
            r'(?m)^(\s*(?:port|resource)\s*=\s*)("[^"\n]*"|\'[^\'\n]*\')',
            rf'\g<1>"{address}"',
            found.group("body"),
            count=1,
        )
        if count:
            return text[: found.start("body")] + body + text[found.end("body") :]
    raise DescriptionError(
        f"{original}: {key}: its port cannot be replaced; write it as a line of its own under [{key}];"
        " nothing was written"
    )


def _with_twin(text: str, control: str, time: float | str) -> str:
    lines = f'control = "{control}"\ntime = {f"{time:g}" if isinstance(time, float) else f"{chr(34)}{time}{chr(34)}"}\n'
    found = _table(text, "twin")
    if found is None:
        return f"{text.rstrip()}\n\n[twin]\n{lines}"
    kept = re.sub(r"(?m)^\s*(?:control|time)\s*=.*\n?", "", found.group("body"))
    return text[: found.start("body")] + lines + kept + text[found.end("body") :]


def _table(text: str, key: str) -> re.Match[str] | None:
    """Return the lines of a table from its header to the next header."""
    name = r"\s*\.\s*".join(rf"""["']?{re.escape(part)}["']?""" for part in key.split(".", 1))
    return re.search(rf"(?m)^\s*\[\s*{name}\s*\][^\n]*\n(?P<body>(?:(?!\s*\[)[^\n]*\n?)*)", text)
