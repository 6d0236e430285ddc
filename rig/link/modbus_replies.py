"""What a Modbus reply means, whatever carried it: a busy slave is asked again, an exception says who must act."""

from collections.abc import Callable

from pymodbus.pdu import ModbusPDU

from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, LinkLost, NoSuchRegister, RigError
from rig.link.byte_stream import ByteStream

_BUSY = (5, 6)
_BUSY_ATTEMPTS, _BUSY_S = 5, 0.2
_EXCEPTIONS: dict[int, tuple[type[RigError], str]] = {
    1: (DeviceRefused, "illegal function"),
    2: (NoSuchRegister, "illegal register address"),
    3: (DeviceRefused, "illegal value"),
    4: (DeviceFault, "device failure"),
    5: (DeviceRefused, "acknowledged, still busy"),
    6: (DeviceRefused, "busy"),
    8: (DeviceFault, "memory parity error"),
    10: (LinkLost, "gateway path unavailable"),
    11: (LinkLost, "gateway target silent"),
}


def granted(ask: Callable[[ModbusPDU], ModbusPDU], request: ModbusPDU, stream: ByteStream) -> ModbusPDU:
    """Return the reply to ``request`` that is no exception.

    Raises: NoSuchRegister, DeviceRefused, DeviceFault, LinkLost or DeviceNonsense by the exception's code, and what
    ``ask`` raises.
    """
    for _ in range(_BUSY_ATTEMPTS):
        reply = ask(request)
        if not (reply.isError() and reply.exception_code in _BUSY):
            break
        stream.clock.sleep(_BUSY_S)
    if reply.isError():
        kind, text = _EXCEPTIONS.get(reply.exception_code, (DeviceNonsense, "unknown exception"))
        raise kind(
            f"{stream.name}: unit {request.dev_id} answered exception {reply.exception_code} ({text}) to"
            f" {in_words(request)}; nothing was changed; compare the request with the device's manual"
        )
    return reply


def in_words(request: ModbusPDU) -> str:
    """Return a request in words, for messages."""
    return f"function {request.function_code}, register {request.address}"
