"""What a reply that is none looks like: the cause that its bytes suggest, in words for whoever stands at the rig."""

_TEXT = frozenset(range(32, 127)) | frozenset(b"\r\n\t")
_STRANGE = 0.2
"""The share of bytes that are no text above which none of them is."""


def remedy(sent: bytes, received: bytes, otherwise: str) -> str:
    """Return what to look at, from what was sent and what came; ``otherwise`` where the bytes suggest nothing."""
    if not received:
        return "nothing came at all: check power, address and cable, and that no two cables changed places"
    if sent and received.startswith(sent):
        return "the question itself came back: an echo; switch the local echo of the adapter or of the device off"
    if _is_text(sent) and not _is_text(received):
        return "what came is no text: check baud rate and parity, and that this is the right device"
    return otherwise


def _is_text(data: bytes) -> bool:
    return bool(data) and sum(byte not in _TEXT for byte in data) <= _STRANGE * len(data)
