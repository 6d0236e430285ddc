"""Judge whether an axis does what it was told, and nothing else: values in, a verdict out.

What an axis was told last bounds where it may be seen: on its way from where it stood to its target and no further,
not away from it, no faster than asked, within the turn of a rate in its sense, and where it was left when it should
stand. A look is a question and its answer, so a position was true at some moment between the two; every bound allows
for that. A home search goes where the machine likes, but no faster than its speed and not much more than a turn, and
ends at the machine's zero. That zero moves in it, so one read-back that leaps is none too fast; the next that leaps on
is. An end elsewhere inside the limits may be the home of a machine that counts from another place, or an order that the
line made of the search; a zero that moves though the axis had one says that one of the two was wrong. Both are doubts:
searched once more, it has to end where it ended, and there ever after. A stop is bounded by the second at rest that
ends it.
"""

from dataclasses import dataclass, replace

from rig.abilities.abilities import AxisState
from rig.abilities.rest import band_deg

OVERSPEED = 1.5
"""Times the speed asked for: the machine's own speed is a setting, known no better than this on some."""
MARGIN_DEG = 0.5
"""Beyond corridor and limits: overshoot of a servo that settles on its target."""
STANDING_TOLERANCES = 5.0
"""Arrival tolerances by which the read-back of an axis at rest may wander."""
AT_REST_S = 1.0
"""A stopped axis is at rest when it was seen so long at one place."""
RUN_ON_S = 1.0
"""Of full speed: the way of a stop that takes two seconds."""
WHOLE_TURN_DEG = 360.0
HOME_DEG = 400.0
"""The longest way of a home search: a whole turn, and back off the mark and onto it again."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """What the rig file says of an axis."""

    limits_deg: tuple[float, float]
    speed_dps: float
    tolerance_deg: float
    """Of arrival."""
    home_deg: float = 0.0
    """Where a home search ends."""
    has_been_home: bool = False
    """Whether one ended there on this connection: then every later one does."""

    @property
    def margin_deg(self) -> float:
        return MARGIN_DEG + self.tolerance_deg

    @property
    def standing_deg(self) -> float:
        return STANDING_TOLERANCES * self.tolerance_deg

    @property
    def has_ends(self) -> bool:
        """Whether its limits are less than a turn apart: else they are those of positions, and a rate has none."""
        return self.limits_deg[1] - self.limits_deg[0] < WHOLE_TURN_DEG


@dataclass(frozen=True, slots=True)
class Seen:
    """One look."""

    position_deg: float
    sent_s: float
    answered_s: float
    """Rig seconds before the question and behind the answer."""
    is_moving: bool | None = None
    """None where only the angle was asked."""
    is_homed: bool = True
    is_known: bool = True
    """False where nobody knows where it stands: the angle says nothing."""
    is_led: bool = False
    """The angle is where the machine holds it: no hand changes it."""

    @classmethod
    def of(cls, state: AxisState, sent_s: float, answered_s: float) -> "Seen":
        is_known = not state.unknown
        return cls(state.position_deg, sent_s, answered_s, state.is_moving, state.is_homed, is_known, state.is_led)


@dataclass(frozen=True, slots=True)
class Unknown:
    """Nothing is known: nobody has told it anything on this connection, or its positions were lost."""

    may_move: bool = False
    """Something that we began may move it still: an order that went out before, a watchdog that was proved."""
    resting: Seen | None = None
    """Since when it was seen at one place, where its machine does not say whether it moves: led, and without a home."""


@dataclass(frozen=True, slots=True)
class Standing:
    """It was left at rest."""

    at_deg: float
    is_homed: bool
    doubt: str = ""
    """Why the home search that brought it here has to be seen twice."""


@dataclass(frozen=True, slots=True)
class Moving:
    """It was sent to a position."""

    from_deg: float
    target_deg: float
    speed_dps: float
    furthest_deg: float
    """Along its way, seen so far."""


@dataclass(frozen=True, slots=True)
class Homing:
    """It searches its home."""

    travelled_deg: float = 0.0
    leapt_deg: float = 0.0
    """How far the look before this one was off what its speed allows: a zero that was set, or the first of too fast."""
    had_zero: bool = False
    """It was homed when the search began, and stood where it was left."""
    zero_moved_deg: float = 0.0
    """By how much it leapt since, though it had one."""


@dataclass(frozen=True, slots=True)
class Turning:
    """It turns at a rate; the rates since it last stood span ``slowest_dps`` to ``fastest_dps``, 0 included."""

    slowest_dps: float
    fastest_dps: float
    began: Seen | None = None
    """The first look since."""

    @property
    def top_dps(self) -> float:
        return max(abs(self.slowest_dps), abs(self.fastest_dps))


@dataclass(frozen=True, slots=True)
class Stopping:
    """It was told to stop."""

    resting: Seen | None = None
    """Since when it was seen at one place."""
    may_move: bool = True
    """Something that we began before the stop may move it still."""


Task = Unknown | Standing | Moving | Homing | Turning | Stopping


@dataclass(frozen=True, slots=True)
class Watched:
    """What is known of an axis."""

    task: Task = Unknown()
    last: Seen | None = None
    is_nowhere: bool = False
    """Nobody knows where it stands, by two looks in a row, since a line can turn a digit over."""


def expecting_move(watched: Watched, target_deg: float, speed_dps: float) -> Watched:
    """Return what is expected of an axis that is sent to a position from where it was seen last."""
    task = watched.task
    if isinstance(task, Moving) and task.target_deg == target_deg:
        return watched  # the same order told again: the way is the same
    if watched.last is None:
        return replace(watched, task=Unknown(may_move=True))
    here_deg = watched.last.position_deg
    return replace(watched, task=Moving(here_deg, target_deg, speed_dps, here_deg))


def expecting_turn(watched: Watched, rate_dps: float) -> Watched:
    """Return what is expected of an axis that is given a rate, standing or turning."""
    task = watched.task if isinstance(watched.task, Turning) else Turning(0.0, 0.0)
    spanned = replace(task, slowest_dps=min(task.slowest_dps, rate_dps), fastest_dps=max(task.fastest_dps, rate_dps))
    return replace(watched, task=spanned)


def expecting_home(watched: Watched) -> Watched:
    """Return what is expected of an axis that is told to search its home."""
    task = watched.task
    return replace(watched, task=Homing(had_zero=isinstance(task, Standing) and task.is_homed))


def expecting_stop(watched: Watched) -> Watched:
    """Return what is expected of an axis that is told to stop: one that stands goes on standing."""
    return watched if isinstance(watched.task, Standing) else replace(watched, task=Stopping(None, _may_move(watched)))


def _may_move(watched: Watched) -> bool:
    """Return whether something that we began may move it."""
    task = watched.task
    return task.may_move if isinstance(task, Unknown | Stopping) else not isinstance(task, Standing)


def broken_off(watched: Watched, now_s: float) -> Moving | None:
    """Return the move that a stop breaks off, from as far as it can have come; None where it is sent to no target."""
    task, last = watched.task, watched.last
    if not isinstance(task, Moving) or last is None:
        return None
    left_deg = task.target_deg - last.position_deg
    gone_deg = min(abs(left_deg), task.speed_dps * max(now_s - last.sent_s, 0.0))
    return replace(task, from_deg=last.position_deg + (gone_deg if left_deg > 0.0 else -gone_deg))


def run_on_deg(move: Moving, stands_deg: float, tolerance_deg: float) -> float:
    """Return how far an axis went on to its target though it was told to stop; 0 where it did not.

    One that stops from full speed is through long before: nothing is said of an axis that was nearly there.
    """
    left_deg = abs(move.target_deg - move.from_deg)
    is_there = abs(move.target_deg - stands_deg) <= tolerance_deg
    return left_deg if is_there and left_deg > RUN_ON_S * move.speed_dps + tolerance_deg else 0.0


def unseen(watched: Watched) -> Watched:
    """Return what is known of an axis whose look says nothing of its motion: of what was begun, that it may go on."""
    return Watched(Unknown(may_move=_may_move(watched)))


def judge(bounds: Bounds, watched: Watched, seen: Seen, *, must_stand: bool = False) -> tuple[Watched, str]:
    """Return what is known after a look, and what the axis does that it was not told; empty where there is nothing.

    ``must_stand``: another axis is on its way, or it is about to be told something itself. What nobody has told
    anything, or rested after its stop, does not move then. What nobody knew the place of, as of a servo without pulses,
    has moved where it has one without an order.
    """
    if watched.is_nowhere and seen.is_known and not _may_move(watched):
        return Watched(Unknown(), seen), _unordered(seen, "where it stood was not known, and it")
    known, breach = _by_task(bounds, watched, seen, must_stand=must_stand)
    was_known = watched.last is None or watched.last.is_known
    return replace(known, is_nowhere=not (seen.is_known or was_known)), breach


def _by_task(bounds: Bounds, watched: Watched, seen: Seen, *, must_stand: bool) -> tuple[Watched, str]:
    task = watched.task
    match task:
        case Standing():
            return _standing(bounds, task, seen)
        case Moving():
            return _moving(bounds, task, watched.last, seen)
        case Turning():
            if not seen.is_homed:
                return Watched(Unknown(may_move=True), seen), ""
            low_deg, high_deg = bounds.limits_deg
            margin_deg = bounds.margin_deg
            if bounds.has_ends and not low_deg - margin_deg <= seen.position_deg <= high_deg + margin_deg:
                return Watched(Unknown(), seen), (
                    f"turned beyond its limits: at {seen.position_deg:g}°, allowed {low_deg:g} to {high_deg:g}°"
                )
            for before in (watched.last, task.began):
                if before is None:
                    continue
                if too_fast := _too_fast(bounds, before, seen, task.slowest_dps, task.fastest_dps):
                    return Watched(Unknown(), seen), too_fast
            return Watched(task if task.began is not None else replace(task, began=seen), seen), ""
        case Homing():
            return _homing(bounds, task, watched.last, seen)
        case Stopping():
            if must_stand and seen.is_moving and task.resting is not None:
                return Watched(Unknown(), seen), _unordered(
                    seen, f"it rested at {task.resting.position_deg:g}° behind its stop and"
                )
            return Watched(_coming_to_rest(bounds, task, seen), seen), ""
        case Unknown():
            return _unknown(bounds, task, seen, must_stand=must_stand)


def _unordered(seen: Seen, subject: str) -> str:
    return f"moves, though nothing told it to: {subject} is at {seen.position_deg:g}° now"


def _unknown(bounds: Bounds, task: Unknown, seen: Seen, *, must_stand: bool) -> tuple[Watched, str]:
    """Judge an axis that was told nothing. One that is led, and without a home, stands when it was seen to rest."""
    rested = task.resting if seen.is_led else None
    is_displaced = rested is not None and _is_off(bounds, rested.position_deg, seen)
    if must_stand and (seen.is_moving or is_displaced) and not task.may_move:
        subject = "it" if rested is None else f"it rested at {rested.position_deg:g}° and"
        return Watched(Unknown(), seen), _unordered(seen, subject)
    if seen.is_moving is False and not (seen.is_led and not seen.is_homed):
        return Watched(Standing(seen.position_deg, seen.is_homed), seen), ""
    return Watched(_coming_to_rest(bounds, task, seen), seen), ""


def _is_off(bounds: Bounds, at_deg: float, seen: Seen) -> bool:
    return seen.is_known and abs(seen.position_deg - at_deg) > bounds.standing_deg


def _standing(bounds: Bounds, task: Standing, seen: Seen) -> tuple[Watched, str]:
    """Judge an axis that should stand: without a home it may be turned by hand, unless led; none moves by itself."""
    if seen.is_homed != task.is_homed and not seen.is_moving:
        return Watched(Unknown(), seen), ""
    is_held = task.is_homed or seen.is_led
    is_displaced = is_held and _is_off(bounds, task.at_deg, seen)
    if seen.is_moving or is_displaced:
        what = "moves" if seen.is_moving else "was moved"
        return Watched(Unknown(), seen), (
            f"{what}, though nothing told it to: left at {task.at_deg:g}°, now at {seen.position_deg:g}°,"
            f" allowed within {bounds.standing_deg:g}°"
        )
    return Watched(task if is_held else Standing(seen.position_deg, False), seen), ""


def _moving(bounds: Bounds, task: Moving, last: Seen | None, seen: Seen) -> tuple[Watched, str]:
    if not seen.is_homed:
        return Watched(Unknown(may_move=True), seen), ""
    here_deg, margin_deg = seen.position_deg, bounds.margin_deg
    way = 1.0 if task.target_deg >= task.from_deg else -1.0
    low_deg, high_deg = sorted((task.from_deg, task.target_deg))
    course = f"sent from {task.from_deg:g} to {task.target_deg:g}°, it is at {here_deg:g}°"
    if not low_deg - margin_deg <= here_deg <= high_deg + margin_deg:
        return Watched(Unknown(), seen), f"left its way: {course}, allowed {margin_deg:g}° beside it"
    if (task.furthest_deg - here_deg) * way > margin_deg:
        return Watched(Unknown(), seen), f"turns away from its target: {course}, it was at {task.furthest_deg:g}°"
    if last is not None and (too_fast := _too_fast(bounds, last, seen, -task.speed_dps, task.speed_dps)):
        return Watched(Unknown(), seen), too_fast
    if seen.is_moving is False and abs(here_deg - task.target_deg) <= bounds.tolerance_deg:
        return Watched(Standing(here_deg, True), seen), ""
    furthest_deg = max(way * task.furthest_deg, way * here_deg) * way
    return Watched(replace(task, furthest_deg=furthest_deg), seen), ""


def _homing(bounds: Bounds, task: Homing, last: Seen | None, seen: Seen) -> tuple[Watched, str]:
    is_over = seen.is_moving is False and seen.is_homed
    if last is None:
        return _home_found(bounds, task, seen) if is_over else (Watched(task, seen), "")
    turned_deg = seen.position_deg - last.position_deg
    too_fast = _too_fast(bounds, last, seen, -bounds.speed_dps, bounds.speed_dps)
    if too_fast and task.had_zero:
        task = replace(task, zero_moved_deg=task.zero_moved_deg + turned_deg)
    if is_over:
        return _home_found(bounds, task, seen)
    if too_fast:
        if task.leapt_deg * turned_deg > 0.0:
            return Watched(Unknown(), seen), f"home: {too_fast}"
        return Watched(replace(task, leapt_deg=turned_deg), seen), ""
    travelled_deg = task.travelled_deg + abs(turned_deg)
    if travelled_deg > HOME_DEG:
        return Watched(Unknown(), seen), (
            f"home: turned by {travelled_deg:g}° and found none, allowed {HOME_DEG:g}°; it is at {seen.position_deg:g}°"
        )
    return Watched(replace(task, travelled_deg=travelled_deg, leapt_deg=0.0), seen), ""


def _home_found(bounds: Bounds, task: Homing, seen: Seen) -> tuple[Watched, str]:
    """Judge where a home search ended: where the last one did not, or beyond the limits, was an order to go there."""
    (low_deg, high_deg), margin_deg = bounds.limits_deg, bounds.margin_deg
    here_deg, doubt = seen.position_deg, ""
    if task.zero_moved_deg:
        doubt = f"its zero moved by {task.zero_moved_deg:.3g}°, though it was homed"
    if abs(here_deg - bounds.home_deg) <= margin_deg:
        return Watched(Standing(here_deg, True, doubt), seen), ""
    if bounds.has_been_home:
        breach = f"home: ended at {here_deg:g}°, the search before it at {bounds.home_deg:g}°"
        return Watched(Unknown(), seen), breach
    if low_deg - margin_deg <= here_deg <= high_deg + margin_deg:
        doubt = f"ended at {here_deg:g}°, not at its zero of {bounds.home_deg:g}°"
        return Watched(Standing(here_deg, True, doubt), seen), ""
    return Watched(Unknown(), seen), (
        f"home: ended at {here_deg:g}°, beyond its limits and not at its home of {bounds.home_deg:g}°"
    )


def after_home(bounds: Bounds, at_deg: float) -> Bounds:
    """Return what is known once a home search has ended there."""
    is_there = abs(at_deg - bounds.home_deg) <= bounds.margin_deg
    return replace(bounds, home_deg=bounds.home_deg if is_there else at_deg, has_been_home=True)


def _coming_to_rest(bounds: Bounds, task: Unknown | Stopping, seen: Seen) -> Task:
    if seen.is_moving is not False or not seen.is_known:
        return replace(task, resting=None)
    within_deg = band_deg(bounds.tolerance_deg)
    rests = task.resting is not None and abs(seen.position_deg - task.resting.position_deg) <= within_deg
    if not rests:
        return replace(task, resting=seen)
    assert task.resting is not None
    if seen.answered_s - task.resting.sent_s < AT_REST_S:
        return task
    return Standing(seen.position_deg, seen.is_homed)


def _too_fast(bounds: Bounds, before: Seen, now: Seen, slowest_dps: float, fastest_dps: float) -> str:
    """Empty where the turn between two looks fits the rates in the longest time that can lie between them."""
    longest_s = now.answered_s - before.sent_s
    turned_deg = now.position_deg - before.position_deg
    most_deg = OVERSPEED * fastest_dps * longest_s + bounds.margin_deg
    least_deg = OVERSPEED * slowest_dps * longest_s - bounds.margin_deg
    if least_deg <= turned_deg <= most_deg:
        return ""
    rate_dps = turned_deg / longest_s if longest_s > 0.0 else float("inf")
    is_wrong_way = (turned_deg > 0.0 and fastest_dps <= 0.0) or (turned_deg < 0.0 and slowest_dps >= 0.0)
    limit_dps = OVERSPEED * max(-slowest_dps, fastest_dps)
    excess = "the wrong way" if is_wrong_way else f"over its limit of {limit_dps:.4g} °/s"
    return f"turns at {rate_dps:.4g} °/s, {excess}: from {before.position_deg:g} to {now.position_deg:g}°"
