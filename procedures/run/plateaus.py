"""The temperature plateau at which a run stands: reached by a soak, left with its band, reached anew."""

from procedures.plan.steps import Dwell, Soak
from procedures.records.states import State
from procedures.run.context import RunContext
from procedures.run.dwell.soak import soak
from procedures.run.judgement.history import plateaus_of, replications_before
from procedures.run.judgement.judge import Band
from procedures.run.judgement.suspect_dwells import Suspects
from procedures.run.live_dwells import LiveDwells
from rig.abilities.chamber_alarms import alarm_clause

INTERLOCK = "interlock"
"""Cause of a hold, and phase under which the twins answer what is read between dwells."""


class Plateaus:
    """The plateaus of a plan, and the one at which the rig stands now, which none is before the first soak."""

    def __init__(self, context: RunContext, live: LiveDwells, suspects: Suspects, epoch: int) -> None:
        self._context, self._live, self._suspects, self._epoch = context, live, suspects, epoch
        self._rig, self._progress_log = context.rig, context.progress_log
        self._planned = plateaus_of(context.plan.steps)
        self._replications = replications_before(context.plan)
        self._now: Soak | None = None

    def of(self, step: int) -> Soak | None:
        """Return the soak that a step stands under; None before the first."""
        return self._planned.get(step)

    def is_at_that_of(self, step: int) -> bool:
        """Return whether the rig stands where a step is measured."""
        return self._planned.get(step) == self._now

    def has_lost(self, dwell: Dwell) -> bool:
        """Return whether a dwell needs another plateau than this; a check set is measured at any."""
        return dwell.purpose != "check" and not self.is_at_that_of(dwell.step)

    def bands(self) -> dict[str, Band]:
        """Return environment to the band that its temperature has to keep, degrees Celsius."""
        now = self._now
        return {} if now is None else {now.environment: Band(now.setpoint_degc, now.band_degc)}

    def leave(self) -> None:
        """Trust no plateau until the next soak."""
        self._now = None

    def bring_to(self, step: Soak) -> None:
        """Hold a setpoint until it is reached and soaked. Raises: RunEnds, RigError."""
        self._progress_log.event(
            "intent", {"step": step.step, "soak": step.environment, "setpoint_degc": step.setpoint_degc}
        )
        self._rig.chance.announce(step.step, "soak", self._epoch, self._replications[step.step])
        self._progress_log.tell("soak", f"{step.environment} to {step.setpoint_degc:g} °C for {step.soak_s:g} s")
        environment = self._rig.environments[step.environment]
        announced = self._live.soaks(step)
        degc = soak(environment, step, self._rig.clock, self._context.stand, announced)
        self._progress_log.event("soaked", {"step": step.step, "temperature_degc": degc})
        self._now = step
        self._suspects.forget()

    def regained(self) -> bool:
        """Wait for the temperature where it has left its band, and soak anew; return False where it has not."""
        now = self._now
        if now is None:
            return False
        environment = self._rig.environments[now.environment]
        degc = environment.temperature_degc()
        if abs(degc - now.setpoint_degc) <= now.band_degc:
            return False
        before = self._progress_log.state
        allowed = f"{now.setpoint_degc:g} ± {now.band_degc:g} °C (procedure file: environment.band_degc)"
        reason = f"{now.environment}: got {degc:.2f} °C, allowed {allowed}{alarm_clause(environment)}"
        self._progress_log.enter(State.HELD, reason, cause=INTERLOCK)
        self._context.explain()
        self.bring_to(now)
        self._progress_log.enter(before)
        return True
