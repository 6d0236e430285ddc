"""From open lines to running: see that nothing moves, that mounts are as declared, and that a restart made no step."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from types import MappingProxyType

from ams.finding_kinds import OF_THE_TABLE
from procedures.common_mode.check_sets import BACK_AT, RESTART_STEP
from procedures.common_mode.visit_watch import VisitWatch, since_check_set
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import key_of, void_detail
from procedures.records.declared_supply import at_declared
from procedures.records.dwells import DwellRecord
from procedures.records.progress import STRAY_MOTION
from procedures.records.states import State
from procedures.run.dwell.measure import OpenRig
from procedures.run.ending import Ending, RunEnds
from procedures.run.judgement.history import History
from procedures.run.judgement.mount_check import contradictions
from procedures.run.judgement.restart_step import compare, strongest
from procedures.run.progress_log import ProgressLog
from rig.abilities.abilities import Axis
from rig.description.rig_file import Sensor
from rig.description.signal_chain import Chain
from rig.errors import DeviceFault, DeviceNonsense, DeviceSilent, LinkLost, MotionBreach, RigError
from rig.motion.standstill import stop_what_moves


def require_standstill(rig: OpenRig, progress_log: ProgressLog) -> dict[str, str]:
    """Stop what moves, and tell of it and of what is not where it was left; return the fault of each axis that has one.

    Raises: RunEnds where one moved outside its limits, or goes on.
    """
    _stop_what_moves(rig, rig.axes, progress_log)
    return faults_of(rig.axes)


def _stop_what_moves(rig: OpenRig, axes: Mapping[str, Axis], progress_log: ProgressLog) -> None:
    try:
        sentences = stop_what_moves(axes, rig.clock, rig.motion)
    except DeviceFault as error:
        cause = "supervision" if isinstance(error, MotionBreach) else "device"
        raise RunEnds(Ending(State.TRIPPED, str(error), cause=cause)) from error
    for sentence in sentences:
        progress_log.event(STRAY_MOTION, {"text": sentence})
        progress_log.tell(STRAY_MOTION, sentence)


def open_lines(rig: OpenRig, progress_log: ProgressLog) -> None:
    """Open every line anew, and stop what moves; where a line stays away, what may move is stopped all the same.

    Raises: RigError where one stays away, and as :func:`require_standstill`.
    """
    try:
        rig.reconnect()
    except RigError:
        may_move = {name: axis for name, axis in rig.axes.items() if rig.motion.known(name).may_be_moved_by}
        _stop_what_moves(rig, may_move, progress_log)
        raise
    require_standstill(rig, progress_log)


def faults_of(axes: Mapping[str, Axis]) -> dict[str, str]:
    """Return what each axis says of itself that a person has to clear; one that does not answer says nothing."""
    found = {}
    for name, axis in axes.items():
        with suppress(DeviceSilent, DeviceNonsense, LinkLost):
            found[name] = axis.state().fault
    return {name: fault for name, fault in found.items() if fault}


def require_no_fault(axes: Mapping[str, Axis], known: Mapping[str, str] = MappingProxyType({})) -> None:
    """See that no axis says what a person has to clear: nothing may answer that with a search for home.

    ``known``: said when its line was opened, so a person has begun or resumed since. Raises: DeviceFault.
    """
    for name, fault in faults_of(axes).items():
        if name not in known:
            raise DeviceFault(f"{name}: {fault}; it was not homed; clear it at the machine")


def require_declared_mounts(
    sensors: Mapping[str, Sensor], checks: Mapping[int, DwellRecord], progress_log: ProgressLog
) -> None:
    """Check every sensor against its declared mount; a contradicted check set is taken back.

    Raises: RunEnds naming every axis that contradicts.
    """
    dwells = tuple(checks.values())
    found = [sentence for name, sensor in sensors.items() for sentence in contradictions(name, sensor, dwells)]
    if found:
        sentence = f"mount check: {'; '.join(found)}; correct mount, wiring or rig file"
        reason = "the mount check found a contradiction"
        progress_log.event(VOIDED, void_detail(map(key_of, dwells), "", reason, "mount"))
        raise RunEnds(Ending(State.TRIPPED, sentence, cause="mount"))


def require_no_step(
    history: History,
    checks: Mapping[int, DwellRecord],
    progress_log: ProgressLog,
    chains: Mapping[str, Chain],
    watch: VisitWatch,
    *,
    is_alike: bool,
    is_at_plateau_of: Callable[[int], bool] = lambda _step: False,
) -> None:
    """Compare the check set with the one before, or with what was measured of one that was cut short.

    A turn that a person said continue to at a visit is no new step where the check set stands as the newest visit; nor
    is one back to where the rig stood before a step at which the run tripped: somebody put it right.
    ``is_at_plateau_of``: whether a step stands at the plateau of the check set.
    ``is_alike``: that was measured at the same plateau. Raises: RunEnds where there is a step.
    """
    if not is_alike:
        progress_log.event(RESTART_STEP, {"tested": False, "reason": "the check set was measured at another plateau"})
        return
    earlier = history.earlier_checks
    since = min(dwell.epoch for dwell in earlier.values())
    judged = watch.compare_check_sets(earlier, checks, since_check_set(since))
    sentences = [finding.text for finding in judged.findings] if judged is not None else []
    before = {step: at_declared(dwell, chains) for step, dwell in earlier.items()}
    after = {step: at_declared(dwell, chains) for step, dwell in checks.items()}
    found = compare(before, after, (at_declared(dwell, chains) for dwell in history.visits))
    steps = [step for step in found if step.is_step]
    worst = strongest(found)
    sentence = f"{worst.channel} at step {worst.step} changed by {worst.change_v:.3g} V, t = {worst.t:.3g}"
    is_turned = judged is not None and judged.holds
    detail = {"tested": True, "comparisons": len(found), "steps": len(steps), "worst": sentence}
    is_known = (
        judged is not None
        and is_turned
        and history.is_turn_accepted
        and all(finding.kind in OF_THE_TABLE for finding in judged.findings)
        and watch.stands_as_since_the_turn(checks, is_at_plateau_of)
    )
    whole = {"attitudes": len(before), "of": len(checks), "told": sentences, "turned": is_turned}
    known = {"accepted": "the turn that a person continued with at a visit"} if is_known else {}
    is_step = (bool(steps) or is_turned) and not is_known
    back_at = _epoch_it_is_back_at(history, checks, chains, watch, is_at_plateau_of) if is_step else None
    back = {} if back_at is None else {BACK_AT: back_at, "text": _back_in_words(back_at, since)}
    progress_log.event(RESTART_STEP, {**detail, **whole, "against_epoch": since, **known, **back})
    if back_at is not None:
        progress_log.tell("check", _back_in_words(back_at, since))
    elif is_step:
        measured = [f"{sentence}, allowed {worst.t_limit:.3g}"] if steps else []
        is_table = judged is not None and any(finding.kind in OF_THE_TABLE for finding in judged.findings)
        where = "the table's coupling, its base and the common fixture" if is_table else "mount, sensor and meter"
        raise RunEnds(
            Ending(
                State.TRIPPED,
                f"the restart made a step: {'; '.join([*sentences, *measured])}; look at {where}; "
                "a resume with a name and a reason accepts it",
                cause="seam",
            )
        )


def _epoch_it_is_back_at(
    history: History,
    checks: Mapping[int, DwellRecord],
    chains: Mapping[str, Chain],
    watch: VisitWatch,
    is_at_plateau_of: Callable[[int], bool],
) -> int | None:
    """Return the newest epoch before an accepted step as whose check set this one stands, attitude by attitude.

    None where it stands as none of them, or where one lacks an attitude, stood at another plateau, or cannot be judged.
    """
    for epoch, earlier in history.checks_before_steps.items():
        if not earlier.keys() >= checks.keys() or not is_at_plateau_of(min(earlier)):
            continue
        judged = watch.compare_check_sets(earlier, checks, since_check_set(epoch))
        before = {step: at_declared(dwell, chains) for step, dwell in earlier.items()}
        after = {step: at_declared(dwell, chains) for step, dwell in checks.items()}
        found = compare(before, after, (at_declared(dwell, chains) for dwell in history.visits))
        if judged is not None and not judged.findings and not any(step.is_step for step in found):
            return epoch
    return None


def _back_in_words(back_at: int, since: int) -> str:
    return (
        f"the check set differs from that of epoch {since}, and stands again as that of epoch {back_at} did: what had "
        f"changed was put right, and the run goes on from epoch {back_at}"
    )
