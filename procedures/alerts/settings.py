"""``alerts.toml``: who is told, how, and how often. It is no part of a run, so no address gets into a journal."""

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, ClassVar, Self

from platformdirs import user_config_path
from pydantic import Field, field_validator, model_validator

from rig.description.device_settings import Positive
from rig.errors import DescriptionError
from rig.toml_file import StrictTable, as_tuple, read_toml


class Escalation(StrictTable):
    """``[escalate]``: who is told when nobody has acknowledged an alarm for so long."""

    after_min: Positive = 30.0
    urls: tuple[str, ...] = ()
    command: tuple[str, ...] = ()

    @field_validator("urls", "command", mode="before")
    @classmethod
    def _lists_are_tuples(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _tells_somebody(self) -> Self:
        if not self.urls and not self.command:
            raise ValueError("give urls or a command: an escalation to nobody is none")
        return self


class AlertSettings(StrictTable):
    """The whole file; everything in it is optional."""

    instead: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("mail_to", "mail", "email", "to", "url"),
        "unknown key: write urls, a list of addresses; mail is one of them: "
        'urls = ["mailto://USER:PASSWORD@example.org?to=NAME@example.org"]',
    )
    urls: tuple[str, ...] = ()
    """Addresses of apprise, such as ``mailto://…`` or ``ntfy://…``; needs ``pip install 'calrig[alerts]'``."""
    command: tuple[str, ...] = ()
    """Program and arguments; subject and text come on its standard input."""
    every_h: Positive | None = None
    """A word on progress so often."""
    heartbeat: str | None = None
    """A file that is touched or an ``http(s)://`` address that is fetched while the run lives."""
    heartbeat_every_s: Annotated[float, Field(ge=5.0)] = 60.0
    least_gap_s: Positive = 600.0
    """The same alert is not told again sooner."""
    repeat_every_s: Annotated[float, Field(ge=10.0)] = 900.0
    """An alarm (held, tripped, failed) that nobody acknowledged is told again so often."""
    escalate: Escalation | None = None
    deadline_s: Annotated[float, Field(gt=0.0, le=300.0)] = 30.0
    """So long a message may take before it counts as lost."""

    @property
    def secrets(self) -> tuple[str, ...]:
        """What may hold a token or an address; the name of a program is told."""
        others = self.escalate or AlertSettings()
        return (*self.urls, *self.command[1:], *others.urls, *others.command[1:], self.heartbeat or "")

    @field_validator("urls", "command", mode="before")
    @classmethod
    def _lists_are_tuples(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _heartbeat_is_file_or_web(self) -> Self:
        if self.heartbeat is not None and "://" in self.heartbeat and not is_web(self.heartbeat):
            raise ValueError("heartbeat must be a file, http://… or https://…")
        return self


def is_web(address: str) -> bool:
    return address.startswith(("http://", "https://"))


def read_alerts(path: Path) -> AlertSettings:
    """Return the settings of an alerts file.

    Raises: DescriptionError naming every mistake; also where apprise is asked for and not installed.
    """
    settings = read_toml(path).validate(AlertSettings)
    has_urls = settings.urls or (settings.escalate is not None and settings.escalate.urls)
    if has_urls and find_spec("apprise") is None:
        raise DescriptionError(
            f"{path}: urls: needs apprise, which is not installed; nothing was started; "
            "pip install 'calrig[alerts]', or use command"
        )
    return settings


def alerts_file(path: Path | None) -> Path | None:
    """Return the file that an option names; without one the user's own, or None where there is none."""
    of_user = user_config_path("calrig") / "alerts.toml"
    return path or (of_user if of_user.exists() else None)


def chosen_alerts(path: Path | None) -> AlertSettings | None:
    """Return the settings of a file; without one those of the user's own file, or None where there is none.

    It is for whoever has something to tell now: an address that cannot work keeps no other from being told.
    :func:`procedures.alerts.addresses.usable_alerts` refuses it while there is time.

    Raises as :func:`read_alerts`.
    """
    file = alerts_file(path)
    return None if file is None else read_alerts(file)
