"""What the sensors of each model sense, as C: specific force (TP), gravity (CR), angular velocity (CR's gyros).

Source: TP (2), (4), (5); CR (III-B.5), (III-B.6), (III-C.2) to (III-C.5), as the convention's text prints them.
"""

from collections.abc import Mapping
from types import MappingProxyType

from ams.sets.sensed_quantity import FIELDS

_TP = """
    f[0] = sin(pitch);
    f[1] = -cos(pitch) * sin(roll);
    f[2] = -cos(pitch) * cos(roll);
"""
_STING = """
    (void)roll;
    f[0] = -sin(pitch) * cos(yaw);
    f[1] = sin(pitch) * sin(yaw);
    f[2] = cos(pitch);
"""
_MODEL = """
    f[0] = -sin(pitch) * cos(yaw);
    f[1] = cos(roll) * sin(pitch) * sin(yaw) + sin(roll) * cos(pitch);
    f[2] = -sin(roll) * sin(pitch) * sin(yaw) + cos(roll) * cos(pitch);
"""
_GYRO = """
    (void)pitch;
    f[0] = sin(yaw) * pitch_rate_dps + roll_rate_dps;
    f[1] = cos(yaw) * cos(roll) * pitch_rate_dps + sin(roll) * yaw_rate_dps;
    f[2] = -cos(yaw) * sin(roll) * pitch_rate_dps + cos(roll) * yaw_rate_dps;
"""
BODIES: Mapping[str, str] = MappingProxyType(
    {
        "pitch-roll": _TP,
        "pitch-roll-extended": _TP,
        "pitch-only": _TP,
        "pitch-yaw-roll-sting": _STING,
        "pitch-yaw-roll-model": _MODEL,
        "gyro": _GYRO,
    }
)


def field_function(prefix: str, model: str) -> list[str]:
    """``…_force``: from the inputs of the model, in degrees and degrees a second, to its field."""
    inputs = FIELDS[model].inputs
    angles = [name.removesuffix("_deg") for name in inputs if name.endswith("_deg")]
    given = ", ".join(f"double {name}" for name in inputs)
    radians = ", ".join(f"{angle} = {angle}_deg * degree" for angle in angles)
    return [
        f"static inline void {prefix}_force({given}, double f[3])",
        "{",
        "    const double degree = 0.017453292519943295;",
        f"    const double {radians};",
        *BODIES[model].strip("\n").split("\n"),
        "}",
    ]
