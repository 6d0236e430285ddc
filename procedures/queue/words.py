"""The queue in words, for the terminal and for programs."""

from collections.abc import Iterator, Mapping
from datetime import datetime

from procedures.queue.state import OVER, Arming, Item, ItemState, Queue, folded
from rig.local_time import at_both
from rig.plain_text import one_line


def queue_lines(queue: Queue, boot: str, now_utc: datetime) -> Iterator[str]:
    """Yield where the queue stands, then its items in order; those that are over last."""
    yield armed_sentence(queue, boot, now_utc)
    yield mounted_sentence(queue)
    due = next(iter(queue.in_state(ItemState.WAITING)), None)
    for item in sorted(queue.items, key=lambda item: item.state in OVER):
        if item.state is ItemState.REMOVED:
            continue
        messages = f": {one_line('; '.join(item.reasons))}" if item.reasons else ""
        yield f"{item.number:>4}  {item.state:<16} {one_line(item.title)}{_window(item)}{messages}"
        if item is due and (awaited := awaited_sentence(queue, item)):
            yield f"      {awaited}"
        if item.run:
            yield f"      {item.run}"


def armed_sentence(queue: Queue, boot: str, now_utc: datetime) -> str:
    """Say whether anything starts, and by whose word."""
    if why := queue.why_not_armed(boot, now_utc):
        return f"disarmed: {one_line(why)}"
    assert queue.arming is not None
    return armed_until(queue.arming)


def disarming_sentence(queue: Queue) -> str:
    """Say that what was done last has disarmed the queue, and why; empty where it has not."""
    was_armed = folded(queue.events[:-1]).arming is not None
    if queue.arming is not None or not was_armed:
        return ""
    return f"the queue is disarmed by it: {one_line(queue.disarmed_because)}; it starts nothing until it is armed again"


def armed_until(arming: Arming) -> str:
    """Say who armed it until when."""
    return f"armed by {one_line(arming.by)} until {at_both(arming.until_utc)}"


def mounted_sentence(queue: Queue) -> str:
    """Say what is mounted, who says so, and since when; else why nobody's word for it stands."""
    if queue.attestation is None:
        return f"mounted: {one_line(queue.unsaid_because)}"
    said = queue.attestation
    return f"mounted: {one_line(mounted_words(said.mounted))}, says {one_line(said.by)}, at {at_both(said.said_utc)}"


def awaited_sentence(queue: Queue, item: Item) -> str:
    """Say which attestation the item waits for, and why the one that was given is none; empty where it fits."""
    if queue.is_mounted(item):
        return ""
    said = queue.attestation
    instead = queue.unsaid_because if said is None else f"{mounted_words(said.mounted)} is, says {said.by}"
    no_face = "" if any(item.needs.values()) else " (its rig file names no datum face)"
    return one_line(f"waits for an attestation that {mounted_words(item.needs)} is mounted{no_face}; {instead}")


def mounted_words(mounted: Mapping[str, str]) -> str:
    """Return sensors with their datum faces."""
    return ", ".join(f"{name}{f' datum {datum}' if datum else ''}" for name, datum in mounted.items())


def item_document(item: Item) -> dict[str, object]:
    """Return an item as ``calrig queue list --json`` has it."""
    return {
        "item": item.number,
        "place": str(item.state),
        "title": item.title,
        "procedure": item.procedure.path,
        "procedure_sha256": item.procedure.sha256,
        "rig": item.rig.path,
        "rig_sha256": item.rig.sha256,
        "out": item.out,
        "needs": dict(item.needs),
        "added_by": item.added_by,
        "not_before_utc": None if item.not_before_utc is None else item.not_before_utc.isoformat(),
        "not_after_utc": None if item.not_after_utc is None else item.not_after_utc.isoformat(),
        "told": list(item.reasons),
        "run": item.run or None,
    }


def _window(item: Item) -> str:
    begins = f", not before {at_both(item.not_before_utc)}" if item.not_before_utc else ""
    return begins + (f", not after {at_both(item.not_after_utc)}" if item.not_after_utc else "")
