"""What the journal says was done already: where a run stands when a process takes it up.

The noise reference is rebuilt from the same dwells in the same order in which an uninterrupted run learned them, so
that an interrupted run judges alike.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

from procedures.common_mode.check_sets import accepted_epochs, first_checks, steps_in_mid_run
from procedures.journal.audit.dropped_sensors import dropped_sensors
from procedures.journal.journal_reader import JournalReader
from procedures.journal.voids import KIND as VOIDED
from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell, Soak, Step
from procedures.records.dwells import DwellRecord, Event, NoiseReference
from procedures.records.states import GOING, State

TABLE = "table"
"""The cause of a hold at a visit that shows all sensors turned."""
INTEGRATION = "integration"
"""The event of what ``[dwell.adaptive]`` chose before the first dwell."""


@dataclass(frozen=True)
class History:
    """Dwells of the epochs before this one, in the order of commitment."""

    dwells: tuple[DwellRecord, ...]
    epoch: int
    """Of the process that begins now, 1-based."""
    first_check_epoch: int | None
    """The first whose check set was finished; None where there is none."""
    baseline_epoch: int | None
    """Whose check set later ones are compared with: the first of this mounting, or one whose step a person accepted."""
    mounting: int = 1
    """Of the package, 1-based."""
    dropped: frozenset[str] = frozenset()
    """Sensors that are measured no more: none whose lack a person took back."""
    accepted_epochs: tuple[int, ...] = ()
    """Whose step a person accepted: nothing is compared with what was measured before the last of them."""
    steps_in_mid_run: tuple[int, ...] = ()
    """Epochs that began with a step, there or back: no visit is compared with one from before them."""
    is_turn_accepted: bool = False
    """Whether a person said continue at the last visit that was held for a turn, and nothing was taken back since."""
    integrations: Mapping[str, float] = field(default_factory=dict)
    """Channel to the power-line cycles that were chosen for it; empty where nothing was left open or tried."""

    @property
    def accepted_steps(self) -> frozenset[int]:
        """Steps that are not measured again; check dwells are, in every epoch."""
        return frozenset(dwell.step for dwell in self.dwells if dwell.accepted and dwell.purpose != "check")

    @property
    def baseline(self) -> dict[int, DwellRecord]:
        """Step to dwell of the check set that later ones are compared with."""
        return self.check_set(self.baseline_epoch) if self.baseline_epoch is not None else {}

    @property
    def earlier_checks(self) -> dict[int, DwellRecord]:
        """Step to what a check set is compared with, whole or not."""
        return first_checks(self.dwells, self.mounting, max(self.accepted_epochs, default=1), self.epoch)

    @property
    def checks_before_steps(self) -> Mapping[int, Mapping[int, DwellRecord]]:
        """Return the epochs from which on check sets counted until a step was accepted, the newest first, with these.

        Where a step was put right since, a check set stands as some of these did. None without such a step.
        """
        begun = (1, *self.accepted_epochs)
        spans = reversed(list(pairwise(begun)))
        return {first: first_checks(self.dwells, self.mounting, first, last) for first, last in spans}

    def check_set(self, epoch: int) -> dict[int, DwellRecord]:
        """Step to accepted check dwell of one epoch."""
        return {
            dwell.step: dwell
            for dwell in self.dwells
            if dwell.purpose == "check" and dwell.accepted and dwell.epoch == epoch
        }

    def attempts(self, step: int) -> int:
        """Return the judged attempts of a step so far, outside the check set."""
        return self._judged_attempts.get(step, 0)

    @cached_property
    def _judged_attempts(self) -> Mapping[int, int]:
        judged: dict[int, int] = {}
        for dwell in self.dwells:
            if dwell.purpose != "check":
                judged[dwell.step] = max(judged.get(dwell.step, 0), dwell.attempt)
        return judged

    @property
    def measured_once(self) -> tuple[DwellRecord, ...]:
        """Accepted dwells as an uninterrupted run has them: of the check sets only the first whole one."""
        first = self.first_check_epoch
        return tuple(
            dwell for dwell in self.dwells if dwell.accepted and (dwell.purpose != "check" or dwell.epoch == first)
        )

    @property
    def visits(self) -> tuple[DwellRecord, ...]:
        """Accepted dwells of this mounting: what two visits to one attitude differ by."""
        return tuple(dwell for dwell in self.measured_once if dwell.mounting == self.mounting)

    def noise(self) -> NoiseReference:
        """Return the noise reference as the process before had learned it."""
        reference = NoiseReference()
        for dwell in self.measured_once:
            reference.learn(dwell.readings)
        return reference


def history_of(
    dwells: Iterable[DwellRecord],
    epochs_opened: int,
    plan: Plan,
    accepted: tuple[int, ...] = (),
    mounting: int = 1,
    remounted_after: int = 0,
    dropped: frozenset[str] = frozenset(),
) -> History:
    """Return where dwells leave a run.

    ``accepted``: the epochs whose step a person accepted with name and reason; the check set of the last counts from
    then on. ``remounted_after``: how many epochs were opened before the package was last moved.
    """
    found = tuple(dwells)
    wanted = {dwell.step for dwell in plan.check_set}
    bare = History(found, epochs_opened + 1, None, None)
    whole = [epoch for epoch in range(1, epochs_opened + 1) if wanted and wanted <= bare.check_set(epoch).keys()]
    alike = [epoch for epoch in whole if epoch > remounted_after]
    last_accepted = max(accepted, default=None)
    baseline = last_accepted if last_accepted in alike else next(iter(alike), None)
    return History(found, epochs_opened + 1, next(iter(whole), None), baseline, mounting, dropped, accepted)


def read_history(reader: JournalReader, plan: Plan) -> History:
    """Return where the journal stands. Raises: JournalError."""
    epochs, remounted_after, mounting = 0, 0, 1
    for event in reader.events():
        epochs += event.kind == "opened"
        if event.kind == VOIDED and event.detail.get("remounted"):
            remounted_after, mounting = epochs, mounting + 1
    accepted = accepted_epochs(reader.events())
    dwells = tuple(reader.dwells())
    sensors = dropped_sensors(reader.events(), dwells, plan.sensors)
    dropped = frozenset(sensor.name for sensor in sensors if not sensor.is_measured_again)
    found = history_of(dwells, epochs, plan, accepted, mounting, remounted_after, dropped)
    found = replace(
        found,
        is_turn_accepted=_is_turn_accepted(reader.events()),
        steps_in_mid_run=steps_in_mid_run(reader.events()),
    )
    tried = reader.last_event(INTEGRATION)
    return found if tried is None else replace(found, integrations=_integrations(tried))


def _is_turn_accepted(events: Iterable[Event]) -> bool:
    held, is_accepted = "", False
    for event in events:
        if event.kind == VOIDED:
            is_accepted = False
        elif event.kind == "state":
            if held == TABLE:
                is_accepted = event.detail.get("to") in GOING
            held = str(event.detail.get("cause", "")) if event.detail.get("to") == State.HELD else ""
    return is_accepted


def _integrations(event: Event) -> dict[str, float]:
    chosen = event.detail["nplc"]
    assert isinstance(chosen, dict)
    return {str(channel): float(nplc) for channel, nplc in chosen.items()}


def agenda(steps: Sequence[Step], accepted: frozenset[int]) -> tuple[Step, ...]:
    """Return what is left to do, in order.

    The soak in force, the whole check set, then every step without an accepted dwell.

    A later soak is kept only where a dwell follows it before the next one. Nothing left is an empty agenda.
    """
    dwells = [step for step in steps if isinstance(step, Dwell)]
    missing = [dwell for dwell in dwells if dwell.purpose != "check" and dwell.step not in accepted]
    if not missing:
        return ()
    checks = [dwell for dwell in dwells if dwell.purpose == "check"]
    soaks = [step for step in steps if isinstance(step, Soak)]
    left: list[Step] = []
    for index, dwell in enumerate(missing):
        soak = next((soak for soak in reversed(soaks) if soak.step < dwell.step), None)
        if soak is not None and soak not in left:
            left.append(soak)
        if index == 0:
            left.extend(checks)
        left.append(dwell)
    return tuple(left)


def plateaus_of(steps: Sequence[Step]) -> dict[int, Soak]:
    """Step to the soak that it stands under; a step before the first soak is missing."""
    found, soak = {}, None
    for step in steps:
        if isinstance(step, Soak):
            soak = step
        elif soak is not None:
            found[step.step] = soak
    return found


def replications_before(plan: Plan) -> dict[int, float]:
    """Step to the replications completed when it begins: the twins' drift follows it, by the plan and not by time."""
    points = max(len(plan.design_dwells) / plan.replications, 1.0)
    done, found = 0, {}
    for step in plan.steps:
        found[step.step] = done / points
        done += isinstance(step, Dwell) and step.purpose == "design"
    return found
