"""What CR's models have in common in a coefficient set: their printed equation and the direction of k."""

from ams.arrays import FloatArray
from ams.models.cr import sensitive_axis
from ams.models.sensor_model import Equation


def cr_equation(
    nominal_axis: str, symbol: str, directions: tuple[str, str, str], sensitivity: str, sources: tuple[str, str, str]
) -> Equation | None:
    """Return the printed equation, None for what is no axis."""
    if nominal_axis not in "xyz":
        return None
    i = "xyz".index(nominal_axis)
    along, first, second = (f"{symbol}_{'xyz'[(i + index) % 3]}" for index in range(3))
    primary = "output = offset_v + " + " + ".join(
        f"{name}*{symbol}_{axis}" for name, axis in zip(directions, "xyz", strict=True)
    )
    derived = (
        f"v = b + S*(cos C {along} + sin C (sin A {first} - cos A {second})); b = offset_v, S = {sensitivity}, "
        "C = coning_deg, A = azimuth_deg, T = pitch_deg, P = yaw_deg, F = roll_deg"
    )
    return Equation(sources[i], primary, derived)


def along_cr(nominal_axis: str, angles_rad: FloatArray) -> FloatArray:
    """Return the (3,) unit vector of k from coning and azimuth."""
    return sensitive_axis(nominal_axis, angles_rad[1], angles_rad[0])
