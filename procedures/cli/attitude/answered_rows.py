"""How rows become answers: of a file, answered again where its rows prove something of earlier ones, or of a stream."""

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from shutil import copyfileobj
from tempfile import SpooledTemporaryFile
from typing import IO, Final, cast

from rich.console import Console
from threadpoolctl import threadpool_limits

from ams.inference.rows.angle_stream import AngleStream
from ams.inputs.hdf5_blocks import blocks_of
from ams.whole_file import whole_file
from procedures.cli.attitude.lines import is_line, opened_source, opened_target
from procedures.cli.attitude.plot import PlottedRows
from procedures.cli.attitude.rig_stream import StreamWiring, opened_stream
from procedures.cli.attitude.rows import JsonRows, Rows, RowWriter, writer_named
from procedures.cli.attitude.source import REMEDIES
from procedures.cli.attitude.stream import WriterOf, answer_blocks, answer_stream
from procedures.cli.attitude.tally import TalliedRows
from procedures.cli.attitude.view import ViewedRows
from procedures.errors import RequestError
from rig.clock import SystemClock

_IN_MEMORY_BYTES: Final = 1 << 26
"""Of answers for standard output that wait until the last row is read; more wait on the disk."""


@dataclass(frozen=True)
class Answers:
    """Where answers go: a file, datagrams, standard output, and the screen."""

    out: str | None
    view: bool
    plot: Path | None
    sensor: str

    def writer(self, columns: Sequence[str], file: IO[bytes] | None) -> RowWriter:
        """Return what takes the answers; ``file`` None: they are shown and not written."""
        taken: RowWriter | None = None
        if file is not None:
            taken = JsonRows(file, columns) if is_sent(self.out) else writer_named(path_of(self.out), file, columns)
            taken = taken if self.view else TalliedRows(self.sensor, taken)
        if self.view:
            taken = ViewedRows(self.sensor, Console(), SystemClock(), taken)
        assert taken is not None
        return taken if self.plot is None else PlottedRows(self.sensor, self.plot, taken)


def answer_all(
    found: AngleStream,
    again: Iterable[AngleStream],
    data: str | None,
    wiring: StreamWiring | None,
    for_s: float | None,
    answers: Answers,
) -> bool:
    """Answer every row of where rows come from: a rig's stream, standard input, a socket or a file.

    ``again``: what the rows of a file are to be answered with instead, each asked for after the last row of the one
    before. Return whether every row was answered with what all of them prove, as those of a file are.
    """
    if wiring is not None:
        _require_channels(found, wiring)
        with opened_stream(wiring, for_s) as blocks:
            _answer_stream(lambda writer_of: answer_blocks(found, writer_of, blocks), answers)
    elif data is None or data == "-":
        _answer_stream(lambda writer_of: answer_stream(found, writer_of, sys.stdin.buffer), answers)
    elif is_line(data):
        with opened_source(data) as source:
            _answer_stream(lambda writer_of: answer_stream(found, writer_of, source), answers)
    elif answers.view:
        raise RequestError(
            "--view: shows rows as they arrive: DATA is then -, socket://… or udp://…, or --rig and --stream are given;"
            " nothing was read"
        )
    else:
        return _answer_file(found, again, Path(data), answers)
    return False


def _require_channels(found: AngleStream, wiring: StreamWiring) -> None:
    """Refuse what the angles need and no channel tells. Raises: RequestError."""
    missing = [name for name in found.needed if name not in wiring.units]
    if missing:
        raise RequestError(
            f"{wiring.rig}: the set needs {', '.join(missing)}, which the stream {wiring.name} does not tell; nothing "
            "was opened"
        )


def _answer_stream(answering: Callable[[WriterOf], None], answers: Answers) -> None:
    """Block by block, into a file as well: what was answered stays when the stream breaks."""
    with one_thread():
        out = answers.out
        if out is None:
            to = None if answers.view else sys.stdout.buffer
            answering(lambda columns: (answers.writer(columns, to), to or BytesIO()))
        elif is_sent(out):
            with opened_target(out) as target:
                answering(lambda columns: (answers.writer(columns, target), target))
        elif out.endswith(".parquet"):
            raise RequestError(f"--out {out}: a stream is written as .csv or .jsonl; nothing was written")
        else:
            with Path(out).open("wb") as file:
                answering(lambda columns: (answers.writer(columns, file), file))


def one_thread() -> threadpool_limits:
    """Keep the linear algebra to one thread: its blocks are small, and beside other work two wait for each other.

    On a busy machine of two cores that made it five times as long.
    """
    return threadpool_limits(limits=1, user_api="blas")


def _answer_file(found: AngleStream, again: Iterable[AngleStream], data: Path, answers: Answers) -> bool:
    """Answer a file piece by piece; nothing is written where one of them is wrong.

    Where its rows prove something of earlier ones it is read and answered again; return whether that could be done.
    """
    with _output(answers.out) as target, one_thread():
        writer = _written(found, data, answers, target)
        is_flagged_throughout = data.is_file() and not is_sent(answers.out)
        for better in again if is_flagged_throughout else ():
            writer.discard()
            target.seek(0)
            target.truncate()
            writer = _written(better, data, answers, target)
        writer.close()
    return is_flagged_throughout


def _written(found: AngleStream, data: Path, answers: Answers, target: IO[bytes]) -> RowWriter:
    """Write every row of a file; what took them is still to be closed."""
    writer = answers.writer(found.answers, target)
    for readings in blocks_of(data, found.needed, found.optional, REMEDIES):
        writer.write(Rows.of(found.answer(readings)))
        if is_sent(answers.out):
            target.flush()
    writer.write(Rows.of(found.finish()))
    return writer


def is_sent(out: str | None) -> bool:
    """Return whether answers go out in datagrams."""
    return out is not None and is_line(out)


def path_of(out: str | None) -> Path | None:
    """Return the file that is named, None for standard output."""
    return None if out is None else Path(out)


@contextmanager
def _output(out: str | None) -> Iterator[IO[bytes]]:
    """Yield what becomes the file, or goes to standard output, when all is written."""
    if out is not None and is_line(out):
        with opened_target(out) as target:
            yield target
        return
    if out is not None:
        with whole_file(Path(out)) as file:
            yield file
        return
    with SpooledTemporaryFile(max_size=_IN_MEMORY_BYTES) as memory:
        yield cast(IO[bytes], memory)
        memory.seek(0)
        copyfileobj(memory, sys.stdout.buffer)
        sys.stdout.buffer.flush()
