"""Text files that hold their own checksum: the last line is the SHA-256 of all bytes above it.

Every format of text says the line in its own comment, so that the file stays what its readers expect.
"""

import hashlib
import re
from dataclasses import dataclass

from ams.errors import SetError

INTACT = "the set is not used; take an intact copy, or export the set again"


@dataclass(frozen=True)
class ChecksumLine:
    """How one format begins and ends."""

    kind: str
    """What the format calls itself in messages, such as ``C header``."""
    head: bytes
    """What every file of the format begins with."""
    before: bytes
    """The last line up to the checksum."""
    after: bytes
    """The last line from the checksum on, its line end included."""

    def append_to(self, body: bytes) -> bytes:
        """Return the file: the body, which begins with the head and ends a line, and its last line."""
        return body + self._line(body)

    def checked_body(self, content: bytes, where: str) -> bytes:
        """Return what stands above the last line.

        Raises: SetError for an empty, another, a truncated or a changed file.
        """
        if not content:
            raise SetError(f"{where}: is empty: got 0 bytes; {INTACT}")
        if not content.startswith(self.head):
            first_line = content.split(b"\n")[0][:60]
            raise SetError(
                f"{where}: is not a coefficient set as {self.kind}: its first line is {first_line!r}, "
                f"needed is {self.head.decode().splitlines()[0]}; "
                f"another kind of file, saved again by another program, or damaged; {INTACT}"
            )
        found = re.search(rb"\n(" + re.escape(self.before) + rb"[^\n]*\n)\Z", content)
        if found is None:
            raise SetError(
                f"{where}: is truncated or was saved again by another program: the checksum line is missing "
                f"at the end of its {len(content)} bytes; {INTACT}"
            )
        body = content[: found.start(1)]
        if self._line(body) != found.group(1):
            raise SetError(
                f"{where}: checksum: does not fit the content: changed or damaged after it was written; {INTACT}"
            )
        return body

    def _line(self, body: bytes) -> bytes:
        return self.before + hashlib.sha256(body).hexdigest().encode() + self.after
