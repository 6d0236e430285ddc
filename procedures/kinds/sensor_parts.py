"""Sensors of the reports by their makers' names: what a table says of one, beside what it showed at rest.

CR's tables 1 and 2 hold noise densities of accelerometers and drifts of gyros, SR the scales of the parts that flew. A
reading that is no angle by itself, volts behind a meter or a device's counts, becomes one by the part's scale; what
the table says is held against the use before anything is measured, and against the record afterwards. A gyro's noise
is given in mV, of which CR does not say whether it is r.m.s. or over which band, so that it is not used.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, sqrt
from typing import Final, Literal

from ams.rounding import two_digits

COVERAGE: Final = 2.0


@dataclass(frozen=True)
class SensorPart:
    """A part as a table has it; None for what it does not state."""

    measures: Literal["acceleration", "rate"]
    source: str
    scale: Mapping[str, float]
    """Reading per g or per °/s, by the unit of the reading."""
    noise_g_per_sqrt_hz: float | None = None
    drift_dps: float | None = None
    """How far the zero may wander."""

    def expected_deg(self, use_s: float) -> float | None:
        """Return by how much its angle is wrong at the end of the use, zeroed over as long before (k = 2).

        White noise of the one-sided density d has the Allan deviation d/√(2τ); a drift is integrated as it stands.
        """
        if self.drift_dps is not None:
            return self.drift_dps * use_s
        if self.noise_g_per_sqrt_hz is not None:
            return degrees(COVERAGE * sqrt(2.0) * self.noise_g_per_sqrt_hz / sqrt(2.0 * use_s))
        return None


def _accelerometer(noise_ug: float, mv_per_g: float | None) -> SensorPart:
    scale = {} if mv_per_g is None else {"v": mv_per_g / 1000.0}
    return SensorPart("acceleration", "CR table 1", scale, noise_g_per_sqrt_hz=noise_ug * 1e-6)


def _gyro(drift_dps: float, mv_per_dps: float) -> SensorPart:
    return SensorPart("rate", "CR table 2", {"v": mv_per_dps / 1000.0}, drift_dps=drift_dps)


PARTS: Final[Mapping[str, SensorPart]] = {
    "ADXL105": _accelerometer(225.0, 250.0),
    "MX201A": _accelerometer(750.0, 500.0),
    "MXA2500A": _accelerometer(750.0, 500.0),
    "MXD2020A": _accelerometer(40.0, None),
    "ENC-03J": _gyro(5.0, 0.67),
    "ENV-05F-03": _gyro(9.0, 25.0),
    "MGL80301ZT0": _gyro(0.2, 0.6),
    "MG-L106C": _gyro(0.2, 0.6),
    "SCA3000": SensorPart("acceleration", "SR, conversion equations", {"counts": 1333.0}),
    "ITG-3200": SensorPart("rate", "SR, conversion equations", {"counts": 14.375}),
}


def forecast_of(name: str, part: SensorPart, use_s: float, allowed_deg: float) -> str | None:
    """Say what a part's table lets expect of a use; None where it states nothing that decides."""
    expected = part.expected_deg(use_s)
    if expected is None:
        return None
    cause = "drift" if part.drift_dps is not None else "noise"
    relation = "within" if expected <= allowed_deg else "beyond"
    return (
        f"{name} by {part.source}: its {cause} alone makes {expected:.3g}° in {use_s:g} s, {relation} the allowed "
        f"±{allowed_deg:g}°"
    )


def checked(part: SensorPart, random_walk_per_sqrt_s: float, at_use: float, per_unit: float) -> tuple[str, ...]:
    """Return what a table states, what the record showed and how they lie; nothing where the table states nothing.

    ``at_use`` is the Allan deviation at the time of use; it and the random walk are readings, ``per_unit`` their scale.
    """
    if part.noise_g_per_sqrt_hz is not None:
        # A one-sided density d has the Allan deviation d/√(2τ).
        shown, stated = sqrt(2.0) * random_walk_per_sqrt_s / per_unit * 1e6, part.noise_g_per_sqrt_hz * 1e6
        what, unit = "white noise", "µg/√Hz"
    elif part.drift_dps is not None:
        shown, stated = COVERAGE * sqrt(2.0) * at_use / per_unit, part.drift_dps
        what, unit = "drift over the use", "°/s"
    else:
        return ()
    times = f"{shown / stated:.2g}"
    relation = "within the table" if float(times) <= 1.0 else f"{times} times the table"
    return what, f"{stated:g} {unit}", f"{two_digits(shown)} {unit}", relation
