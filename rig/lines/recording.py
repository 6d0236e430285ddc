"""Lines that are kept while they talk, and rigs that are replayed from what was kept: one transcript a line.

Both are line sources for :func:`rig.assembly.open_rig.open_rig`.
"""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from rig.clock import Clock
from rig.errors import DescriptionError
from rig.link.byte_stream import ByteStream
from rig.link.transcript import Player, Recorder, read_transcript

LineSource = Callable[[str, Callable[[], ByteStream]], ByteStream]
"""Asked for every line by its key (``axes.pitch``) and how to open it."""


def recording(folder: Path, files: ExitStack) -> LineSource:
    """Open every line and keep what is said on it in ``folder``; the files close with ``files``."""
    folder.mkdir(parents=True, exist_ok=True)

    def source(key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        file = files.enter_context(_transcript(folder, key).open("w", encoding="utf-8"))
        return Recorder(open_line(), lambda line: file.write(f"{line}\n"))

    return source


def replaying(folder: Path, clock: Clock) -> LineSource:
    """Open nothing: every line answers from its transcript in ``folder``, and says where the conversation departs."""

    def source(key: str, _open_line: Callable[[], ByteStream]) -> ByteStream:
        path = _transcript(folder, key)
        if not path.exists():
            raise DescriptionError(f"{path}: no transcript of {key}; nothing was opened; record the rig first")
        return Player(read_transcript(path), clock, f"transcript of {key}")

    return source


def _transcript(folder: Path, key: str) -> Path:
    return folder / f"{key}.jsonl"
