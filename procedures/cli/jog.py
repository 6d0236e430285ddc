"""``calrig jog``: one motion or one look by hand, under the limits and the lock of the rig."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from procedures.cli.output import finite, print_json, say
from procedures.cli.stopping import stoppable_wait
from procedures.errors import RequestError

if TYPE_CHECKING:
    from rig.assembly import Rig
    from rig.devices.abilities import Wait

Json = Annotated[bool, Parameter(negative=())]
LIVE_PAUSE_S = 0.2


def jog(
    *,
    rig: Path,
    axis: str | None = None,
    to: float | None = None,
    by: float | None = None,
    home: Annotated[bool, Parameter(negative=())] = False,
    read: Annotated[bool, Parameter(negative=())] = False,
    samples: int = 10,
    live: Annotated[bool, Parameter(negative=())] = False,
    json: Json = False,
) -> None:
    """Move one axis by hand, or read the channels. Every move ends at rest, verified by read-back.

    Parameters
    ----------
    rig
        The rig file.
    axis
        The axis to move, such as pitch.
    to
        Go to this attitude, degrees.
    by
        Go this much further, degrees; may be negative.
    home
        Run the reference move of --axis.
    read
        Read every channel of the rig (after the move, if one is asked for).
    samples
        Readings a channel.
    live
        Go on reading until Ctrl-C.
    json
        Print one JSON document.
    """
    from rig.assembly import open_rig
    from rig.description import read_rig

    wanted = [name for name, given in (("--to", to is not None), ("--by", by is not None), ("--home", home)) if given]
    _refuse_unclear(axis, wanted, read or live, samples, live=live and json)
    description = read_rig(rig)
    with open_rig(description, rig_file=rig, purpose="jog") as opened, stoppable_wait(opened.clock) as wait:
        if wanted and description.uses_twins:
            _home_twins(opened, wait)
        document: dict[str, Any] = {"rig": description.rig.name}
        is_reading = read or live or not wanted
        if is_reading:
            for readout in opened.readouts.values():
                readout.prepare()
        if wanted:
            assert axis is not None
            document |= {"axis": axis, "position_deg": _move(opened, axis, to, by, wait)}
        if is_reading:
            document["positions_deg"] = {name: device.state().position_deg for name, device in opened.axes.items()}
            document["readings"] = _readings(opened, samples, wait)
        _tell(document, json)
        if live:
            _follow(opened, samples, wait)


def _follow(opened: "Rig", samples: int, wait: "Wait") -> None:
    """One line a round with every channel's mean, until the wait is ended."""
    from rig.clock import SystemClock
    from rig.errors import WaitEnded

    try:
        while True:
            told = _readings(opened, samples, wait)
            say("   ".join(f"{name} {_mean(reading)}" for name, reading in told.items()))
            SystemClock().sleep(LIVE_PAUSE_S)
    except WaitEnded:
        return


def _mean(reading: dict[str, float | int | None]) -> str:
    return "overload" if reading["mean_v"] is None else f"{reading['mean_v']:+.7f} V"


def _refuse_unclear(axis: str | None, wanted: list[str], read: bool, samples: int, *, live: bool) -> None:
    if live:
        raise RequestError("jog: --live goes on for ever and --json is one document; give one of them; nothing moved")
    if len(wanted) > 1:
        raise RequestError(f"jog: {' and '.join(wanted)} together are unclear; give one of them; nothing moved")
    if wanted and axis is None:
        raise RequestError(f"jog: {wanted[0]} needs --axis; nothing moved")
    if axis is not None and not wanted and not read:
        raise RequestError("jog: --axis needs --to, --by or --home; nothing moved")
    if samples < 2:
        raise RequestError(f"jog: --samples: got {samples}, allowed 2 or more; nothing moved")


def _move(opened: "Rig", axis: str, to: float | None, by: float | None, wait: "Wait") -> float:
    from rig import jog as by_hand

    if to is not None:
        return by_hand.jog_to(opened, axis, to, wait)
    if by is not None:
        return by_hand.jog_by(opened, axis, by, wait)
    return by_hand.home(opened, axis, wait)


def _readings(opened: "Rig", samples: int, wait: "Wait") -> dict[str, dict[str, float | int | None]]:
    from rig.jog import readings

    channels = [channel for readout in opened.readouts.values() for channel in readout.channels]
    return {
        reading.channel: {
            "mean_v": finite(reading.mean_v),
            "standard_deviation_v": finite(reading.standard_deviation_v),
            "samples": reading.samples,
            "overloads": reading.overloads,
        }
        for reading in readings(opened, channels, samples, wait)
    }


def _home_twins(opened: "Rig", wait: "Wait") -> None:
    """Twins in this process were switched on by it: unlike a machine they cannot have been homed before."""
    from rig.jog import home

    for axis in opened.axes:
        home(opened, axis, wait)


def _tell(document: dict[str, Any], json: bool) -> None:
    if json:
        print_json(document)
        return
    if "axis" in document:
        say(f"{document['axis']}: at rest at {document['position_deg']:g}°")
    for name, position_deg in document.get("positions_deg", {}).items():
        say(f"{name:<16} {position_deg:+.4f}°")
    for channel, reading in document.get("readings", {}).items():
        mean_v, sd_v = reading["mean_v"], reading["standard_deviation_v"]
        told = _mean(reading) if mean_v is None else f"{_mean(reading)}   s {sd_v or 0.0:.2g} V"
        say(f"{channel:<16} {told}   ({reading['samples']} readings)")
