"""The meters' proofs while a run lasts: before the first dwell, on time or when a meter's temperature moved, at last.

A proof beyond its limit says nothing about when the meter went wrong: what was measured since its last good one is
taken back, and the run trips or holds as the rig file says.
"""

from collections.abc import Callable, Mapping
from math import inf, isfinite

from procedures.run.dwell.measure import OpenRig
from procedures.run.judgement.alarm import Alarm, Response
from rig.abilities.abilities import Wait
from rig.abilities.self_checking import MeterLook, MeterProof, SelfChecking

KIND = "meter_check"
CAUSE = "meter"
PHASE = "meter-check"
"""Under which the twins answer what is read for it."""


class MeterWatch:
    """Of one epoch: a new one begins with a proof of every meter that is asked for any."""

    def __init__(self, rig: OpenRig, record: Callable[[str, Mapping[str, object]], None], wait: Wait) -> None:
        self._clock = rig.clock
        self._record = record
        self._wait = wait
        self._meters: dict[str, tuple[SelfChecking, float]] = {
            name: (readout, readout.check_every_s)
            for name, readout in rig.readouts.items()
            if isinstance(readout, SelfChecking) and readout.check_every_s is not None
        }
        self._good_s: dict[str, float] = {}
        """When a meter was last seen good, rig seconds; none since its last proof was bad."""
        self._bad: set[str] = set()

    def owes(self, last_dwell_s: float | None) -> bool:
        """Return whether a meter was not proven since the last dwell ended."""
        return last_dwell_s is not None and any(self._good_s.get(name, -inf) < last_dwell_s for name in self._meters)

    def look(self, announce: Callable[[], None], last_dwell_s: float | None = None) -> Alarm | None:
        """Check the meters that are due; ``last_dwell_s`` where nothing else is left to measure.

        Raises: RigError of a meter, WaitEnded.
        """
        for name, (meter, every_s) in self._meters.items():
            occasion = self._occasion(name, meter, every_s, last_dwell_s)
            if occasion:
                announce()
                alarm = self._check(name, meter, occasion)
                if alarm is not None:
                    return alarm
        return None

    def _occasion(self, name: str, meter: SelfChecking, every_s: float, last_dwell_s: float | None) -> str:
        """Return why a check is due; empty where it is not."""
        good_s = self._good_s.get(name)
        if good_s is None:
            return "again" if name in self._bad else "start"
        if last_dwell_s is not None and good_s < last_dwell_s:
            return "end"
        if self._clock.monotonic_s() - good_s >= every_s:
            return "time"
        return "temperature" if meter.needs_check() else ""

    def _check(self, name: str, meter: SelfChecking, occasion: str) -> Alarm | None:
        look = meter.check_itself(self._wait)
        bad = [proof for proof in look.proofs if not proof.is_good]
        self._record(KIND, _detail(name, occasion, look))
        if not bad:
            self._good_s[name] = self._clock.monotonic_s()
            return None
        sentence = ", ".join(_proof_in_words(name, proof) for proof in bad)
        last_good_s = self._good_s.pop(name, None)
        self._bad.add(name)
        response: Response = "trip" if meter.check_action == "trip" else "ask"
        return Alarm(
            CAUSE,
            f"{name}: a proof of the meter failed: {sentence}; what was measured since the last good one is taken back;"
            " look at meter, scanner and reference",
            response,
            last_good_s,
        )


def _detail(name: str, occasion: str, look: MeterLook) -> dict[str, object]:
    return {
        "readout": name,
        "occasion": occasion,
        "temperature_degc": look.temperature_degc,
        "is_calibrated_anew": look.is_calibrated_anew,
        "proofs": [
            {
                "what": proof.what,
                "value_v": proof.value_v if isfinite(proof.value_v) else None,
                "expected_v": proof.expected_v,
                "limit_v": proof.limit_v,
                "is_good": proof.is_good,
            }
            for proof in look.proofs
        ],
    }


def _proof_in_words(name: str, proof: MeterProof) -> str:
    got = f"{proof.value_v - proof.expected_v:+.3g} V off" if isfinite(proof.value_v) else "overloaded"
    return (
        f"the {proof.what} reads {proof.value_v:.9g} V, {got}, allowed {proof.limit_v or 0.0:g} V"
        f" (rig file: readouts.{name}.checks)"
    )
