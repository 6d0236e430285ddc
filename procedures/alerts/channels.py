"""How an alert gets out: a local command, apprise, a heartbeat. Each call may block; the dispatcher gives it time."""

import difflib
import errno
import re
import subprocess
import urllib.request
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from procedures.alerts.settings import is_web
from rig.clock import SystemClock

SHORTEST_SECRET = 6
"""Letters; what is shorter is a word that would be found everywhere."""
AGAIN_S = 0.5
"""Between two attempts to begin a process that the system has no room for now."""
_NO_ROOM = (errno.EAGAIN, errno.ENOMEM)


class NotDelivered(Exception):
    """A message did not get out, and why."""


@dataclass(frozen=True, slots=True)
class Message:
    """What somebody should know."""

    subject: str
    text: str


def by_command(command: Sequence[str], message: Message, deadline_s: float) -> None:
    """Give a message to the user's own command on its standard input, in UTF-8 whatever the locale is.

    Where the system has no room for another process now, it is asked again until the deadline.

    Raises: NotDelivered.
    """
    clock = SystemClock()
    ends_s = clock.monotonic_s() + deadline_s
    try:
        while (done := _ended(command, message, ends_s - clock.monotonic_s())) is None:
            clock.sleep(AGAIN_S)
    except subprocess.TimeoutExpired:
        raise NotDelivered(f"command {command[0]}: did not end within {deadline_s:g} s") from None
    except (OSError, ValueError) as error:
        raise NotDelivered(f"command {command[0]}: {getattr(error, 'strerror', None) or error}") from None
    if done.returncode:
        raise NotDelivered(f"command {command[0]}: exit status {done.returncode}: {done.stderr.strip()[:200]}")


def _ended(command: Sequence[str], message: Message, left_s: float) -> "subprocess.CompletedProcess[str] | None":
    """Return what became of the process; None where there was no room for one, and is time for another attempt."""
    try:
        return subprocess.run(  # noqa: S603  the user's own command, without a shell
            list(command), input=f"{message.subject}\n\n{message.text}\n", capture_output=True,
            encoding="utf-8", errors="backslashreplace", timeout=left_s, check=False,
        )  # fmt: skip
    except OSError as error:
        if error.errno not in _NO_ROOM or left_s <= AGAIN_S:
            raise
    return None


def by_apprise(urls: Sequence[str], message: Message) -> None:
    """Send a message to the services of apprise URLs; one that does not take it keeps it from no other.

    Apprise says only that something failed, so the error names the services, never their addresses.

    Raises: NotDelivered naming every service that failed.
    """
    import apprise

    failed = []
    for url in urls:
        sender = apprise.Apprise()
        if not sender.add(url):
            failed.append(f"{starred(url)} is no address that it knows")
        elif not sender.notify(title=message.subject, body=message.text):
            failed.append(f"{starred(url)} did not take the message")
    if failed:
        raise NotDelivered(f"apprise: {', '.join(failed)}")


def starred(url: str) -> str:
    """Return the service of an address, and nothing of what may be secret."""
    service, mark, _ = url.partition("://")
    return f"{service}://…" if mark else "…"


def address_complaint(url: str) -> str:
    """Return why apprise can send nothing to an address, in words without a secret; empty where it can."""
    import apprise

    if apprise.Apprise().add(url):
        return ""
    service = url.partition("://")[0].lower()
    known = {
        name
        for plugin in apprise.Apprise().details()["schemas"]
        for protocols in (plugin["protocols"], plugin["secure_protocols"])
        for name in protocols or ()
    }
    if service in known:
        return "apprise cannot read it as an address of that service: a part is missing or wrong"
    near = difflib.get_close_matches(service, sorted(known), n=1)
    return "apprise knows no such service" + (f"; did you mean {near[0]}://?" if near else "")


def without_secrets(text: str, secrets: Sequence[str]) -> str:
    """Return the text without any argument or address of the settings, whole or in parts: it goes into a journal."""
    parts = {part for secret in secrets for part in (secret, *re.split(r"[/:@?&=#,\s]+", secret))}
    for part in sorted(parts, key=len, reverse=True):
        if len(part) >= SHORTEST_SECRET:
            text = text.replace(part, "…")
    return text


def beat(target: str, deadline_s: float) -> None:
    """Touch the file or fetch the address. Raises: NotDelivered."""
    try:
        if not is_web(target):
            Path(target).touch()
            return
        with urllib.request.urlopen(target, timeout=deadline_s) as answer:  # noqa: S310  http and https only
            answer.read(1024)
    except (OSError, ValueError) as error:
        raise NotDelivered(f"heartbeat not sent: {error}") from None
