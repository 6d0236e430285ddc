"""The table's own index errors, carried into the output covariance U_Y.

An index of an axis has one error, the same for every reading taken at it: in every replication, and at every attitude
that shares the index, whatever the axis reads there on coming back (:mod:`ams.inputs.indices`). A certificate gives a
*limit* on these errors, not what they look like: white from tooth to tooth, once a turn (an axis off the centre of its
scale), twice (an elliptic scale), or a mixture. Independent teeth alone would let the uncertainty fall with the root of
their number, which no real table does. So the errors E(a) of an axis have, unless its shape is declared, the covariance

    u² [w₀ δ(a, a′) + w₁ cos(a − a′) + w₂ cos 2(a − a′)],     u = 0.9 × limit,  w = (0.30, 0.35, 0.35),

each term of which alone carries a curve that reaches the limit. An axis that was set to read true at an index a₀ has
E(a) − E(a₀) and the uncertainty of setting it; one whose certificate lists errors at angles is corrected by
interpolation and keeps the uncertainty of the list and what lies between its angles. Every covariance is made of
columns: G Gᵀ with ∂v/∂angle times a column for every independent part. Source: TP 10, 'inclusion of calibration
standard uncertainties', for the columns; the weights by simulation (docs/mathematics.md).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final, Literal

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError
from ams.inputs.indices import standing_at
from ams.observations import Observations
from ams.remembered import remembered

UncertaintyKind = Literal["limit", "standard", "expanded"]
Shape = Literal["unknown", "independent", "smooth"]
AXES: Final = ("pitch", "roll", "yaw")
_INDEX_GRID_RAD: Final = float(np.deg2rad(1e-5))


@dataclass(frozen=True)
class _Parts:
    """Variance of index errors within a limit of one, part by part."""

    teeth: float
    harmonics: Mapping[int, float]
    """Times a turn to variance."""


_U2: Final = 0.9**2
_SHAPES: Final[Mapping[Shape, _Parts]] = MappingProxyType(
    {
        "unknown": _Parts(0.30 * _U2, {1: 0.35 * _U2, 2: 0.35 * _U2}),
        "independent": _Parts(1.0 / 3.0, {}),
        "smooth": _Parts(0.0, {1: 0.35 * _U2, 2: 0.35 * _U2, **dict.fromkeys(range(3, 9), 0.05 * _U2)}),
    }
)
SHAPES: Final = tuple(_SHAPES)


@dataclass(frozen=True)
class KnownErrors:
    """Errors of an axis that its certificate lists at angles: where it truly stands, less what it shows."""

    angle_rad: FloatArray
    """(n,) rising, within one turn, two or more."""
    error_rad: FloatArray
    """(n,)"""
    standard_uncertainty_rad: FloatArray
    """(n,)"""

    def weights(self, angle_rad: FloatArray) -> FloatArray:
        """Return (N, n) of linear interpolation; beyond the ends across the rest of the turn."""
        first, turn = self.angle_rad[0], 2.0 * np.pi
        inside = (angle_rad - first + _INDEX_GRID_RAD) % turn - _INDEX_GRID_RAD
        edges = np.append(self.angle_rad - first, turn)
        below = np.clip(np.searchsorted(edges, inside, side="right") - 1, 0, self.angle_rad.size - 1)
        share = np.clip((inside - edges[below]) / (edges[below + 1] - edges[below]), 0.0, 1.0)
        share = np.where(np.abs(inside - edges[below + 1]) < _INDEX_GRID_RAD, 1.0, share)
        share = np.where(np.abs(inside - edges[below]) < _INDEX_GRID_RAD, 0.0, share)
        rows = np.arange(angle_rad.size)
        weights = np.zeros((angle_rad.size, self.angle_rad.size))
        weights[rows, below] += 1.0 - share
        weights[rows, (below + 1) % self.angle_rad.size] += share
        return weights


@dataclass(frozen=True)
class IndexErrors:
    """What is declared of the errors of one axis beside their limit."""

    shape: Shape = "unknown"
    zero_rad: float | None = None
    """The index at which the axis was set to read true."""
    zero_standard_uncertainty_rad: float = 0.0
    """Of setting it there."""
    known: KnownErrors | None = None


_UNDECLARED: Final = IndexErrors()


@dataclass(frozen=True)
class TableUncertainty:
    """What the table's certificate states for the indices of each axis, radians."""

    pitch_rad: float
    roll_rad: float
    kind: UncertaintyKind = "standard"
    """``limit``: no error is larger; ``expanded``: ``coverage_factor`` times a standard uncertainty. A standard
    uncertainty is that of a limit √3 times as large."""
    coverage_factor: float = 2.0
    yaw_rad: float = 0.0
    errors: Mapping[str, IndexErrors] = field(default_factory=dict)
    """Axis to what is declared beside the limit; an axis that is not there has errors of unknown shape."""

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
        for name, declared in self.errors.items():
            if name not in AXES or declared.shape not in SHAPES:
                raise ObservationsError(
                    f"table uncertainty: index errors of {name}: got {declared.shape!r}, allowed "
                    f"{', '.join(SHAPES)} for {', '.join(AXES)}; nothing was solved; correct the rig file"
                )

    def standard_rad(self) -> Mapping[str, float]:
        """Return the standard uncertainty per axis, keyed ``pitch``, ``roll`` and ``yaw``, rad."""
        divisor = {"limit": np.sqrt(3.0), "standard": 1.0, "expanded": self.coverage_factor}[self.kind]
        stated = {"pitch": self.pitch_rad, "roll": self.roll_rad, "yaw": self.yaw_rad}
        return {name: float(value / divisor) for name, value in stated.items()}

    def limit_rad(self, axis: str) -> float:
        """Return the limit of the index errors of an axis: √3 standard uncertainties where it is no limit."""
        return float(np.sqrt(3.0)) * self.standard_rad()[axis]

    def declared(self, axis: str) -> IndexErrors:
        """Return what an axis declares beside the limit of its errors."""
        return self.errors.get(axis, _UNDECLARED)

    def correction_rad(self, axis: str, angle_rad: FloatArray) -> FloatArray:
        """Return (N,) to add to what the axis shows; zero where its certificate lists no errors."""
        declared = self.declared(axis)
        if declared.known is None:
            return np.zeros_like(angle_rad)
        error = declared.known.weights(angle_rad) @ declared.known.error_rad
        if declared.zero_rad is not None:
            error = error - declared.known.weights(np.array([declared.zero_rad])) @ declared.known.error_rad
        return np.asarray(error)

    def index_errors(self, axis: str, angle_rad: FloatArray) -> "IndexColumns":
        """Return the independent parts of the errors of an axis at (N,) angles that it shows."""
        declared, standard_rad = self.declared(axis), self.standard_rad()[axis]
        if declared.known is None:
            return _errors_of_shape(declared, standard_rad, angle_rad)
        return _beside_zero(declared, angle_rad, lambda shown: _corrected(declared, standard_rad, shown))


@dataclass(frozen=True)
class IndexColumns:
    """Errors of an axis as Σ column × a number of zero mean with a standard deviation of its own."""

    names: tuple[str, ...]
    standard_rad: FloatArray
    """(q,)"""
    columns: FloatArray
    """(N, q)"""

    def beside(self, other: "IndexColumns") -> "IndexColumns":
        return IndexColumns(
            (*self.names, *other.names),
            np.concatenate([self.standard_rad, other.standard_rad]),
            np.hstack([self.columns, other.columns]),
        )

    def without_nothing(self) -> "IndexColumns":
        """Return the columns but those that do nothing."""
        kept = self.columns.any(axis=0) & (self.standard_rad > 0.0)
        names = tuple(name for name, is_kept in zip(self.names, kept, strict=True) if is_kept)
        return IndexColumns(names, self.standard_rad[kept], self.columns[:, kept])

    @property
    def scaled_rad(self) -> FloatArray:
        """(N, q) one standard deviation of each."""
        return self.standard_rad * self.columns


@remembered(16)
def _errors_of_shape(declared: IndexErrors, standard_rad: float, angle_rad: FloatArray) -> IndexColumns:
    """Return the errors of an axis whose certificate lists none."""
    return _beside_zero(declared, angle_rad, lambda shown: _shaped(_SHAPES[declared.shape], standard_rad, shown))


def _beside_zero(
    declared: IndexErrors, angle_rad: FloatArray, errors_at: Callable[[FloatArray], IndexColumns]
) -> IndexColumns:
    """Return errors at (N,) angles less those at the index where the axis was set to read true, if there is one."""
    if declared.zero_rad is None:
        return errors_at(angle_rad).without_nothing()
    found = errors_at(np.append(angle_rad, declared.zero_rad))
    less = replace(found, columns=found.columns[:-1] - found.columns[-1])
    standard_rad = np.array([declared.zero_standard_uncertainty_rad])
    set_to_zero = IndexColumns(("set to zero",), standard_rad, np.ones((angle_rad.size, 1)))
    return less.beside(set_to_zero).without_nothing()


def _shaped(parts: _Parts, standard_rad: float, angle_rad: FloatArray) -> IndexColumns:
    """``standard_rad``: of the certificate, limit/√3."""
    unit = _of_unit_limit(tuple(parts.harmonics), tuple(parts.harmonics.values()), parts.teeth, angle_rad)
    return replace(unit, standard_rad=standard_rad * unit.standard_rad)


@remembered(32)
def _of_unit_limit(
    harmonics: tuple[int, ...], variances: tuple[float, ...], teeth: float, angle_rad: FloatArray
) -> IndexColumns:
    names, standard, columns = [], [], []
    for times, variance in zip(harmonics, variances, strict=True):
        for word, wave in (("cosine", np.cos), ("sine", np.sin)):
            names.append(f"{_times_a_turn(times)}, {word}")
            standard.append(np.sqrt(3.0 * variance))
            columns.append(wave(times * angle_rad))
    waves = np.stack(columns, axis=1) if columns else np.zeros((angle_rad.size, 0))
    found = IndexColumns(tuple(names), np.array(standard), waves)
    if teeth == 0.0:
        return found
    stands, mean_rad = standing_at(angle_rad)
    words = tuple(f"tooth {angle:.9g}°" for angle in np.round(np.rad2deg(mean_rad), 4).tolist())
    return found.beside(IndexColumns(words, np.full(mean_rad.size, np.sqrt(3.0 * teeth)), stands))


def _times_a_turn(times: int) -> str:
    return {1: "once a turn", 2: "twice a turn"}.get(times, f"{times} times a turn")


def _corrected(declared: IndexErrors, standard_rad: float, angle_rad: FloatArray) -> IndexColumns:
    """Return what a correction by interpolation leaves.

    That is the list's own errors, of a shape that nobody knows, and between the listed angles how far the curve departs
    from the straight lines.
    """
    known = declared.known
    assert known is not None
    weights = known.weights(angle_rad)
    between = _shaped(_SHAPES[declared.shape], standard_rad, np.concatenate([angle_rad, known.angle_rad]))
    here, listed = np.split(between.columns, [angle_rad.size])
    left = here - weights @ listed
    left[np.abs(left) < 1e-12] = 0.0
    stated = _shaped(_SHAPES["unknown"], 1.0, known.angle_rad)
    stated = replace(
        stated,
        names=tuple(f"list, {name}" for name in stated.names),
        columns=weights @ (known.standard_uncertainty_rad[:, None] * stated.columns),
    )
    return replace(between, columns=left).beside(stated)


def index_members(table: TableUncertainty, angles_rad: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
    """Angle to (N, q): columns of one standard uncertainty each of the errors at the angles that the axes show."""
    found = {name: table.index_errors(name, angles_rad[name]).scaled_rad for name in AXES if name in angles_rad}
    return {name: columns for name, columns in found.items() if columns.shape[1] > 0}


def columns_of_members(members: Mapping[str, FloatArray], slopes_v_per_rad: Mapping[str, FloatArray]) -> FloatArray:
    """Return (N, q) columns G from :func:`index_members` and the slopes of one sensor axis."""
    blocks = [slopes_v_per_rad[name][:, None] * block for name, block in members.items() if name in slopes_v_per_rad]
    rows = next(iter(slopes_v_per_rad.values())).size
    return np.hstack(blocks) if blocks else np.zeros((rows, 0))


def index_columns(
    table: TableUncertainty, angles_rad: Mapping[str, FloatArray], slopes_v_per_rad: Mapping[str, FloatArray]
) -> FloatArray:
    """(N, q) columns G: output error that one standard uncertainty of each part of the index errors causes, volts."""
    return columns_of_members(index_members(table, angles_rad), slopes_v_per_rad)


def corrected(observations: Observations, table: TableUncertainty | None) -> Observations:
    """Return the observations at the angles where the table truly stood, as far as its certificate lists its errors."""
    if table is None or not any(declared.known is not None for declared in table.errors.values()):
        return observations
    yaw_rad = observations.yaw_rad
    return replace(
        observations,
        pitch_rad=observations.pitch_rad + table.correction_rad("pitch", observations.pitch_rad),
        roll_rad=observations.roll_rad + table.correction_rad("roll", observations.roll_rad),
        yaw_rad=None if yaw_rad is None else yaw_rad + table.correction_rad("yaw", yaw_rad),
    )


def shown_rad(table: TableUncertainty, angles_rad: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
    """Return what the axes showed where :func:`corrected` put them.

    It is so to within an error times its slope, far below an index.
    """
    return {name: angle - table.correction_rad(name, angle) for name, angle in angles_rad.items()}


def known_errors(
    angle_deg: Sequence[float], error_arcsec: Sequence[float], standard_uncertainty_arcsec: Sequence[float]
) -> KnownErrors:
    """Return the errors as a certificate lists them; angles rise, within one turn."""
    arcsec = np.deg2rad(1.0 / 3600.0)
    return KnownErrors(
        np.deg2rad(np.array(angle_deg, dtype=float)),
        arcsec * np.array(error_arcsec, dtype=float),
        arcsec * np.array(standard_uncertainty_arcsec, dtype=float),
    )
