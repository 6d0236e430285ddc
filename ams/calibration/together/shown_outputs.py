"""What an output leaves of the means of its points beside all that it may show by itself, over its own sensitivity.

Outputs of a package are asked together for what the whole of it shares; each counts by what it scatters by itself.
"""

from typing import Final, Generic, NamedTuple, TypeVar

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.sensed_force import Accelerometer, along_force, attitude_of_points, is_rolled
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import FloatArray
from ams.frames import Attitude
from ams.models.pitch_yaw_roll import PitchYawRoll
from ams.solve.extension import blocks_of_angles

LEAST_DOF: Final = 30
"""Of fewer the weights of the outputs are too little known: of 13 a level of 5 % rings in 12 %."""
MAY_SHOW: Final = 4.0
"""Times the level: by nominal axes and equal weights it is seen a little less, or a little more."""
OutputSeen = tuple[Evidence, int]
"""What the tests look at, and which output of it."""
Design = TypeVar("Design")


class ShownOutput(NamedTuple, Generic[Design]):
    """Of one output."""

    axis: str
    design: Design
    """What it is asked for, beside what it may show by itself."""
    k: FloatArray
    """(3,) per g."""
    left: FloatArray
    """(K,) of its means, over its sensitivity."""
    dof: float

    @property
    def per_g(self) -> float:
        """Its sensitivity."""
        return float(np.linalg.norm(self.k))

    @property
    def variance(self) -> float:
        """Of a mean."""
        return float(self.left @ self.left) / self.dof


def rolled_base(evidence: Evidence, output: int) -> Accelerometer | None:
    """Return the model of an output that tells of what turns with roll; None of one that tells nothing."""
    base = accelerometer_base(evidence.models[output])
    if base is None or not is_rolled(base) or not evidence.precision_variance[output] > 0.0:
        return None
    return base


def attitude_where_read(evidence: Evidence, base: Accelerometer) -> Attitude:
    """Return where the points were read: without yaw points of the same angles are one block."""
    alike = None if isinstance(base, PitchYawRoll) else blocks_of_angles(evidence.rows, evidence.layout)
    return attitude_of_points(base, evidence.rows, evidence.layout) if alike is None else Attitude(*alike)


def shown_output(
    evidence: Evidence, output: int, base: Accelerometer, design: Design, q: FloatArray
) -> ShownOutput[Design] | None:
    """Return what one output shows beside (K, P) orthonormal ``q``; None where too little is left to weigh it by."""
    dof = evidence.layout.points - q.shape[1]
    if dof < LEAST_DOF:
        return None
    k = along_force(base, evidence.primary[output])
    means = evidence.point_effects[:, output] / np.linalg.norm(k)
    left = means - q @ (q.T @ means)
    return ShownOutput(base.nominal_axis, design, k, left, float(dof)) if left.any() else None
