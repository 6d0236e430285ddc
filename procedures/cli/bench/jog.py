"""``calrig jog``: motions and looks by hand, under the limits and the lock of the rig; alone, the jog screen."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from typing import Annotated, Any

from cyclopts import Parameter

from ams.units import printed
from ams.whole_file import replace_file
from procedures.cli.bench.homes_kept import homes_kept
from procedures.cli.bench.positions import position_in_words, positions_document
from procedures.cli.bench.stop_axes import stop_axes
from procedures.cli.locations import shared_archive_url
from procedures.cli.options import Flag, Json
from procedures.cli.options import Rig as RigFile
from procedures.cli.output import note, print_json, say
from procedures.cli.queues_disarmed import note_disarmed
from procedures.cli.run.stopping import stoppable_wait
from procedures.errors import ExitStatus, RequestError
from procedures.jog_screen.inferred import inferred_attitude
from procedures.jog_screen.served import jog_for_pages
from procedures.lease.keeper import leased
from procedures.numbers import finite
from rig.abilities.abilities import Wait
from rig.abilities.rest import band_deg
from rig.assembly.open_rig import Rig, choose_clock, open_rig
from rig.assembly.unguarded import unguarded_sentences
from rig.clock import Clock, SystemClock, VirtualClock
from rig.description.device_settings import TWIN_PORT
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import RigError, WaitEnded
from rig.motion import jog as by_hand
from rig.motion.jog import home, readings
from rig.motion.standstill import stop_what_moves

LIVE_PAUSE_S = 0.2


def jog(
    *,
    rig: RigFile,
    axis: str | None = None,
    to: float | None = None,
    by: float | None = None,
    rate: float | None = None,
    for_s: Annotated[float | None, Parameter(name="--for")] = None,
    home: Flag = False,
    stop: Flag = False,
    read: Flag = False,
    samples: int = 10,
    live: Flag = False,
    json: Json = False,
    coefficient_set: Annotated[Path | None, Parameter(name="--set")] = None,
    snapshot: Path | None = None,
    log: Path | None = None,
    served: Annotated[bool, Parameter(negative=(), show=False)] = False,
) -> ExitStatus:
    """Move one axis by hand, or read the channels; with nothing but --rig, at a terminal, the jog screen.

    Every move ends at rest, verified by read-back. A rate is stopped after its time, at Ctrl-C, and when the terminal
    is lost.

    Parameters
    ----------
    axis
        The axis to move, such as pitch.
    to
        Go to this attitude, degrees.
    by
        Go this much further, degrees; may be negative.
    rate
        Turn at this rate, degrees a second, for the time of --for; the rate measured meanwhile is told.
    for_s
        How long to turn, seconds.
    home
        Run the reference move of --axis.
    stop
        Stop --axis, or every axis, and see it stand.
    read
        Read every channel and every thermometer of the rig (after the move, if one is asked for); of streams it is
        said that they are not read.
    samples
        Readings a channel.
    live
        Go on reading until Ctrl-C.
    coefficient_set
        For the screen: a coefficient set, any format; the attitude that it makes of the readings is shown.
    snapshot
        For the screen: the CSV file that snapshots are added to; by default beside the rig file.
    log
        For the screen: the file that every action is added to, a JSON line each; by default beside the rig file.
    served
        For the console: orders as lines of JSON on standard input, what is seen on standard output.
    """
    wanted = _wanted(to, by, rate, home=home, stop=stop)
    _refuse_unclear(axis, wanted, read or live, samples, for_s, live=live and json)
    description = read_rig(rig)
    if served or (not (wanted or read or live or json) and sys.stdin.isatty() and sys.stdout.isatty()):
        return _screen(description, rig, coefficient_set, snapshot, log, served=served)
    if coefficient_set or snapshot or log:
        raise RequestError(
            "jog: --set, --snapshot and --log belong to the screen, which needs a terminal; nothing moved"
        )
    for sentence in unguarded_sentences(description) if wanted else ():
        note(sentence)
    document: dict[str, Any] = {"rig": description.rig.name}
    if stop:
        document |= stop_axes(description, rig, axis)  # nobody's lease keeps anybody from a stop
        if not (read or live):
            _tell_stop(document, json)
            return ExitStatus.DONE
        wanted = []
    with (
        _stop_first(document if stop else {}, json) as is_read,
        leased(shared_archive_url(), "jog", note) as lease,
        open_rig(description, rig_file=rig, purpose="jog", write=replace_file, claim=lease.claim) as opened,
        stoppable_wait(opened.clock) as wait,
        homes_kept(opened),
    ):
        note_disarmed()
        for sentence in stop_what_moves(opened.axes, opened.clock, opened.motion) if wanted else ():
            note(sentence)
        if wanted:
            opened.require_identities()
        if wanted:
            _home_what_has_none(opened, None if home else axis, wait)
        is_reading = read or live or not wanted
        if is_reading:
            for readout in opened.readouts.values():
                readout.prepare()
        if rate is not None and for_s is not None and axis is not None:
            document |= {"axis": axis, **_turned(opened, axis, rate, for_s, wait)}
        elif wanted:
            assert axis is not None
            document |= {"axis": axis, "position_deg": _move(opened, axis, to, by, wait)}
        if is_reading:
            document |= _read(opened, samples, wait)
        _tell(document, json)
        is_read.set()
        if live:
            _follow(opened, samples, wait)
    return _ended(document)


def _screen(
    description: RigDescription,
    rig: Path,
    coefficient_set: Path | None,
    snapshot: Path | None,
    log: Path | None,
    *,
    served: bool,
) -> ExitStatus:
    """Run the jog screen, or the session behind a page of the console.

    Twins of this process live in real time there, whatever the file says of virtual time.
    """
    for name, axis in description.axes.items():
        if axis.port == "terminal":
            raise RequestError(
                f"jog: axes.{name}: port: this axis asks its operator at this terminal, which the screen needs;"
                " nothing was opened; jog it with --axis, or give its operator a terminal elsewhere (socket://host:port)"
            )
    inferred = None if coefficient_set is None else inferred_attitude(coefficient_set, description)
    actions = log or rig.with_name(f"{rig.stem}.jog.jsonl")
    snapshots = snapshot or rig.with_name(f"{rig.stem}.snapshots.csv")
    with (
        leased(shared_archive_url(), "jog", note) as lease,
        open_rig(
            description,
            clock=_bench_clock(description),
            rig_file=rig,
            purpose="jog",
            write=replace_file,
            claim=lease.claim,
        ) as opened,
        homes_kept(opened),
    ):
        note_disarmed()
        if served:
            with open(sys.stdin.fileno(), "rb", buffering=0, closefd=False) as orders:
                return jog_for_pages(opened, actions, snapshots, inferred, orders, sys.stdout.buffer, note)
        from procedures.jog_screen.session import jog_on_screen  # textual: not for a single motion

        return jog_on_screen(opened, rig, actions, snapshots, inferred, note)


def _bench_clock(description: RigDescription) -> Clock:
    """Return the clock for a person who watches: the machine's time where the rig's is virtual."""
    clock = choose_clock(description)
    return SystemClock() if isinstance(clock, VirtualClock) else clock


def _follow(opened: Rig, samples: int, wait: Wait) -> None:
    """Print one line a round with every channel's mean, until the wait is ended."""
    try:
        while True:
            readings = _readings(opened, samples, wait)
            say("   ".join(f"{name} {_mean(reading)}" for name, reading in readings.items()))
            SystemClock().sleep(LIVE_PAUSE_S)
    except WaitEnded:
        return


def _mean(reading: dict[str, Any], with_spread: bool = False) -> str:
    unit = next(key for key in reading if key.startswith("mean_")).removeprefix("mean_")
    if (mean := reading[f"mean_{unit}"]) is None:
        return "overload"
    spread = f"   s {reading[f'standard_deviation_{unit}'] or 0.0:.2g} {printed(unit)}" if with_spread else ""
    return f"{mean:+.7f} {printed(unit)}{spread}"


def _wanted(to: float | None, by: float | None, rate: float | None, *, home: bool, stop: bool) -> list[str]:
    given = {
        "--to": to is not None,
        "--by": by is not None,
        "--rate": rate is not None,
        "--home": home,
        "--stop": stop,
    }
    return [name for name, is_given in given.items() if is_given]


def _refuse_unclear(
    axis: str | None, wanted: list[str], read: bool, samples: int, for_s: float | None, *, live: bool
) -> None:
    if live:
        raise RequestError("jog: --live goes on for ever and --json is one document; give one of them; nothing moved")
    if len(wanted) > 1:
        raise RequestError(f"jog: {' and '.join(wanted)} together are unclear; give one of them; nothing moved")
    if wanted and axis is None and "--stop" not in wanted:
        raise RequestError(f"jog: {wanted[0]} needs --axis; nothing moved")
    if ("--rate" in wanted) != (for_s is not None):
        raise RequestError("jog: --rate and --for belong together: a rate ends after its time; nothing moved")
    if for_s is not None and not 0.0 < for_s <= 86_400.0:
        raise RequestError(f"jog: --for: got {for_s:g} s, allowed above 0 up to 86400 s; nothing moved")
    if axis is not None and not wanted and not read:
        raise RequestError("jog: --axis needs --to, --by, --rate, --home or --stop; nothing moved")
    if samples < 2:
        raise RequestError(f"jog: --samples: got {samples}, allowed 2 or more; nothing moved")


def _move(opened: Rig, axis: str, to: float | None, by: float | None, wait: Wait) -> float:
    with by_hand.doubt_named(opened, axis), by_hand.seen_at_rest(opened, axis):
        if to is not None:
            return by_hand.jog_to(opened, axis, to, wait, note)
        if by is not None:
            return by_hand.jog_by(opened, axis, by, wait, note)
        return by_hand.home(opened, axis, wait, note)


def _turned(opened: Rig, axis: str, rate_dps: float, for_s: float, wait: Wait) -> dict[str, Any]:
    with by_hand.doubt_named(opened, axis):
        turn = by_hand.turn_for(opened, axis, rate_dps, for_s, wait)
    measured = turn.measured
    return {
        "commanded_dps": rate_dps,
        "rate_dps": measured.rate_dps,
        "rate_limit_dps": measured.uncertainty_dps,
        "rate_doubt": turn.doubt,
        "turned_deg": measured.turned_deg,
        "position_deg": opened.axes[axis].state().position_deg,
    }


def _ended(document: dict[str, Any]) -> ExitStatus:
    """Return the status, with a word on a turn that was not made as asked; what was not read is told already."""
    if None in document.get("temperatures_degc", {}).values():
        return ExitStatus.FAILED
    if not (doubt := document.get("rate_doubt")):
        return ExitStatus.DONE
    note(f"{document['axis']}: {doubt}")
    return ExitStatus.FAILED


def _moving(opened: Rig, before_deg: dict[str, float | None]) -> list[str]:
    """Tell of every axis that did not stand while the channels were read, such as one that a dead process left turning.

    The machine's word alone is not enough: some have none for a rotation.
    """
    moving = []
    for name, device in opened.axes.items():
        state = device.state()
        turned_deg = 0.0 if (from_deg := before_deg[name]) is None or state.unknown else state.position_deg - from_deg
        if state.is_moving or abs(turned_deg) > band_deg(device.arrival_tolerance_deg):
            moving.append(name)
            note(
                f"{name}: moves: {turned_deg:+.4f}° while the channels were read, which are of no one attitude;"
                " calrig jog --stop stops it"
            )
    return moving


def _readings(opened: Rig, samples: int, wait: Wait) -> dict[str, dict[str, float | int | None]]:
    channels = [channel for readout in opened.readouts.values() for channel in readout.channels]
    return {
        reading.channel: {
            f"mean_{reading.unit}": finite(reading.mean),
            f"standard_deviation_{reading.unit}": finite(reading.standard_deviation),
            "samples": reading.samples,
            "overloads": reading.overloads,
        }
        for reading in readings(opened, channels, samples, wait)
    }


def _home_what_has_none(opened: Rig, moved: str | None, wait: Wait) -> None:
    """Twins in this process were switched on by it: unlike a machine they cannot have been homed before. An operator,
    too, is asked for the zero of the axis that is ``moved``: nobody remembers it. Machines are left alone.
    """
    for name, axis in opened.description.axes.items():
        if axis.port == TWIN_PORT or (name == moved and axis.is_set_by_hand):
            home(opened, name, wait)


def _read(opened: Rig, samples: int, wait: Wait) -> dict[str, Any]:
    """Read what axes, chambers and channels tell now."""
    document = positions_document({name: device.state() for name, device in opened.axes.items()})
    temperatures_degc = _temperatures(opened)
    readings = _readings(opened, samples, wait)
    moving = _moving(opened, document["positions_deg"])
    return {**document, "temperatures_degc": temperatures_degc, "readings": readings, "moving": moving}


def _temperatures(opened: Rig) -> dict[str, float | None]:
    """Read every chamber and probe; None where one does not answer, which is said: all others are read.

    It is said, too, which streams are not read: they are recorded over time, not on demand.
    """
    for name, stream in opened.streams.items():
        channels = ", ".join(channel.rpartition(".")[2] for channel in stream.channels)
        note(f"streams.{name}: not read here ({channels}); calrig prove reads a stream")
    found: dict[str, float | None] = {}
    for name, environment in opened.environments.items():
        try:
            found[name] = environment.temperature_degc()
        except WaitEnded:
            raise
        except RigError as error:
            found[name] = None
            note(f"{name}: not read: {error}")
    return found


@contextmanager
def _stop_first(document: dict[str, Any], json: bool) -> Iterator[Event]:
    """Tell of a stop, unless there was none: before anything is opened that may fail, to people; else where it did.

    What it yields is set once the one document of JSON is printed with all that was read.
    """
    stop, is_read = dict(document), Event()
    if stop and not json:
        _tell_stop(stop, json)
    try:
        yield is_read
    except BaseException:
        if stop and json and not is_read.is_set():
            print_json(stop)
        raise


def _tell_stop(document: dict[str, Any], json: bool) -> None:
    if json:
        print_json(document)
        return
    for name in document["stopped"]:
        say(f"{name}: {position_in_words(document, name, 'stands still at ')}")


def _tell(document: dict[str, Any], json: bool) -> None:
    if json:
        print_json(document)
        return
    if "rate_dps" in document:
        say(
            f"{document['axis']}: turned {document['turned_deg']:+g}° at {document['rate_dps']:+.6g} °/s"
            f" (± {document['rate_limit_dps']:.2g} °/s)"
        )
    if "axis" in document:
        say(f"{document['axis']}: at rest at {document['position_deg']:g}°")
    for name in document.get("positions_deg", {}):
        if name not in document.get("stopped", ()):
            say(f"{name:<16} {position_in_words(document, name)}")
    for name, degc in document.get("temperatures_degc", {}).items():
        say(f"{name:<16} {'does not answer' if degc is None else f'{degc:.2f} °C'}")
    for channel, reading in document.get("readings", {}).items():
        say(f"{channel:<16} {_mean(reading, with_spread=True)}   ({reading['samples']} readings)")
