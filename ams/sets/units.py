"""The unit that a name ends in."""

UNITS = (
    ("_v_per_g3", "V/g^3"),
    ("_v_per_g2", "V/g^2"),
    ("_v_per_g", "V/g"),
    ("_v_per_dps", "V/(deg/s)"),
    ("_v_per_degc", "V/degC"),
    ("_v_per_h", "V/h"),
    ("_g_per_v", "g/V"),
    ("_per_degc", "1/degC"),
    ("_degc", "degC"),
    ("_deg", "deg"),
    ("_dps", "deg/s"),
    ("_mps2", "m/s^2"),
    ("_v", "V"),
    ("_g", "g"),
    ("_s", "s"),
)
"""The first ending that fits counts."""


def unit_of(name: str) -> str | None:
    """The unit in the name, None where it ends in none that sets know."""
    return next((unit for ending, unit in UNITS if name.endswith(ending)), None)
