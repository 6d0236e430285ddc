"""Names of parameters as a person reads them: the quantity, and the unit that the name ends in."""

UNITS = {
    "_v_per_g3": "V/g³",
    "_v_per_g2": "V/g²",
    "_v_per_mps2": "V/(m/s²)",
    "_v_per_g": "V/g",
    "_g_per_v": "g/V",
    "_v_per_h": "V/h",
    "_v_per_degc": "V/°C",
    "_v_per_dps": "V/(°/s)",
    "_per_degc": "1/°C",
    "_degc": "°C",
    "_deg": "°",
    "_v": "V",
    "_g": "g",
    "_s": "s",
}


def label_and_unit(name: str) -> tuple[str, str]:
    """``sensitivity_v_per_g`` as ``sensitivity`` and ``V/g``."""
    for ending, unit in UNITS.items():
        if name.endswith(ending):
            return name.removesuffix(ending).replace("_", " "), unit
    return name.replace("_", " "), ""
