"""calrig's own log: what was called, how it ended, and what its runs told, a line each; never in the way of a run.

It is no record: that is the journal's chain of hashes. Lines are handed to a thread of their own; what does not fit
into its queue, or cannot be written, is lost without a word. No secret gets in: of an address only its beginning is
kept.
"""

import json
import logging
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from functools import partial
from io import TextIOWrapper
from logging.handlers import QueueHandler, QueueListener, RotatingFileHandler
from pathlib import Path
from queue import Full, Queue
from typing import TypeVar

from platformdirs import user_log_path

from procedures.errors import RequestError
from procedures.records.progress import Progress, RunObserver, line_of
from rig.plain_text import one_line
from rig.threads import begun

FILE, FORM, LEVEL = "CALRIG_LOG", "CALRIG_LOG_FORMAT", "CALRIG_LOG_LEVEL"
"""Environment variables: a file or ``off``; ``text`` or ``json``; ``debug``, ``info``, ``warning`` or ``error``."""
LARGEST_BYTES, KEPT_FILES = 1_000_000, 5
MOST_WAITING = 1000
"""Lines that the writing thread may be behind."""
CLOSING_S = 1.0
"""Seconds that the end of a command waits for a disk that hangs."""
LEVELS = {"info": logging.INFO, "debug": logging.DEBUG, "warning": logging.WARNING, "error": logging.ERROR}
T = TypeVar("T")
_LOG = logging.getLogger("calrig")
_ADDRESS = re.compile(r"\b(?!(?:sqlite|file|socket|rfc2217|loop|spy)://)([A-Za-z][\w+.-]*://)[^\s'\",;]+")
_LOGIN = re.compile(r"://[^\s/@'\"]+@")


def log_path(environment: Mapping[str, str] = os.environ) -> Path | None:
    """Return the file of the log; None where it is off."""
    given = environment.get(FILE, "")
    if given.lower() == "off":
        return None
    return Path(given) if given else user_log_path("calrig", appauthor=False) / "calrig.log"


@contextmanager
def logged(arguments: Sequence[str], environment: Mapping[str, str] = os.environ) -> Iterator[None]:
    """Write a log while a command is at work. Raises: RequestError for a setting that is none."""
    listener = _begun(environment)
    if listener is None:
        yield
        return
    tell("command", " ".join(("calrig", *arguments)))
    try:
        yield
    finally:
        _LOG.propagate = True
        for handler in _queued_handlers():
            _LOG.removeHandler(handler)
            handler.close()
        with suppress(MemoryError):  # the words of the command are worth more
            begun(partial(_closed, listener), "the end of the log").join(CLOSING_S)


def tell(what: str, message: str, level: str = "info") -> None:
    """Put one line into the log, addresses cut off; nothing where there is no log."""
    if _queued_handlers():
        _LOG.log(LEVELS[level], "%s", without_addresses(message), extra={"what": what})


class LoggedObserver:
    """Puts what a run tells into the log, then tells it on: dwells for those who ask for ``debug``."""

    def __init__(self, run: str, then: RunObserver) -> None:
        self._run = run
        self._then = then

    def on_event(self, progress: Progress) -> None:
        level = "debug" if progress.event in ("dwell", "check", "soak") else "info"
        tell("run", f"{self._run}: {progress.event}: {line_of(progress)}", level)
        self._then.on_event(progress)


def without_addresses(text: str) -> str:
    """Return the text with every address cut behind its ``scheme://``; those of files and ports lose their login."""
    return _LOGIN.sub("://…@", _ADDRESS.sub(r"\1…", text))


def _begun(environment: Mapping[str, str]) -> QueueListener | None:
    path = log_path(environment)
    if path is None or _queued_handlers():  # off, or a command inside a command
        return None
    form, level = _setting(environment, FORM, FORMS), _setting(environment, LEVEL, LEVELS)
    file = _QuietFile(
        path, maxBytes=LARGEST_BYTES, backupCount=KEPT_FILES, encoding="utf-8", errors="replace", delay=True
    )
    file.setFormatter(form())
    lines: Queue[logging.LogRecord] = Queue(MOST_WAITING)
    listener = _Listener(lines, file)
    try:
        listener.start()
    except MemoryError:  # the words of the command are worth more
        return None
    _LOG.setLevel(level)
    _LOG.propagate = False
    _LOG.addHandler(_QueuedHandler(lines))
    return listener


def _setting(environment: Mapping[str, str], name: str, allowed: Mapping[str, T]) -> T:
    """Return what a variable says, the first of what is allowed where it is not set. Raises: RequestError."""
    given = environment.get(name, "").lower() or next(iter(allowed))
    if given not in allowed:
        raise RequestError(
            f"{name}: got {one_line(given)!r}, allowed are {', '.join(allowed)}; nothing was done; correct the variable"
        )
    return allowed[given]


def _queued_handlers() -> list[logging.Handler]:
    return [handler for handler in _LOG.handlers if isinstance(handler, _QueuedHandler)]


def _closed(listener: QueueListener) -> None:
    with suppress(OSError, Full):
        listener.stop()
        for file in listener.handlers:
            file.close()


class _Listener(QueueListener):
    """Writes in a thread that is known to have begun."""

    def start(self) -> None:
        """Begin. Raises: MemoryError where no thread can be had."""
        self._writer = begun(self._write, "the log")

    def stop(self) -> None:
        self.enqueue_sentinel()
        self._writer.join()

    def _write(self) -> None:
        while (line := self.dequeue(block=True)) is not None:
            self.handle(line)


class _QueuedHandler(QueueHandler):
    """Hands a line to the writing thread, which is never waited for."""

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802  logging's name
        """Say nothing: the queue is full."""


class _QuietFile(RotatingFileHandler):
    """A file that loses a line where it cannot be opened, written or turned over; the writing thread opens it."""

    def _open(self) -> TextIOWrapper:
        Path(self.baseFilename).parent.mkdir(parents=True, exist_ok=True)
        return super()._open()

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802  logging's name
        """Say nothing: the screen belongs to the command."""


def _utc(record: logging.LogRecord) -> str:
    return datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")


class _Text(logging.Formatter):
    """One line for a person."""

    def format(self, record: logging.LogRecord) -> str:
        what = getattr(record, "what", record.name)
        return f"{_utc(record)} {record.levelname.lower()} {record.process} {what}: {one_line(record.getMessage())}"


class _JsonLines(logging.Formatter):
    """One JSON object a line for a program."""

    def format(self, record: logging.LogRecord) -> str:
        document = {
            "utc": _utc(record),
            "level": record.levelname.lower(),
            "process": record.process,
            "what": getattr(record, "what", record.name),
            "message": record.getMessage(),
        }
        return json.dumps(document, ensure_ascii=False)


FORMS: Mapping[str, type[logging.Formatter]] = {"text": _Text, "json": _JsonLines}
