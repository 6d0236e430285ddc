"""The ability of a readout to prove itself between dwells, and what it has proved."""

from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

from rig.abilities.abilities import Wait


@dataclass(frozen=True, slots=True)
class MeterProof:
    """One reading of something whose value is known."""

    what: str
    """Such as ``short on 10 V``."""
    value_v: float
    """NaN where it was overloaded."""
    expected_v: float
    limit_v: float | None
    """How far it may be off; None where it is recorded only."""

    @property
    def is_good(self) -> bool:
        return self.limit_v is None or abs(self.value_v - self.expected_v) <= self.limit_v


@dataclass(frozen=True, slots=True)
class MeterLook:
    """What a meter proved about itself at one time."""

    proofs: tuple[MeterProof, ...]
    temperature_degc: float | None
    """Its own, None where it does not tell."""
    is_calibrated_anew: bool
    """It has just calibrated itself to its own standards."""


@runtime_checkable
class SelfChecking(Protocol):
    """A readout that can prove itself between dwells."""

    name: str
    check_every_s: float | None
    """None where the rig file asks for no checks: then nothing below is called."""
    check_action: Literal["hold", "trip"]

    def needs_check(self) -> bool:
        """Return whether it should be checked before its time, since its own temperature has moved."""

    def check_itself(self, wait: Wait) -> MeterLook:
        """Calibrate where the rig file asks for it, then read short and reference. Raises: RigError, WaitEnded."""
