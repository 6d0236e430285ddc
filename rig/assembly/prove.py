"""First contact with real devices: what each says of itself, beside what its twin would say.

Every device is asked all that can be asked without motion and heat (meters are reset and read, streams run for a
moment); the same is asked of the twins of the same rig file. What differs is named: what a device is, its unit and
scale, a reply that is missing, the form of a reply on the wire, channels that changed places. All bytes are kept, so
that what a device did becomes a transcript that a test replays.
"""

import json
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from rig.assembly.open_rig import Claim, Rig, claimed_by_nobody_else, open_rig
from rig.assembly.questions import Answers, answers_of
from rig.clock import Clock, VirtualClock
from rig.description.rig_file import RigDescription
from rig.drivers.twin_lines import without_twin
from rig.lines.recording import LineSource, recording
from rig.link.transcript import Entry, read_transcript
from rig.motion.move import home_and_arrive

SAME_VOLTS = 0.01
"""Of the larger of two readings: nearer than this they are the same signal."""
SAME_GRAVITY, SAME_RATE = 0.2, 0.25
_NUMBER = re.compile(rb"\d+(?=\.\d)|(?<![\d.])\d+(?![\d.])")
_SHOWN = 40
_UNASKED = "it cannot be asked who it is"


@dataclass(frozen=True, slots=True)
class Difference:
    """What a device says otherwise than its twin."""

    field: str
    device: str
    twin: str


@dataclass(frozen=True)
class DeviceProof:
    """One device of the rig file (``axes.pitch``)."""

    key: str
    answers: Answers
    differences: tuple[Difference, ...]
    is_alone: bool = False
    """Its driver has no twin: it was asked and recorded, and there is nothing to compare with."""


def prove(
    description: RigDescription,
    folder: Path,
    *,
    rig_file: Path | None = None,
    motion: str | None = None,
    clock: Clock | None = None,
    line_source: LineSource | None = None,
    claim: Claim = claimed_by_nobody_else,
) -> tuple[DeviceProof, ...]:
    """Ask the devices and their twins, keep every byte in ``folder`` (``device``, ``twin``), compare.

    ``motion`` names an axis that moves, by at most 5 degrees; it must be homed. ``clock``, ``line_source`` and
    ``claim`` are those of the real side. Raises: what opening a rig raises, RequestRefused where the axis cannot be
    proven.
    """
    with ExitStack() as files:
        source = _through(recording(folder / "device", files), line_source)
        real = files.enter_context(
            open_rig(
                description,
                clock=clock,
                rig_file=rig_file,
                purpose="calrig prove",
                line_source=source,
                claim=claim,
            )
        )
        device = answers_of(real, motion)
    alone = without_twin(description)
    on_twins = _without(description.all_on_twins(), alone)
    with ExitStack() as files:
        now = VirtualClock(datetime(2024, 1, 1, tzinfo=UTC))
        twins = open_rig(on_twins, clock=now, line_source=recording(folder / "twin", files))
        moved = None if f"axes.{motion}" in alone else motion
        twin = answers_of(_homed_like(files.enter_context(twins), device, moved), moved)
    wire = {key: tuple(_wire_differences(folder, key)) for key in device if key not in alone}
    stated = _stated(description)
    return tuple(
        DeviceProof(key, answers, (), is_alone=True)
        if key in alone
        else DeviceProof(key, answers, (*_differences(answers, twin[key], stated.get(key)), *wire[key]))
        for key, answers in device.items()
    )


def _without(description: RigDescription, devices: Collection[str]) -> RigDescription:
    """Return a rig without some devices, named such as ``axes.pitch``."""
    tables = {
        table: {name: part for name, part in getattr(description, table).items() if f"{table}.{name}" not in devices}
        for table in ("axes", "readouts", "environment", "streams", "field")
    }
    return description.model_copy(update=tables)


def _through(kept: LineSource, inner: LineSource | None) -> LineSource:
    if inner is None:
        return kept
    return lambda key, open_line: kept(key, lambda: inner(key, open_line))


def _homed_like(twins: Rig, device: Mapping[str, Answers], motion: str | None) -> Rig:
    """Twins wake without a home: those of axes that have one are homed, so that they are asked in the same state."""
    for name, axis in twins.axes.items():
        if name == motion or device[f"axes.{name}"].recorded.get("is_homed") == "true":
            home_and_arrive(axis, twins.clock, twins.clock.sleep)
    return twins


def _stated(description: RigDescription) -> dict[str, str]:
    tables = (
        ("axes", description.axes),
        ("readouts", description.readouts),
        ("environment", description.environment),
        ("streams", description.streams),
    )
    return {
        f"{table}.{name}": settings.identity
        for table, devices in tables
        for name, settings in devices.items()
        if settings.identity is not None
    }


def _differences(device: Answers, twin: Answers, stated: str | None) -> Iterator[Difference]:
    for name in [*device.compared, *(name for name in twin.compared if name not in device.compared)]:
        said, expected = device.compared.get(name), twin.compared.get(name)
        if name == "identity" and stated is not None and said is not None and stated in said:
            continue  # it is the one that the rig file means
        if name == "identity" and said is not None and _UNASKED in said and _UNASKED in (expected or ""):
            continue  # what is told is our own text, with the port in it
        if said is not None and said != expected:
            yield Difference(name, said, expected or "nothing")
    yield from _other_sizes(device, twin)
    yield from _swapped(device.recorded, twin.recorded)


def _other_sizes(device: Answers, twin: Answers) -> Iterator[Difference]:
    for name, tolerance in (("gravity", SAME_GRAVITY), ("samples_hz", SAME_RATE)):
        said, expected = device.recorded.get(name), twin.recorded.get(name)
        if isinstance(said, float) and isinstance(expected, float) and abs(said - expected) > tolerance * abs(expected):
            yield Difference(name, f"{said:.4g}", f"{expected:.4g}")


def _swapped(device: Mapping[str, float | str], twin: Mapping[str, float | str]) -> Iterator[Difference]:
    """Yield the pairs of channels of which each reads what the other's twin reads."""
    names = [name for name in device if "." in name and isinstance(device[name], float) and name in twin]

    def is_same(first: str, second: str) -> bool:
        said, expected = float(device[first]), float(twin[second])
        return abs(said - expected) <= SAME_VOLTS * max(abs(said), abs(expected), 1e-3)

    reads = {name: [other for other in names if is_same(name, other)] for name in names}
    yield from (_gone_round(ring, device, twin) for ring in _rings(reads))
    for index, name in enumerate(names):
        for other in names[index + 1 :]:
            if is_same(name, other) and is_same(other, name) and not (is_same(name, name) or is_same(other, other)):
                yield Difference(
                    f"channels {name} and {other}",
                    f"{device[name]:.6g} and {device[other]:.6g}",
                    f"{twin[name]:.6g} and {twin[other]:.6g}: they changed places",
                )


def _rings(reads: Mapping[str, list[str]]) -> Iterator[list[str]]:
    """Yield channels of which each reads, of all signals, that of the next alone, and the last that of the first."""
    next_of = {name: others[0] for name, others in reads.items() if len(others) == 1}
    seen: set[str] = set()
    for first in next_of:
        ring, name = [first], next_of[first]
        while name in next_of and name not in ring:
            ring.append(name)
            name = next_of[name]
        if name == first and len(ring) > 2 and not seen & set(ring):
            seen |= set(ring)
            yield ring


def _gone_round(ring: list[str], device: Mapping[str, float | str], twin: Mapping[str, float | str]) -> Difference:
    said, expected = (", ".join(f"{side[name]:.6g}" for name in ring) for side in (device, twin))
    return Difference(f"channels {', '.join(ring)}", said, f"{expected}: each reads the signal of the next")


def _wire_differences(folder: Path, key: str) -> Iterator[Difference]:
    """Yield replies whose form is another one, each question once. What a stream sends unasked has no question."""
    device, twin = (folder / side / f"{key}.jsonl" for side in ("device", "twin"))
    if key.startswith("streams.") or not (device.exists() and twin.exists()):
        return
    said, expected = _forms(read_transcript(device)), _forms(read_transcript(twin))
    for request, forms in said.items():
        strange = [form for form in forms if form not in expected.get(request, forms)]
        if strange:
            yield Difference(f"reply to {_shown(request)}", strange[0], expected[request][0])


def _forms(entries: list[Entry]) -> dict[bytes, list[str]]:
    """Question to the forms of its answers, each once, in the order met: a state is told in more than one way."""
    forms: dict[bytes, list[str]] = {}
    request, reply, was_reading = b"", b"", False
    for entry in [*entries, Entry(0, 0.0, "write", b"")]:
        if entry.operation != "write":
            reply, was_reading = reply + entry.data, True
            continue
        if was_reading:
            known = forms.setdefault(request, [])
            known += [form for form in [_form(reply)] if form not in known]
            request, reply, was_reading = b"", b"", False
        request += entry.data
    return forms


def _form(reply: bytes) -> str:
    """Return the form of an answer. Text: every whole number an N, decimals and ends as they are. Bytes: how many."""
    if not reply:
        return "nothing"
    if not all(32 <= byte < 127 or byte in b"\r\n\t" for byte in reply):
        return f"{len(reply)} bytes"
    text = re.sub(rb"\.\d+", lambda found: b"." + b"d" * (len(found[0]) - 1), _NUMBER.sub(b"N", reply))
    return _shown(re.sub(rb"(?<![A-Za-z])-(?=N)", b"+", text))


def _shown(data: bytes) -> str:
    return repr(data[:_SHOWN])[1:] + ("…" if len(data) > _SHOWN else "")


def document_of(proofs: tuple[DeviceProof, ...]) -> dict[str, object]:
    """Return what ``--json`` prints and the bundle keeps."""
    return {
        "devices": [
            {
                "device": proof.key,
                "answers": proof.answers.compared,
                "told": json.loads(json.dumps(proof.answers.recorded)),
                "differences": [
                    {"field": difference.field, "device": difference.device, "twin": difference.twin}
                    for difference in proof.differences
                ],
            }
            for proof in proofs
        ],
        "differences": sum(len(proof.differences) for proof in proofs),
    }
