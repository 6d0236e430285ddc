"""What a rig file says that a run must respect beside its plan, as plain values."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from procedures.records.declared_supply import correcting
from procedures.run.judgement.interlocks import Interlock
from rig.description.rig_file import RigDescription
from rig.description.signal_chain import Chain
from rig.description.supply_bands import supply_bands

LEAST_FREE_MB = 64.0
LINK_ERROR_RATE = 0.02


@dataclass(frozen=True, slots=True)
class WarmUp:
    """A channel that must have come to rest before anything is measured."""

    channel: str
    warm_up_s: float
    slope_v_per_h: float | None


@dataclass(frozen=True, slots=True)
class RunLimits:
    """Read from ``rig.toml`` as the journal keeps it."""

    temperatures: tuple[tuple[str, Interlock], ...] = ()
    """Environment name and its band."""
    voltages: tuple[tuple[str, Interlock], ...] = ()
    """Full channel name and its band."""
    rejected: tuple[int, int] | None = None
    """(most, within): more rejected attempts than that among the last so many."""
    min_free_mb: float = LEAST_FREE_MB
    max_link_error_rate: float = LINK_ERROR_RATE
    warm_ups: tuple[WarmUp, ...] = ()
    chains: Mapping[str, Chain] = field(default_factory=dict)
    """By full channel name, those that change what is read."""


def run_limits_of(rig: RigDescription) -> RunLimits:
    locks = rig.interlocks
    return RunLimits(
        temperatures=tuple(
            (name, _lock(f"environment.{name}", "°C", lock.band_degc, lock.hysteresis_degc, lock.delay_s, lock.action,
                         f"rig file: interlocks.temperature.{name}"))
            for name, lock in locks.temperature.items()
        ),
        voltages=(
            *(
                (name, _lock(name, "V", lock.band_v, lock.hysteresis_v, lock.delay_s, lock.action,
                             f"rig file: interlocks.voltage.{name}"))
                for name, lock in locks.voltage.items()
            ),
            *_supplies(rig),
        ),
        rejected=None if locks.rejected is None else (locks.rejected.most, locks.rejected.within),
        min_free_mb=locks.min_free_mb,
        max_link_error_rate=locks.max_link_error_rate,
        warm_ups=tuple(
            WarmUp(channel, chain.warm_up_s, chain.warm_up_slope_v_per_h)
            for channel, chain in rig.chain.items()
            if chain.warm_up_s > 0.0 or chain.warm_up_slope_v_per_h is not None
        ),
        chains=correcting(rig.chain),
    )  # fmt: skip


def _supplies(rig: RigDescription) -> tuple[tuple[str, Interlock], ...]:
    """Return an interlock for every supply with declared bands, on what all of them allow, unless an interlock of the
    rig file says how.
    """
    return tuple(
        (supply, _lock(supply, "V", (band.low_v, band.high_v), 0.0, 0.0, "hold", f"rig file: {band.keys}"))
        for supply, band in supply_bands(rig.chain).items()
        if supply not in rig.interlocks.voltage
    )


def _lock(
    name: str, unit: str, band: tuple[float, float], hysteresis: float, delay_s: float, action: str, key: str
) -> Interlock:
    return Interlock(name, unit, *band, hysteresis, delay_s, "trip" if action == "trip" else "hold", key)
