"""Campaigns of several mountings, which know nothing of calrig, as the joint fit takes them."""

import numpy as np
from physics_scenes.mounting_scenes import Remounted

from ams.observations import Observations
from ams.solve.table_errors import Mounting


def mountings_of(drawn: Remounted, campaign: int) -> list[Mounting]:
    """One campaign as the joint fit takes it; replications are numbered on."""
    found, first = [], 0
    for mounted in drawn.mountings:
        output_v = mounted.output_v[campaign]
        n, points, _ = output_v.shape
        rows = Observations(
            replication=first + np.repeat(np.arange(1, n + 1), points),
            point=np.tile(np.arange(points), n),
            pitch_rad=np.tile(np.deg2rad(mounted.pitch_deg), n),
            roll_rad=np.tile(np.deg2rad(mounted.roll_deg), n),
            outputs={axis: output_v[..., index].ravel() for index, axis in enumerate("xyz")},
        )
        found.append(Mounting(rows, tuple(map(tuple, mounted.package_from_table))))
        first += n
    return found
