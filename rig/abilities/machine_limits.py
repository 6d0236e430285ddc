"""A controller's own limits against those of the file: they must let the axis go wherever the file lets it."""

from rig.errors import RequestRefused

_SLACK_DEG = 1e-3


def require_travel(name: str, limits_deg: tuple[float, float], machine_deg: tuple[float, float]) -> None:
    """Refuse where the machine's travel ends inside the file's limits, both as attitudes. Raises: RequestRefused."""
    low_deg, high_deg = limits_deg
    machine_low_deg, machine_high_deg = sorted(machine_deg)
    if machine_low_deg > low_deg + _SLACK_DEG or machine_high_deg < high_deg - _SLACK_DEG:
        raise RequestRefused(
            f"{name}: the controller's own limits end the travel at {machine_low_deg:g} and {machine_high_deg:g}°,"
            f" inside those of the file, {low_deg:g} to {high_deg:g}° (axes.{name}: limits_deg); nothing moved;"
            " make the file's limits as narrow, or set the controller's wider"
        )
