"""A common-mode judgement as findings: which sensors, how much, about what, and whose doing it is."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from ams.findings import ALL_AFTER, ON_ONE_SIDE, Finding, turned_the_table
from ams.rounding import significant
from ams.surveillance.common_mode import CommonMode, SensorChange
from ams.surveillance.common_mode_causes import LIKE_AXES, ROTATION, Cause
from ams.surveillance.common_mode_columns import Estimate
from ams.surveillance.turns import BASE, FIXTURE, FIXTURE_X, FIXTURE_Y, FIXTURE_Z, PITCH, ROLL, ROTATIONS, YAW
from ams.units import in_arcsec, in_words, signed, signed_in_words

NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
_TEMPERATURE = "temperature"
_SHARED = {
    "table-rotation": "a rotation of the table",
    "meter-gain": "the meter's gain",
    "meter-offset": "the meter's offset",
}
_PLAIN = 3.0
"""In standard uncertainties."""
_ABOUT = {
    ROLL: "about roll",
    PITCH: "about pitch",
    YAW: "about yaw",
    FIXTURE_X: "about its forward axis",
    FIXTURE_Y: "about its lateral axis",
    FIXTURE_Z: "about its normal",
}


_SEVERAL_OUTPUTS = (
    "several outputs changed at that moment, each by an amount of its own: the sensor, or what they share (the meter, "
    "a supply) and one of them beside it"
)


def findings_of(
    found: CommonMode,
    sensors: Sequence[str],
    between: str,
    unit: str = "v",
    steps: Sequence[int] = (),
    *,
    is_shared: bool = False,
) -> tuple[Finding, ...]:
    """Return a finding for every significant cause.

    ``sensors``: all that were looked at. ``between``: which visits, such as ``between visits 2 and 3``. ``unit``: of
    the readings. ``steps``: the dwells in doubt. ``is_shared``: whether other sensors are known to have turned as well.
    """
    common = _common(found, sensors, between, unit, tuple(steps), is_shared=is_shared)
    return (*common, *_sensor_changes(found, between, tuple(steps)))


def _common(
    found: CommonMode, sensors: Sequence[str], between: str, unit: str, steps: tuple[int, ...], *, is_shared: bool
) -> Iterator[Finding]:
    who = found.seen_by or who_agree(found.agreeing, sensors)
    for cause in found.stated:
        text = f"{who} {_what(found, cause, between, unit)}: {_whose(found, cause, is_shared=is_shared)}"
        yield Finding(cause.kind, text, True, found.p_value, steps, _details(found, cause))


def _sensor_changes(found: CommonMode, between: str, steps: tuple[int, ...]) -> Iterator[Finding]:
    for odd in found.sensor_changes:
        others = [name for name in found.agreeing if name != odd.sensor]
        rest = f"the other {_number(len(others))} agree" if len(others) > 1 else f"{others[0]} did not"
        size = f"{_arcsec(odd.largest_rad)} at most, on {odd.axis}"
        change = f"changed by itself {between} ({size}) while {rest}"
        turned = f"turned by itself by {_arcsec(odd.attribution.turned_rad)} {between} ({size}) while {rest}"
        text = {
            "mount": f"{odd.sensor} {turned}: its mount is loose, not the sensor, table or meter",
            "sensor": f"{odd.sensor} {change}: the sensor, not table or meter, and no turn of its mount explains it",
            "either": f"{odd.sensor} {change}: the sensor, not table or meter; a loose mount would look the same here",
        }[odd.attribution.culprit]
        text = _doubted(odd, f"{odd.sensor} changed by itself {between} ({size})") if odd.also else text
        details: dict[str, float | str | None] = {
            "sensor": odd.sensor,
            "largest_arcsec": in_arcsec(odd.largest_rad),
            "culprit": odd.attribution.culprit,
            "turned_arcsec": None if odd.attribution.culprit == "sensor" else in_arcsec(odd.attribution.turned_rad),
        }
        if odd.also:
            details["confounded_with"] = ", ".join(dict.fromkeys(str(cause.kind) for cause in odd.also))
        yield Finding("sensor-change", text, True, odd.p_value, steps, details)


def _doubted(odd: SensorChange, change: str) -> str:
    """Say what would look the same as a change that one axis alone shows."""
    kinds = {cause.kind for cause in odd.also}
    same = [words for kind, words in _SHARED.items() if kind in kinds]
    mount = "" if odd.attribution.culprit == "sensor" else " on its mount or in itself"
    return f"{change}, and no other axis shows it: the sensor{mount}; {' or '.join(same)} would look the same here"


def who_agree(agreeing: Sequence[str], sensors: Sequence[str]) -> str:
    """Return how many of the sensors did alike."""
    if len(sensors) == 1:
        return sensors[0]
    if len(agreeing) == len(sensors):
        return "both sensors" if len(sensors) == 2 else f"all {_number(len(sensors))} sensors"
    return f"{_number(len(agreeing))} of {_number(len(sensors))} sensors"


def _what(found: CommonMode, cause: Cause, between: str, unit: str) -> str:
    sizes = {name: found.estimates[name] for name in cause.parts if name in found.estimates}
    if cause.kind == "table-rotation":
        verb = "tilted" if cause.parts == (BASE,) else "turned"
        return f"{verb} by {turn_in_words(found, cause)} {between}"
    if cause.name.endswith(LIKE_AXES):
        return f"changed {between}, all axes of one name alike, as offset or sensitivity and as no rotation alone would"
    size = next(iter(sizes.values()), None)
    if cause.kind == "meter-gain" and size is not None:
        u_ppm = significant(1e6 * size.standard_uncertainty)
        return f"read {signed(1e6 * size.value, 3)} ppm (u {u_ppm} ppm) more {between}"
    if cause.kind == "meter-offset" and size is not None:
        u = in_words(size.standard_uncertainty, unit)
        return f"read {signed_in_words(size.value, unit, 3)} (u {u}) more {between}"
    if cause.parts:
        return f"changed {between}: {cause.name}"
    return f"changed {between}, as neither a rotation nor gain or offset of the meter would"


def turn_in_words(found: CommonMode, cause: Cause) -> str:
    """Return how far the table turned and about what."""
    sizes = {name: found.estimates[name] for name in cause.parts if name in found.estimates}
    if cause.name == ROTATION:
        return f"up to {significant(abs(in_arcsec(found.rotation_rad)), 3)}″"
    if cause.parts == (BASE,):
        return f"{_angle(sizes[BASE])} about the base's forward axis"
    plain = _plain(sizes) if cause.name == FIXTURE else sizes
    turns = [f"{_angle(sizes[name])} {_ABOUT.get(name, 'with the base')}" for name in ROTATIONS if name in plain]
    return ", ".join(turns)


def _plain(sizes: Mapping[str, Estimate]) -> set[str]:
    """Return about what a turn is told from none, and what it is largest about: the other angles are in the details."""
    plain = {name for name, size in sizes.items() if abs(size.value) > _PLAIN * size.standard_uncertainty}
    return plain | {max(sizes, key=lambda name: abs(sizes[name].value))}


def _whose(found: CommonMode, cause: Cause, *, is_shared: bool) -> str:
    """Say whose doing it is, and what else would look the same."""
    other = {
        _TEMPERATURE if other_cause.name.endswith(LIKE_AXES) else str(other_cause.kind) for other_cause in found.also
    } - {str(cause.kind)}
    lone = found.seen_by or (found.agreeing[0] if len(found.agreeing) == 1 else "")
    if cause.kind == "table-rotation":
        is_alone = bool(lone) and not is_shared
        whose = "the table, its base or the common fixture" + ("" if is_alone else ", not the sensors")
        if is_alone and cause.name == FIXTURE:
            whose = f"{lone} on its mount, or the fixture: no slip of the table and no tilt of its base alone does that"
        elif is_alone and _may_be_on_mount(found, cause):
            other = other | {"sensor on its mount"}
    elif cause.kind == "sensor-change":
        outputs = {part.rpartition(" ")[2] for part in cause.parts}
        whose = "the sensor" if len(outputs) < 2 else _SEVERAL_OUTPUTS
    elif cause.name.endswith(LIKE_AXES):
        whose, other = "what all sensors share (temperature, supply)", other - {_TEMPERATURE}
    else:
        whose = f"the meter ({cause.name}), or what all sensors share (supply, temperature)"
        other = (other - {_TEMPERATURE}) | ({"sensor-change"} if lone else set())
    words = {
        **_SHARED,
        "sensor-change": f"a change of {lone} itself",
        _TEMPERATURE: "what a temperature does to sensors of one make",
        "sensor on its mount": f"{lone} on its mount",
    }
    same = [text for name, text in words.items() if name in other]
    return f"{whose}; {' or '.join(same)} would look the same here" if same else whose


def _may_be_on_mount(found: CommonMode, cause: Cause) -> bool:
    """Return whether a package that turned on its mount looks the same: about the axis that carries it, as a slip."""
    return found.carried_by in cause.parts or any(other.name == FIXTURE for other in found.also)


def _details(found: CommonMode, cause: Cause) -> dict[str, float | str | None]:
    same = ", ".join(dict.fromkeys(other_cause.kind for other_cause in found.also if other_cause.kind != cause.kind))
    details: dict[str, float | str | None] = {"cause": cause.name, "confounded_with": same or None}
    if found.seen_by and cause.kind == "sensor-change":
        details["sensor"] = found.seen_by
    if cause.kind == "table-rotation":
        details["turned_arcsec"] = in_arcsec(found.rotation_rad)
    for name in cause.parts:
        if name not in found.estimates:
            continue
        estimate, key = found.estimates[name], name.replace(" ", "_")
        if name in ROTATIONS:
            details[f"{key}_arcsec"] = in_arcsec(estimate.value)
            details[f"{key}_standard_uncertainty_arcsec"] = in_arcsec(estimate.standard_uncertainty)
        else:
            details[key], details[f"{key}_standard_uncertainty"] = estimate.value, estimate.standard_uncertainty
    return details


def _angle(estimate: Estimate) -> str:
    return f"{_arcsec(estimate.value)} (u {significant(in_arcsec(estimate.standard_uncertainty))}″)"


def _arcsec(angle_rad: float) -> str:
    size = in_arcsec(angle_rad)
    return f"{signed(round(size), 9) if abs(size) >= 100.0 else signed(size, 3)}″"


def _number(count: int) -> str:
    return NUMBERS[count] if count < len(NUMBERS) else str(count)


def on_one_side(finding: Finding) -> Finding:
    """Return a turn of the table as what no result rests on: all dwells that count stand after it, or before it."""
    if finding.kind != "table-rotation":
        return finding
    untied = finding.adding("all dwells that count stand on one side of it", "prove the level and the zero of the axes")
    return replace(untied, details={**finding.details, ON_ONE_SIDE: 1.0})


def all_after(finding: Finding) -> Finding:
    """Return a turn of the table that all dwells that count stand after as one that parts them from the declared zero.

    A turn too small to stop a run, or that may be something else, is what :func:`on_one_side` makes of it.
    """
    if not turned_the_table([finding]):
        return on_one_side(finding)
    parted = finding.adding(
        "all dwells that count stand after it, by as much off the zero of the axes and the level that the rig file "
        "declares, and no stated uncertainty holds that",
        "set the zero and read the level anew and calibrate again from the start, in a new run, or have the set "
        "released from quarantine by name and reason",
    )
    return replace(parted, details={**finding.details, ALL_AFTER: 1.0})


def still_in_doubt(finding: Finding, steps: tuple[int, ...]) -> Finding:
    """Return what a visit showed that was taken back since, with the steps in doubt whose dwells still count."""
    counting = (
        f"the dwell in doubt of step {steps[0]} still counts"
        if len(steps) == 1
        else f"{len(steps)} dwells in doubt, of steps {steps[0]} to {steps[-1]}, still count"
    )
    doubted = finding.adding(
        f"the visit that showed it was taken back, and {counting}",
        f"take {'it' if len(steps) == 1 else 'them'} back as well",
    )
    return replace(doubted, steps=steps)
