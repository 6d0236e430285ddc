"""Take away what only POSIX systems have, as far as calrig could see it, and put Windows' ways in its place.

A lock is one byte of an open file, and an open file is neither replaced nor deleted.

Called before calrig is imported, in a process of its own. Libraries that have a Windows side of their own, and the
standard library, are imported first and keep what they need.
"""

import errno
import fcntl
import os
import signal
import socket
import sys
import types
from collections.abc import Callable
from contextlib import suppress
from typing import Any

MODULES = ("fcntl", "termios", "tty", "pty", "resource", "pwd", "grp", "curses", "readline", "syslog")
SIGNALS = ("SIGHUP", "SIGQUIT", "SIGTSTP", "SIGTTIN", "SIGTTOU", "SIGKILL", "SIGPIPE", "SIGUSR1", "SIGUSR2")
OF_OS = (
    "getuid",
    "geteuid",
    "getgid",
    "pwrite",
    "pread",
    "openpty",
    "O_DIRECTORY",
    "ttyname",
    "mkfifo",
    "set_blocking",
)
_KEPT_BY_THE_LIBRARIES = (
    "apsw", "asyncio", "getpass", "matplotlib", "multiprocessing.connection", "pandas",
    "platformdirs", "psutil", "pymodbus.client", "rich.console", "scipy.io", "serial.tools.list_ports", "sqlalchemy",
    "subprocess", "tempfile",
)  # fmt: skip


def take_away_posix() -> None:
    """Leave this process what a Windows machine has."""
    for name in _KEPT_BY_THE_LIBRARIES:
        __import__(name)
    sys.modules |= dict.fromkeys(MODULES)  # type: ignore[arg-type]  None: importing it fails
    sys.modules["msvcrt"] = locking_of_windows()
    for name in SIGNALS:
        delattr(signal, name)
    for name in OF_OS:
        delattr(os, name)
    for name in ("AF_UNIX", "send_fds", "recv_fds"):
        delattr(socket, name)
    socket.socketpair = _pair_over_tcp  # type: ignore[assignment]
    keep_open_files()


def keep_open_files() -> None:
    """Refuse from now on what Windows refuses: to replace, rename or delete a file that this process has open."""
    for name in ("replace", "rename", "remove", "unlink"):
        setattr(os, name, _refusing(getattr(os, name)))


def _refusing(act: Callable[..., None]) -> Callable[..., None]:
    def kept(*paths: Any, **options: Any) -> None:
        folder = options.get("dir_fd")
        for path in paths:
            at = os.path.realpath(path if folder is None else f"/proc/self/fd/{folder}/{os.fspath(path)}")
            if _is_open(at):
                raise PermissionError(errno.EACCES, "it is being used by another process (WinError 32)", str(path))
        act(*paths, **options)

    return kept


def _is_open(path: str) -> bool:
    """Whether this process has the file open, or one in the folder."""
    for handle in os.listdir("/proc/self/fd"):
        with suppress(OSError):
            opened = os.readlink(f"/proc/self/fd/{handle}")
            if (opened == path and not os.path.isdir(path)) or opened.startswith(f"{path}{os.sep}"):
                return True
    return False


def _pair_over_tcp() -> tuple[socket.socket, socket.socket]:
    """Two ends as the standard library makes them on Windows."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        near = socket.create_connection(listener.getsockname())
        return near, listener.accept()[0]


def locking_of_windows() -> types.ModuleType:
    """One byte, exclusive, of an open file, held until it is given back or the file is closed."""
    module = types.ModuleType("msvcrt")
    module.LK_NBLCK, module.LK_UNLCK = 2, 0  # type: ignore[attr-defined]

    def locking(handle: int, mode: int, size: int) -> None:
        assert size == 1
        assert os.lseek(handle, 0, os.SEEK_CUR) > 1_000_000, "Windows locks from where the file stands: text is there"
        fcntl.flock(handle, fcntl.LOCK_UN if mode == 0 else fcntl.LOCK_EX | fcntl.LOCK_NB)

    module.locking = locking  # type: ignore[attr-defined]
    return module
