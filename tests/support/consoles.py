"""A console that is served, in a process of its own as people start it, over folders of runs made for it."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO
from urllib.parse import urlsplit

_LINK = re.compile(r"http://\S+")


@dataclass
class ServedConsole:
    """Where it listens, and the links that it tells."""

    process: subprocess.Popen[str]
    output: IO[str]
    _unused: str = ""

    @property
    def address(self) -> str:
        """Where it is; the link that says so is kept for whoever enters by it."""
        self._unused = self.link()
        return "http://" + urlsplit(self._unused).netloc

    def link(self) -> str:
        """Return the next link; each opens one browser."""
        if self._unused:
            link, self._unused = self._unused, ""
            return link
        for line in self.output:
            if found := _LINK.search(line):
                return found[0]
        raise AssertionError("the console ended before it told a link")


@contextmanager
def served_console(runs: Path, archive: Path, files: Path | None = None) -> Iterator[ServedConsole]:
    """Serve until the end of the block."""
    words = ["console", "--listen", "127.0.0.1:0", "--out", str(runs), "--archive", f"sqlite:///{archive}"]
    words += ["--files", str(files or runs)]
    command = [sys.executable, "-m", "procedures.cli.main", *words]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "TZ": "Europe/Berlin"}
    process = subprocess.Popen(command, stderr=subprocess.PIPE, encoding="utf-8", env=environment)
    assert process.stderr is not None
    try:
        yield ServedConsole(process, process.stderr)
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(10)
        process.stderr.close()
