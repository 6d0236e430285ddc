"""Whether the devices that answer are those that a run began with."""

from collections.abc import Mapping


def other_devices(known: Mapping[str, str], found: Mapping[str, str]) -> str:
    """Describe what differs, in one sentence."""
    changed = [name for name in {**known, **found} if known.get(name) != found.get(name)]
    differences = "; ".join(f"{name}: was {known.get(name)!r}, is {found.get(name)!r}" for name in changed)
    return f"not the devices this run began with: {differences}"
