"""What the laboratory declares in the rows called *declared*, as the keys of its files lead to it.

A design names it: ``declared_arcsec = 1.0`` is a level of the base and zeros of the axes within ±1″. Everything else
of a design is the campaign's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from physics_scenes.temperature_scenes import OFFSET_TC_G_PER_DEGC, SENSITIVITY_TC_PER_DEGC
from solved_campaigns import ARCSEC, table_of

from ams.inputs.shared_errors import NONLINEARITY, SHIFTS, SHIFTS_WITHIN, Effect, SharedError
from ams.inputs.table_uncertainty import IndexErrors, TableUncertainty
from ams.models.thermal import Order

LEVEL, TABLE = "declared_arcsec", "declared_table_arcsec"
USED, ORDER = "declared_degc", "declared_order"
METER = "declared_ppm"
SHIFTED, LOST = "declared_shift_arcsec", "declared_shift_share"
BENT = "declared_departure_ug"
BESIDE, COIL = "declared_beside_ut", "declared_coil_deg"
THERMOMETER = "own_thermometer"
"""The sensor's own temperature is what is recorded."""
KEYS: Mapping[str, tuple[str, str]] = {
    LEVEL: ("level and zeros ±{:g}″", "`[level] uncertainty_arcsec`, `[axes.NAME] index_zero_uncertainty_arcsec`"),
    TABLE: ("indices ±{:g}″", "`[axes.NAME] uncertainty_arcsec`"),
    USED: ("used within ±{:g} °C", "`use_temperature_degc` with the data sheet's largest coefficients"),
    ORDER: ("coefficients of order {:g}", "`[solve] temperature_order`"),
    THERMOMETER: ("thermometer on the sensor", "`[sensors.SERIAL] temperature`"),
    METER: ("meter ±{:g} ppm", "`[standards.NAME] uncertainty_v` of the meter"),
    SHIFTED: ("offset within ±{:g}″ now and until next time", "`[sensors.SERIAL] largest_offset_shift_v`"),
    LOST: ("sensitivity within ±{:g} now and until next time", "`[sensors.SERIAL] largest_sensitivity_shift`"),
    BENT: ("departures within ±{:g} µg", "`[sensors.SERIAL] largest_nonlinearity_v`"),
    BESIDE: ("surroundings u {:g} µT", "`[levels] surroundings_uncertainty_ut`"),
    COIL: ("direction of the coil u {:g}°", "`[field.NAME] direction_uncertainty_deg`"),
}
"""Of a design: its words in a row, and the keys that declare it."""
JOINT = "jointly"
"""Of a design: package and table are solved together."""
PLANS: Mapping[str, str] = {
    JOINT: "joint fit",
    "replications": "{:g} replications",
    "check_before_count": "no reference visit, {:g} of 6 check dwells before",
}
"""Of a design: the words of a plan that is not the usual one."""
NOMINAL_V_PER_G = 2.5
_OF_BASE: tuple[Effect, ...] = ("pitch", "base-tilt")


@dataclass(frozen=True)
class Declared:
    """Limits, zero where nothing is declared."""

    limits: Mapping[str, float]

    def __getitem__(self, key: str) -> float:
        return self.limits.get(key, 0.0)

    def table(self, scene: str) -> tuple[TableUncertainty | None, TableUncertainty | None]:
        """Return what is declared of the table, and the same as independent teeth."""
        zero_u_arcsec = self[LEVEL] / 3.0**0.5
        if not scene.startswith("table-"):
            if zero_u_arcsec == 0.0:
                return None, None
            errors = dict.fromkeys(("pitch", "roll"), IndexErrors("unknown", 0.0, zero_u_arcsec * ARCSEC))
            return TableUncertainty(0.0, 0.0, "limit", errors=errors), None
        zero = 0.0 if scene.endswith("zeroed") or zero_u_arcsec > 0.0 else None
        limit_arcsec = self[TABLE] or 1.0
        return (
            table_of(limit_arcsec, zero_rad=zero, zero_u_arcsec=zero_u_arcsec),
            table_of(limit_arcsec, shape="independent"),
        )

    @property
    def order(self) -> Order:
        """Of the temperature coefficients that are asked for."""
        return 2 if self[ORDER] == 2.0 else 1

    @property
    def errors(self) -> tuple[SharedError, ...]:
        """What all readings of an axis share."""
        limits: Sequence[tuple[str, Effect, float]] = (
            *((f"level, {effect}", effect, self[LEVEL] * ARCSEC) for effect in _OF_BASE),
            ("temperature of use, offset", "reading", self[USED] * OFFSET_TC_G_PER_DEGC * NOMINAL_V_PER_G),
            ("temperature of use, sensitivity", "gain", self[USED] * SENSITIVITY_TC_PER_DEGC),
            ("multimeter gain", "gain", self[METER] * 1e-6),
        )
        shifts: Sequence[tuple[str, Effect, float]] = (
            (NONLINEARITY, "departure", self[BENT] * 1e-6 * NOMINAL_V_PER_G),
            (SHIFTS[0], "reading", self[SHIFTED] * ARCSEC * NOMINAL_V_PER_G),
            (SHIFTS_WITHIN[0], "reading-course", self[SHIFTED] * ARCSEC * NOMINAL_V_PER_G),
            (SHIFTS[1], "gain", self[LOST]),
            (SHIFTS_WITHIN[1], "gain-course", self[LOST]),
        )
        return (
            *(SharedError(*limit[:2], limit[2] / 3.0**0.5) for limit in limits if limit[2] > 0.0),
            *(SharedError(*limit[:2], limit[2] / 3.0**0.5, is_of_one_channel=True) for limit in shifts if limit[2]),
        )

    @property
    def by_axis(self) -> Mapping[str, tuple[SharedError, ...]]:
        """Axis to :attr:`errors`."""
        return dict.fromkeys("xyz", self.errors)


def separated(design: Mapping[str, float]) -> tuple[Mapping[str, float], Declared]:
    """Return what a design says of the campaign, and what is declared."""
    declared = {name: value for name, value in design.items() if name.startswith("declared_")}
    return {name: value for name, value in design.items() if name not in (*declared, JOINT)}, Declared(declared)


def in_words(design: Mapping[str, float]) -> str:
    """Name what a design declares, as a row has it; empty where it declares nothing."""
    return ", ".join(KEYS[name][0].format(value) for name, value in design.items() if name in KEYS)


def plan_in_words(design: Mapping[str, float]) -> str:
    """Name what of a design's plan is not the usual one, as a row has it; empty where it is."""
    return ", ".join(PLANS[name].format(value) for name, value in design.items() if name in PLANS)


def keys_of(design: Mapping[str, float]) -> str:
    """Name the keys of rig file and procedure that declare it."""
    return ", ".join(KEYS[name][1] for name in design if name in KEYS)
