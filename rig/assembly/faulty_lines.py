"""The twins' lines of a rig with the faults of a plan on them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from zlib import crc32

import numpy as np

from rig.description.fault_plan import FaultPlan
from rig.description.rig_file import RigDescription
from rig.drivers.twin_lines import TwinLine
from rig.twins.physics.world import World
from rig.twins.serving.faulty import FaultyTwin


def drivers_of(description: RigDescription) -> dict[str, str]:
    """Return the driver of every table of the rig file that has a line (``axes.pitch``)."""
    return (
        {f"axes.{name}": axis.driver for name, axis in description.axes.items()}
        | {f"readouts.{name}": readout.driver for name, readout in description.readouts.items()}
        | {f"environment.{name}": chamber.driver for name, chamber in description.environment.items()}
        | {f"streams.{name}": stream.driver for name, stream in description.streams.items()}
    )


def with_faults(
    lines: Sequence[TwinLine], plan: FaultPlan, world: World, starts_s: float, tell: Callable[[str], None]
) -> list[TwinLine]:
    """Return the same lines, each with its share of the plan.

    ``starts_s``: rig seconds from which ``at_s`` counts.
    """
    by_key: dict[str, FaultyTwin] = {}
    faulty = []
    for line in lines:
        chance = np.random.default_rng([plan.seed, crc32(line.keys[0].encode())])
        rules = plan.of_line(line.keys)
        twin = FaultyTwin(line.twin, line.keys, rules, chance, world, starts_s, by_key.__getitem__, tell)
        by_key |= dict.fromkeys(line.keys, twin)
        faulty.append(replace(line, twin=twin))
    return faulty
