"""First contact with real devices: what each says of itself, beside what its twin would say.

Every device is asked all that can be asked without motion and heat (meters are reset and read, streams run for a
moment); the same is asked of the twins of the same rig file. What differs is named: what a device is, its unit and
scale, a reply that is missing, the form of a reply on the wire, channels that changed places. All bytes are kept, so
that what a device did becomes a transcript that a test replays.
"""

import json
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from rig.assembly.open_rig import Rig, open_rig
from rig.clock import Clock, VirtualClock
from rig.description.drivers import TABLES
from rig.description.rig_file import RigDescription
from rig.devices.abilities import Axis, Environment, Readout, Stream, Wait
from rig.drivers.twin_lines import without_twin
from rig.errors import DeviceFault, DeviceRefused, RequestRefused, RigError
from rig.lines.recording import LineSource, recording
from rig.link.transcript import Entry, read_transcript
from rig.motion.move import home_and_arrive, move_and_arrive, trusted_state

LARGEST_MOVE_DEG, MOVE_DEG = 5.0, 2.0
READINGS = 3
STREAM_S = 1.0
SAME_VOLTS = 0.01
"""Of the larger of two readings: nearer than this they are the same signal."""
SAME_GRAVITY, SAME_RATE = 0.2, 0.25
STOP_LOOK_S, STOP_LIMIT_S = 0.2, 30.0
_NUMBER = re.compile(rb"\d+(?=\.\d)|(?<![\d.])\d+(?![\d.])")
_SHOWN = 40
_UNASKED = "it cannot be asked who it is"


@dataclass(frozen=True, slots=True)
class Difference:
    """What a device says otherwise than its twin."""

    field: str
    device: str
    twin: str


@dataclass
class Answers:
    """What one device told: ``compared`` must be as the twin's, ``told`` is for the record."""

    compared: dict[str, str] = field(default_factory=dict)
    told: dict[str, float | str] = field(default_factory=dict)


@dataclass(frozen=True)
class DeviceProof:
    """One device of the rig file (``axes.pitch``)."""

    key: str
    answers: Answers
    differences: tuple[Difference, ...]
    has_twin: bool = True
    """Without one it is asked and recorded alone."""


def prove(
    description: RigDescription,
    folder: Path,
    *,
    rig_file: Path | None = None,
    motion: str | None = None,
    clock: Clock | None = None,
    line_source: LineSource | None = None,
) -> tuple[DeviceProof, ...]:
    """Ask the devices and their twins, keep every byte in ``folder`` (``device``, ``twin``), compare.

    A device whose driver has no twin is asked and kept alone.

    ``motion`` names an axis that moves, by at most 5 degrees; it must be homed. ``clock`` and ``line_source`` are those
    of the real side. Raises: what opening a rig raises, RequestRefused where the axis cannot be proven.
    """
    with ExitStack() as files:
        source = _through(recording(folder / "device", files), line_source)
        real = files.enter_context(
            open_rig(description, clock=clock, rig_file=rig_file, purpose="calrig prove", line_source=source)
        )
        device = _asked(real, motion)
    alone = without_twin(description)
    on_twins = _without(description.all_on_twins(), alone)
    with ExitStack() as files:
        now = VirtualClock(datetime(2024, 1, 1, tzinfo=UTC))
        twins = open_rig(on_twins, clock=now, line_source=recording(folder / "twin", files))
        moved = None if f"axes.{motion}" in alone else motion
        twin = _asked(_homed_like(files.enter_context(twins), device, moved), moved)
    wire = {key: tuple(_wire_differences(folder, key)) for key in device}
    stated = _stated(description)
    return tuple(
        DeviceProof(key, answers, (), has_twin=False)
        if key in alone
        else DeviceProof(key, answers, (*_differences(answers, twin[key], stated.get(key)), *wire[key]))
        for key, answers in device.items()
    )


def _without(description: RigDescription, keys: Collection[str]) -> RigDescription:
    """Return the rig without some of its devices."""
    left = {
        table: {name: device for name, device in getattr(description, table).items() if f"{table}.{name}" not in keys}
        for table in TABLES
    }
    return description.model_copy(update=left)


def _through(kept: LineSource, inner: LineSource | None) -> LineSource:
    if inner is None:
        return kept
    return lambda key, open_line: kept(key, lambda: inner(key, open_line))


def _homed_like(twins: Rig, device: Mapping[str, Answers], motion: str | None) -> Rig:
    """Twins wake without a home: those of axes that have one are homed, so that they are asked in the same state."""
    for name, axis in twins.axes.items():
        if name == motion or device[f"axes.{name}"].told.get("is_homed") == "true":
            home_and_arrive(axis, twins.clock, twins.clock.sleep)
    return twins


def _asked(rig: Rig, motion: str | None) -> dict[str, Answers]:
    answers = {key: Answers() for key in rig.by_table()}
    for key, device in rig.by_table().items():
        if not _try(answers[key], "identity", device.identify):
            continue
        if key.startswith("axes."):
            _ask_axis(rig.axes[key.removeprefix("axes.")], answers[key])
        elif key.startswith("readouts."):
            _ask_readout(rig.readouts[key.removeprefix("readouts.")], rig.clock.sleep, answers[key])
        elif key.startswith("environment."):
            _ask_environment(rig.environments[key.removeprefix("environment.")], answers[key])
        elif key.startswith("streams."):
            _ask_stream(rig.streams[key.removeprefix("streams.")], rig.clock, answers[key])
    if motion is not None and "identity" in answers[f"axes.{motion}"].compared:
        _move(rig.axes[motion], rig.clock, answers[f"axes.{motion}"])
    return answers


def _try(answers: Answers, name: str, ask: Callable[[], str]) -> bool:
    """Whether it answered; an error is an answer, told by its kind and its first sentence."""
    try:
        answers.compared[name] = ask()
    except RigError as error:
        answers.compared[name] = f"{type(error).__name__}: {error}"
        return False
    return True


def _ask_axis(axis: Axis, answers: Answers) -> None:
    def state() -> str:
        told = axis.state()
        answers.told |= {"position_deg": told.position_deg, "is_homed": str(told.is_homed).lower()}
        seat = "seated" if told.is_seated else "not seated"
        return f"{'moving' if told.is_moving else 'at rest'}, {seat}{f', {told.fault}' if told.fault else ''}"

    _try(answers, "state", state)


def _ask_readout(readout: Readout, wait: Wait, answers: Answers) -> None:
    def prepared() -> str:
        readout.prepare()
        return "set up and read back"

    if not _try(answers, "setting up", prepared):
        return
    for channel in readout.channels:

        def burst(channel: str = channel) -> str:
            read = readout.read(channel, READINGS, wait)
            answers.told[channel] = float(read.samples.mean())
            return f"{read.samples.size} readings{', overload' if read.overload.any() else ''}"

        _try(answers, f"reading {channel}", burst)


def _ask_environment(chamber: Environment, answers: Answers) -> None:
    def look() -> str:
        answers.told |= {"temperature_degc": chamber.temperature_degc(), "setpoint_degc": chamber.setpoint_degc()}
        return "temperature and set point are told"

    _try(answers, "temperature", look)


def _ask_stream(stream: Stream, clock: Clock, answers: Answers) -> None:
    def samples() -> str:
        stream.start()
        try:
            clock.sleep(STREAM_S)
            block = stream.poll()
        finally:
            stream.stop()
        means = {
            channel.rpartition(".")[2]: float(values.mean()) for channel, values in block.values.items() if values.size
        }
        answers.told |= {f"mean {name}": mean for name, mean in means.items()}
        answers.told["samples_hz"] = block.samples / STREAM_S
        if {"ax", "ay", "az"} <= means.keys():
            answers.told["gravity"] = sum(means[name] ** 2 for name in ("ax", "ay", "az")) ** 0.5
        return f"samples{'' if block.samples else ' are missing'}{', some are refused' if block.refused > 1 else ''}"

    _try(answers, "stream", samples)


def _move(axis: Axis, clock: Clock, answers: Answers) -> None:
    """Try a move and back, a stop on the way, the limits. Raises: RequestRefused before anything moved."""
    from_deg, far_deg = _ends(axis)

    def there_and_back() -> str:
        move_and_arrive(axis, far_deg, clock, clock.sleep)
        move_and_arrive(axis, from_deg, clock, clock.sleep)
        return "arrived there and back"

    def stopped() -> str:
        axis.start_move(far_deg)
        clock.sleep(STOP_LOOK_S)
        try:
            axis.stop()
        except DeviceRefused:
            _await_rest(axis, clock)
            return "there is no stop"
        place_deg = _await_rest(axis, clock)
        low_deg, high_deg = sorted((from_deg, far_deg))
        if not low_deg - axis.arrival_tolerance_deg <= place_deg <= high_deg + axis.arrival_tolerance_deg:
            raise DeviceFault(f"{axis.name}: it stopped at {place_deg:g} deg, beyond its move; look at the machine")
        move_and_arrive(axis, from_deg, clock, clock.sleep)
        return "stopped inside the move"

    def limits() -> str:
        for beyond_deg in (axis.limits_deg[0] - 1.0, axis.limits_deg[1] + 1.0):
            try:
                axis.check_target(beyond_deg)
            except RequestRefused:
                continue
            return f"{beyond_deg:g} deg is not refused"
        return "refused before anything is sent"

    if _try(answers, "move", there_and_back):
        _try(answers, "stop", stopped)
    _try(answers, "limits", limits)


def _ends(axis: Axis) -> tuple[float, float]:
    """Where it is, on its increment, and a place at most 5 degrees away inside its limits.

    An axis without a home is refused: a home may be far away.
    """
    state = trusted_state(axis)
    step_deg = axis.increment_deg * max(1.0, MOVE_DEG // axis.increment_deg) if axis.increment_deg else MOVE_DEG
    from_deg = (
        round(state.position_deg / axis.increment_deg) * axis.increment_deg
        if axis.increment_deg
        else (state.position_deg)
    )
    if step_deg > LARGEST_MOVE_DEG:
        raise RequestRefused(
            f"{axis.name}: --motion: its smallest step is {step_deg:g} deg, allowed here {LARGEST_MOVE_DEG:g}; nothing"
            " moved; leave --motion out"
        )
    far_deg = from_deg + (step_deg if from_deg + step_deg <= axis.limits_deg[1] else -step_deg)
    axis.check_target(far_deg)
    axis.check_target(from_deg)
    return from_deg, far_deg


def _await_rest(axis: Axis, clock: Clock) -> float:
    limit_s = clock.monotonic_s() + STOP_LIMIT_S
    while (state := axis.state()).is_moving:
        if clock.monotonic_s() >= limit_s:
            raise DeviceFault(f"{axis.name}: it does not come to rest within {STOP_LIMIT_S:g} s; look at the machine")
        clock.sleep(STOP_LOOK_S)
    return state.position_deg


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
    yield from _swapped(device.told, twin.told)


def _other_sizes(device: Answers, twin: Answers) -> Iterator[Difference]:
    for name, tolerance in (("gravity", SAME_GRAVITY), ("samples_hz", SAME_RATE)):
        said, expected = device.told.get(name), twin.told.get(name)
        if isinstance(said, float) and isinstance(expected, float) and abs(said - expected) > tolerance * abs(expected):
            yield Difference(name, f"{said:.4g}", f"{expected:.4g}")


def _swapped(device: Mapping[str, float | str], twin: Mapping[str, float | str]) -> Iterator[Difference]:
    """Pairs of channels of which each reads what the other's twin reads."""
    names = [name for name in device if "." in name and isinstance(device[name], float) and name in twin]

    def is_same(one: str, other: str) -> bool:
        said, expected = float(device[one]), float(twin[other])
        return abs(said - expected) <= SAME_VOLTS * max(abs(said), abs(expected), 1e-3)

    for place, one in enumerate(names):
        for other in names[place + 1 :]:
            if is_same(one, other) and is_same(other, one) and not (is_same(one, one) or is_same(other, other)):
                yield Difference(
                    f"channels {one} and {other}",
                    f"{device[one]:.6g} V and {device[other]:.6g} V",
                    f"{twin[one]:.6g} V and {twin[other]:.6g} V: they changed places",
                )


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
    """Of text: every whole number an N, decimals and ends as they are. Of bytes: how many."""
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
                "has_twin": proof.has_twin,
                "answers": proof.answers.compared,
                "told": json.loads(json.dumps(proof.answers.told)),
                "differences": [
                    {"field": one.field, "device": one.device, "twin": one.twin} for one in proof.differences
                ],
            }
            for proof in proofs
        ],
        "differences": sum(len(proof.differences) for proof in proofs),
    }
