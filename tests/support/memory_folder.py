"""Temporary files in memory: most of a run's seconds are the disk's, which no law is about."""

import os
import shutil
import tempfile
from pathlib import Path

IN_MEMORY = Path("/dev/shm")
LEAST_FREE_BYTES = 4 * 2**30


def keep_temporary_files_in_memory() -> None:
    """Use the memory's file system for this process and its children, unless the user names a folder in ``TMPDIR``."""
    if "TMPDIR" in os.environ or not IN_MEMORY.is_dir() or not os.access(IN_MEMORY, os.W_OK):
        return
    runs_programs = not os.statvfs(IN_MEMORY).f_flag & getattr(os, "ST_NOEXEC", 0)  # some tests compile one and run it
    if runs_programs and shutil.disk_usage(IN_MEMORY).free >= LEAST_FREE_BYTES:
        os.environ["TMPDIR"] = str(IN_MEMORY)
        tempfile.tempdir = None  # it was looked up already
