"""Write ``calrig.1``, the manual page: what ``--help`` says of every command, set by docutils.

It is committed, because the wheel carries it and its build has no calrig to ask. `make man` renews it; a test compares.
"""

import sys
from itertools import takewhile
from pathlib import Path

from docutils.core import publish_string

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT)]

from procedures.cli.main import GROUPS, make_app  # noqa: E402

PAGE = Path(__file__).with_name("calrig.1")
HEAD = """\
======
calrig
======
------------------------------------
calibrate attitude sensors on a rig
------------------------------------
:Manual section: 1
:Manual group: calrig

SYNOPSIS
========
**calrig** *COMMAND* [*ARGUMENTS*] [*OPTIONS*]

DESCRIPTION
===========
calrig drives an indexing table, a multimeter and a chamber through a designed grid of attitudes, records every reading
of every dwell, solves the calibration with an uncertainty that holds, archives the coefficients and exports them.
**calrig demo** does the whole job on a simulated rig.

Software is not the emergency stop: keep the machine's own stop button within reach.

EXIT STATUS
===========
0
    done
1
    failed
2
    the request or a file is wrong
3
    held, or waiting for a person
4
    aborted by the operator

FILES
=====
*rig.toml*
    what stands in the laboratory
*procedure.toml*
    what is to be done
*runs/RUN*
    a run: its journal, from which everything else can be made again, and what was made of it

"""
_CONTENTS = ".. contents:: Table of Contents\n   :local:\n   :depth: 6\n"


def man_page() -> bytes:
    """Return the page."""
    text = HEAD + "\n".join(
        f"{heading.upper()}\n{'=' * len(heading)}\n\n" + "\n".join(_command(name) for name, _, _ in commands)
        for heading, commands in GROUPS.items()
    )
    settings = {"report_level": 3, "halt_level": 3, "datestamp": None, "strip_comments": True}
    return bytes(publish_string(text, writer="manpage", settings_overrides=settings))


def _command(name: str) -> str:
    """Return what one command says of itself, and of its own commands: a section each, headed by its words."""
    written = make_app(name)[name].generate_docs(output_format="rst", recursive=True)
    parts = written.replace(_CONTENTS, "").split(".. _cyclopts-")[1:]
    return "\n".join(_section(part.partition("::\n\n")[2]) for part in parts)


def _section(part: str) -> str:
    usage, _, text = part.partition("\n")
    words = list(takewhile(lambda word: word.islower() and word.isascii() and word[0].isalpha(), usage.split()))
    title = f"calrig {' '.join(words)}"
    return f"{title}\n{'-' * len(title)}\n**calrig** {_escaped(usage.strip())}\n{text}"


def _escaped(text: str) -> str:
    return text.replace("*", "\\*").replace("|", "\\|")


if __name__ == "__main__":
    PAGE.write_bytes(man_page())
