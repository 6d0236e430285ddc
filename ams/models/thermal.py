"""Temperature terms on offset and sensitivity, for any model that is linear in its primary parameters.

b(T) = b0 + b1 (T − T0), S(T) = S0 (1 + s1 (T − T0)), with T the sensor's own temperature. Known coefficients are
*applied* (the model stays linear, their uncertainty is carried as a common error); unknown ones are *estimated*, which
asks for a real span of temperature that is not time in disguise. Source: TP 9.2.1 (figure 28b).
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.errors import DesignError, ObservationsError
from ams.models.added_parameters import WithAddedParameters
from ams.models.model import Stimulus
from ams.observations import Observations

TEMPERATURE_NAMES = ("offset_tc_v_per_degc", "sensitivity_tc_per_degc")
SMALLEST_SPAN_DEGC = 5.0
LARGEST_CORRELATION = 0.8


@dataclass(frozen=True)
class TemperatureCoefficients:
    """Known coefficients of one sensor axis with their standard uncertainties."""

    offset_tc_v_per_degc: float
    sensitivity_tc_per_degc: float
    offset_tc_standard_uncertainty_v_per_degc: float = 0.0
    sensitivity_tc_standard_uncertainty_per_degc: float = 0.0


@dataclass(frozen=True)
class WithTemperature(WithAddedParameters):
    """A linear model whose first primary parameter is the offset, with temperature terms behind its own parameters."""

    reference_degc: float
    known: TemperatureCoefficients | None = None
    """None: the coefficients are estimated."""

    @property
    def added_names(self) -> tuple[str, ...]:
        return TEMPERATURE_NAMES

    @property
    def reference(self) -> tuple[str, float]:
        return "reference_temperature_degc", self.reference_degc

    @property
    def fixed(self) -> Mapping[str, tuple[float, float]]:
        if self.known is None:
            return {}
        known = self.known
        return {
            "offset_tc_v_per_degc": (known.offset_tc_v_per_degc, known.offset_tc_standard_uncertainty_v_per_degc),
            "sensitivity_tc_per_degc": (
                known.sensitivity_tc_per_degc,
                known.sensitivity_tc_standard_uncertainty_per_degc,
            ),
        }

    @property
    def basis_key(self) -> Hashable | None:
        if self.known is None:
            return None
        return (self.base.basis_key, self.reference_degc, self.known.sensitivity_tc_per_degc)

    def basis(self, stimulus: Stimulus) -> FloatArray:
        assert self.known is not None
        columns = self.base.basis(stimulus)
        columns[:, 1:] *= (1.0 + self.known.sensitivity_tc_per_degc * self._rise_degc(stimulus))[:, None]
        return columns

    def start(self, stimulus: Stimulus, output_v: FloatArray) -> FloatArray:
        """Estimate a slope for each sensitivity, then one that the slopes share: exact for noise-free data."""
        columns, rise = self.base.basis(stimulus), self._rise_degc(stimulus)[:, None]
        free = np.linalg.lstsq(np.hstack([columns, rise, rise * columns[:, 1:]]), output_v, rcond=None)[0]
        size = columns.shape[1]
        k, k_slope = free[1:size], free[size + 1 :]
        return np.concatenate([free[: size + 1], [k @ k_slope / (k @ k)]])

    def predict(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        rise = self._rise_degc(stimulus)
        acceleration_part = self._sensed(primary, stimulus)
        return np.asarray(primary[0] + primary[-2] * rise + (1.0 + primary[-1] * rise) * acceleration_part)

    def jacobian(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        rise = self._rise_degc(stimulus)
        columns = self.base.basis(stimulus) * np.ones_like(primary[:1])
        columns[:, 1:] *= (1.0 + primary[-1] * rise)[:, None]
        return np.column_stack([columns, rise, rise * self._sensed(primary, stimulus)])

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        scale = 1.0 + primary[-1] * self._rise_degc(stimulus)
        return {name: scale * slope for name, slope in self.base.angle_jacobian(primary[:-2], stimulus).items()}

    def _sensed(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        return np.asarray(self.base.basis(stimulus)[:, 1:] @ primary[1:-2])

    def _rise_degc(self, stimulus: Stimulus) -> FloatArray:
        if stimulus.temperature_degc is None:
            raise ObservationsError(
                "temperature: the model has temperature terms and no temperature was measured; "
                "give a column temperature_degc or solve with temperature none"
            )
        return np.asarray(stimulus.temperature_degc) - self.reference_degc


def refuse_unless_estimable(observations: Observations) -> None:
    """Refuse observations that cannot tell temperature coefficients from offset, sensitivity and time.

    Without times the order of the rows stands for time.

    Raises:
        DesignError: the span is under 5 °C, or temperature follows time with a correlation above 0.8.
    """
    temperature = observations.temperature_degc
    if temperature is None:
        raise ObservationsError(
            f"{observations.source}: temperature coefficients cannot be estimated: no temperature was measured; "
            "give a column temperature_degc or solve with temperature none"
        )
    span_degc = float(np.ptp(temperature))
    if span_degc < SMALLEST_SPAN_DEGC:
        raise DesignError(
            f"{observations.source}: temperature coefficients cannot be estimated: it spans {span_degc:.3g} °C, "
            f"allowed {SMALLEST_SPAN_DEGC:g} °C or more; add plateaus, or apply known coefficients"
        )
    time = np.arange(observations.rows) if observations.time_s is None else observations.time_s
    correlation = float(np.corrcoef(time, temperature)[0, 1])
    if abs(correlation) > LARGEST_CORRELATION:
        raise DesignError(
            f"{observations.source}: temperature coefficients cannot be estimated: temperature and time have a "
            f"correlation of {correlation:.2f}, allowed −{LARGEST_CORRELATION:g} to "
            f"{LARGEST_CORRELATION:g}: temperature would "
            "be time in disguise; visit every plateau more than once and from both sides, or apply known coefficients"
        )
