"""Which devices a run knows, who took another one over, and which dwells each of them measured.

The journal keeps what answered whenever devices were asked who they are (``identities``), before anybody judges it: it
tells who was there, not who belongs there. A run's devices are those of its first answers, and each that somebody took
over by name later (``override`` with ``devices``); an answer that says more of the same device is kept instead.
"""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from procedures.journal.audit.changes import KIND as OVERRIDE
from procedures.plan.plan import Plan
from procedures.records.dwells import DwellRecord, Event

ANSWERED = "identities"
"""Kind of the event: table (``axes.pitch``) to what the device there said."""
TAKEN_OVER = "devices"
"""In an ``override``: table to what the device said that somebody answered for."""
_WAY = re.compile(
    r"(?<=columns) at [^;]*(?=; it cannot be asked who it is)|(?<=^HP3458A) at address \d+"
    r"|, by (?:VISA |[^,]*GPIB).*$|, (?:VISA |[^,]*GPIB).*, address \d+$"
)
"""What journals of before 2026-12 hold of the way to a device: an address, an adapter that an AR488 names with commas.

Nothing else is taken away: a driver of somebody else's may end with an address, and a serial number may stand before.
"""


@dataclass(frozen=True, slots=True)
class KnownDevices:
    """By table."""

    of_run: Mapping[str, str] = field(default_factory=dict)
    """Empty where none was asked yet."""
    seen_last: Mapping[str, str] = field(default_factory=dict)
    """Who answered last, whether it belongs there or not: only what a person was shown can be taken over."""


@dataclass(frozen=True, slots=True)
class Tenure:
    """A device that measured dwells of the design which count, or the one that the run began with."""

    identity: str
    steps: tuple[int, ...]
    """In the order of time; none of a device that was replaced before it measured what counts."""
    by: str = ""
    """Who took it over; empty of the first, and where nobody did."""
    reason: str = ""

    def in_words(self, held: Iterable["Tenure"]) -> str:
        """Say how many dwells of which steps, between which none of the others is; ``held``: every one there."""
        if not self.steps:
            return "no dwell that counts"
        others = {step for tenure in held if tenure is not self for step in tenure.steps}
        plural = "" if len(self.steps) == 1 else "s"
        return f"{len(self.steps)} dwell{plural} of step{plural} {_ranges(sorted(self.steps), others)}"


def other_devices(known: Mapping[str, str], found: Mapping[str, str]) -> dict[str, str]:
    """Return table to a sentence for each device that is another one; empty where the same devices answer.

    A driver may tell more of its device than the one that the run began with, never less or otherwise.
    """
    return {
        name: f"{name}: was {known.get(name)!r}, is {found.get(name)!r}"
        for name in {**known, **found}
        if not _is_same(known.get(name), found.get(name))
    }


def known_devices(events: Iterable[Event]) -> KnownDevices:
    """Return whom the run knows, as its journal tells; every version of journals."""
    of_run: dict[str, str] = {}
    seen: Mapping[str, str] = {}
    for event in events:
        if event.kind == ANSWERED:
            seen = _answers(event)
            of_run |= {name: who for name, who in seen.items() if _is_same(of_run.get(name, who), who)}
        elif event.kind == OVERRIDE:
            of_run |= _taken_over(event)
    return KnownDevices(of_run, seen)


def is_used(name: str, plan: Plan) -> bool:
    """Return whether a device is of the run: a stream that no dwell reads is not, everything else is."""
    table, _, stream = name.partition(".")
    reference = () if plan.attitude_reference is None else plan.attitude_reference.channels.values()
    return table != "streams" or any(channel.partition(".")[0] == stream for channel in (*plan.channels, *reference))


def tenures_in(events: Iterable[Event], dwells: Iterable[DwellRecord], plan: Plan) -> dict[str, tuple[Tenure, ...]]:
    """Return, by table, who measured which dwells of the design that count: one device, or several in order of time.

    The one that the run began with is the first, whether it measured any or none: what the rig file declares is of it.
    A device that the run does not use is left out where it gave place to another.
    """
    counted = {_key(dwell.step, dwell.attempt, dwell.epoch) for dwell in dwells if _counts(dwell)}
    found: dict[str, list[_Occupant]] = {}
    for event in events:
        if event.kind == ANSWERED:
            for name, who in _answers(event).items():
                occupants = found.setdefault(name, [])
                if occupants and _is_same(occupants[-1].identity, who):
                    occupants[-1].identity = who
                else:
                    occupants.append(_Occupant(who))
        elif event.kind == OVERRIDE:
            for occupant in (found[name][-1] for name in _taken_over(event) if name in found):
                occupant.by, occupant.reason = str(event.detail["by"]), str(event.detail["reason"])
        elif event.kind == "dwell" and _key_in(event) in counted:
            for occupants in found.values():
                occupants[-1].steps.append(int(str(event.detail["step"])))
    held = {name: tuple(_tenures(occupants)) for name, occupants in found.items()}
    return {name: tenures if is_used(name, plan) else tenures[:1] for name, tenures in held.items()}


def replacements(tenures: Mapping[str, Sequence[Tenure]]) -> list[str]:
    """Return a sentence for each device in whose place several measured: which dwells by whom, and who answers."""
    return [
        f"{name} was replaced during the run: {'; then '.join(_by_whom(tenure, held) for tenure in held)}"
        for name, held in tenures.items()
        if len(held) > 1
    ]


def identities_in_words(tenures: Mapping[str, Sequence[Tenure]]) -> dict[str, str]:
    """Return table to what the device there says of itself; of several each with the dwells that it measured."""
    return {
        name: held[0].identity
        if len(held) == 1
        else "; then ".join(f"{tenure.identity} ({tenure.in_words(held)})" for tenure in held)
        for name, held in tenures.items()
    }


def dwells_by_device(held: Iterable[Tenure]) -> dict[str, int]:
    """Return identity to how many dwells that device measured, however often it came back; the first is the run's."""
    counts: dict[str, int] = {}
    for tenure in held:
        who = next((known for known in counts if _is_same(known, tenure.identity)), tenure.identity)
        counts[who] = counts.get(who, 0) + len(tenure.steps)
    return counts


@dataclass(slots=True)
class _Occupant:
    identity: str
    steps: list[int] = field(default_factory=list)
    by: str = ""
    reason: str = ""


def _tenures(occupants: Iterable[_Occupant]) -> list[Tenure]:
    """Leave out who measured nothing that counts, but the first; neighbours that then are one device are one tenure."""
    found: list[Tenure] = []
    for occupant in occupants:
        if found and _is_same(found[-1].identity, occupant.identity):
            before = found.pop()
            found.append(Tenure(occupant.identity, (*before.steps, *occupant.steps), before.by, before.reason))
        elif occupant.steps or not found:
            found.append(Tenure(occupant.identity, tuple(occupant.steps), occupant.by, occupant.reason))
    return found


def _by_whom(tenure: Tenure, held: Sequence[Tenure]) -> str:
    answers = f", taken over by {tenure.by}: {tenure.reason}," if tenure.by else ""
    return f"{tenure.identity!r}{answers} measured {tenure.in_words(held)}"


def _ranges(steps: Sequence[int], others: Collection[int]) -> str:
    spans: list[list[int]] = []
    for step in steps:
        if spans and not any(spans[-1][1] < other < step for other in others):
            spans[-1][1] = step
        else:
            spans.append([step, step])
    return ", ".join(f"{first}" if first == last else f"{first} to {last}" for first, last in spans)


def _counts(dwell: DwellRecord) -> bool:
    return dwell.accepted and dwell.purpose == "design"


def _key(step: object, attempt: object, epoch: object) -> tuple[str, str, str]:
    return str(step), str(attempt), str(epoch)


def _key_in(event: Event) -> tuple[str, str, str]:
    return _key(*(event.detail.get(name) for name in ("step", "attempt", "epoch")))


def _answers(event: Event) -> dict[str, str]:
    return {str(name): str(who) for name, who in event.detail.items()}


def _taken_over(event: Event) -> dict[str, str]:
    devices = event.detail.get(TAKEN_OVER)
    return {str(name): str(who) for name, who in devices.items()} if isinstance(devices, dict) else {}


def _is_same(known: str | None, found: str | None) -> bool:
    if known is None or found is None:
        return known == found
    parts = iter(found.split(", "))
    return known == found or all(part in parts for part in _WAY.sub("", known).split(", "))
