"""The look around wherever a run stands still: in a pause, in a hold, in a soak, while a gate or a field is waited for.

Axes, clocks, interlocks and the files of the journal are judged as they are between two dwells. What trips, trips at
once. What a hold would answer holds nothing that stands still already: what was measured since is taken back, people
are told, and the run does not go on before it is over. Where a person is waited for nothing may move: what asks for a
new epoch (a line, a home that is lost) is told, and waits for that person's ``continue``; elsewhere it begins at once.
"""

from collections.abc import Callable

from procedures.records.progress import AT_REST
from procedures.records.states import State
from procedures.run.context import RunContext
from procedures.run.ending import Ending, RunEnds
from procedures.run.judgement.alarm import LOST, Alarm, TrustLost, lost_link

FIRST_SILENCE_S, LONGEST_SILENCE_S = 2.0, 60.0
"""Between two questions to what does not answer while a person is waited for, whose ``continue`` opens its line anew: a
question without an answer keeps requests waiting."""


def end_where_nothing_holds(alarm: Alarm) -> None:
    """Raise what an alarm asks for that no hold answers. Raises: RunEnds (a trip), TrustLost (a new epoch)."""
    if alarm.response == "trip":
        raise RunEnds(Ending(State.TRIPPED, alarm.reason, cause=alarm.cause))
    if alarm.response == "restart":
        raise TrustLost(alarm.cause, alarm.reason)


class Vigil:
    """Of one epoch. ``announce`` tells the twins what is read; ``take_back`` hears every alarm that a hold answers."""

    def __init__(self, context: RunContext, announce: Callable[[], None], take_back: Callable[[Alarm], None]) -> None:
        self._watch, self._progress_log, self._clock = context.watch, context.progress_log, context.rig.clock
        self._announce, self._take_back = announce, take_back
        self._reported: set[str] = set()
        """What people were told of, by what was looked at."""
        self._silent: dict[str, tuple[float, float]] = {}
        """What did not answer to when it is asked again, rig seconds, and the pause before."""
        self._owed: Alarm | None = None
        """What a new epoch has to mend when a person says continue."""

    def look(self, *, waits_for_person: bool = False, held_by: str = "") -> None:
        """Look once at everything. ``held_by``: cause of the hold in which the run stands, of which people know.

        Raises: RunEnds (a trip), TrustLost and RigError of what cannot be asked where no person is waited for,
        MotionBreach, WaitEnded, StorageFailed where the files of the journal are not those of the run any more.
        """
        self._progress_log.require_journal()
        for name, look in self._watch.at_rest(self._announce).items():
            due_s, pause_s = self._silent.get(name, (0.0, 0.0))
            if pause_s and self._clock.monotonic_s() < due_s:
                continue
            try:
                alarms = list(look())
            except LOST as error:
                if not waits_for_person:
                    raise
                pause_s = min(max(2.0 * pause_s, FIRST_SILENCE_S), LONGEST_SILENCE_S)
                self._silent[name] = (self._clock.monotonic_s() + pause_s, pause_s)
                alarms = [lost_link(error)]
            else:
                self._silent.pop(name, None)
            if not alarms:
                self._reported.discard(name)
            for alarm in alarms:
                self._act_on(name, alarm, waits_for_person, held_by)

    def require_trust(self) -> None:
        """Begin the new epoch that waited for a person. Raises: TrustLost."""
        if self._owed is not None:
            raise TrustLost(self._owed.cause, self._owed.reason)

    def _act_on(self, name: str, alarm: Alarm, waits_for_person: bool, held_by: str) -> None:
        if alarm.response == "restart" and waits_for_person:
            self._owed = self._owed or alarm
            self._tell_once(name, f"{alarm.reason}; a new epoch begins when somebody says continue, by homing")
            return
        self._take_back(alarm)
        end_where_nothing_holds(alarm)
        if alarm.cause != held_by:
            self._tell_once(name, f"{alarm.reason}; the run stands still, and does not go on before it is over")

    def _tell_once(self, name: str, text: str) -> None:
        if name not in self._reported:
            self._reported.add(name)
            self._progress_log.event(AT_REST, {"text": text})
            self._progress_log.tell(AT_REST, text)
