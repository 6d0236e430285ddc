"""Whether the devices that answer are those that a run began with."""

from collections.abc import Mapping


def other_devices(known: Mapping[str, str], found: Mapping[str, str]) -> str:
    """Describe what differs, in one sentence; empty where the same devices answer.

    A driver may tell more of its device than the one that the run began with, never less or otherwise.
    """
    changed = [name for name in {**known, **found} if not _is_same(known.get(name), found.get(name))]
    differences = "; ".join(f"{name}: was {known.get(name)!r}, is {found.get(name)!r}" for name in changed)
    return f"not the devices this run began with: {differences}" if changed else ""


def _is_same(known: str | None, found: str | None) -> bool:
    if known is None or found is None:
        return known == found
    parts = iter(found.split(", "))
    return all(part in parts for part in known.split(", "))
