"""Laws of a stream that keeps nobody waiting: in order while it is taken, the newest once it is taken again."""

import os
import sys
from contextlib import suppress

import pytest

from procedures.run.unhindered import Unhindered

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there the stream is written to at once")
LINES = [f"dwell {number} of 3000, {'.' * 80}\n" for number in range(3000)]


def test_what_is_taken_comes_whole_and_in_order() -> None:
    reader, writer = os.pipe()
    with os.fdopen(writer, "w") as stream:
        stream.write("before\n")
        unhindered = Unhindered(stream)
        for line in LINES[:40]:
            unhindered.write(line)
            unhindered.flush()
    assert os.read(reader, 65_536).decode() == "before\n" + "".join(LINES[:40])
    os.close(reader)


def test_a_stream_that_is_held_keeps_nobody_waiting_and_gets_the_newest_when_it_is_let_go() -> None:
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    with suppress(BlockingIOError):
        while True:
            os.write(writer, b"#" * 512)
    os.set_blocking(writer, True)
    unhindered = Unhindered(os.fdopen(writer, "w"))
    for line in LINES:
        unhindered.write(line)
        unhindered.flush()
    seen = b""
    while not seen.endswith(LINES[-1].encode()):
        seen += os.read(reader, 65_536)
    assert len(seen) < 65_536 + 2 * 65_536 + 512
    os.close(reader)


def test_a_stream_that_is_gone_raises_nothing() -> None:
    reader, writer = os.pipe()
    unhindered = Unhindered(os.fdopen(writer, "w"))
    os.close(reader)
    for line in LINES[:40]:
        unhindered.write(line)
        unhindered.flush()
