"""What is done at the attitude of a dwell: it rests and is read, it turns, it follows a motion, maybe in a field.

A dwell with streams records them all at once. Where a reference sensor is declared, it tells the attitude, and where it
closes the loop the axes are corrected until it does.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import floor
from types import MappingProxyType

from procedures.plan.adaptive import Reading
from procedures.plan.plan import Plan
from procedures.plan.steps import Applied, Dwell, Follow, Rest, Turn
from procedures.records.dwells import Measurement, MotionRecord, StreamTiming
from procedures.run.dwell.alignment import align, timing
from procedures.run.dwell.attitude_reference import approach, reference_attitude
from procedures.run.dwell.following import follow
from procedures.run.dwell.measure import Announcement, OpenRig, look, measure, read_channels, settle_at
from procedures.run.dwell.stream_recorder import recording
from procedures.run.dwell.turning import as_readings, streams_of, turn
from rig.abilities.abilities import Wait
from rig.errors import DeviceFault

_FIELD_LOOK_S = 0.1


def perform(
    rig: OpenRig,
    plan: Plan,
    dwell: Dwell,
    announcement: Announcement,
    wait: Wait,
    stand: Wait,
    readings: Mapping[str, Reading] = MappingProxyType({}),
) -> Measurement:
    """Everything of one attempt but the way to the attitude.

    ``stand``: waits for a field, in which nothing moves and nothing is read.
    ``readings``: of the channels that are not read as ``[dwell]`` says; they rest and are no streams.

    Raises: RigError of the device that failed, WaitEnded.
    """
    applied_ut = {} if dwell.applied is None else _apply(rig, dwell.applied, stand)
    match dwell.motion:
        case Turn():
            measured = turn(rig, plan, dwell, dwell.motion, announcement, wait)
        case Follow():
            measured = follow(rig, plan, dwell, dwell.motion, announcement, wait)
        case _ if _is_plain(rig, plan, dwell):
            return measure(rig, plan, dwell, announcement, wait, readings)
        case _:
            measured = _at_rest(rig, plan, dwell, announcement, wait, readings)
    assert measured.motion is not None
    return replace(measured, motion=replace(measured.motion, field_ut=applied_ut))


def _is_plain(rig: OpenRig, plan: Plan, dwell: Dwell) -> bool:
    """Return True for a dwell of readouts only, for as many samples as ``[dwell]`` says."""
    return (
        dwell.motion is None and dwell.applied is None and plan.attitude_reference is None and not streams_of(rig, plan)
    )


def _apply(rig: OpenRig, applied: Applied, stand: Wait) -> dict[str, float]:
    """Bring a coil to its field where it does not stand there. Raises: DeviceFault, WaitEnded (withdrawn)."""
    coil = rig.fields[applied.coil]
    if coil.state().applied_ut != applied.field_ut:
        coil.start_field(applied.field_ut)
        try:
            while (state := coil.state()).applied_ut != applied.field_ut:
                if state.fault:
                    raise DeviceFault(
                        f"field.{applied.coil}: {state.fault}; {applied.field_ut:g} µT do not stand; see to the coil"
                    )
                stand(_FIELD_LOOK_S)
        finally:
            if coil.state().applied_ut != applied.field_ut:
                coil.stop()
    return {applied.coil: applied.field_ut}


def _at_rest(
    rig: OpenRig,
    plan: Plan,
    dwell: Dwell,
    announcement: Announcement,
    wait: Wait,
    chosen: Mapping[str, Reading],
) -> Measurement:
    """Settle, correct by the reference, record all streams at once and every other channel one after the other."""
    announcement.settle(rig.chance)
    commanded_deg = approach(rig, plan, dwell, wait)
    settled = settle_at(rig, plan, wait)
    reference_deg = reference_attitude(rig, plan, wait)
    before = look(rig, dwell.targets_deg)
    timings: tuple[StreamTiming, ...] = ()
    with recording(streams_of(rig, plan), rig.clock, wait) as recorder:
        recorder.start()
        announcement.read(rig.chance)
        began_s = rig.clock.monotonic_s()
        wanted = {name: _samples(plan, dwell, stream.rate_hz) for name, stream in streams_of(rig, plan).items()}
        on_demand = [channel for channel in plan.channels if channel.partition(".")[0] not in wanted]
        readings = read_channels(rig, plan, on_demand, recorder.wait, chosen)
        while short := [name for name, count in wanted.items() if recorder.samples(name) < count]:
            left = max((wanted[name] - recorder.samples(name)) / rig.streams[name].rate_hz for name in short)
            recorder.wait(left + recorder.poll_s)
        parts = {name: recording.part(0, wanted[name]) for name, recording in recorder.stop().items()}
    readings |= as_readings(parts, plan, began_s)
    timings = tuple(timing(part, align(part)) for part in parts.values())
    record = MotionRecord(commanded_deg=commanded_deg, streams=timings)
    after = look(rig, dwell.targets_deg)
    return Measurement(before, after, readings, settled.is_settled, settled.took_s, record, reference_deg or None)


def _samples(plan: Plan, dwell: Dwell, rate_hz: float) -> int:
    """Return the samples of one stream: as long as the dwell rests, or as many as ``[dwell]`` says."""
    if isinstance(dwell.motion, Rest):
        return floor(dwell.motion.rest_seconds * rate_hz + 1e-6)
    return plan.dwell.samples
