"""What a laboratory has not declared and a certificate must say, a phrase each: asked before a run and of its set.

Source: ISO/IEC 17025:2017, 7.8.2.1, 7.8.4.1.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

from ams.findings import Said
from ams.observations import Observations
from ams.sets.verdict_conditions import (
    NO_CROSSTALK,
    NO_DIRECTIONS,
    NO_FIELD,
    NO_GRAVITY,
    NO_LEVEL,
    NO_METER,
    NO_STANDARD_OF_RATES,
    NO_TABLE,
    NO_TEMPERATURE,
    NO_THERMOMETER,
)
from rig.description.rig_file import RigDescription, Sensor

NOBODY_APPROVED = "nobody has signed the set as approved"
OF_A_TWIN = "the readings come from a twin (SIMULATED)"
VOLTS = "v"
"""As it is written in a key."""
_OF_A_COIL: Final = MappingProxyType(
    {
        "strength": ("uncertainty_ut", "a field that is wrong by a part is a sensitivity that is wrong by it"),
        "direction": ("direction_uncertainty_deg", "a field that lies otherwise is a package that is turned"),
    }
)
"""What may be wrong of a coil, by which key it is declared, and what it does to a sensor."""


@dataclass(frozen=True)
class Declared:
    """The tables of a rig file that a certificate is written from."""

    laboratory: Mapping[str, Any]
    job: Mapping[str, Any]
    level: Mapping[str, Any]
    has_standards: bool
    senses_gravity: bool
    references: Sequence[Said]
    """What is to be said of a gravity without an uncertainty, and of meters and turning axes without a standard."""


def declared_gaps(declared: Declared) -> Iterator[Said]:
    """Yield what is not declared, and where it is."""
    is_elsewhere = bool(declared.job.get("location"))
    for key, what in (
        ("name", "name"),
        ("address", "address" if is_elsewhere else "address, the place of the calibration,"),
        ("capability_deg", "stated capability"),
    ):
        if not declared.laboratory.get(key):
            yield Said(f"the laboratory's {what} is not declared", f"declare [laboratory] {key}")
    for key, what in (
        ("customer", "customer"),
        ("customer_contact", "contact of the customer (address, e-mail or telephone)"),
        ("item", "description of the item"),
    ):
        if not declared.job.get(key):
            yield Said(f"the {what} is not declared", f"declare [job] {key}")
    if not declared.has_standards:
        yield Said("no standard is declared, so nothing is traceable", "declare [standards] and standard = …")
    if declared.senses_gravity and not (declared.level.get("before") or declared.level.get("after")):
        yield Said("the level of the base was not read", "declare [level] before and after")
    yield from declared.references


def level_remarks(rig: RigDescription) -> tuple[Said, ...]:
    """Say that nobody read the level of the base, where the attitude is counted from it."""
    reference = rig.attitude_reference
    is_referred = reference is not None and {"pitch", "roll"} <= set(reference.channels)
    if rig.level.before is not None or rig.level.after is not None or is_referred:
        return ()
    return (
        Said(
            f"{NO_LEVEL}: a tilted base, or an axis that was set to zero wrongly, passes for a turned package and is "
            "not in these uncertainties",
            "read it before and after ([level] of the rig file)",
        ),
    )


def table_remarks(rig: RigDescription, sensor: Sensor, turned: Iterable[str]) -> tuple[Said, ...]:
    """Say of the axes that ``turned`` that nobody declared how far their indices may be wrong.

    Of sensors of gravity or of a field; what senses rates is not held against indices.

    An axis whose attitude a reference sensor tells has the uncertainty of that.
    """
    referred = () if rig.attitude_reference is None else tuple(rig.attitude_reference.channels)
    axes = {name: rig.axes[name] for name in turned if name in rig.axes and name not in referred}
    unknown = [name for name, axis in axes.items() if not axis.uncertainty_arcsec and axis.index_table is None]
    if sensor.measures == "rate" or not unknown:
        return ()
    return (
        Said(
            f"{NO_TABLE} ({', '.join(unknown)}): what they are wrong by is in no figure stated here, but as far as it "
            "scatters from attitude to attitude; a smooth error of the table is a wrong sensitivity, offset or "
            "direction of every sensor on it",
            f"declare {' and '.join(f'axes.{name}.uncertainty_arcsec' for name in unknown)} of the rig file, as the "
            "certificate of the table states it, or its list of errors (index_table)",
        ),
    )


def meter_remarks(rig: RigDescription, sensor: Sensor | None) -> tuple[Said, ...]:
    """Say that nobody declared how far the volts of a sensor's meters may be wrong, where its outputs are volts.

    Without a sensor the caller does not know which meter measured: none is in its uncertainties.
    """
    if sensor is None:
        fact = f"{NO_METER}: which sensor was measured is not told, so that no meter is counted"
        return (Said(fact, "name the sensor of the rig file (--sensor NAME)"),)
    units = rig.channel_units()
    in_volts = [channel for channel in sensor.channels.values() if units.get(channel) == VOLTS]
    readouts = dict.fromkeys(channel.partition(".")[0] for channel in in_volts)
    unknown = [name for name in readouts if name in rig.readouts and not _states_volts(rig, name)]
    rangeless = dict.fromkeys(
        readout
        for readout, _, name in (channel.partition(".") for channel in in_volts)
        if readout in rig.readouts and readout not in unknown and rig.readouts[readout].range_of_channel_v(name) is None
    )
    of_gain = tuple(
        Said(
            f"{NO_METER} ({name}) for its gain: its driver {rig.readouts[name].driver} does not tell the range that it "
            "reads on, so that what its gain is wrong by is in no figure stated here",
            "have whoever wrote the driver tell it (range_of_channel_v of its settings, docs/own-driver.md)",
        )
        for name in rangeless
    )
    if not unknown:
        return of_gain
    return (
        *of_gain,
        Said(
            f"{NO_METER} ({', '.join(unknown)}): what its zero and its gain are wrong by is in no figure stated here",
            _volts_to_declare(rig, unknown),
        ),
    )


def _volts_to_declare(rig: RigDescription, unknown: Sequence[str]) -> str:
    """Say by which keys the meters are declared: the standard where none is named, else what its table lacks."""
    bare = [f"readouts.{name}.standard" for name in unknown if rig.readouts[name].standard is None]
    lacking = dict.fromkeys(
        f"standards.{standard}.uncertainty_v" for name in unknown if (standard := rig.readouts[name].standard)
    )
    under = "uncertainty_v of that standard under [standards.NAME]"
    keys = [*bare, *([under] if bare else []), *lacking]
    return f"declare {' and '.join(keys)} of the rig file"


def crosstalk_remarks(rig: RigDescription, sensor: Sensor | None) -> tuple[Said, ...]:
    """Say that nobody declared how far the channels of the scanners leak into each other that read a sensor."""
    scanners = {} if sensor is None else rig.scanners_behind(sensor)
    unknown = [name for name, scanner in scanners.items() if scanner.crosstalk_ratio is None]
    if not unknown:
        return ()
    return (
        Said(
            f"{NO_CROSSTALK} ({', '.join(unknown)}): what leaks from its other channels into a reading is the same all "
            "night, passes for offset, sensitivity and direction and is in no residual, nor in any figure stated here",
            f"declare {' and '.join(f'readouts.{name}.crosstalk_ratio' for name in unknown)} of the rig file, a limit "
            "from the scanner's manual or measured with a neighbouring channel at full scale (-100 dB is 1e-5)",
        ),
    )


def rate_remarks(rig: RigDescription, sensor: Sensor, turned: Iterable[str]) -> tuple[Said, ...]:
    """Say that no standard is behind the rates that a gyro was held against, of the axes that ``turned``."""
    reference = rig.attitude_reference
    referred = () if reference is None or reference.standard is None else tuple(reference.channels)
    axes = [name for name in turned if name in rig.axes and name not in referred]
    unknown = [name for name in axes if rig.axes[name].standard is None]
    if sensor.measures != "rate" or not unknown:
        return ()
    return (
        Said(
            f"{NO_STANDARD_OF_RATES} ({', '.join(unknown)}): a rate that is wrong by a part is a sensitivity that is "
            "wrong by it, and is in no figure stated here",
            f"declare {' and '.join(f'axes.{name}.standard' for name in unknown)} and its certificate under "
            "[standards.NAME] of the rig file",
        ),
    )


def direction_remarks(rig: RigDescription, sensor: Sensor, turned: Iterable[str]) -> tuple[Said, ...]:
    """Say that nobody declared how far the axes that ``turned`` a gyro may lean, from which its direction is told."""
    unknown = [name for name in turned if name in rig.axes and not rig.axes[name].direction_uncertainty_arcsec]
    if sensor.measures != "rate" or not unknown:
        return ()
    keys = " and ".join(f"axes.{name}.direction_uncertainty_arcsec" for name in unknown)
    return (undeclared_directions(f"declare {keys} of the rig file", f" ({', '.join(unknown)})"),)


def undeclared_directions(what_to_do: str, which: str = "") -> Said:
    """Say of axes of the table, ``which`` in brackets, that nobody declared how far they lean, and what to do."""
    return Said(
        f"{NO_DIRECTIONS}{which}: axes that are not square, and a package that is seated askew on them, are the same "
        "angle in the coning and in what a gyro reads across its axis; no residual shows it, and it is in no figure "
        "stated here",
        what_to_do,
    )


def temperature_remarks(rows: Observations, use_degc: tuple[float, float] | None = None) -> tuple[str, ...]:
    """Say of readings without a temperature that nothing is known of the sensor at any other than theirs.

    ``use_degc``: the range of use where it is declared.
    """
    if rows.temperature_degc is not None:
        return ()
    flagged = (
        "no use at another is flagged"
        if use_degc is None
        else f"use is flagged outside {use_degc[0]:g} to {use_degc[1]:g} °C, which is declared and not measured"
    )
    return (
        f"{NO_TEMPERATURE}: what the sensor reads otherwise at another temperature is not in the uncertainty, and "
        f"{flagged}; one that went with the attitude, as in layered air, passes for sensitivity and "
        "for terms of second order; in a file it is the column temperature_degc, in a rig file temperature of the "
        "sensor",
    )


def thermometer_remarks(rig: RigDescription, sensors: Iterable[Sensor], temperature: str) -> tuple[Said, ...]:
    """Say that nobody declared how far the temperatures may be wrong that offset and sensitivity are stated over.

    ``temperature``: what is done about it (``[solve] temperature``).
    """
    if temperature == "none" or all(_states_degrees(rig, sensor) for sensor in sensors):
        return ()
    return (
        Said(
            f"{NO_THERMOMETER}: offset and sensitivity are those at the temperatures that were read, and what those "
            "are wrong by is in no figure stated here",
            "declare environment.NAME.standard (chain.CHANNEL.standard of a sensor with a temperature of its own) and "
            "uncertainty_degc of that standard under [standards.NAME] of the rig file",
        ),
    )


def gravity_remarks(rig: RigDescription, *, senses_gravity: bool) -> tuple[Said, ...]:
    """Say that nobody declared how far the stated gravity may be wrong, where sensitivities are per local g."""
    stated = rig.rig
    if not senses_gravity or stated.gravity_mps2 is None or stated.gravity_uncertainty_mps2:
        return ()
    return (undeclared_gravity(stated.gravity_mps2),)


def undeclared_gravity(gravity_mps2: float) -> Said:
    """Say of a gravity without an uncertainty what is wrong by as much as it is."""
    return Said(
        f"{NO_GRAVITY} ({gravity_mps2:g} m/s²): by the part that it is wrong, every sensitivity per m/s² is wrong, and "
        "every output told at another gravity, and that is in no figure stated here; sensitivities per local g and "
        "angles at the gravity of the calibration do not depend on it",
        "declare rig.gravity_uncertainty_mps2 of the rig file, a standard uncertainty; or leave rig.gravity_mps2 out, "
        "and rig.latitude_deg with rig.height_m give it with what gravity anomalies do",
    )


def field_remarks(rig: RigDescription, coils: Iterable[str], surroundings: str | None) -> tuple[Said, ...]:
    """Say that nobody declared how far the fields may be wrong that a magnetometer was held against.

    ``coils``: those that made a field. ``surroundings``: the key by which what stands beside them is declared, where
    it is stated without an uncertainty.
    """
    known = {coil: rig.field[coil] for coil in coils if coil in rig.field}
    keys, effects = dict[str, str](), list[str]()
    for what, (key, effect) in _OF_A_COIL.items():
        unknown = [coil for coil, settings in known.items() if not getattr(settings, key)]
        keys |= {f"{what} of {coil}": f"field.{coil}.{key}" for coil in unknown}
        effects += [effect] if unknown else []
    if surroundings is not None:
        keys["surroundings"] = surroundings
        effects.append("what stands beside a coil passes for offset and sensitivity")
    if not keys:
        return ()
    return (
        Said(
            f"{NO_FIELD} ({', '.join(keys)}): {', and '.join(effects)}; no residual shows it, and it is in no figure "
            "stated here",
            f"declare {' and '.join(keys.values())} as standard uncertainty, by the certificate of the coil or of the "
            "magnetometer that it was measured with",
        ),
    )


def _states_volts(rig: RigDescription, readout: str) -> bool:
    standard = rig.standards.get(rig.readouts[readout].standard or "")
    return standard is not None and standard.uncertainty_v is not None


def _states_degrees(rig: RigDescription, sensor: Sensor) -> bool:
    """Return whether a standard is behind the sensor's own thermometer, else behind that of the rig's only chamber."""
    if sensor.temperature is not None:
        chain = rig.chain.get(sensor.temperature.channel)
        names = [] if chain is None else [chain.standard]
    else:
        names = [environment.standard for environment in rig.environment.values()]
    standard = rig.standards.get(names[0] or "") if len(names) == 1 else None
    return standard is not None and bool(standard.uncertainty_degc)
