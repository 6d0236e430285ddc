"""What a command is doing while nothing else shows it: one line that is overwritten, on a terminal alone."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO, cast

from rich.console import Console
from rich.text import Text

from procedures.run.unhindered import Unhindered


@contextmanager
def working(stream: TextIO | None = None) -> Iterator[Callable[[str], None]]:
    """Yield what is told each step; elsewhere than on a terminal it says nothing."""
    stream = sys.stderr if stream is None else stream
    if not stream.isatty():
        yield lambda _step: None
        return
    console = Console(file=cast(TextIO, Unhindered(stream)))
    with console.status(Text("solving"), spinner="line") as status:
        yield lambda step: status.update(Text(step))
