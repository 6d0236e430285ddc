"""What nobody declared of a rig: remarks of a result, and findings beside the tests of its data."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Final

from ams.finding_kinds import FindingKind
from ams.findings import Finding, Said
from ams.models.registry import takes_levels
from procedures.description.kind_tables import Levels
from procedures.plan.plan import Plan
from procedures.records.declared_gaps import (
    crosstalk_remarks,
    direction_remarks,
    field_remarks,
    gravity_remarks,
    level_remarks,
    meter_remarks,
    rate_remarks,
    table_remarks,
)
from rig.description.rig_file import RigDescription, Sensor

LEVEL_PRIORS: Final = frozenset({"pitch_zero", "base_tilt"})
"""Priors of a joint fit by which the tilt of a base is declared whose level nobody read."""


@dataclass(frozen=True)
class Undeclared:
    """Of each kind what is to be said, and where it is declared."""

    level: tuple[Said, ...] = ()
    """Of the base, where attitudes are counted from it."""
    meter: tuple[Said, ...] = ()
    rates: tuple[Said, ...] = ()
    """Of a standard of them."""
    gravity: tuple[Said, ...] = ()
    """Of its uncertainty, where sensitivities are per local g."""
    table: tuple[Said, ...] = ()
    """Of the indices of its axes, where attitudes are told by them."""

    directions: tuple[Said, ...] = ()
    """Of its axes, where gyros turned about them."""
    crosstalk: tuple[Said, ...] = ()
    """Of the scanner before the meter."""
    field: tuple[Said, ...] = ()
    """Of coils and of what stands beside them, where magnetometers are held against them."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """All of them as sentences."""
        return tuple(said.text for said in (*self.level, *self.references))

    @property
    def references(self) -> tuple[Said, ...]:
        """All of them but the level of the base, which a certificate asks for by itself."""
        others = (self.table, self.meter, self.crosstalk, self.rates, self.directions, self.field, self.gravity)
        return tuple(said for every in others for said in every)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Each as a finding that no test made."""
        kinds: Mapping[FindingKind, tuple[Said, ...]] = {
            "level-undeclared": self.level,
            "table-undeclared": (*self.table, *self.directions),
            "meter-undeclared": (*self.meter, *self.crosstalk),
            "rate-undeclared": self.rates,
            "gravity-undeclared": self.gravity,
            "field-undeclared": self.field,
        }
        return tuple(
            Finding(kind, said.fact, is_significant=False, what_to_do=said.what_to_do)
            for kind, every in kinds.items()
            for said in every
        )


def undeclared_of(rig: RigDescription, sensor: Sensor, plan: Plan) -> Undeclared:
    """Return what nobody declared of the rig, as far as a plan holds a sensor against it."""
    levels, turned, solve = plan.kind_table("levels", Levels), plan.axes, plan.solve
    is_of_magnet = levels is not None and levels.method == "magnet-difference"  # which tells its levels itself
    # Indices and a tilted base turn what senses a direction, and no rates.
    is_turned = sensor.measures != "rate" and not is_of_magnet
    stands_level = solve.joint and set(solve.joint_priors_arcsec) >= LEVEL_PRIORS
    coils = dict.fromkeys(dwell.applied.coil for dwell in plan.dwells if dwell.applied is not None)
    is_unsure = levels is not None and levels.surroundings_ut is not None and not levels.surroundings_uncertainty_ut
    beside = "levels.surroundings_uncertainty_ut of the procedure" if is_unsure else None
    return Undeclared(
        level_remarks(rig) if is_turned and not stands_level else (),
        meter_remarks(rig, sensor),
        rate_remarks(rig, sensor, turned),
        gravity_remarks(rig, senses_gravity=sensor.measures == "acceleration"),
        table_remarks(rig, sensor, turned) if is_turned else (),
        direction_remarks(rig, sensor, turned) if not takes_levels(solve.model) else (),
        crosstalk_remarks(rig, sensor),
        field_remarks(rig, coils, beside) if sensor.measures == "field" and not is_of_magnet else (),
    )


def undeclared_of_plan(rig: RigDescription, plan: Plan) -> Undeclared:
    """Return the same of all sensors of a plan, each once."""
    every = [undeclared_of(rig, sensor, plan) for sensor in plan.sensors.values()]
    return Undeclared(
        **{
            kind.name: tuple(dict.fromkeys(said for sensor in every for said in getattr(sensor, kind.name)))
            for kind in fields(Undeclared)
        }
    )
