"""What is believed of the sensors of a rig before they are measured, and where each figure comes from.

The noise of a reading is what the procedure states, else the twin's, else half an arc second a dwell (TP's precision).
Lack of fit and drift are what a pilot run of the same rig showed, else the twin's drift, else none: what nobody has
measured is not made up, and the forecast says so.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import hypot, radians, sqrt

import numpy as np

from ams.arrays import FloatArray
from ams.models.accelerometer import vector_from_angles
from ams.observations import Sampled
from ams.solve.expected import Belief
from ams.solve.resolution import rounded_variance
from ams.units import RAD_PER_ARCSEC
from procedures.description.procedure_file import Solve
from rig.description.rig_file import AxisTruth, RigDescription, Sensor

NOMINAL_CONING_DEG = 0.3
"""Assumed where no truth is known: only the azimuth's uncertainty depends on it, as its inverse."""
NOMINAL_AZIMUTH_DEG = 40.0


@dataclass(frozen=True)
class AxisBelief:
    """One sensor axis as it is believed to be."""

    offset_v: float
    k_v_per_g: FloatArray
    """(3,) vector of sensitivities, TP's terms."""
    coning_deg: float
    reading_v: float
    """Standard deviation of one reading of a burst, rounded as it is."""
    dwell_v: float
    """What the mean of a dwell has of its own, however many readings it is of."""
    lack_of_fit_v: float
    offset_drift_v: float
    """Standard deviation between replications."""
    sensitivity_drift: float
    """Relative."""
    noise_source: str
    components_source: str
    """Where lack of fit and drift come from."""
    count: float | None = None
    """What one count of its readings is declared to be; None of those that send no counts."""
    sampled: Sampled | None = None
    """What samples have shown; None: what count and noise let expect."""

    def noise_v(self, samples: int) -> float:
        """Return the standard deviation of the mean of a dwell."""
        return hypot(self.dwell_v, self.reading_v / sqrt(samples))

    def integrated(self, cycles_ratio: float) -> "AxisBelief":
        """Return the belief for readings of another integration time: their noise falls with its square root."""
        return replace(self, reading_v=self.reading_v / sqrt(cycles_ratio))

    def belief(self, samples: int, points: int) -> Belief:
        """Return it as the mathematics takes it, by the names of primary parameters; of so many points of a design."""
        drift = {
            f"k_{axis}_v_per_g": abs(k) * self.sensitivity_drift for axis, k in zip("xyz", self.k_v_per_g, strict=True)
        }
        sampled = self.sampled
        if sampled is None and self.count is not None:
            sampled = Sampled(self.count, self.reading_v**2 * (1.0 - 1.0 / samples), points)
        return Belief(self.noise_v(samples), self.lack_of_fit_v, {"offset_v": self.offset_drift_v, **drift}, sampled)


@dataclass(frozen=True)
class Shown:
    """What one sensor axis showed in a run before, per sensitivity: another of its type may have it too."""

    reading_g: float
    """Standard deviation of one reading, local g."""
    dwell_g: float
    """What the mean of a dwell had of its own."""
    lack_of_fit_g: float
    offset_drift_g: float
    sensitivity_drift: float


@dataclass(frozen=True)
class Pilot:
    """What a run of the same rig showed."""

    source: str
    """Its name, for the forecast."""
    shown: Mapping[tuple[str, str], Shown]
    """Sensor and axis."""
    of_type: Mapping[tuple[str, str], Shown]
    """Type of sensor (``sensors.NAME.model``) and axis: the largest that one of them showed."""


def beliefs_of(
    rig: RigDescription,
    solve: Solve,
    samples: int,
    replications: int,
    sensors: Mapping[str, Sensor],
    pilot: Pilot | None = None,
) -> dict[tuple[str, str], AxisBelief]:
    """Return what is believed of every axis of the sensors; ``samples`` of a dwell whose noise is stated."""
    beliefs = {
        (serial, str(axis)): _belief(rig, solve, samples, replications, (serial, str(axis)), sensor)
        for serial, sensor in sensors.items()
        for axis in sensor.channels
    }
    if pilot is None:
        return beliefs
    return {
        (serial, axis): _as_shown(belief, serial, axis, sensors[serial].model, pilot)
        for (serial, axis), belief in beliefs.items()
    }


def _as_shown(belief: AxisBelief, serial: str, axis: str, model: str, pilot: Pilot) -> AxisBelief:
    shown = pilot.shown.get((serial, axis))
    source = pilot.source if shown is not None else f"{pilot.source}, its {model}"
    shown = shown or pilot.of_type.get((model, axis))
    if shown is None:
        return belief
    v_per_g = float(np.linalg.norm(belief.k_v_per_g))
    return replace(
        belief,
        reading_v=shown.reading_g * v_per_g,
        dwell_v=shown.dwell_g * v_per_g,
        lack_of_fit_v=shown.lack_of_fit_g * v_per_g,
        offset_drift_v=shown.offset_drift_g * v_per_g,
        sensitivity_drift=shown.sensitivity_drift,
        noise_source=source,
        components_source=f"lack of fit and drift of {source}",
    )


def _belief(
    rig: RigDescription, solve: Solve, samples: int, replications: int, name: tuple[str, str], sensor: Sensor
) -> AxisBelief:
    serial, axis = name
    truth = _truth(rig, serial, axis)
    nominal = sensor.nominal_v_per_g(axis) or (0.0 if truth is None else truth.sensitivity_v_per_g) or 1.0
    coning_deg, azimuth_deg = (
        (NOMINAL_CONING_DEG, NOMINAL_AZIMUTH_DEG) if truth is None else (truth.coning_deg, truth.azimuth_deg)
    )
    k = vector_from_angles(axis, nominal, radians(coning_deg), radians(azimuth_deg))
    channel = next(channel for label, channel in sensor.channels.items() if label == axis)
    count = rig.channel_counts().get(channel)
    plain = AxisBelief(
        0.0, np.asarray(k), coning_deg, 0.0, 0.0, 0.0, 0.0, 0.0, "", "no lack of fit and no drift assumed", count
    )
    if truth is not None and "expected_noise_arcsec" not in solve.model_fields_set:
        reading_v = truth.noise if count is None else sqrt(rounded_variance(count, truth.noise**2))
        plain = replace(plain, reading_v=reading_v, noise_source=f"the twin's {truth.noise:g} V a reading")
    else:
        noise_arcsec = solve.expected_noise_arcsec
        source = "solve.expected_noise_arcsec" if "expected_noise_arcsec" in solve.model_fields_set else "assumed"
        of_dwell_v = noise_arcsec * RAD_PER_ARCSEC * abs(nominal)
        plain = replace(
            plain, reading_v=of_dwell_v * sqrt(samples), noise_source=f"{noise_arcsec:g}″ a dwell, {source}"
        )
    return plain if truth is None else _drifting_as(truth, replications, plain)


def _drifting_as(truth: AxisTruth, replications: int, plain: AxisBelief) -> AxisBelief:
    """Return the belief with the twin's drift: so much a replication is a spread that grows with their number."""
    if truth.offset_drift_v_per_replication == 0.0 and truth.sensitivity_drift_per_replication == 0.0:
        return plain
    spread = sqrt(replications * (replications + 1) / 12.0)
    return replace(
        plain,
        offset_drift_v=spread * abs(truth.offset_drift_v_per_replication),
        sensitivity_drift=spread * abs(truth.sensitivity_drift_per_replication),
        components_source="the twin's drift, no lack of fit assumed",
    )


def _truth(rig: RigDescription, serial: str, axis: str) -> AxisTruth | None:
    if rig.twin is None:
        return None
    return next((truth for name, truth in rig.twin.truth.get(serial, {}).items() if name == axis), None)
