"""Homes that outlive a connection, where the machine itself can prove that it kept them.

Some controllers have no word for "homed": a new command would have to home again before it may move. What such an axis
was left with is kept in the user's state folder, and the next connection compares it with the machine: only what agrees
is taken over. Nothing here is believed without the machine. Twins in this process live no longer than it: not kept.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from hashlib import blake2b
from pathlib import Path

from platformdirs import user_state_path

from rig.abilities.abilities import Axis, Remembering, WriteFile
from rig.clock import WAIT_SLICE_S, Clock
from rig.description.device_settings import TWIN_PORT, AxisSettings
from rig.description.rig_file import RigDescription
from rig.local_time import at_both

FORMAT = "calrig home 1"


@dataclass(frozen=True, slots=True)
class _Left:
    """How an axis was left."""

    left_utc: datetime
    mark: Mapping[str, float]


class HomeMemory:
    """Of the axes of one rig; ``folder``: by default in the user's state folder."""

    def __init__(self, description: RigDescription, clock: Clock, write: WriteFile, folder: Path | None = None) -> None:
        self._description = description
        self._clock = clock
        self._write = write
        self._folder = folder

    def take_over(self, axes: Mapping[str, Axis]) -> dict[str, str]:
        """Let every axis take the home over that it was left with; returns why not, for those that did not.

        Raises: DeviceSilent, DeviceNonsense, LinkLost.
        """
        refusals = {name: self._refusal(name, axis) for name, axis in axes.items() if isinstance(axis, Remembering)}
        return {name: why for name, why in refusals.items() if why}

    def keep(self, axes: Mapping[str, Axis]) -> None:
        """Keep how every axis is left; one that does not rest homed is forgotten.

        Raises: as :meth:`take_over`; OSError where the folder does not take it.
        """
        for name, axis in axes.items():
            path = self._path(name)
            if path is None or not isinstance(axis, Remembering):
                continue
            state = axis.state()
            if state.is_homed and not state.is_moving and not state.fault:
                mark = axis.home_mark()
                path.parent.mkdir(parents=True, exist_ok=True)
                self._write(path, _as_text(_Left(self._clock.now_utc(), mark)).encode("utf-8"))
            else:
                path.unlink(missing_ok=True)

    def _refusal(self, name: str, axis: Remembering) -> str:
        path = self._path(name)
        left = None if path is None else _read(path)
        if left is None:
            return ""
        axis.home_mark()  # the first words on a line wait for its silence: the time away ends after them
        pace = self._clock.slice_s / WAIT_SLICE_S  # rig seconds in a second
        away_s = (self._clock.now_utc() - left.left_utc).total_seconds() * pace
        why = axis.resume_home(left.mark, away_s)
        return (
            f"{name}: the home of {at_both(left.left_utc, to_the_second=True)} does not hold any more: {why}"
            if why
            else ""
        )

    def _path(self, name: str) -> Path | None:
        axis: AxisSettings = self._description.axes[name]
        if axis.port == TWIN_PORT:
            return None
        folder = self._folder
        if folder is None:
            folder = user_state_path("calrig") / "homes"
        rig = self._description.rig.name
        identity = blake2b(f"{rig}|{name}|{axis.driver}|{axis.port}|{axis.axis}".encode(), digest_size=8).hexdigest()
        return folder / f"{name}-{identity}.json"


def _read(path: Path) -> _Left | None:
    """Return what was left, None where nothing whole is kept: then the axis is homed anew, which does no harm."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        if document["format"] != FORMAT:
            return None
        mark = {str(key): float(value) for key, value in document["mark"].items()}
        return _Left(datetime.fromisoformat(document["left_utc"]), mark)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def _as_text(left: _Left) -> str:
    return json.dumps({"format": FORMAT, "left_utc": left.left_utc.isoformat(), "mark": dict(left.mark)})
