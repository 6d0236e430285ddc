"""Programs of the operating system that a few tests need: skipped with the reason where missing, never in CI."""

import os
import shutil
from pathlib import Path

import pytest


def require_program(name: str, *, also_in: tuple[str, ...] = ()) -> str:
    """Return the path of a program, or skip the test; with ``CALRIG_REQUIRE_PROGRAMS`` set (`.ci/run`) fail it instead.

    Args:
        name: the program as it is called, e.g. ``"mbpoll"``.
        also_in: folders to look in after the search path, e.g. where a database keeps its server programs.
    """
    found = shutil.which(name) or next((str(Path(d) / name) for d in also_in if (Path(d) / name).exists()), None)
    if found:
        return found
    reason = f"needs the program {name}: `.ci/packages` installs it"
    if os.environ.get("CALRIG_REQUIRE_PROGRAMS"):
        pytest.fail(reason)
    pytest.skip(reason)
