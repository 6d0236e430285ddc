"""What a controller counts at its home: a setting of its own, which another program may have changed.

A home search succeeds all the same, and every angle is then off by as much: it is compared before anything moves.
"""

from rig.description.device_settings import AxisSettings
from rig.errors import FileContradicted

_SAME_DEG = 1e-5
"""Controllers print such a number with five or six decimals."""


class HomePresetSettings(AxisSettings):
    """Of an axis whose controller can be asked for it."""

    home_preset_deg: float = 0.0
    """What the machine's own counter becomes where its home search ends."""

    @property
    def home_attitude_deg(self) -> float:
        return self.attitude_deg(self.home_preset_deg)


def require_preset(name: str, settings: HomePresetSettings, reads_deg: float, setting: str, unit_deg: float) -> None:
    """Compare what the controller has with the file. Raises: FileContradicted.

    ``setting``: its name there, which takes multiples of ``unit_deg``.
    """
    need_deg = settings.home_preset_deg
    if abs(reads_deg - need_deg) > max(_SAME_DEG, 0.5 * unit_deg):
        raise FileContradicted(
            f"{name}: the controller counts its home as {reads_deg:g}° ({setting}), the rig file says {need_deg:g}"
            f" (axes.{name}: home_preset_deg): all angles are counted from there; nothing moved; give the controller"
            " what the file says and home the axis, or correct the file and see where the zero stands (zero_deg)"
        )
