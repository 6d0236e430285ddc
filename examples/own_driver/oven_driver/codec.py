"""The words on the wire: bytes to values and back, no port and no device.

The oven is made up. 9600 baud, lines end with CR LF, and every reply repeats its question's word:

| question       | reply                    |                                        |
|----------------|--------------------------|----------------------------------------|
| ``ID?``        | ``ID OVEN-3 SN 17``      | who it is                              |
| ``TEMP?``      | ``TEMP +023.45``         | the air, °C, two decimals              |
| ``SET?``       | ``SET +025.00``          | the setpoint                           |
| ``SET +030.00``| ``SET +030.00``          | takes a setpoint; ``ERR 2`` refuses it |
"""

import re

from rig.errors import DeviceNonsense, DeviceRefused

HUNDREDTHS = 100
DEGC = re.compile(rb"(?P<word>TEMP|SET) (?P<degc>[+-]\d{3}\.\d{2})")
_IDENTITY = re.compile(rb"ID (?P<name>OVEN-\d+ SN \d+)")


def read_degc(name: str, word: str, reply: bytes) -> float:
    """Return the number of a whole line, or nothing: a number picked out of a damaged line is a wrong number."""
    if reply.startswith(b"ERR "):
        raise DeviceRefused(f"{name}: the oven refused it: {reply!r}; nothing was changed; see its manual for the code")
    line = DEGC.fullmatch(reply)
    if line is None or line["word"] != word.encode():
        raise DeviceNonsense(f"need {word} and a temperature such as {word} +023.45")
    return float(line["degc"])


def read_identity(reply: bytes) -> str:
    line = _IDENTITY.fullmatch(reply)
    if line is None:
        raise DeviceNonsense("need ID OVEN-n SN n")
    return line["name"].decode("ascii")


def write_degc(word: str, degc: float) -> bytes:
    """Return a word with its temperature, such as ``SET +030.00``."""
    return b"%s %+07.2f" % (word.encode(), degc)
