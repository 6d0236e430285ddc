"""Whether the base tilted from one replication to the next, as all outputs of a package show it together.

A level that is read before and after a run says nothing of the hours between: a building that leans in the sun comes
back by the morning, and the mean of the tilt, common to all replications, passes for an offset and a square of the
force. No sensor and no mount does what a tilt of the base does: it turns gravity by an angle that is fixed in the
laboratory, sin α sin R on y and sin α cos R on z about pitch, cos R and −sin R about the forward axis. So each
replication has two angles, of all outputs together, in what its own offset and sensitivities leave, where neither a
drift of a sensor nor a package that is mounted anew has any part. A slip of the zero of pitch between two replications
looks the same as a tilt about pitch.

What is as likely as not to be chance is counted before it is told: where the angles scatter by more than one in twenty
do, their largest less smallest is a limit of the tilt in the uncertainties, about each axis. Source: MATH 10.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.sensed_force import along_force, attitude_of_points, is_rolled
from ams.analysis.diagnostics.size_words import within
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import FloatArray
from ams.findings import Finding
from ams.frames import specific_force, specific_force_by_base, specific_force_by_pitch
from ams.inputs.shared_errors import SHOWN_BY_ROWS, Effect, SharedError
from ams.remembered import remembered
from ams.solve.linear_form import orthogonal
from ams.solve.seen_directions import seen_directions
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, f_tail, median
from ams.statistics.intervals import t_quantile
from ams.units import in_arcsec

BASE_TILT: Final = "tilt of the base between replications"
_COUNTED: Final = 0.1
"""The chance of angles that scatter as much by noise alone, below which they are counted."""
_ALONE: Final = 0.05
"""The same of what is left without the output that shows most."""
_UNLIKE: Final = 0.01
"""The chance of outputs that differ as much in one rotation."""
_SHARE: Final = 0.2
"""Of what they show together: outputs that differ by less have it in common, though they tilt within a replication."""
_STRUCK: Final = 6.0
"""Standard deviations: a dwell that stands farther off is drawn in."""
_DRAWN_IN: Final = 5.0
_FEWEST: Final = 2
"""Outputs, and angles that they see."""
_REPLICATIONS: Final = 3
"""Two have one difference: what it is by chance would stand as the limit of a tilt in every uncertainty."""
_SLOW: Final = 2
"""Degree in the number of the replication of a slow course: an even tilt, and one that comes back."""
_MEASURED: Final = 0.9
"""Of the points: a replication with fewer is not asked."""


@dataclass(frozen=True)
class BaseTilt:
    """Of the base, as the replications differ in it."""

    p_value: float
    range_rad: tuple[float, float]
    """Largest less smallest, about the pitch axis and about the forward axis."""
    standard_uncertainty_rad: tuple[float, float]
    """Of such a difference between two replications."""
    dof: float
    is_of_several: bool
    """Whether it is shown without the output that shows most: one output proves no rotation."""

    @property
    def counted(self) -> tuple[SharedError, ...]:
        """What is in the uncertainties: the limit of a tilt that is common to all rows, about each axis."""
        kinds: tuple[tuple[str, Effect], ...] = (("pitch", "pitch"), ("roll", "base-tilt"))
        return tuple(
            SharedError(
                f"{BASE_TILT}, about {about}", effect, size / 3.0**0.5, "limit",
                stated=f"limit {in_arcsec(size):.3g}″, {SHOWN_BY_ROWS}: largest less smallest of the replications",
                is_weighed=False,
            )
            for (about, effect), size in zip(kinds, self.range_rad, strict=True)
        )  # fmt: skip


@dataclass(frozen=True)
class _Shown:
    """Of one output, or of several together."""

    scores: FloatArray
    """(n, 2)"""
    information: FloatArray
    """(2, 2) of one replication, per square radian."""
    whole: FloatArray
    """(2,) the same, beside nothing: what offset and sensitivities absorb is in it."""

    @cached_property
    def _root(self) -> FloatArray:
        """(2, r) directions of the angles that are seen, over the square root of their information."""
        return seen_directions(self.information, self.whole)

    @property
    def rank(self) -> int:
        return int(self._root.shape[1])

    @cached_property
    def angles_rad(self) -> FloatArray:
        """(n, 2) of the replications, about their mean."""
        return np.asarray(self.scores @ self._root @ self._root.T)

    def square(self, courses: FloatArray) -> float:
        """Return what the angles explain along (n, c) courses of unit length, over the variance of readings."""
        along = courses.T @ self.scores @ self._root
        return float(np.sum(along**2))


def judge_base(outputs: Sequence[tuple[Evidence, int]]) -> BaseTilt | None:
    """Return how the base tilted between the replications of a package; None where nothing shows that it did."""
    if len(outputs) < _FEWEST or outputs[0][0].layout.replications < _REPLICATIONS:
        return None
    shown = [found for evidence, index in outputs if (found := _shown(evidence, index)) is not None]
    if len(shown) < _FEWEST:
        return None
    whole, dof = _together(shown), float(sum(evidence.grid.dof for evidence, _ in outputs))
    if whole.rank < _FEWEST:
        return None
    of_courses = [(_chance(whole, courses, dof), courses) for courses in _courses(whole.scores.shape[0])]
    least, courses = min(of_courses, key=lambda found: found[0])
    p_value = min(1.0, len(of_courses) * least)
    if not p_value <= _COUNTED or _are_unlike(shown, whole, courses, dof):
        return None
    about_pitch, about_forward = np.ptp(whole.angles_rad, axis=0).tolist()
    u_pitch, u_forward = np.sqrt(2.0 * np.diag(np.linalg.inv(whole.information))).tolist()
    is_of_several = _chance(_but_the_plainest(shown, courses), courses, dof) <= _ALONE
    return BaseTilt(p_value, (about_pitch, about_forward), (u_pitch, u_forward), dof, is_of_several)


def tilt_finding(tilt: BaseTilt, *, is_counted: bool) -> Finding:
    """Return what is said of a tilt; ``is_counted``: whether it is in the uncertainties."""
    sizes = [
        f"{within(in_arcsec(size), float(t_quantile(0.95, tilt.dof)) * in_arcsec(u))}″"
        for size, u in zip(tilt.range_rad, tilt.standard_uncertainty_rad, strict=True)
    ]
    held = (
        "as much is in the uncertainties, as a limit of how far the base stood off while it was measured; where it "
        "stood farther off in all replications, that is not"
        if is_counted
        else "it is not in the stated uncertainties"
    )
    fact = (
        f"the base tilted between the replications, by {sizes[0]} about the pitch axis and {sizes[1]} about the "
        "forward axis (largest less smallest), or the zero of pitch moved: all outputs of the package turn by it "
        f"together, and no sensor and no mount does that; readings of the level before and after do not show it; {held}"
    )
    details: dict[str, float | str | None] = {
        "test": BASE_TILT,
        "turned_arcsec": in_arcsec(max(tilt.range_rad)),
        "about_pitch_arcsec": in_arcsec(tilt.range_rad[0]),
        "about_forward_axis_arcsec": in_arcsec(tilt.range_rad[1]),
    }
    what_to_do = (
        "find what tilts the base (sun, air conditioning, oil, a load that moves), read the level between the "
        "replications, and measure again"
    )
    return Finding("table-rotation", fact, True, tilt.p_value, (), details, is_held=is_counted, what_to_do=what_to_do)


@cache
def _courses(replications: int) -> tuple[FloatArray, ...]:
    """Return (n, c) orthonormal columns of what the replications may differ by: at all, and by a slow course alone."""
    legendre = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, replications), replications - 1)
    at_all = np.linalg.qr(legendre)[0][:, 1:]
    return (at_all,) if replications - 1 <= _SLOW else (at_all, at_all[:, :_SLOW])


def _chance(shown: _Shown, courses: FloatArray, dof: float) -> float:
    numbers = float(courses.shape[1] * shown.rank)
    return float(f_tail(shown.square(courses) / numbers, numbers, dof)) if numbers > 0.0 else 1.0


def _are_unlike(shown: Sequence[_Shown], whole: _Shown, courses: FloatArray, dof: float) -> bool:
    """Return whether the outputs do not have one rotation together."""
    square, between = whole.square(courses), float(courses.shape[1])
    numbers = between * (sum(output.rank for output in shown) - whole.rank)
    apart = sum(output.square(courses) for output in shown) - square
    if not numbers > 0.0 or float(f_tail(apart / numbers, numbers, dof)) >= _UNLIKE:
        return False
    return apart - numbers > _SHARE * (square - between * whole.rank)


def _but_the_plainest(shown: Sequence[_Shown], courses: FloatArray) -> _Shown:
    squares = [output.square(courses) for output in shown]
    return _together([*shown[: (most := int(np.argmax(squares)))], *shown[most + 1 :]])


def _together(shown: Sequence[_Shown]) -> _Shown:
    scores, information, whole = (
        np.asarray(sum(getattr(output, name) for output in shown)) for name in ("scores", "information", "whole")
    )
    return _Shown(scores, information, whole)


def _shown(evidence: Evidence, index: int) -> _Shown | None:
    """Return what an output shows; None of one that senses no attitude, or has no scatter."""
    base, variance = accelerometer_base(evidence.models[index]), float(evidence.precision_variance[index])
    if base is None or not variance > 0.0:
        return None
    left, sd = evidence.departures[:, index], variance**0.5
    if float(np.abs(left).max()) > _STRUCK * sd:
        sd = SD_PER_MEDIAN_DEVIATION * median(np.abs(left)) or sd
        left = np.clip(left, -_DRAWN_IN * sd, _DRAWN_IN * sd)
    stood = attitude_of_points(base, evidence.rows, evidence.layout)
    roll = stood.roll_rad if is_rolled(base) else np.zeros_like(stood.roll_rad)
    changes, left_of_them, taken = _changes(stood.pitch_rad, roll, stood.yaw_rad)
    k = along_force(base, evidence.primary[index])
    pattern = left_of_them @ k
    by_replication = _by_replication(evidence, left, taken)
    if by_replication.shape[0] < _REPLICATIONS:
        return None
    whole = ((changes @ k) ** 2).sum(axis=1)
    return _Shown(by_replication @ pattern.T / sd**2, pattern @ pattern.T / sd**2, whole / sd**2)


def _by_replication(evidence: Evidence, left: FloatArray, taken: FloatArray) -> FloatArray:
    """Return the (n, K) departures of the replications that have nearly all points, beside (K, 4) directions."""
    layout = evidence.layout
    grid = evidence.on_grid(left[:, None]).reshape(layout.replications, layout.points)
    if layout.is_complete:
        return grid
    is_there = evidence.on_grid(np.ones((layout.rows, 1))).reshape(grid.shape) > 0.0
    whole = np.count_nonzero(is_there, axis=1) >= _MEASURED * layout.points
    for values, here in zip(grid, is_there, strict=True):
        values[here] -= taken[here] @ np.linalg.lstsq(taken[here], values[here], rcond=None)[0]
    measured = grid[whole]
    return np.asarray(measured - measured.sum(axis=0) / max(measured.shape[0], 1))


@remembered(16)
def _changes(
    pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (2, K, 3) changes of the specific force by both tilts, and what a replication leaves of them, the same.

    Third: the (K, 4) orthonormal directions of what it has of its own, its offset and its sensitivities.
    """
    changes = np.stack([by(pitch_rad, roll_rad, yaw_rad) for by in (specific_force_by_pitch, specific_force_by_base)])
    taken, _ = orthogonal(np.column_stack([np.ones_like(pitch_rad), specific_force(pitch_rad, roll_rad, yaw_rad)]))
    return changes, changes - taken @ (taken.T @ changes), taken
