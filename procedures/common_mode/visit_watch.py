"""Reference visits and check sets over all sensors: what changed, since when, and which dwells are in doubt.

The engine takes every accepted dwell in as it comes; the report takes them in again from the journal, in the same
order, and so says the same. A visit is the dwells that stand together at the reference attitudes; each is compared with
the one before it, and where that shows nothing with the first, so that what creeps is seen as well; the first of all
with the check set before it, at the attitudes that both have. A check set is compared attitude by attitude with what
earlier ones measured of it, whole or not. From an epoch whose step a person accepted on, nothing is compared with what
was measured before: its check set and its visits begin anew.
"""

import shlex
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ams.findings import Finding, turned_the_table
from ams.surveillance.common_mode import CommonMode, judge_visits
from ams.surveillance.common_mode_columns import Visits
from ams.surveillance.common_mode_words import all_after, findings_of, on_one_side
from ams.surveillance.turns import AXES_OF_TABLE
from procedures.common_mode.check_sets import check_set_pairs, first_checks, steps_in_mid_run
from procedures.common_mode.opening_checks import OpeningChecks
from procedures.common_mode.planned_visits import plateau_numbers_of, visits_of
from procedures.common_mode.sensed_axes import Attitude, KnownAxes, attitude_of, sensed_axes
from procedures.common_mode.ways_out import TO_MEASURE_AGAIN, Moment, in_doubt, take_back_commands
from procedures.plan.plan import Plan
from procedures.records.declared_supply import at_declared
from procedures.records.dwells import DwellRecord, Event, read_back_rad
from rig.description.signal_chain import Chain

FALSE_ALARM = 1e-4
"""Of each of the two tests of a visit or a check set; a night has some fifty of them."""
LARGEST_TC_PER_DEGC = 1e-4
"""In g, of offset or sensitivity: no servo accelerometer for attitudes has more (70 µg and 200 ppm of a tilted g)."""
STEEPEST_DEG = 45.0
"""Pitch up to which a turn about roll moves readings by more than two thirds of what it does at level."""


@dataclass(frozen=True)
class Judged:
    """One comparison."""

    step: int
    """The last step of the later visit."""
    between: str
    common: CommonMode
    findings: tuple[Finding, ...]
    doubtful: tuple[int, ...]
    """Steps of the design measured in between."""
    since: Moment
    """When the last dwell before it ended."""
    until: Moment
    """When the first dwell after it began."""
    learned: int
    """Dwells before it that the scatter is known from."""
    is_slow: bool = False
    """Whether it crept from visit to visit and shows only against the first."""

    @property
    def sentence(self) -> str:
        """All that was found, as it is told."""
        return "; ".join(finding.text for finding in self.findings)

    @property
    def holds(self) -> bool:
        """Whether a person has to look before anything more is measured."""
        return bool(turned_the_table(self.findings))


@dataclass(frozen=True)
class _Visit:
    number: int
    dwells: tuple[DwellRecord, ...]
    taken: int
    """Dwells learned from when it began."""
    learned_before_turn: int | None = None
    """Of these, those of before the turn that it shows; None where it shows none."""

    @property
    def at(self) -> dict[Attitude, DwellRecord]:
        """Its dwells by where they were to stand."""
        return {attitude_of(dwell): dwell for dwell in self.dwells}


class VisitWatch:
    """Of one run. Anything but accelerometers at rest on a table of pitch, roll and yaw is not judged.

    ``accepted``: the epochs whose step a person accepted.
    """

    def __init__(self, plan: Plan, chains: Mapping[str, Chain], accepted: Iterable[int] = ()) -> None:
        self._chains = chains
        axes, channels = sensed_axes(plan.sensors if plan.is_at_rest and set(plan.axes) <= set(AXES_OF_TABLE) else {})
        self._is_watching = bool(channels)
        self._sensors = axes.sensors
        self._unit = "v"
        self.known = KnownAxes(axes, channels)
        self._visit_of = visits_of(plan)
        self._attitudes = Counter(self._visit_of.values())
        self._plateau_of = plateau_numbers_of(plan)
        self._opening = OpeningChecks(self._plateau_of)
        self._open: dict[int, DwellRecord] = {}
        self._visits: list[_Visit] = []
        """In the order in which they were completed."""
        self._since: list[int] = []
        """Steps of the design since the last visit."""
        self._accepted = frozenset(accepted)
        self._first_epoch = 0
        """The last of these that was reached: nothing is compared with what was measured before it."""

    def take(self, dwell: DwellRecord) -> Judged | None:
        """Take a dwell in; what a visit shows that it completes, where it can be compared.

        Nothing is learned from a dwell that does not count, but where the run stood then.
        """
        if not self._is_watching:
            return None
        self._reach(dwell.epoch)
        taken = self.known.taken
        if not dwell.accepted:
            self._opening.saw(dwell, taken)
            return None
        dwell = at_declared(dwell, self._chains)
        self._opening.saw(dwell, taken)
        self.known.learn(dwell, self._plateau_of.get(dwell.step, 0))
        if dwell.purpose == "design":
            self._since.append(dwell.step)
        visit_number = self._visit_of.get(dwell.step)
        if dwell.purpose != "reference" or visit_number is None:
            return None
        if self._open and self._visit_of[next(iter(self._open))] != visit_number:
            self._open.clear()
        self._open[dwell.step] = dwell
        if len(self._open) < self._attitudes[visit_number]:
            return None
        measured = (self._open[step] for step in sorted(self._open))
        visit = _Visit(visit_number, tuple(dwell for dwell in measured if dwell.epoch >= self._first_epoch), taken)
        self._open.clear()
        self._visits = [visit for visit in self._visits if visit.number != visit_number]  # one that was taken back
        judged = self._judged(visit)
        if judged is not None and judged.findings:
            visit = replace(visit, learned_before_turn=judged.learned)
        self._visits.append(visit)
        self._since.clear()
        return judged

    def _since_turn(self) -> list[_Visit]:
        """Return the visits from the last that showed a turn: it is told once, and what comes is compared with it."""
        turns = [index for index, visit in enumerate(self._visits) if visit.learned_before_turn is not None]
        return self._visits[max(turns, default=0) :]

    def _reach(self, epoch: int) -> None:
        """Begin anew where a person accepted a step: what comes stands as its check set stood.

        Of a visit that was begun before it only what is measured from then on is compared.
        """
        accepted = max((first for first in self._accepted if first <= epoch), default=0)
        if accepted > self._first_epoch:
            self._first_epoch = accepted
            self._visits.clear()
            self._since.clear()
            self.known.forget_attitudes()

    def take_back(self, steps: Iterable[int]) -> None:
        """Forget voided dwells, which are measured again; what is left of a visit of theirs waits for them."""
        gone = set(steps)
        self._opening.take_back(gone)
        broken = [visit for visit in self._visits if not gone.isdisjoint(dwell.step for dwell in visit.dwells)]
        for visit in self._since_turn():
            if visit in broken:
                self._open = self._open or {dwell.step: dwell for dwell in visit.dwells}
        self._visits = [visit for visit in self._visits if visit not in broken]
        self._open = {step: dwell for step, dwell in self._open.items() if step not in gone}
        self._since = [step for step in self._since if step not in gone]

    def compare_check_sets(
        self, before: Mapping[int, DwellRecord], after: Mapping[int, DwellRecord], between: str
    ) -> Judged | None:
        """Return what a check set shows against the same attitudes measured before; None where there are none."""
        pairs = [
            (at_declared(before[step], self._chains), at_declared(dwell, self._chains))
            for step, dwell in after.items()
            if step in before
        ]
        if not self._is_watching or not pairs:
            return None
        until = self.known.taken - len(after)
        return self._compared([first for first, _ in pairs], [second for _, second in pairs], between, until, ())

    def stands_as_since_the_turn(self, checks: Mapping[int, DwellRecord], is_alike: Callable[[int], bool]) -> bool:
        """Return whether a check set shows nothing against the newest visit since the last turn that was found.

        ``checks``: step to dwell. ``is_alike``: whether a step stands at the plateau of the check set. False where no
        attitude of both shows a new turn for sure, or where nothing judges it; the scatter is that from before the
        turn, which would hide a further one.
        """
        visits = self._since_turn()
        learned = visits[0].learned_before_turn if visits else None
        if not self._is_watching or learned is None:
            return False
        visited = visits[-1].at
        after = [dwell for dwell in checks.values() if attitude_of(dwell) in visited]
        before = [visited[attitude_of(dwell)] for dwell in after]
        is_shown = any(abs(dwell.targets_deg.get("pitch", 0.0)) <= STEEPEST_DEG for dwell in after)
        is_surely_shown = is_shown and (len(after) > 1 or len(self._sensors) > 1)
        mountings = {dwell.mounting for dwell in (*before, *after)}
        if not is_surely_shown or len(mountings) > 1 or not all(is_alike(dwell.step) for dwell in before):
            return False
        earlier, later = ([at_declared(dwell, self._chains) for dwell in dwells] for dwells in (before, after))
        found = self._compared(earlier, later, "since the visit before", learned, ())
        return found is not None and not found.findings

    def _judged(self, visit: _Visit) -> Judged | None:
        alike = [earlier for earlier in self._since_turn() if self._is_alike(earlier, visit)]
        if not alike:
            return self._judged_by_checks(visit)
        last, first = alike[-1], alike[0]
        between = f"between visits {last.number} and {visit.number}"
        found = self._compared_at_shared(last, visit, between, last.taken, self._since)
        if first is last or found is None or found.findings:
            return found
        slowly = f"between visits {first.number} and {visit.number}, little by little"
        crept = self._compared_at_shared(first, visit, slowly, last.taken, ())
        return None if crept is None else replace(crept, is_slow=True)

    def _compared_at_shared(
        self, earlier: _Visit, later: _Visit, between: str, until: int, doubtful: Sequence[int]
    ) -> Judged | None:
        before, after = earlier.at, later.at
        shared = [attitude for attitude in after if attitude in before]
        pairs = [before[attitude] for attitude in shared], [after[attitude] for attitude in shared]
        found = self._compared(*pairs, between, until, doubtful)
        return None if found is None else replace(found, step=later.dwells[-1].step)

    def _judged_by_checks(self, visit: _Visit) -> Judged | None:
        """Compare the first visit of a mounting and a plateau with the check set before it."""
        pair = self._opening.paired(visit.dwells)
        if pair is None:
            return None
        found = self._compared(pair.before, pair.after, f"{pair.between} {visit.number}", pair.taken, pair.since)
        return None if found is None else replace(found, step=visit.dwells[-1].step)

    def _is_alike(self, visit: _Visit, other: _Visit) -> bool:
        """Return whether the same mounting stood at the same temperature and at an attitude that both have."""

        def key(visit: _Visit) -> tuple[int, int]:
            first = visit.dwells[0]
            return first.mounting, self._plateau_of.get(first.step, 0)

        return key(visit) == key(other) and not visit.at.keys().isdisjoint(other.at)

    def _compared(
        self,
        before: Sequence[DwellRecord],
        after: Sequence[DwellRecord],
        between: str,
        until: int,
        doubtful: Sequence[int],
    ) -> Judged | None:
        variance, dof, seating_rad = self.known.scatter(until)
        if not np.isfinite(dof) or dof < 1.0:
            return None
        earlier, later = (np.stack([self.known.means(dwell) for dwell in dwells]) for dwells in (before, after))
        pitch, roll, yaw = read_back_rad(after)
        visits = Visits(
            pitch, roll, later - earlier, later, np.tile(2.0 * variance, (len(after), 1)), dof,
            float(np.sqrt(2.0)) * seating_rad, _warmer_degc(before, after) * LARGEST_TC_PER_DEGC,
            yaw_rad=yaw,
        )  # fmt: skip
        common = judge_visits(self.known.axes, visits, FALSE_ALARM)
        steps = tuple(doubtful)
        read = np.atleast_1d(np.isfinite(later - earlier).any(axis=0))
        sensors = tuple(
            dict.fromkeys(name for name, is_read in zip(self.known.axes.sensor, read, strict=True) if is_read)
        )
        findings = findings_of(common, sensors, between, self._unit, steps)
        since, until_then = max(map(_ended, before)), min(map(_began, after))
        return Judged(after[-1].step, between, common, findings, steps, since, until_then, until)


def _began(dwell: DwellRecord) -> Moment:
    return dwell.epoch, dwell.started_s


def _ended(dwell: DwellRecord) -> Moment:
    return dwell.epoch, dwell.ended_s


def judge_run(
    plan: Plan, chains: Mapping[str, Chain], dwells: Sequence[DwellRecord], events: Iterable[Event]
) -> tuple[Judged, ...]:
    """Return every reference visit and every later check set of a run as it is judged.

    ``dwells``: in the order in which they were measured. A turn of the table that all that counts stands before is told
    and spoils nothing; one that all stands after parts it from the declared zero, until check sets show the table as it
    stood in the first.
    """
    events = tuple(events)
    pairs = {pair.epoch: pair for pair in check_set_pairs(dwells, events) if pair.is_alike}
    if not pairs and not any(dwell.purpose == "reference" for dwell in dwells):
        return ()
    watch = VisitWatch(plan, chains, steps_in_mid_run(events))
    found: list[Judged | None] = []
    for dwell in dwells:
        found.append(watch.take(dwell))
        pair = pairs.get(dwell.epoch)
        is_check = dwell.accepted and dwell.purpose == "check"
        if pair is not None and is_check and dwell.step == list(pair.after)[-1]:
            found.append(watch.compare_check_sets(pair.before, pair.after, since_check_set(pair.since)))

    def first_start() -> VisitWatch:
        """Return what knows the rig's scatter from the first start alone: a turn between starts is no seating."""
        first = VisitWatch(plan, chains)
        for dwell in dwells:
            if dwell.epoch == 1:
                first.take(dwell)
        return first

    return tuple(_as_it_bears(judged, dwells, pairs, first_start) for judged in found if judged is not None)


def _as_it_bears(
    judged: Judged, dwells: Sequence[DwellRecord], alike_epochs: Collection[int], first_start: Callable[[], VisitWatch]
) -> Judged:
    """Return the comparison with its turns of the table as they bear on the dwells that count.

    A package that was moved is solved with a mount of its own: its dwells are not compared with those of before.
    """
    design = [dwell for dwell in dwells if dwell.accepted and dwell.purpose == "design"]
    after = {dwell.mounting for dwell in design if _ended(dwell) >= judged.since}
    before = {dwell.mounting for dwell in design if _began(dwell) < judged.until}
    if after & before or not judged.findings:
        return judged
    is_tied = (
        not after
        or bool(before)
        or _is_a_lone_package_moved(judged, dwells, after)
        or _is_put_right(judged, dwells, design, alike_epochs, first_start)
    )
    bears = on_one_side if is_tied else all_after
    return replace(judged, findings=tuple(bears(finding) for finding in judged.findings))


def _is_a_lone_package_moved(judged: Judged, dwells: Sequence[DwellRecord], mountings: Collection[int]) -> bool:
    """Return whether a person said of the only package that it was moved: of several it was what they stand on."""
    stood = (dwell.mounting for dwell in dwells if _ended(dwell) <= judged.until)
    return len(judged.common.agreeing) == 1 and min(mountings) > max(stood, default=0)


def _is_put_right(
    judged: Judged,
    dwells: Sequence[DwellRecord],
    design: Sequence[DwellRecord],
    alike_epochs: Collection[int],
    first_start: Callable[[], VisitWatch],
) -> bool:
    """Return whether each start that dwells count of has a check set after the turn as the first of the run was."""
    watch = first_start()
    for epoch in {dwell.epoch for dwell in design}:
        of_epoch = [dwell for dwell in dwells if dwell.purpose == "check" and dwell.accepted and dwell.epoch == epoch]
        if epoch not in alike_epochs or any(_began(dwell) < judged.until for dwell in of_epoch):
            return False
        before = first_checks(dwells, of_epoch[0].mounting, 1, epoch)
        if len(before) < len(of_epoch) or any(dwell.epoch > 1 for dwell in before.values()):
            return False
        again = watch.compare_check_sets(before, {dwell.step: dwell for dwell in of_epoch}, since_check_set(1))
        if again is None or again.findings:
            return False
    return True


def _warmer_degc(before: Sequence[DwellRecord], after: Sequence[DwellRecord]) -> float:
    """Return how far the recorded temperatures of two visits lie apart, of the environment where that is farthest."""
    degc = [
        {name: [dwell.temperature_degc[name] for dwell in dwells if name in dwell.temperature_degc] for name in names}
        for dwells in (before, after)
        for names in [dict.fromkeys(name for dwell in dwells for name in dwell.temperature_degc)]
    ]
    apart = (abs(float(np.mean(degc[1][name]) - np.mean(degc[0][name]))) for name in degc[0] if name in degc[1])
    return max(apart, default=0.0)


def since_check_set(epoch: int) -> str:
    """Say since when a check set changed."""
    return f"since the check set of epoch {epoch}"


def way_out(judged: Judged, dwells: Iterable[DwellRecord], folder: Path) -> str:
    """Name the dwells in doubt, and what takes them back of all ``dwells`` that count."""
    run = shlex.quote(str(folder.absolute()))
    if not judged.doubtful:
        return f"calrig continue {run} goes on, and compares with this visit from then on"
    return (
        f"{in_doubt(judged.doubtful)}; {TO_MEASURE_AGAIN}put the table right, calrig stop {run}, then "
        f"{take_back_commands(judged.doubtful, dwells, run)}; then calrig resume {run}; "
        f"calrig continue {run} keeps them and compares with this visit from then on"
    )
