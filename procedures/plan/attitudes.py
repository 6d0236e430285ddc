"""Designs and steps of a package that rests at attitudes.

Steps in their order: for each plateau its soak; before the first design dwell the check set; then the replications,
each in the order asked for, with a return to the reference attitudes after every so many design dwells.
"""

from collections.abc import Iterator, Sequence
from itertools import count

import numpy as np

from ams.models.registry import knows_roll
from procedures.description.procedure_file import EnvironmentPlan, ProcedureDescription
from procedures.errors import PlanError
from procedures.plan.design_kind import DESIGNS, Wanted
from procedures.plan.designs import Design, DesignPoint
from procedures.plan.order import DRAWN_ANEW, SHUFFLED, sequence
from procedures.plan.specific_force import package_specific_force
from procedures.plan.steps import Dwell, Purpose, Soak, Step
from rig.description.rig_file import RigDescription

CHECK_ATTITUDES = 6


def make_design(procedure: ProcedureDescription) -> Design:
    """Make the design that a procedure file asks for. Raises: PlanError naming file, line and key."""
    kind = DESIGNS[procedure.design.kind]
    for key in ("pitch_deg", "roll_deg", "yaw_deg"):
        if key not in kind.takes and getattr(procedure.design, key) is not None:
            raise procedure.error(("design", key), f'kind = "{kind.name}" has attitudes of its own; remove it')
    try:
        return kind.made(Wanted(procedure.design, knows_roll(procedure.solve.model), procedure.path.parent))
    except PlanError as error:
        raise procedure.error(("design", "kind"), str(error)) from None


def environment_of(rig: RigDescription, procedure: ProcedureDescription) -> EnvironmentPlan | None:
    """Return the plateaus with the name of the environment that holds them, or None."""
    if procedure.environment is None:
        return None
    known = ", ".join(rig.environment) or "none"
    name = procedure.environment.name or (next(iter(rig.environment)) if len(rig.environment) == 1 else None)
    if name is None:
        raise procedure.error(
            ("environment",), f"plateaus need one environment of the rig, which has: {known}; give name"
        )
    if name not in rig.environment:
        raise procedure.error(("environment", "name"), f"got {name!r}, the rig has: {known}")
    return procedure.environment.model_copy(update={"name": name})


def plateaus_of(environment: EnvironmentPlan | None) -> Sequence[float | None]:
    return (None,) if environment is None else environment.plateaus_degc


def seed_of(procedure: ProcedureDescription, fresh_seed: int | None) -> int | None:
    if procedure.design.order not in SHUFFLED:
        return None
    if procedure.design.order not in DRAWN_ANEW:
        return procedure.design.seed
    return int(np.random.SeedSequence().generate_state(1)[0]) if fresh_seed is None else fresh_seed


def steps_at_attitudes(
    procedure: ProcedureDescription,
    design: Design,
    axes: Sequence[str],
    environment: EnvironmentPlan | None,
    seed: int | None,
) -> Iterator[Step]:
    numbers = count()
    replications = procedure.replications
    for plateau, setpoint_degc in enumerate(plateaus_of(environment)):
        if environment is not None and setpoint_degc is not None:
            assert environment.name is not None
            yield Soak(
                next(numbers), plateau, environment.name, setpoint_degc, environment.band_degc, environment.soak_s
            )
        if plateau == 0:
            for point in check_points(design):
                yield _dwell(next(numbers), "check", 0, 0, axes, point)
        for replication in range(plateau * replications + 1, (plateau + 1) * replications + 1):
            yield from _replication(procedure, design, axes, replication, seed, numbers)


def _replication(
    procedure: ProcedureDescription,
    design: Design,
    axes: Sequence[str],
    replication: int,
    seed: int | None,
    numbers: "count[int]",
) -> Iterator[Dwell]:
    order, check = procedure.design.order, procedure.check
    chance = None if seed is None else np.random.default_rng([seed, replication])
    points = sequence(design, order, chance)
    for index, point in enumerate(points, start=(replication - 1) * len(points) + 1):
        yield _dwell(next(numbers), "design", replication, point.label, axes, point)
        if check is not None and index % check.reference_every == 0:
            for pitch_deg, roll_deg in check.attitudes_deg:
                at = DesignPoint(0, pitch_deg, roll_deg)
                yield _dwell(next(numbers), "reference", replication, 0, axes, at)


def check_points(design: Design) -> tuple[DesignPoint, ...]:
    """Up to six attitudes of the design as different as they can be: first the one nearest to level, then always the
    one whose specific force lies farthest from those chosen. On a full circle of roll this is the six-point tumble.
    """
    points = sorted(design.points, key=lambda point: (_turned_deg(point), point.label))
    force = package_specific_force(points)
    chosen = [0]
    while len(chosen) < CHECK_ATTITUDES:
        apart = np.linalg.norm(force[:, None, :] - force[chosen], axis=2).min(axis=1).round(9)
        if apart.max() == 0.0:
            break
        chosen.append(int(apart.argmax()))
    return tuple(points[index] for index in chosen)


def _turned_deg(point: DesignPoint) -> float:
    return abs(point.pitch_deg) + abs(point.yaw_deg) + abs(point.roll_deg)


def _dwell(
    step: int,
    purpose: Purpose,
    replication: int,
    point: int,
    axes: Sequence[str],
    attitude: DesignPoint,
) -> Dwell:
    angles = {"pitch": attitude.pitch_deg, "yaw": attitude.yaw_deg, "roll": attitude.roll_deg}
    return Dwell(step, purpose, replication, point, {name: angles[name] for name in axes})
