"""References of a rig file: from one table to another, and to what lies outside the file."""

from collections.abc import Iterable, Mapping

from rig.description.certified_angles import better_than_certified
from rig.description.device_settings import TWIN_PORT
from rig.description.motion_limits import impossible_motion
from rig.description.plausible_limits import implausible_limits, implausible_temperatures
from rig.description.ports import unusable_ports
from rig.description.rig_file import RigDescription
from rig.description.supply_bands import contradicting_supplies
from rig.errors import RequestRefused
from rig.link.gpib import parse_resource, port_of
from rig.toml_file import TomlFile

OVER_RANGE = 1.2
"""Meters read this much of their range before they overload."""
WARM_UP_KEYS = frozenset({"warm_up_s", "warm_up_slope_v_per_h"})
"""Of a chain: all that a channel has that is read beside the sensors' outputs."""


def complaints_about_references(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield what no single table can know: mistakes in references between tables and to other files."""
    channels = {f"{name}.{channel}" for name, readout in rig.readouts.items() for channel in readout.channel_names()}
    streamed = {f"{name}.{channel}" for name, stream in rig.streams.items() for channel in stream.channel_names()}
    if not channels | streamed:
        yield file.complaint((), "no [readouts.NAME] and no [streams.NAME]: nothing could be measured; declare one")
    units = rig.channel_units()
    voltages = {channel for channel in channels if units[channel] == "v"}
    outputs = {channel for channel in channels if units[channel] != "deg"} | streamed
    yield from _unknown_channels(file, rig, voltages, outputs)
    yield from _supplies_nobody_has(file, rig)
    yield from _names_twice(file, rig)
    yield from _undeclared_sensitivities(file, rig, voltages)
    yield from _volts_of_other_units(file, rig, units)
    yield from implausible_limits(file, rig)
    yield from impossible_motion(file, rig)
    yield from implausible_temperatures(file, rig)
    yield from _approved_by_nobody(file, rig)
    yield from _unusable_reference(file, rig, units)
    yield from _ranges_too_small(file, rig)
    yield from _unknown_interlocks(file, rig, voltages)
    yield from _supplies_outside_interlocks(file, rig)
    yield from contradicting_supplies(file, rig)
    yield from _rejections_never_counted(file, rig)
    yield from _unknown_standards(file, rig)
    yield from better_than_certified(file, rig)
    yield from _axis_twice(file, rig)
    yield from _instrument_twice(file, rig)
    yield from _nobody_to_go_with(file, rig)
    yield from _cables_that_never_wind(file, rig)
    yield from _unusable_dialects(file, rig)
    yield from _unusable_resources(file, rig)
    yield from unusable_ports(file, rig)
    if rig.uses_twins:
        yield from _missing_truth(file, rig)
    if not rig.uses_twins and rig.twin is not None and rig.twin.control is None:
        yield file.complaint(
            ("twin",), 'stands there, but no port says "twin" and no control address is given; remove it'
        )


def _approved_by_nobody(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield a complaint about an approval without a name. A run that was stored with one stays one."""
    if rig.approved_by is not None and not rig.approved_by.strip():
        yield file.complaint(
            ("approved_by",),
            f"got {rig.approved_by!r}, allowed is the name of whoever approved rig and procedure; write it, or leave "
            "the key out: then everything is stamped 'engineering'",
        )


def _unknown_channels(file: TomlFile, rig: RigDescription, known: set[str], sensed: set[str]) -> Iterable[str]:
    """Yield references to channels that are not there.

    ``sensed``: what a sensor's output may be, streams included.
    """
    allowed, allowed_outputs = ", ".join(sorted(known)), ", ".join(sorted(sensed))
    taken: dict[str, str] = {}
    for serial, sensor in rig.sensors.items():
        for axis, channel in sensor.channels.items():
            key = ("sensors", serial, "channels", axis)
            if channel not in sensed:
                yield file.complaint(key, f"no channel {channel!r} (allowed: {allowed_outputs})")
            elif channel in taken:
                yield file.complaint(key, f"channel {channel!r} already belongs to {taken[channel]}")
            taken[channel] = f"{serial}.{axis}"
        if sensor.temperature and sensor.temperature.channel not in known:
            yield file.complaint(
                ("sensors", serial, "temperature"), f"no channel {sensor.temperature.channel!r} (allowed: {allowed})"
            )
    for channel, chain in rig.chain.items():
        if channel not in known:
            yield file.complaint(("chain", channel), f"no channel {channel!r} (allowed: {allowed})")
        elif channel not in _of_sensors(rig):
            yield from _chain_of_no_output(file, rig, channel)
        if chain.load_resistor_at is not None and chain.load_resistor_at not in rig.environment:
            allowed_chambers = ", ".join(sorted(rig.environment)) or "none"
            yield file.complaint(
                ("chain", channel, "load_resistor_at"),
                f"no environment {chain.load_resistor_at!r} (allowed: {allowed_chambers})",
            )
        if chain.supply_channel is not None and chain.supply_channel not in known:
            yield file.complaint(
                ("chain", channel, "supply_channel"), f"no channel {chain.supply_channel!r} (allowed: {allowed})"
            )


def _of_sensors(rig: RigDescription) -> frozenset[str]:
    """Return the channels of all sensors: outputs and thermometers."""
    outputs = (channel for sensor in rig.sensors.values() for channel in sensor.channels.values())
    thermometers = (sensor.temperature.channel for sensor in rig.sensors.values() if sensor.temperature)
    return frozenset((*outputs, *thermometers))


def _chain_of_no_output(file: TomlFile, rig: RigDescription, channel: str) -> Iterable[str]:
    """Yield keys that mean nothing where no sensor is read: a supply has to warm up, no more."""
    is_supply = any(chain.supply_channel == channel for chain in rig.chain.values())
    meaningless = sorted(key for key in rig.chain[channel].model_fields_set if not (is_supply and key in WARM_UP_KEYS))
    if not is_supply or meaningless:
        yield file.complaint(
            ("chain", channel, *meaningless[:1]),
            f"{channel} is no output of a sensor, so this would change nothing (sensors' channels: "
            f"{', '.join(sorted(_of_sensors(rig)))}); a chain belongs to the channel of the sensor, and names its "
            f'supply there: supply_channel = "{channel}"',
        )


def _supplies_nobody_has(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield truths of supplies that no chain names and no interlock watches: the twin would read them nowhere."""
    known = {chain.supply_channel for chain in rig.chain.values() if chain.supply_channel} | set(rig.interlocks.voltage)
    for channel in rig.twin.supplies if rig.twin else ():
        if channel not in known:
            allowed = ", ".join(sorted(known)) or "none"
            yield file.complaint(
                ("twin", "supplies", channel),
                f"no supply_channel of a [chain] and no [interlocks.voltage] has it (allowed: {allowed})",
            )


def _names_twice(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    for name in set(rig.readouts) & set(rig.streams):
        yield file.complaint(
            ("streams", name), f"a readout is called {name!r} as well; its channels would be ambiguous"
        )


def _nobody_to_go_with(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield declarations that several devices may act at once where at most one of the rig can."""
    for table, wanted, able, what, example in (
        ("motion", rig.motion.together, rig.moving_together(), "axes that move beside others", "no manual axis"),
        ("reading", rig.reading.together, rig.reading_together(), "readouts that read beside others", "a second meter"),
    ):
        if wanted and len(able) < 2:
            yield file.complaint(
                (table, "together"),
                f"true, but it needs at least two {what}, such as {example}; the rig has "
                f"{', '.join(able) or 'none'}; remove it",
            )


def _undeclared_sensitivities(file: TomlFile, rig: RigDescription, voltages: set[str]) -> Iterable[str]:
    """Yield sensors without a declared polarity: that of an accelerometer read in volts is never guessed."""
    for serial, sensor in rig.sensors.items():
        read_in_volts = voltages & set(sensor.channels.values())
        undeclared = [axis for axis in sensor.channels if sensor.nominal_v_per_g(axis) == 0.0]
        if sensor.measures == "acceleration" and read_in_volts and undeclared:
            yield file.complaint(
                ("sensors", serial, "nominal_sensitivity_v_per_g"),
                f"nominal_sensitivity_v_per_g must not be 0 (axis {', '.join(undeclared)}); its sign declares the "
                "polarity",
            )


def _volts_of_other_units(file: TomlFile, rig: RigDescription, units: Mapping[str, str]) -> Iterable[str]:
    """Yield what is declared in volts of sensors that are not read in volts."""
    for serial, sensor in rig.sensors.items():
        others = [channel for channel in sensor.channels.values() if units.get(channel, "v") != "v"]
        limits = ("largest_offset_shift_v", "largest_nonlinearity_v", "largest_offset_tc_v_per_degc")
        for key in (*limits, sensor.nominal_key):
            if getattr(sensor, key) != 0.0 and others:
                yield file.complaint(
                    ("sensors", serial, key), f"is in volts, and {', '.join(others)} is not read in volts; remove it"
                )


def _unusable_reference(file: TomlFile, rig: RigDescription, units: Mapping[str, str]) -> Iterable[str]:
    reference = rig.attitude_reference
    angles = sorted(channel for channel, unit in units.items() if unit == "deg")
    about = {
        f"{name}.{channel}": axis
        for name, readout in rig.readouts.items()
        for channel, axis in readout.attitude_axes().items()
    }
    for axis, channel in reference.channels.items() if reference else ():
        key = ("attitude_reference", "channels", axis)
        if axis not in rig.axes:
            yield file.complaint(key, f"the rig has no axis {axis!r} (it has: {', '.join(rig.axes)})")
        if channel not in angles:
            yield file.complaint(key, f"no channel {channel!r} in degrees (allowed: {', '.join(angles) or 'none'})")
        elif about.get(channel, axis) != axis:
            yield file.complaint(
                key, f"{channel} tells {about[channel]} (its key about), not {axis}; correct one of the two"
            )


def _ranges_too_small(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield ranges that one g does not fit into; a range never changes inside a run."""
    for serial, sensor in rig.sensors.items():
        for axis, channel in sensor.channels.items():
            readout, _, name = channel.partition(".")
            settings = rig.readouts.get(readout)
            is_known = settings is not None and name in settings.channel_names()  # it is told where it is not
            range_v = settings.range_of_channel_v(name) if settings is not None and is_known else None
            if range_v is not None and OVER_RANGE * range_v < abs(sensor.nominal_v_per_g(axis)):
                yield file.complaint(
                    ("readouts", readout, "channels", name, "range_v"),
                    f"got {range_v:g} V, but {serial}.{axis} is declared to make "
                    f"{abs(sensor.nominal_v_per_g(axis)):g} V at one g; choose a larger range",
                )


def _unknown_interlocks(file: TomlFile, rig: RigDescription, channels: set[str]) -> Iterable[str]:
    for kind, watched, known in (
        ("temperature", rig.interlocks.temperature, set(rig.environment)),
        ("voltage", rig.interlocks.voltage, channels),
    ):
        for name in watched:
            if name not in known:
                allowed = ", ".join(sorted(known)) or "none"
                yield file.complaint(("interlocks", kind, name), f"nothing of that name (allowed: {allowed})")


def _supplies_outside_interlocks(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield interlocks that would stop every run: what a chain states of the supply lies outside their band."""
    for name, lock in rig.interlocks.voltage.items():
        low_v, high_v = lock.band_v
        for channel, chain in rig.chain.items():
            stated = chain.supply_band_v if chain.supply_nominal_v is None else (chain.supply_nominal_v,) * 2
            if chain.supply_channel != name or stated is None or (stated[0] <= high_v and low_v <= stated[1]):
                continue
            key = "supply_band_v" if chain.supply_nominal_v is None else "supply_nominal_v"
            volts = " to ".join(f"{value:g}" for value in dict.fromkeys(stated))
            yield file.complaint(
                ("interlocks", "voltage", name, "band_v"),
                f"{low_v:g} to {high_v:g} V leaves out {volts} V, which [chain.{channel}] {key} states for it: every "
                f"run would {lock.action} at once; give a band around it, or correct {key}",
            )
            break


def _rejections_never_counted(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield an interlock that could never fire. Of files only: journals hold rigs from before it was refused."""
    rejected = rig.interlocks.rejected
    if rejected is not None and rejected.most >= rejected.within:
        yield file.complaint(
            ("interlocks", "rejected", "most"),
            f"got most = {rejected.most} of within = {rejected.within} dwells, allowed is most below within: of so few "
            "never more are rejected, and the interlock would never fire; correct one of them",
        )


def _unknown_standards(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    tables: list[tuple[tuple[str, ...], str | None]] = [
        *((("axes", name), axis.standard) for name, axis in rig.axes.items()),
        *((("readouts", name), readout.standard) for name, readout in rig.readouts.items()),
        *((("environment", name), chamber.standard) for name, chamber in rig.environment.items()),
        *((("chain", name), chain.standard) for name, chain in rig.chain.items()),
        *((("streams", name), stream.standard) for name, stream in rig.streams.items()),
        *((("field", name), coil.standard) for name, coil in rig.field.items()),
        (("attitude_reference",), rig.attitude_reference.standard if rig.attitude_reference else None),
        (("level",), rig.level.standard),
    ]
    for key, standard in tables:
        if standard is not None and standard not in rig.standards:
            known = ", ".join(rig.standards) or "none is declared"
            yield file.complaint((*key, "standard"), f"no standard {standard!r} (allowed: {known})")


def _axis_twice(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield axes of one controller with the same number; two twins without numbers are two controllers."""
    taken: dict[tuple[str, str, tuple[int, ...]], str] = {}
    for name, axis in rig.axes.items():
        address = (axis.driver, axis.port, axis.line_address)
        if axis.port != TWIN_PORT and address in taken:
            number = ", ".join(map(str, axis.line_address))
            yield file.complaint(("axes", name, "axis"), f"axis {number} at {axis.port} is already {taken[address]}")
        taken[address] = name
    named: dict[tuple[str, str, str], str] = {}
    for name, axis in rig.axes.items():
        axis_id = getattr(axis, "axis_id", None)
        if axis_id is None or axis.port == TWIN_PORT:
            continue
        if (other := named.setdefault((axis.driver, axis.port, axis_id), name)) != name:
            yield file.complaint(
                ("axes", name, "axis_id"), f"axis {axis_id!r} at {axis.port} is already {other}; give each its own"
            )


ADDRESS_PARTS = ("unit", "address", "loop", "channel")
"""Keys that tell several devices of one line apart."""


def _instrument_twice(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield instruments that are another one of the file: what sets the one sets the other behind its back."""
    tables: tuple[tuple[str, str, Mapping[str, object]], ...] = (
        ("readouts", "resource", rig.readouts),
        ("environment", "port", rig.environment),
        ("streams", "port", rig.streams),
    )
    taken: dict[tuple[object, ...], str] = {}
    for table, key, devices in tables:
        for name, device in devices.items():
            where = getattr(device, key, None)
            if where in (None, TWIN_PORT):
                continue
            address = tuple(getattr(device, part, None) for part in ADDRESS_PARTS)
            if (other := taken.setdefault((where, *address), f"{table}.{name}")) != f"{table}.{name}":
                yield file.complaint(
                    (table, name, key),
                    f"{where} is already {other}; two devices need two addresses: correct one, or leave it out",
                )


def _cables_that_never_wind(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield cables of axes that never wind them up. Of files only: journals hold rigs from before it was refused."""
    for name, axis in rig.axes.items():
        if axis.wrap_turns is not None and axis.turning != "revolves":
            remedy = "give top_rate_dps, or remove it" if hasattr(axis, "top_rate_dps") else "remove it"
            yield file.complaint(
                ("axes", name, "wrap_turns"), f"the axis does not turn on and on, no cable of it winds up; {remedy}"
            )


def _missing_truth(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    if rig.twin is None:
        yield file.complaint((), 'a port says "twin", so a [twin] table with [twin.truth.SENSOR.AXIS] is needed')
        return
    for serial, sensor in rig.sensors.items():
        for axis in sensor.channels:
            if axis not in rig.twin.truth.get(serial, {}):
                yield file.complaint(
                    ("twin",),
                    f"[twin.truth.{serial}.{axis}] is missing; the twin needs the sensor's truth, such as "
                    "{ offset_v = 0.0, sensitivity_v_per_g = 2.5 } (docs/files.md); --rehearse does without",
                )
    for serial in rig.twin.truth:
        if serial not in rig.sensors:
            yield file.complaint(("twin", "truth", serial), f"no sensor {serial!r} (allowed: {', '.join(rig.sensors)})")


def _unusable_dialects(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield dialects that cannot be used, read before any port is opened."""
    for name, axis in rig.axes.items():
        for key, sentence in axis.file_complaints(file.path.parent):
            yield file.complaint(("axes", name, *key), sentence)
    for name, readout in rig.readouts.items():
        for key, sentence in readout.file_complaints(file.path.parent):
            yield file.complaint(("readouts", name, *key), sentence)


def _unusable_resources(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    for name, readout in rig.readouts.items():
        for key in ("resource", "scanner_resource"):
            resource = getattr(readout, key, None)
            if resource is None:
                continue
            has_scanner = "scanner_resource" in type(readout).model_fields  # such a meter is on a bus
            try:
                parse_resource(resource, 0) if has_scanner else port_of(resource)
            except RequestRefused as error:
                yield file.complaint(("readouts", name, key), str(error))
