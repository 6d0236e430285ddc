"""A sensor model of your own: a clinometer whose spring stiffens, v = b + S·s + C·s³ with s = sin(α − φ).

The class has the members of ``ams.models.model.Model``, which the solvers take; ``MODEL`` registers it for files, sets,
exports and attitude (``pyproject.toml``). Without installation the class alone is solved with: ``python
examples/own_model/stiffening.py``. What each member is for: docs/mathematics.md, "A model of your own".
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ams import CalibrationRequest, Observations, TableUncertainty, to_document
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.models.accelerometer import PITCH_ROLL_FORM
from ams.models.model import Stimulus
from ams.models.sensor_model import Equation, ModelOutput, SensorModel
from ams.units import RAD_PER_ARCSEC

RAD_PER_DEG = np.pi / 180.0
NAMES = ("offset_v", "sensitivity_v_per_g", "stiffening_v_per_g", "pitch_misalignment_deg")


@dataclass(frozen=True)
class StiffeningClinometer:
    """Primary parameters b, S, C (volts per g at 1 g) and φ in degrees, as the files have them."""

    nominal_axis: str = "x"
    name: str = "stiffening-clinometer"
    convention: str = "TP"
    measured_unit: str = "v"
    primary_names: tuple[str, ...] = NAMES
    parameter_names: tuple[str, ...] = NAMES
    basis_key: Hashable | None = None
    """None: not linear in its primary parameters, so it is iterated from ``start``."""

    @property
    def fixed(self) -> Mapping[str, tuple[float, float]]:
        return {}

    def basis(self, stimulus: Stimulus) -> FloatArray:
        raise NotImplementedError("asked for only where basis_key is set")

    def start(self, stimulus: Stimulus, output_v: FloatArray) -> FloatArray:
        """Start from the model without misalignment, which is linear: good enough to iterate from."""
        s = np.sin(stimulus.pitch_rad)
        columns = np.stack([np.ones_like(s), s, s**3], axis=1)
        return np.append(np.linalg.lstsq(columns, output_v, rcond=None)[0], 0.0)

    def predict(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        b, S, C, phi = primary
        s = np.sin(stimulus.pitch_rad - RAD_PER_DEG * phi)
        return np.asarray(b + S * s + C * s**3)

    def jacobian(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        s = np.sin(stimulus.pitch_rad - np.deg2rad(primary[3]))
        return np.stack([np.ones_like(s), s, s**3, -np.deg2rad(self._by_pitch(primary, stimulus))], axis=1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        return {"pitch": self._by_pitch(primary, stimulus), "roll": np.zeros_like(stimulus.pitch_rad)}

    def parameters(self, primary: FloatArray) -> FloatArray:
        return np.array(primary)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:  # noqa: ARG002 (the same everywhere)
        return np.eye(4)

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:  # noqa: ARG002
        return {}

    def _by_pitch(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        _, S, C, phi = primary
        angle = stimulus.pitch_rad - np.deg2rad(phi)
        return np.asarray((S + 3.0 * C * np.sin(angle) ** 2) * np.cos(angle))


def _value_v(primary: Mapping[str, float], f: FloatArray) -> FloatArray:
    """Return the same equation as a function of the specific force: s = f_x cos φ + f_z sin φ at no roll."""
    b, S, C, phi = (primary[name] for name in NAMES)
    s = f[..., 0] * np.cos(np.deg2rad(phi)) + f[..., 2] * np.sin(np.deg2rad(phi))
    return np.asarray(b + S * s + C * s**3)


def _pitch_rad(primary: Mapping[str, float], output_v: FloatArray) -> FloatArray:
    """Return the root of C·s³ + S·s = v − b near (v − b)/S, by Newton's method."""
    b, S, C, phi = (primary[name] for name in NAMES)
    s = (output_v - b) / S
    for _ in range(20):
        s = s - (S * s + C * s**3 - (output_v - b)) / (S + 3.0 * C * s**2)
    return np.asarray(np.arcsin(np.where(np.abs(s) <= 1.0, s, np.nan)) + np.deg2rad(phi))


def _equation(nominal_axis: str) -> Equation | None:
    text = "v = b + S*s + C*s^3 with s = f_x cos p + f_z sin p; b = offset_v, S = sensitivity_v_per_g, "
    text += "C = stiffening_v_per_g (at 1 g), p = pitch_misalignment_deg"
    return Equation("own", text, "the same") if nominal_axis == "x" else None


_SINE = "(f[0] * cos({pitch_misalignment_deg} * 0.017453292519943295)"
_SINE += " + f[2] * sin({pitch_misalignment_deg} * 0.017453292519943295))"
MODEL = SensorModel(
    name="stiffening-clinometer",
    make=StiffeningClinometer,
    columns=("pitch",),
    set_form=replace(
        PITCH_ROLL_FORM,  # the same field, with the same inputs and the same C
        equation=_equation,
        along=None,
        output=ModelOutput(
            primary_names=NAMES,
            value_v=_value_v,
            c=f"{{offset_v}} + ({{sensitivity_v_per_g}} + {{stiffening_v_per_g}} * {_SINE} * {_SINE}) * {_SINE}",
            pitch_rad=_pitch_rad,
        ),
    ),
)


def measured(truth: FloatArray, noise_v: float, rng: np.random.Generator, replications: int = 4) -> Observations:
    """Return a stand-in for ``ams.read_csv``: ±60° by 5° without roll."""
    pitch = np.deg2rad(np.tile(np.arange(-60.0, 61.0, 5.0), replications))
    points = pitch.size // replications
    s = np.sin(pitch - np.deg2rad(truth[3]))
    output = truth[0] + truth[1] * s + truth[2] * s**3 + noise_v * rng.standard_normal(pitch.size)
    return Observations(
        replication=np.repeat(np.arange(1, replications + 1), points),
        point=np.tile(np.arange(points), replications),
        pitch_rad=pitch,
        roll_rad=np.zeros(pitch.size),
        outputs={"x": output},
    )


def main() -> None:
    rows = measured(np.array([0.01, 2.5, -0.02, 0.3]), 2e-5, np.random.default_rng(1))
    request = CalibrationRequest(
        nominal_axes={"x": "x"},
        models={"x": StiffeningClinometer()},
        table=TableUncertainty(pitch_rad=RAD_PER_ARCSEC, roll_rad=0.0, kind="limit"),
    )
    solved = to_document(calibrate(rows, request))["axes"]["x"]  # type: ignore[index]
    for name, found in solved["parameters"].items():
        print(f"{name:<24} {found['value']:+.7f}   u {found['standard_uncertainty']:.1e}")  # noqa: T201
    print(f"standard error {solved['standard_error_v']:.2e} V")  # noqa: T201


if __name__ == "__main__":
    main()
