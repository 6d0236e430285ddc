"""Attitudes of a plan where an axis cannot go, of whatever kind the plan is.

Every attitude that a step goes to passes the check that the driver makes before it moves, the one-sided approach
included, and is refused by file, line and key with the nearest angle that would do.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.plan.steps import Dwell, Step
from rig.abilities.targets import BrokenRule, Miswritten, Rule, broken_rules, is_on_increment, nearest_targets_deg
from rig.description.device_settings import AxisSettings
from rig.description.rig_file import RigDescription

Key = Sequence[object]
KeyOfAxis = Callable[[str], Key]
Targets = Mapping[str, float]
"""What is asked for, in words, to the angle."""


def unreachable(
    rig: RigDescription, procedure: ProcedureDescription, steps: Iterable[Step], key_of: KeyOfAxis
) -> Iterator[PlanError]:
    """Tell one reason an axis and rule, naming the worst point. ``key_of``: the key that asks for an axis' angles."""
    dwells = sorted((step for step in steps if isinstance(step, Dwell)), key=lambda dwell: dwell.point)
    reference = [dwell for dwell in dwells if dwell.purpose == "reference"]
    for axis, settings in rig.axes.items():
        yield from _of_axis(procedure, key_of(axis), axis, settings, _targets(dwells, axis))
        # The reference attitudes are asked for at a key of their own.
        wanted_deg = dict.fromkeys(dwell.targets_deg[axis] for dwell in reference if axis in dwell.targets_deg)
        several = len(wanted_deg) > 1
        named = {f"the reference attitude{f' at {angle:g}°' if several else ''}": angle for angle in wanted_deg}
        yield from _of_axis(procedure, ("check", f"{axis}_deg"), axis, settings, named)


def _targets(dwells: Iterable[Dwell], axis: str) -> dict[str, float]:
    """Return design points by their label, and what else the check set visits."""
    targets: dict[str, float] = {}
    others: dict[str, float] = {}
    for dwell in dwells:
        if axis not in dwell.targets_deg:
            continue
        if dwell.purpose == "design":
            targets[f"point {dwell.point}"] = dwell.targets_deg[axis]
        elif dwell.purpose == "check":
            others["the check attitude"] = dwell.targets_deg[axis]
    return targets | {name: angle for name, angle in others.items() if angle not in targets.values()}


def _of_axis(
    procedure: ProcedureDescription, key: Key, axis: str, settings: AxisSettings, targets: Targets
) -> Iterator[PlanError]:
    if not targets:
        return
    if not is_on_increment(settings.approach_deg, settings.increment_deg):
        yield procedure.error(
            key,
            f"the one-sided approach of {settings.approach_deg:g}° (axes.{axis}.approach_deg) is no multiple of the "
            f"table's {settings.increment_deg:g}°; nothing moved; correct the rig file",
        )
    miswritten = settings.miswritten()
    broken = {
        name: {item.rule: item for item in _broken(settings, angle, miswritten)} for name, angle in targets.items()
    }
    yield from _beyond_limits(procedure, key, axis, settings, targets, _those(broken, "limits_deg"))
    yield from _off_increment(procedure, key, axis, settings, targets, _those(broken, "increment_deg"))
    yield from _miswritten(procedure, key, axis, targets, _those(broken, "written"))


def _broken(settings: AxisSettings, target_deg: float, miswritten: Miswritten) -> Iterator[BrokenRule]:
    table_deg = settings.table_deg(target_deg)
    return broken_rules(
        target_deg, table_deg, settings.limits_deg, settings.increment_deg, settings.approach_deg, miswritten
    )


def _those(broken: Mapping[str, Mapping[Rule, BrokenRule]], rule: Rule) -> dict[str, BrokenRule]:
    return {name: items[rule] for name, items in broken.items() if rule in items}


def _beyond_limits(
    procedure: ProcedureDescription,
    key: Key,
    axis: str,
    settings: AxisSettings,
    targets: Targets,
    broken: Mapping[str, BrokenRule],
) -> Iterator[PlanError]:
    if not broken:
        return
    name = max(broken, key=lambda each: broken[each].excess_deg)
    low, high = settings.limits_deg
    approach = f" with its approach of {settings.approach_deg:g}°" if settings.approach_deg else ""
    yield procedure.error(
        key,
        f"{name} asks for {axis} {targets[name]:g}°, allowed {low:g} to {high:g}° (axes.{axis}.limits_deg), "
        f"{broken[name].excess_deg:g}° too far{approach}, nearest {_nearest(settings, targets[name])}; nothing moved; "
        "ask for less, or widen the limits",
    )


def _off_increment(
    procedure: ProcedureDescription,
    key: Key,
    axis: str,
    settings: AxisSettings,
    targets: Targets,
    broken: Mapping[str, BrokenRule],
) -> Iterator[PlanError]:
    if not broken:
        return
    name = next(iter(broken))
    yield procedure.error(
        key,
        f"{name} asks for {axis} {targets[name]:g}°, the table stops only at multiples of {settings.increment_deg:g}° "
        f"(axes.{axis}.increment_deg), nearest {_nearest(settings, targets[name])} ({len(broken)} of {len(targets)} "
        "points are off); nothing moved; choose other steps",
    )


def _miswritten(
    procedure: ProcedureDescription, key: Key, axis: str, targets: Targets, broken: Mapping[str, BrokenRule]
) -> Iterator[PlanError]:
    if not broken:
        return
    name = next(iter(broken))
    yield procedure.error(
        key,
        f"{name} asks for {axis} {targets[name]:g}°: {broken[name].why} (axes.{axis}.dialect; {len(broken)} of "
        f"{len(targets)} points cannot be told); nothing moved; choose other angles, or another zero_deg of the axis",
    )


def _nearest(settings: AxisSettings, target_deg: float) -> str:
    return " and ".join(f"{angle:g}°" for angle in nearest_targets_deg(settings, target_deg)) or "none"
