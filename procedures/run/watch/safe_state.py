"""The safe state: every axis stopped and seen at rest, streams quiet, and the chamber where the procedure wants it.

All of it at once, each part within its deadline, and no part keeps another from its stop. A chamber keeps its
setpoint unless the procedure says ``[environment] end_degc``: a package that cools alone at night is no danger, and
the soak is not lost. Signals only leave a mark (:mod:`procedures.run.steering`), so none can skip this.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial

from procedures.plan.plan import Plan
from procedures.plan.steps import Soak
from procedures.records.axes_at_rest import axes_in_words
from procedures.run.dwell.measure import OpenRig
from procedures.run.judgement.alarm import CHAMBER
from rig.defects import defect_text
from rig.errors import RigError
from rig.motion.move import stop_all
from rig.motion.out_of_reach import LostLine, stopped_in_reach, unknown_behind
from rig.threads import at_once

NOT_SEEN, IN_DOUBT = "standstill", "order in doubt"
"""The causes of an ending after which not every axis is known to stand still, and of one after which an order that no
machine answered may still move an axis.
"""
LIMIT_S = 30.0
"""For everything but the axes, which have their own deadline."""
UNANSWERED = (
    f"stop: a device did not answer within {LIMIT_S:g} s, or no memory was left to ask it; use the stop button at the"
    " machine"
)
MOST_STOPS = 3
BETWEEN_LOOKS_S = 0.2


@dataclass(frozen=True, slots=True)
class Safe:
    """What is known when everything was told to stop."""

    failures: tuple[str, ...]
    """After which not every axis is known to stand."""
    positions_deg: dict[str, float] = field(default_factory=dict)
    """Read back at rest; an axis that does not answer is missing."""
    known: tuple[str, ...] = ()
    """Where something failed: what is known all the same, a sentence each for axes that do not answer and outputs."""
    of_chamber: tuple[str, ...] = ()
    """Why the chamber was not sent to its end: axes rest without it, and a person looks all the same."""
    unknown: dict[str, str] = field(default_factory=dict)
    """Axis to why nobody knows where it stands."""
    in_doubt: tuple[str, ...] = ()
    """Orders that may still move axes that were seen to stand: no machine answered them, and a stop ends none."""
    reopened: str = ""
    """Which line was out while an axis turned, after how long it was opened again, and that it was stopped then."""

    @property
    def cause(self) -> str:
        """The cause of an ending by what failed; empty where nothing did."""
        if self.failures:
            return NOT_SEEN
        return IN_DOUBT if self.in_doubt else CHAMBER if self.of_chamber else ""

    @property
    def reasons(self) -> tuple[str, ...]:
        """What a person is told of it as the reason of the ending, a sentence each."""
        return *self.failures, *self.of_chamber, *self.known, *self.in_doubt, *filter(None, [self.reopened])

    @property
    def in_words(self) -> str:
        """What people are told of the axes, a sentence; what failed stands in the reason already."""
        return axes_in_words(self.positions_deg, self.failures, self.in_doubt, self.unknown)

    def detail(self) -> dict[str, object]:
        """Return the event of the journal."""
        known = {"known": list(self.known)} if self.known else {}
        chamber = {"of_chamber": list(self.of_chamber)} if self.of_chamber else {}
        in_doubt = {"in_doubt": list(self.in_doubt)} if self.in_doubt else {}
        unknown = {"unknown": self.unknown} if self.unknown else {}
        of_axes = {"positions_deg": self.positions_deg, **unknown}
        reopened = {"reopened": self.reopened} if self.reopened else {}
        return {**of_axes, "failures": list(self.failures), **known, **chamber, **in_doubt, **reopened}


def make_safe(rig: OpenRig, plan: Plan, *, is_over: bool = True, is_open: bool = True) -> Safe:
    """Never raises for a device. ``is_over``: the process gives the rig up, so the chamber goes to its end as well.

    ``is_open``: False where lines were lost and not all were opened since; where something fails that is tried once
    more, behind the first stop, since what moves on an open line waits for no other. Where a line broke while an axis
    turned at a rate it is opened again as soon as it can be, and the axis stopped: it would turn on, and an adapter
    that was unplugged mostly is back within seconds.
    """

    def stop(unopened: str) -> Safe:
        return _unless_strangers(rig, _attempted(rig, plan, _unopened(unopened) if unopened else "", is_over=is_over))

    safe, line = stopped_in_reach(rig, stop, lambda safe: bool(safe.failures or safe.of_chamber), is_open=is_open)
    return safe if line is None or safe.failures else replace(safe, reopened=_reopened(line))


def _unless_strangers(rig: OpenRig, safe: Safe) -> Safe:
    """Return what is known where every stop was obeyed: what another device answers tells nothing of an axis."""
    if safe.failures or not (strangers := rig.stranger_axes(rig.axes)):
        return safe
    seen_deg = {name: degrees for name, degrees in safe.positions_deg.items() if name not in strangers}
    failures = (f"stop: {unknown_behind(strangers)}",)
    known = (*rig.motion.in_words(strangers), *safe.known)
    return replace(safe, failures=failures, positions_deg=seen_deg, known=known, unknown={**safe.unknown, **strangers})


def _reopened(line: LostLine) -> str:
    names = " and ".join(line.turning)
    return (
        f"{names} turned when its line was lost, and turned on until the line was opened again, {line.waited_s:.0f} s"
        f" after the first stop that did not reach it; {names} was stopped then"
    )


def _attempted(rig: OpenRig, plan: Plan, unopened: str, *, is_over: bool) -> Safe:
    """``unopened``: why the lines cannot be opened; empty where they are open."""
    failures: list[str] = []
    of_chamber: list[str] = []
    work: list[tuple[Callable[[], None], list[str]]] = [(lambda: stop_all(rig.axes, rig.clock), failures)]
    if is_over:
        work += [(part, of_chamber) for part in _chamber(rig, plan)]
    are_done = at_once([partial(_attempt, *part) for part in work], LIMIT_S, "the safe state")
    failures += [UNANSWERED for is_done in are_done if not is_done]
    positions_deg = _seen_at_rest(rig, failures) if all(are_done) else {}
    in_doubt, unseen = rig.motion.in_doubt(positions_deg), [name for name in rig.axes if name not in positions_deg]
    unknown = unknown_positions(rig) if all(are_done) else {}
    positions_deg = {name: degrees for name, degrees in positions_deg.items() if name not in unknown}
    if not failures and not of_chamber:
        return Safe((), positions_deg, unknown=unknown, in_doubt=in_doubt)
    if unopened and failures:  # one cause of whatever else failed
        failures, of_chamber = [unopened], []
    known = (*rig.motion.in_words(unseen), *_outputs_left(rig, plan))
    return Safe(tuple(failures), positions_deg, known, tuple(of_chamber), unknown, in_doubt)


def _unopened(why: str) -> str:
    found = f"stop: not every axis is known to stand still, since the lines cannot be opened: {why}"
    return f"{found}; use the stop button at the machine"


def _outputs_left(rig: OpenRig, plan: Plan) -> list[str]:
    """Say what goes on by itself: nothing here takes a setpoint back."""
    chambers = dict.fromkeys(step.environment for step in plan.steps if isinstance(step, Soak))
    return [
        *(f"{name} goes on holding the temperature that it was told last" for name in chambers),
        *(f"{name} stays at the field that was set last" for name in rig.fields),
    ]


def _seen_at_rest(rig: OpenRig, failures: list[str]) -> dict[str, float]:
    """Return where the axes rest, by two looks that agree over lines without an error, each of every axis.

    A question that the line damages can itself send servos home. Where they do not agree, everything is stopped again.
    """
    for _ in range(MOST_STOPS):
        before_deg, errors = resting_deg(rig), _line_errors(rig)
        rig.clock.sleep(BETWEEN_LOOKS_S)
        now_deg = resting_deg(rig)
        is_whole = now_deg.keys() == rig.axes.keys()  # one that moves is missing in both, which agrees as well
        if failures or (is_whole and now_deg == before_deg and _line_errors(rig) == errors):
            return now_deg
        _attempt(lambda: stop_all(rig.axes, rig.clock), failures)
    now_deg = resting_deg(rig)
    unseen = ", ".join(name for name in rig.axes if name not in now_deg)
    failures.append(
        f"stop: not every axis is known to stand still: {unseen or 'one of them'} moves again after it was seen at "
        "rest, or does not answer; use the stop button at the machine"
    )
    return now_deg


def _line_errors(rig: OpenRig) -> int:
    return sum(counts.errors for counts in rig.link_counts().values())


def _chamber(rig: OpenRig, plan: Plan) -> list[Callable[[], None]]:
    wanted = plan.environment
    if wanted is None or wanted.end_degc is None:
        return []
    assert wanted.name is not None, "the planner fills it in"
    environment, end_degc = rig.environments[wanted.name], wanted.end_degc
    return [lambda: environment.hold(end_degc)]


def _attempt(work: Callable[[], None], failures: list[str]) -> None:
    try:
        work()
    except RigError as error:
        failures.append(str(error))
    except Exception as error:  # noqa: BLE001  the rim of a thread: no defect may keep the others from their stop
        failures.append(f"stop: {defect_text(error)}")


def unknown_positions(rig: OpenRig) -> dict[str, str]:
    """Return axis to why nobody knows where it stands; one that does not answer is told by its stop."""
    found = {}
    for name, axis in rig.axes.items():
        with suppress(Exception):
            if why := axis.state().unknown:
                found[name] = why
    return found


def known_rest_deg(rig: OpenRig) -> dict[str, float]:
    """Read back now as :func:`resting_deg`, without axes of which nobody knows where they are."""
    unknown = unknown_positions(rig)
    return {name: degrees for name, degrees in resting_deg(rig).items() if name not in unknown}


def resting_deg(rig: OpenRig) -> dict[str, float]:
    """Read back now; an axis that does not answer, or moves, is missing."""
    found = {}
    for name, axis in rig.axes.items():
        try:
            state = axis.state()
        except Exception:  # noqa: BLE001, S112  its stop has failed as well, and that is told
            continue
        if not state.is_moving:
            found[name] = state.position_deg
    return found
