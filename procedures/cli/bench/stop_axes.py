"""``calrig jog --stop`` where no stop guard stops them: every line of axes by itself, and nothing but axes.

A meter that is switched off, and a line that is gone, keep no axis of another line from its stop.
"""

from pathlib import Path
from typing import Any

from ams.whole_file import replace_file
from procedures.cli.bench.homes_kept import homes_kept
from procedures.cli.bench.positions import position_in_words, positions_document
from procedures.cli.output import note
from procedures.cli.queues_disarmed import disarmed_by
from procedures.cli.run.stopping import stoppable_wait
from procedures.queue.hands import JOG_STOP
from rig.abilities.abilities import AxisState
from rig.assembly.open_rig import choose_clock, open_rig
from rig.description.rig_file import RigDescription
from rig.drivers.twin_lines import axis_lines
from rig.errors import DeviceFault, RequestRefused, RigError, WaitEnded
from rig.motion import jog as by_hand


def stop_axes(description: RigDescription, rig_file: Path, axis: str | None) -> dict[str, Any]:
    """Stop an axis, or every axis, and see it stand; return which, and where each stands.

    Raises: RequestRefused for an axis that there is not; what kept one from its stop, and DeviceFault for one that
    stands outside its limits, when all others were told.
    """
    if axis is not None and axis not in description.axes:
        raise RequestRefused(f"no axis {axis!r} (allowed: {', '.join(description.axes)}); nothing moved")
    stand: dict[str, AxisState] = {}
    failures: list[RigError] = []
    try:
        with stoppable_wait(choose_clock(description)):  # a signal cuts no stop short
            for names in axis_lines(description.axes):
                if axis is None or axis in names:
                    try:
                        stopped, outside = _stopped(_alone(description, names), rig_file, axis)
                        stand |= stopped
                        failures += outside
                    except WaitEnded:
                        raise
                    except RigError as error:
                        failures.append(error)
    finally:
        for sentence in disarmed_by(JOG_STOP, rig=rig_file):
            note(sentence)
    document = positions_document(stand)
    if failures:
        for name in stand:
            note(f"{name}: {position_in_words(document, name, 'stands still at ')}")
        raise failures[0] if len(failures) == 1 else DeviceFault("; ".join(dict.fromkeys(map(str, failures))))
    return {"stopped": list(stand), **document}


def _alone(description: RigDescription, names: tuple[str, ...]) -> RigDescription:
    nothing: dict[str, object] = {table: {} for table in ("readouts", "environment", "streams", "field")}
    return description.model_copy(update={"axes": {name: description.axes[name] for name in names}, **nothing})


def _stopped(
    description: RigDescription, rig_file: Path, axis: str | None
) -> tuple[dict[str, AxisState], list[DeviceFault]]:
    """Return where each stands, and what is to be told of one that stands outside its limits."""
    with open_rig(description, rig_file=rig_file, purpose="jog", write=replace_file, for_stop=True) as opened:
        stopped = by_hand.stop(opened, axis)
        with homes_kept(opened):
            stand = {name: opened.axes[name].state() for name in stopped}
            outside = (by_hand.outside_limits(opened, name, state) for name, state in stand.items())
            return stand, [DeviceFault(sentence) for sentence in outside if sentence]
