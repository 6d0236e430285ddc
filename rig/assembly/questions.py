"""What a device is asked at first contact: all that can be asked without motion and heat, and with motion where asked.

The same is asked of its twin; what is compared: :mod:`rig.assembly.prove`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from rig.abilities.abilities import Axis, Environment, Readout, Stream, Wait
from rig.assembly.open_rig import Rig
from rig.clock import Clock
from rig.errors import DeviceFault, DeviceRefused, RequestRefused, RigError
from rig.motion.move import move_and_arrive, trusted_state

LARGEST_MOVE_DEG, MOVE_DEG = 5.0, 2.0
READINGS = 3
STREAM_S = 1.0
STOP_LOOK_S, STOP_LIMIT_S = 0.2, 30.0


@dataclass
class Answers:
    """What one device told: ``compared`` must be as the twin's, ``recorded`` is for the record."""

    compared: dict[str, str] = field(default_factory=dict)
    recorded: dict[str, float | str] = field(default_factory=dict)


def answers_of(rig: Rig, motion: str | None) -> dict[str, Answers]:
    """Ask every device of an open rig; ``motion`` names an axis that moves by at most 5 degrees."""
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
    if motion is not None and motion in rig.axes and "identity" in answers[f"axes.{motion}"].compared:
        _move(rig.axes[motion], rig.clock, answers[f"axes.{motion}"])
    return answers


def _try(answers: Answers, name: str, ask: Callable[[], str]) -> bool:
    """Return whether it answered; an error is an answer, told by its kind and its first sentence."""
    try:
        answers.compared[name] = ask()
    except RigError as error:
        answers.compared[name] = f"{type(error).__name__}: {error}"
        return False
    return True


def _ask_axis(axis: Axis, answers: Answers) -> None:
    def state() -> str:
        axis_state = axis.state()
        answers.recorded |= {"position_deg": axis_state.position_deg, "is_homed": str(axis_state.is_homed).lower()}
        motion = "moving" if axis_state.is_moving else "at rest"
        seat = "seated" if axis_state.is_seated else "not seated"
        return f"{motion}, {seat}{f', {axis_state.fault}' if axis_state.fault else ''}"

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
            answers.recorded[channel] = float(read.samples.mean())
            return f"{read.samples.size} readings{', overload' if read.overload.any() else ''}"

        _try(answers, f"reading {channel}", burst)


def _ask_environment(chamber: Environment, answers: Answers) -> None:
    def look() -> str:
        answers.recorded |= {"temperature_degc": chamber.temperature_degc(), "setpoint_degc": chamber.setpoint_degc()}
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
        answers.recorded |= {f"mean {name}": mean for name, mean in means.items()}
        answers.recorded["samples_hz"] = block.samples / STREAM_S
        if {"ax", "ay", "az"} <= means.keys():
            answers.recorded["gravity"] = sum(means[name] ** 2 for name in ("ax", "ay", "az")) ** 0.5
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
        rest_deg = _await_rest(axis, clock)
        low_deg, high_deg = sorted((from_deg, far_deg))
        if not low_deg - axis.arrival_tolerance_deg <= rest_deg <= high_deg + axis.arrival_tolerance_deg:
            raise DeviceFault(f"{axis.name}: it stopped at {rest_deg:g}°, beyond its move; look at the machine")
        move_and_arrive(axis, from_deg, clock, clock.sleep)
        return "stopped inside the move"

    def limits() -> str:
        for beyond_deg in (axis.limits_deg[0] - 1.0, axis.limits_deg[1] + 1.0):
            try:
                axis.check_target(beyond_deg)
            except RequestRefused:
                continue
            return f"{beyond_deg:g}° is not refused"
        return "refused before anything is sent"

    if _try(answers, "move", there_and_back):
        _try(answers, "stop", stopped)
    _try(answers, "limits", limits)


def _ends(axis: Axis) -> tuple[float, float]:
    """Return where it is, on its increment, and a place at most 5 degrees away inside its limits.

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
            f"{axis.name}: --motion: its smallest step is {step_deg:g}°, allowed here {LARGEST_MOVE_DEG:g}; nothing"
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
