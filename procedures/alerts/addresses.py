"""Every way by which a file of alerts tells people: whether it can work at all, and what became of a trial."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from procedures.alerts.channels import (
    Message,
    NotDelivered,
    address_complaint,
    by_apprise,
    by_command,
    starred,
    without_secrets,
)
from procedures.alerts.settings import AlertSettings, Escalation, alerts_file, read_alerts
from rig.errors import DescriptionError
from rig.threads import at_once
from rig.toml_file import KeyPath, read_toml


@dataclass(frozen=True, slots=True)
class Way:
    """One command or one address."""

    key: KeyPath
    """Of the file."""
    name: str
    """Without what may be secret."""
    deadline_s: float
    command: tuple[str, ...] = ()
    url: str = ""

    def complaint(self) -> str:
        """Return why nothing ever goes out by it; empty where something may."""
        if not self.command:
            return address_complaint(self.url)
        return "" if shutil.which(self.command[0]) else "there is no such program that may be run"

    def deliver(self, message: Message) -> None:
        """Send a message by it alone. Raises: NotDelivered."""
        if self.command:
            by_command(self.command, message, self.deadline_s)
        else:
            by_apprise([self.url], message)


def ways_of(settings: AlertSettings) -> Iterator[Way]:
    """Yield every way in the order of the file: the command, the addresses, then those of the escalation."""
    yield from _ways((), settings, settings.deadline_s)
    if settings.escalate is not None:
        yield from _ways(("escalate",), settings.escalate, settings.deadline_s)


def _ways(table: KeyPath, whom: AlertSettings | Escalation, deadline_s: float) -> Iterator[Way]:
    if whom.command:
        yield Way((*table, "command"), whom.command[0], deadline_s, command=whom.command)
    for number, url in enumerate(whom.urls, start=1):
        yield Way((*table, "urls"), f"{starred(url)} (value {number})", deadline_s, url=url)


def usable_alerts(path: Path | None) -> AlertSettings | None:
    """Return the settings of a file, or of the user's own, every way of which may work; None where there is no file.

    Raises: DescriptionError naming every command that is not there and every address that apprise cannot use; else as
        :func:`procedures.alerts.settings.read_alerts`.
    """
    file = alerts_file(path)
    if file is None:
        return None
    settings, parsed = read_alerts(file), read_toml(file)
    wrong = [
        parsed.complaint(way.key, f"got {way.name}: {complaint}; nobody would be told by it; nothing was started; "
                         "mend it, and try it with calrig alerts FILE --test")
        for way in ways_of(settings) if (complaint := way.complaint())
    ]  # fmt: skip
    if wrong:
        raise DescriptionError("\n".join(wrong))
    return settings


def try_ways(settings: AlertSettings, message: Message) -> list[tuple[Way, str]]:
    """Send a message by every way at once; each with why it did not get out, empty where it did.

    It takes ``deadline_s`` of the settings and a second at most; for each way, where no thread can be had.
    """
    ways = list(ways_of(settings))
    failures = dict.fromkeys(range(len(ways)), f"no answer within {settings.deadline_s:g} s")

    def send(index: int) -> None:
        try:
            ways[index].deliver(message)
            failures[index] = ""
        except NotDelivered as error:
            failures[index] = without_secrets(str(error), settings.secrets)
        except MemoryError:
            failures[index] = "no memory is left"

    within_s = settings.deadline_s + 1.0  # a command that hangs says so itself
    at_once([partial(send, index) for index in range(len(ways))], within_s, "a trial")
    return [(way, failures[index]) for index, way in enumerate(ways)]
