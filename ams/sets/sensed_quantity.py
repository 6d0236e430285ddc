"""What the sensors of each model sense: specific force (TP), gravity (CR), angular velocity (CR's gyros).

Every equation of a set is v = b + k·h with h this field in package axes; so a set needs no more than the name of its
model to be evaluated. Source: TP (2), (4), (5); CR (III-B.5), (III-B.6), (III-C.2) to (III-C.5).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.frames import Attitude, body_rates_rad_s, specific_force
from ams.models.cr import model_gravity_g, sting_gravity_g

PER_G = ("k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g")
PER_DPS = ("k_x_v_per_dps", "k_y_v_per_dps", "k_z_v_per_dps")
RATE_INPUTS = ("pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps")


@dataclass(frozen=True)
class Field:
    """The field of one model, and how a set names its parts."""

    convention: str
    symbol: str
    """Of the field in the printed equations."""
    directions: tuple[str, str, str]
    """Names of k among the primary parameters."""
    inputs: tuple[str, ...]
    """What the equation takes, as named in test vectors, temperature apart."""

    @property
    def sensitivity(self) -> str:
        return self.directions[0].replace("k_x", "sensitivity")


_TP = Field("TP", "f", PER_G, ("pitch_deg", "roll_deg"))
FIELDS: Mapping[str, Field] = MappingProxyType(
    {
        "pitch-roll": _TP,
        "pitch-roll-extended": _TP,
        "pitch-only": _TP,
        "pitch-yaw-roll-sting": Field("CR", "G", PER_G, ("pitch_deg", "roll_deg", "yaw_deg")),
        "pitch-yaw-roll-model": Field("CR", "G", PER_G, ("pitch_deg", "roll_deg", "yaw_deg")),
        "gyro": Field("CR", "w", PER_DPS, ("pitch_deg", "roll_deg", "yaw_deg", *RATE_INPUTS)),
    }
)


def field_at(model: str, attitude: Attitude) -> FloatArray:
    """(…, 3) the field in package axes: local g, or °/s for gyros.

    Raises: OutsideValidity where the model needs a yaw or rates that are not given.
    """
    if FIELDS[model].convention == "TP":
        return specific_force(attitude.pitch_rad, attitude.roll_rad)
    if attitude.yaw_rad is None:
        raise OutsideValidity(f"model {model}: yaw is missing: the set knows yaw; nothing was computed; give yaw_rad")
    if model != "gyro":
        roll = attitude.roll_rad if model == "pitch-yaw-roll-model" else np.zeros_like(attitude.roll_rad)
        return np.asarray(model_gravity_g(sting_gravity_g(attitude.pitch_rad, attitude.yaw_rad), roll))
    if attitude.euler_rate_rad_s is None:
        raise OutsideValidity(
            "model gyro: the rates are missing: gyros sense the rates of pitch, yaw and roll; nothing was computed; "
            "give euler_rate_rad_s"
        )
    euler = np.stack(np.broadcast_arrays(attitude.pitch_rad, attitude.yaw_rad, attitude.roll_rad), axis=-1)
    return np.asarray(np.rad2deg(body_rates_rad_s(euler, attitude.euler_rate_rad_s)))
