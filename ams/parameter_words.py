"""What a person reads for the name of a parameter: its words, its symbol in the reports, its printed unit."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ams.units import label_and_unit


class ParameterWords(NamedTuple):
    """``sensitivity_v_per_g`` as ``sensitivity``, ``S`` and ``V/g``."""

    label: str
    symbol: str
    """As TP, CR or SR write it; empty for a parameter that none of them has."""
    unit: str
    """As it is printed; empty for a pure number."""

    @property
    def lettered(self) -> str:
        """The words, with the letter of SR's lines behind them: ``gain A``, ``offset B``."""
        return f"{self.label} {self.symbol}" if self.symbol in ("A", "B") and self.label != "azimuth" else self.label


_QUADRATIC = ("xx", "yy", "xy", "xz", "yz", "zz")
_WORDS: Mapping[str, tuple[str, str]] = {
    "offset_v": ("offset", "b"),
    "offset_traceless_v": ("offset (tr Q = 0)", "b₀"),
    "sensitivity_v_per_g": ("sensitivity", "S"),
    "sensitivity_v_per_dps": ("sensitivity", "S"),
    "sensitivity_v_per_mps2": ("sensitivity", "S"),
    "coning_deg": ("coning angle", "Ω"),
    "azimuth_deg": ("azimuth", "A"),
    "pitch_misalignment_deg": ("pitch misalignment", "φ"),
    "offset_tc_v_per_degc": ("offset temperature", "b₁"),
    "sensitivity_tc_per_degc": ("sensitivity temperature", "s₁"),
    "offset_tc2_v_per_degc2": ("offset temperature, second order", "b₂"),
    "sensitivity_tc2_per_degc2": ("sensitivity temperature, second order", "s₂"),
    "reference_temperature_degc": ("reference temperature", "T₀"),
    "offset_drift_v_per_h": ("offset drift", "d"),
    "reference_time_s": ("reference time", "t₀"),
    **{f"q_{pair}_v_per_g2": (f"quadratic term {pair}", f"q_{pair}") for pair in _QUADRATIC},
    "k3_v_per_g3": ("cubic term", "K₃"),
    "k2_v_per_dps2": ("quadratic nonlinearity", "K₂"),
    "k3_v_per_dps3": ("cubic nonlinearity", "K₃"),
    **{f"k_{axis}_v_per_{level}": (f"k {way}", f"k_{axis}")
       for axis, way in zip("xyz", ("forward", "right", "down"), strict=True) for level in ("g", "dps")},
    **{f"towards_{axis}_deg": (f"angle towards {axis}", "") for axis in "xyz"},
    **{f"towards_{axis}": (f"angle towards {axis}", "") for axis in "xyz"},  # the tests of their drift
    "coning": ("coning angle", "Ω"),  # the test of its drift
}  # fmt: skip
"""Names that the reports have a symbol for; every other name is read by :func:`ams.units.label_and_unit`."""


def not_determined(names: Sequence[str]) -> str:
    """Return ``coning angle and azimuth are not determined``."""
    return f"{' and '.join(words_of(name).label for name in names)} {'is' if len(names) == 1 else 'are'} not determined"


def words_of_characteristic(name: str) -> str:
    """Return how a characteristic of a history is told: ``sensitivity_v_per_g.x`` is ``sensitivity x``.

    ``angle_deg.yz`` is ``angle between axes yz``.
    """
    kind, _, axis = name.partition(".")
    label = "angle between axes" if kind == "angle_deg" else words_of(kind).label
    return f"{label} {axis}" if axis else label


def words_of(name: str) -> ParameterWords:
    """Return how the parameter of that name is told; any name will do."""
    label, unit = label_and_unit(name)
    if name in _WORDS:
        return ParameterWords(*_WORDS[name], unit)
    if label == "gain":
        return ParameterWords(label, "A", unit)
    if label == "offset" and unit:
        return ParameterWords(label, "B", unit)
    return ParameterWords(label, "", unit)
