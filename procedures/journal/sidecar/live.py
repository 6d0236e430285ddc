"""``live.json`` in a run's folder: what happens between two commits, for screens; never part of the record.

Renamed into place at most once a second while the engine looks around, and at each new phase: what follows may keep the
engine from looking. Removed when the process ends orderly. It is not synced, and a disk that refuses it is not even
told: it can hold no run. Who reads it asks first whether a living process runs the run, and how old it is.
"""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import datetime
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from ams.whole_file import replace_file
from procedures.journal.sidecar.owner import is_owned
from rig.clock import Clock

LIVE_FILE = "live.json"
FORMAT = "calrig live 1"
EVERY_S = 1.0
_MAX_BYTES = 262_144


@dataclass(frozen=True, slots=True)
class Figure:
    """One value that was read."""

    value: float | None
    """None where it was overloaded."""
    unit: str


@dataclass(frozen=True, slots=True)
class Target:
    """A dwell that is approached or comes next."""

    step: int
    purpose: str
    replication: int
    targets_deg: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Live:
    """What the engine does at this moment."""

    phase: str = ""
    """Such as ``moving``, ``settling``, ``reading``, ``soaking``, ``homing``, ``warming up``, ``waiting``."""
    phase_since_utc: datetime | None = None
    now: Target | None = None
    next: Target | None = None
    positions_deg: Mapping[str, float] = field(default_factory=dict)
    """As last read back."""
    readings: Mapping[str, Figure] = field(default_factory=dict)
    """Channel to the mean of its last burst."""
    temperature_degc: Mapping[str, float] = field(default_factory=dict)
    setpoint_degc: Mapping[str, float] = field(default_factory=dict)
    soak_left_s: float | None = None
    """At the least; it counts anew where the temperature leaves its band."""
    usual_s: float | None = None
    """How long the phase is expected to take; None where nobody knows."""
    seldom_over_s: float | None = None
    """Longer in one case of ten."""
    waiting_for: str = ""
    pending_request: str = ""
    """What people asked for and have not got yet, and who: a pause waits for the end of a dwell or a soak."""
    written_utc: datetime | None = None
    format: str = FORMAT


class LiveFile:
    """The engine's side: :meth:`tell` is cheap, :meth:`look` writes what was told when a second has passed."""

    def __init__(self, run_dir: Path, clock: Clock, *, writes_phases: bool = False) -> None:
        """``clock``: a person's, also where the rig's time is virtual.

        ``writes_phases``: each new phase at once, as where devices take their time.
        """
        self._path = run_dir / LIVE_FILE
        self._clock = clock
        self._live = Live()
        self._writes_phases = writes_phases
        self._is_new = False
        self._next_s = clock.monotonic_s()

    def tell(self, phase: str | None = None, **known: Any) -> None:
        """Tell what has changed; a new phase forgets what only the one before waited for."""
        is_new_phase = phase is not None and phase != self._live.phase
        if phase is not None and is_new_phase:
            since_utc = self._clock.now_utc()
            self._live = replace(
                self._live,
                phase=phase,
                phase_since_utc=since_utc,
                soak_left_s=None,
                usual_s=None,
                seldom_over_s=None,
                waiting_for="",
            )
        self._live = replace(self._live, **known)
        self._is_new = True
        if is_new_phase and self._writes_phases:
            self._write()

    def look(self) -> None:
        """Write it where something is new and the last time was a second ago."""
        if self._is_new and self._clock.monotonic_s() >= self._next_s:
            self._write()

    def _write(self) -> None:
        self._is_new, self._next_s = False, self._clock.monotonic_s() + EVERY_S
        document = live_document(replace(self._live, written_utc=self._clock.now_utc()))
        with suppress(OSError):
            replace_file(self._path, json.dumps(document, ensure_ascii=False).encode("utf-8"), is_synced=False)

    def remove(self) -> None:
        """Leave nothing behind, nor what a kill in mid-write left beside it: what it told is over."""
        with suppress(OSError):
            self._path.unlink(missing_ok=True)
            for partial in self._path.parent.glob(f".{LIVE_FILE}.*.partial"):
                partial.unlink(missing_ok=True)


def read_live(run_dir: Path) -> Live | None:
    """Return what a living engine does now; None where none lives, or it has told nothing that can be read."""
    try:
        if not is_owned(run_dir):
            return None
        with open(run_dir / LIVE_FILE, "rb") as file:
            return _adapter().validate_json(file.read(_MAX_BYTES))
    except (OSError, ValidationError):
        return None


def live_document(live: Live) -> dict[str, object]:
    """Return it as it stands in the file: times as texts, what is not finite as null."""
    return {name: _strict(value) for name, value in asdict(live).items()}


@cache
def _adapter() -> TypeAdapter[Live]:
    return TypeAdapter(Live)


def _strict(value: object) -> object:
    if isinstance(value, dict):
        return {key: _strict(part) for key, part in value.items()}
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, float) and not isfinite(value):
        return None
    return value
