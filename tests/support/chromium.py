"""Debian's Chromium, driven by Playwright, wherever the temporary folder lies."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright
from programs import require_program

LONGEST_FOLDER = 60
"""Characters: the profile's socket lies in the temporary folder, and the system refuses a path of more than 107."""
SHORT_FOLDER = "/tmp"


@contextmanager
def chromium(proxy: str | None = None) -> Iterator[Browser]:
    """A browser without a window; its profile is gone with it."""
    program = require_program("chromium")
    with _short_folder(), sync_playwright() as tools:
        way = None if proxy is None else {"server": proxy}
        browser = tools.chromium.launch(executable_path=program, args=["--no-sandbox"], proxy=way)  # type: ignore[arg-type]
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def _short_folder() -> Iterator[None]:
    """Playwright makes the profile where the environment says when it starts."""
    given = os.environ.get("TMPDIR")
    if len(str(Path(tempfile.gettempdir()))) > LONGEST_FOLDER:
        os.environ["TMPDIR"] = SHORT_FOLDER
    try:
        yield
    finally:
        if given is not None:
            os.environ["TMPDIR"] = given
        else:
            os.environ.pop("TMPDIR", None)
