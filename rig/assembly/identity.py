"""Whether the devices that answer are those that the rig file means: by what they say of themselves, not by their port.

A port says where a cable is plugged in, and cables change places. So a rig file may state, for every device, a part of
what it answers to the question who it is; best its serial number.
"""

from collections.abc import Iterator, Mapping
from typing import Protocol

from rig.description.rig_file import RigDescription
from rig.errors import RequestRefused

AXES = "axes."
"""Before the name of an axis, of which people read the name alone."""


class Identifiable(Protocol):
    """Any device."""

    def identify(self) -> str: ...


def expected(description: RigDescription) -> dict[str, str]:
    """Return what devices must say, by table (``axes.pitch``).

    Twins have no serial numbers: nothing is expected of them.
    """
    return {} if description.is_simulated else dict(_stated(description))


def require_expected(expected: Mapping[str, str], identities: Mapping[str, str]) -> None:
    """Refuse devices that are not the expected ones.

    Raises: RequestRefused naming every device that is another one, and whose it is where that can be told.
    """
    wrong = [
        _sentence(key, expected, identities)
        for key in identities
        if key in expected and expected[key] not in identities[key]
    ]
    if wrong:
        raise RequestRefused(f"{'; '.join(wrong)}; nothing moved; put the cables right, or correct the rig file")


def _stated(description: RigDescription) -> Iterator[tuple[str, str]]:
    for table, devices in (
        ("axes", description.axes),
        ("readouts", description.readouts),
        ("environment", description.environment),
        ("streams", description.streams),
    ):
        for name, device in devices.items():
            if device.identity is not None:
                yield f"{table}.{name}", device.identity


def _sentence(key: str, expected: Mapping[str, str], identities: Mapping[str, str]) -> str:
    owner = next((other for other, text in expected.items() if other != key and text in identities[key]), None)
    whose = "" if owner is None else f", which is {owner}: their cables changed places"
    allowed = f"allowed is one with {expected[key]!r} ({key}: identity)"
    return f"{key}: another device answers: got {identities[key]!r}{whose}, {allowed}"


class FirstAnswers:
    """Who answered first, by table (``axes.pitch``), over all openings of the lines."""

    def __init__(self) -> None:
        self._who: dict[str, str] = {}

    def strangers(self, found: Mapping[str, str]) -> dict[str, str]:
        """Take in who answers now; return table to a sentence where that is not who answered there first."""
        self._who = {**found, **self._who}
        return {
            key: f"{key.removeprefix(AXES)}: another device answers on its line: was {self._who[key]!r}, is {who!r}"
            for key, who in found.items()
            if who != self._who[key]
        }
