"""A session at the jog screen, from the open rig to axes that stand still."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from threading import Event

from procedures.errors import ExitStatus
from procedures.jog_screen.app import JogApp, is_hung_up
from procedures.jog_screen.heading import Heading
from procedures.jog_screen.inferred import InferredAttitude
from procedures.jog_screen.leaving import close, leave_anyway
from procedures.jog_screen.log import ActionLog, Snapshots
from procedures.jog_screen.worker import Bench
from rig.assembly.open_rig import Rig
from rig.clock import ScaledClock, SystemClock
from rig.lines.lock import owner_of
from rig.threads import begun


def jog_on_screen(
    rig: Rig,
    rig_file: Path,
    log: Path,
    snapshots: Path,
    inferred: InferredAttitude | None,
    note: Callable[[str], None],
) -> ExitStatus:
    """Show the screen until the operator leaves; however it ends, every axis is stopped, and ``note`` hears how it is.

    Where not every axis was seen to stand the status is 1.
    """
    clock = SystemClock()
    actions = ActionLog(log, clock)
    bench = Bench(rig, actions, Snapshots(snapshots, clock), clock, inferred)
    ended = Event()
    app = JogApp(bench, _heading(rig, rig_file, log))
    try:
        begun(partial(leave_anyway, bench, ended), "the end of the screen")
        app.heed_signals()
        app.run()
        if is_hung_up():
            bench.guard.lose("the terminal is gone")
    finally:
        close(bench, note)
        actions.close()
        ended.set()
        note(f"{bench.last_stop.in_words}; actions are in {log}")
    if app.defect is not None and not bench.guard.lost:
        raise app.defect
    return bench.last_stop.exit_status(bench.guard.lost)


def _heading(rig: Rig, rig_file: Path, log: Path) -> Heading:
    description = rig.description
    twins = "twins" if description.is_simulated else "machines"
    pace = f" at {rig.clock.factor:g} times real time" if isinstance(rig.clock, ScaledClock) else " in real time"
    owner = owner_of(str(rig_file))
    return Heading(
        rig=description.rig.name,
        time=twins + pace,
        owner=f"{rig_file.name}: held by {owner}" if owner else "",
        log=f"actions: {log}",
        sensors={name: frozenset(sensor.channels.values()) for name, sensor in description.sensors.items()},
    )
