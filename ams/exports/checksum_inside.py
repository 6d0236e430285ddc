"""Binary files that hold their own checksum: the SHA-256 of the file with 64 zeros where the checksum stands.

The format keeps a text of fixed length wherever it likes; no reader has to know of it.
"""

import hashlib

from ams.errors import SetError
from ams.exports.checksum_line import INTACT

MARK = b"calrig file sha256:"
CHECKSUM_SLOT = MARK + b"0" * 64


def with_checksum_inside(content: bytes) -> bytes:
    """Return the content, which holds ``CHECKSUM_SLOT`` once, with its checksum in place of the zeros."""
    assert content.count(CHECKSUM_SLOT) == 1, "the format stores the checksum once, as plain bytes"
    return content.replace(CHECKSUM_SLOT, MARK + _sha256(content))


def check_inside(content: bytes, magic: bytes, kind: str, where: str) -> None:
    """Refuse content that is not the file that was written.

    Raises: SetError for an empty file, one of another kind, and one that was changed.
    """
    if not content:
        raise SetError(f"{where}: is empty: got 0 bytes; {INTACT}")
    if not content.startswith(magic):
        raise SetError(
            f"{where}: is not a coefficient set as {kind}: it begins with {content[:8]!r}, needed is {magic!r}; "
            f"it is another kind of file or is damaged; {INTACT}"
        )
    start = content.rfind(MARK) + len(MARK)
    stated, unsealed = content[start : start + 64], content[:start] + b"0" * 64 + content[start + 64 :]
    if MARK not in content or stated != _sha256(unsealed):
        raise SetError(
            f"{where}: checksum: does not fit the {len(content)} bytes of the file: truncated, changed or damaged "
            f"after it was written, or written by another program; {INTACT}"
        )


def check_layout(stated: object, needed: str, where: str) -> None:
    """Refuse numbers that stand in other places than this version knows. Raises: SetError."""
    if stated != needed:
        raise SetError(
            f"{where}: file_format: is of another version: got {stated!r}, this calrig reads {needed!r}; "
            "the set is not used; install the calrig that wrote it"
        )


def _sha256(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()
