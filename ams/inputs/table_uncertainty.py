"""The table's own index errors, carried into the output covariance U_Y.

An index (a tooth of the coupling) has one error, the same for every reading taken at it: in every replication, and at
every attitude that shares the index. With δ the error of an index and ∂v/∂angle the slope of the output there, the
output covariance they cause is G Gᵀ with one column of G per index. Source: TP 10, 'inclusion of calibration standard
uncertainties'.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError

UncertaintyKind = Literal["limit", "standard", "expanded"]
_INDEX_GRID_RAD = float(np.deg2rad(1e-5))


@dataclass(frozen=True)
class TableUncertainty:
    """What the table's certificate states for one index of each axis, radians."""

    pitch_rad: float
    roll_rad: float
    kind: UncertaintyKind = "standard"
    """``limit``: half-width of a rectangular distribution; ``expanded``: divided by ``coverage_factor``."""
    coverage_factor: float = 2.0
    yaw_rad: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("pitch", self.pitch_rad), ("roll", self.roll_rad), ("yaw", self.yaw_rad)):
            if not (np.isfinite(value) and value >= 0.0):
                raise ObservationsError(
                    f"table uncertainty: {name}: got {value!r} rad, allowed 0 or more; nothing was "
                    f"solved; correct the rig file"
                )
        if not self.coverage_factor > 0.0:
            raise ObservationsError(
                f"table uncertainty: coverage factor: got {self.coverage_factor!r}, allowed above 0; nothing was solved"
            )

    def standard_rad(self) -> Mapping[str, float]:
        """Return the standard uncertainty per axis, keyed ``pitch``, ``roll`` and ``yaw``, rad."""
        divisor = {"limit": np.sqrt(3.0), "standard": 1.0, "expanded": self.coverage_factor}[self.kind]
        stated = {"pitch": self.pitch_rad, "roll": self.roll_rad, "yaw": self.yaw_rad}
        return {name: float(value / divisor) for name, value in stated.items()}


def index_members(table: TableUncertainty, angles_rad: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
    """Return (N, indices) by angle, radians.

    It is the index that a row was taken at, times one standard uncertainty of it.
    """
    standard_rad = table.standard_rad()
    return {
        name: standard_rad[name] * _membership(angles_rad[name])
        for name in ("pitch", "roll", "yaw")
        if name in angles_rad and standard_rad[name] > 0.0
    }


def columns_of_members(members: Mapping[str, FloatArray], slopes_v_per_rad: Mapping[str, FloatArray]) -> FloatArray:
    """Return the (N, q) columns G, one per index in use.

    They come from :func:`index_members` and the slopes of one sensor axis.
    """
    blocks = [slopes_v_per_rad[name][:, None] * block for name, block in members.items() if name in slopes_v_per_rad]
    rows = next(iter(slopes_v_per_rad.values())).size
    return np.hstack(blocks) if blocks else np.zeros((rows, 0))


def index_columns(
    table: TableUncertainty, angles_rad: Mapping[str, FloatArray], slopes_v_per_rad: Mapping[str, FloatArray]
) -> FloatArray:
    """Return the (N, q) columns G, one per index in use.

    Each is the output error that one standard uncertainty of that index causes, volts.
    """
    return columns_of_members(index_members(table, angles_rad), slopes_v_per_rad)


def _membership(angle_rad: FloatArray) -> FloatArray:
    """Return (N, indices) one where the row was taken at that index; whole turns are the same index."""
    full_turn = round(2.0 * np.pi / _INDEX_GRID_RAD)
    index = np.round(angle_rad / _INDEX_GRID_RAD).astype(np.int64) % full_turn
    labels, place = np.unique(index, return_inverse=True)
    return np.eye(labels.size)[place]
