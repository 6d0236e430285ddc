"""A disturbance in step with the replications: what it does to each output, and its finding."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from ams.analysis.diagnostics.beliefs import IN_STEP, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.sensed_force import along_force, turned_by
from ams.analysis.diagnostics.size_words import within
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import FloatArray, IntArray
from ams.finding_kinds import FindingKind
from ams.findings import Finding
from ams.frames import specific_force_by_base, specific_force_by_pitch
from ams.remembered import remembered
from ams.solve.dwell_order import turns_in_replication
from ams.solve.layout import Layout
from ams.statistics.intervals import t_quantile
from ams.units import in_arcsec

Way = Literal["meter", "base", "outputs"]
"""By which it reaches the outputs: as one voltage on all of them, as a tilt of the base, or each by an amount of its
own, such as a temperature does."""
WAVES: Final = 3
"""Over a replication, at most: of more an order of rows of a dozen dwells sees other things."""
_KIND: Final[dict[Way, FindingKind]] = {
    "meter": "meter-offset",
    "base": "table-rotation",
    "outputs": "autocorrelation",
}
_TIMES: Final = {1: "once", 2: "twice", 3: "three times"}
_WHAT: Final[dict[Way, str]] = {
    "meter": "one voltage comes and goes on all outputs",
    "base": "the base, or the table, tilts to and fro",
    "outputs": "the outputs come and go, each by an amount of its own,",
}
_CAUSE: Final[dict[Way, str]] = {
    "meter": "hum of the mains that beats with the readings, or what else all outputs share (meter, supply)",
    "base": "a floor, a pump or air conditioning that moves it",
    "outputs": "a temperature that a chamber or an air conditioning cycles",
}

_ALIKE: Final = (
    "the order of the points is the same in every replication, so that the part of it that goes with the attitudes "
    "passes for offset and sensitivities: its size is not known, and the stated uncertainties do not hold it"
)
_DIFFERENT: Final = (
    "the order of the points is another in every replication, so that it is noise of offset and sensitivities, which "
    "the stated uncertainties hold"
)
_DRAW: Final = (
    'draw the order of the points anew for every replication (order = "neighbours" or "random"), which makes noise of '
    "it that the uncertainties hold; or "
)


@dataclass(frozen=True)
class InStep:
    """Of one package."""

    way: Way
    waves: tuple[int, ...]
    """How many periods a replication has, of each that is shown; the plainest first."""
    sizes: FloatArray
    """(2 w,) or, by a base, (4 w,) of the columns of these: cosine and sine; about pitch, then about the forward axis.
    By outputs (2 w m,), those of the first output first. Radians; by the meter volts, by outputs over the sensitivity.
    """
    axes: tuple[str, ...]
    """Nominal axis of each output."""
    standard_uncertainty: float
    """Of the largest amplitude, in its unit."""
    dof: float
    p_value: float
    is_alike: bool = True
    """Whether the order of the points is the same in every replication."""

    @property
    def amplitudes(self) -> FloatArray:
        """(m,) by outputs, (2,) by a base, (1,) by the meter: of the plainest wave, as far as the points show it."""
        parts = self.sizes.reshape(-1, len(self.waves), 2)
        return np.asarray(np.hypot(parts[:, 0, 0], parts[:, 0, 1]))

    @property
    def test(self) -> BeliefTest:
        """As one of every output of the package."""
        unit = "V" if self.way == "meter" else "rad"
        return BeliefTest(
            IN_STEP, _KIND[self.way], self.p_value, float(self.amplitudes.max()), self.standard_uncertainty, unit,
            self.dof, is_held=not self.is_alike, axes=len(self.axes),
        )  # fmt: skip

    def taken_by(self, evidence: Evidence, output: int) -> tuple[FloatArray, FloatArray]:
        """Return (N, c) waves on an output, and their (c,) sizes; the products in its unit."""
        base = accelerometer_base(evidence.models[output])
        assert base is not None, "no other sensor shows it"
        shown = waves_of(evidence.time_order, evidence.layout)[:, waves_at(self.waves)]
        if self.way == "meter":
            return shown, self.sizes
        k = along_force(base, evidence.primary[output])
        if self.way == "outputs":
            parts = self.sizes.reshape(len(self.axes), -1)
            return shown * float(np.linalg.norm(k)), parts[self.axes.index(base.nominal_axis)]
        angles = turned_by(base, evidence.rows)
        return np.hstack([(by(*angles) @ k)[:, None] * shown for by in TILTS]), self.sizes

    def finding(self) -> Finding:
        """Return what is said of it."""
        often = " and ".join(_TIMES[waves] for waves in sorted(self.waves))
        fact = (
            f"{_WHAT[self.way]} in step with the replications, {often} in each: by {self._sized()} to either side, as "
            f"far as the points show it; {_CAUSE[self.way]}; {_ALIKE if self.is_alike else _DIFFERENT}"
        )
        largest = float(self.amplitudes.max())
        size = {"amplitude_v": largest} if self.way == "meter" else {"amplitude_arcsec": in_arcsec(largest)}
        details: dict[str, float | str | None] = {
            "test": IN_STEP,
            **size,
            "periods_in_a_replication": ", ".join(map(str, sorted(self.waves))),
        }
        way_out = f"{_DRAW if self.is_alike else ''}find what comes and goes, and measure again"
        held = not self.is_alike
        return Finding(_KIND[self.way], fact, True, self.p_value, (), details, is_held=held, what_to_do=way_out)

    def _sized(self) -> str:
        half = float(t_quantile(0.95, self.dof)) * self.standard_uncertainty
        if self.way == "meter":
            return f"{within(1e6 * float(self.amplitudes[0]), 1e6 * half)} µV"
        sizes = [f"{within(in_arcsec(size), in_arcsec(half))}″" for size in self.amplitudes.tolist()]
        if self.way == "base":
            return f"{sizes[0]} about the pitch axis and {sizes[1]} about the forward axis"
        return ", ".join(f"{axis} {size}" for axis, size in zip(self.axes, sizes, strict=True))


TILTS: Final = (specific_force_by_pitch, specific_force_by_base)


def waves_at(waves: tuple[int, ...]) -> list[int]:
    """Return the columns of cosine and sine of some waves."""
    return [2 * (count - 1) + part for count in waves for part in (0, 1)]


@remembered(16)
def waves_of(order: IntArray, layout: Layout) -> FloatArray:
    """Return (N, 6) cosine and sine of one, two and three periods over the dwells of every replication."""
    turn, sizes = turns_in_replication(order, layout.replication, layout.replications)
    phase = (2.0 * np.pi * turn / sizes[layout.replication])[:, None] * np.arange(1, WAVES + 1)
    return np.stack([np.cos(phase), np.sin(phase)], axis=2).reshape(layout.rows, -1)
