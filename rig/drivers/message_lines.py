"""How an instrument that talks in messages is reached: on a GPIB, or on a line of its own."""

from rig.lines.open_lines import Lines
from rig.link.gpib import is_on_a_bus, parse_resource
from rig.link.messages import GpibMessages, MessageLine, StreamMessages


def message_line(
    key: str,
    resource: str,
    lines: Lines,
    default_address: int,
    *,
    baud_rate: int = 9600,
    parity: str = "N",
    data_bits: int = 8,
    stop_bits: float = 1.0,
) -> MessageLine:
    """Return the line to the instrument at ``key``; what follows the address is for a serial line.

    Raises: LinkLost, RigBusy, RequestRefused, DeviceSilent, DeviceNonsense.
    """
    if is_on_a_bus(resource):
        parsed = parse_resource(resource, default_address)
        return GpibMessages(lines.bus(key, parsed), parsed.address)
    stream = lines.stream(key, resource, baud_rate, parity=parity, data_bits=data_bits, stop_bits=stop_bits)
    return StreamMessages(stream)
