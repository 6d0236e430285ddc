"""Lines of Zaber's ASCII protocol: ``/device axis id command:checksum`` and three kinds of answers.

``@`` is the reply to a command and repeats its id; ``#`` (info) and ``!`` (alert) may come at any time and belong to
no question. The checksum is the two's complement of the low byte of the sum of everything after the lead character.

Source: Zaber ASCII protocol as its open libraries speak it; ``/1 0 00 get pos:2D`` as zaber-motion 10.2.0 sends it.
"""

import re
from dataclasses import dataclass

TERMINATOR = b"\r\n"
IDS = 100
NO_WARNING = "--"
UNREFERENCED = frozenset({"WR", "WH"})
"""The position is counted from where power came on: not homed."""
INTERRUPTED = "NI"

_REPLY = re.compile(r"@(\d\d) (\d) (?:(\d\d) )?(OK|RJ) (IDLE|BUSY) (--|[A-Z][A-Z0-9]) ([!-~](?:[ -~]*[!-~])?)")
_COMMAND = re.compile(r"/ *(?:(\d{1,2})(?: +(\d)(?: +(\d{1,2}))?)?(?: +|$))?([A-Za-z][ -~]*)?")
_CHECKSUM = re.compile(rb"(.*):([0-9A-Fa-f]{2})", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Command:
    """``text`` empty only asks for the status."""

    device: int
    axis: int
    text: str
    message_id: int | None = None
    has_checksum: bool = True


@dataclass(frozen=True, slots=True)
class Reply:
    device: int
    axis: int
    is_accepted: bool
    is_busy: bool
    warning: str
    data: str
    message_id: int | None = None
    has_checksum: bool = True


def checksum(body: bytes) -> bytes:
    """Return two hexadecimal digits for the characters between the lead character and the colon."""
    return b"%02X" % (-sum(body) & 0xFF)


def encode_command(command: Command) -> bytes:
    parts = [str(command.device), str(command.axis)]
    parts += [] if command.message_id is None else [f"{command.message_id:02d}"]
    parts += [command.text] if command.text else []
    return _closed(f"/{' '.join(parts)}", command.has_checksum) + b"\n"


def decode_command(line: bytes) -> Command | None:
    """Decode a whole line without terminator; None for what is none or has a wrong checksum."""
    opened = _opened(line)
    found = None if opened is None else _COMMAND.fullmatch(opened[0].rstrip())
    if opened is None or found is None:
        return None
    device, axis, message_id, text = found.groups()
    return Command(
        int(device or 0),
        int(axis or 0),
        (text or "").strip(),
        None if message_id is None else int(message_id),
        opened[1],
    )


def encode_reply(reply: Reply) -> bytes:
    parts = [f"@{reply.device:02d}", str(reply.axis)]
    parts += [] if reply.message_id is None else [f"{reply.message_id:02d}"]
    parts += ["OK" if reply.is_accepted else "RJ", "BUSY" if reply.is_busy else "IDLE", reply.warning, reply.data]
    return _closed(" ".join(parts), reply.has_checksum) + TERMINATOR


def decode_reply(line: bytes) -> Reply | None:
    """Decode a whole line without terminator; None for what is no reply or has a wrong checksum."""
    opened = _opened(line)
    found = None if opened is None else _REPLY.fullmatch(opened[0])
    if opened is None or found is None:
        return None
    device, axis, message_id, flag, status, warning, data = found.groups()
    return Reply(
        int(device),
        int(axis),
        flag == "OK",
        status == "BUSY",
        warning,
        data,
        None if message_id is None else int(message_id),
        opened[1],
    )


def is_aside(line: bytes) -> bool:
    """Return whether a line is alert or info: said unasked, or after the reply."""
    return line[:1] in (b"!", b"#")


def decode_integer(data: str) -> int | None:
    """Decode a setting such as ``pos``: one whole number."""
    return int(data) if re.fullmatch(r"-?\d{1,10}", data) else None


def _closed(text: str, has_checksum: bool) -> bytes:
    line = text.encode("ascii")
    return line + b":" + checksum(line[1:]) if has_checksum else line


def _opened(line: bytes) -> tuple[str, bool] | None:
    """Return the line without its checksum, and whether it had one.

    None where that is wrong or a byte is none of ASCII.
    """
    found = _CHECKSUM.fullmatch(line)
    if found is not None and checksum(found[1][1:]) != found[2].upper():
        return None
    try:
        return (found[1] if found else line).decode("ascii"), found is not None
    except UnicodeDecodeError:
        return None
