"""Take away what only POSIX systems have, as far as calrig could see it, and put Windows' way of locking in its place.

Called before calrig is imported, in a process of its own. Libraries that have a Windows side of their own, and the
standard library, are imported first and keep what they need.
"""

import fcntl
import os
import signal
import socket
import sys
import types

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
    "apsw", "asyncio", "concurrent.futures.process", "getpass", "matplotlib", "multiprocessing.connection", "pandas",
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
