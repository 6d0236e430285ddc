"""What a solved calibration is: values, and no behaviour beyond reading them and adding to what is found in them.

The report, the coefficient set and the JSON document are all drawn from these.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal

import numpy as np

from ams.arrays import Centring, FloatArray
from ams.findings import Finding, beyond_the_stated, leaves_nothing, significant_texts, turned_the_table

METHOD_VERSION: Final = 4
"""Of the way from observations to a result: 1 had independent teeth and no terms of low order unless asked for; 2 has
index errors of unknown shape and the terms wherever the points determine them; 3 has the terms in joint fits too;
4 has the nonlinearity of the scale factor of gyros."""


@dataclass(frozen=True)
class ParameterEstimate:
    """One parameter in its edge unit (the unit its name ends in)."""

    name: str
    """Such as ``offset_v``, ``sensitivity_v_per_g``, ``coning_deg``, ``azimuth_deg``."""
    value: float | None
    """None where the observations cannot determine it (the reason is among the warnings)."""
    standard_uncertainty: float | None
    tp_standard_uncertainty: float | None
    """The pooled form of TP (50)."""
    effective_degrees_of_freedom: float | None
    interval_95: tuple[float, float] | None


@dataclass(frozen=True)
class FTest:
    """A variance ratio and the limit it is held against."""

    t: float
    f_95: float
    p_value: float
    numerator_dof: float
    denominator_dof: float
    is_significant: bool
    """Among all tests of the run (Holm, each axis with its share)."""


@dataclass(frozen=True)
class TpReplication:
    """The replication analysis exactly as TP 8 has it."""

    sigma_bias_v: float
    sigma_prec_v: float
    t_bias: float
    f_bias_95: float
    drift: Mapping[str, FTest]
    """Keyed ``offset``, ``sensitivity``, ``coning``, ``azimuth``."""


@dataclass(frozen=True)
class Replication:
    """Lack of fit and drift from n replications of the same points (MATH 5)."""

    replications: int
    points: int
    lack_of_fit: FTest
    drift: Mapping[str, FTest]
    tp: TpReplication
    precision_v: float
    """Square root of MS_prec: the dwell-to-dwell scatter, volts."""
    lack_of_fit_v: float
    """Square root of the lack-of-fit variance per point; 0 where it is not there."""
    per_replication: Mapping[int, Mapping[str, float]]
    """Replication label to parameter name (edge units) to its estimate from that replication alone."""


@dataclass(frozen=True)
class VarianceComponent:
    """One independent part of the covariance of the primary parameters."""

    name: str
    """``replications`` (precision and drift), ``lack-of-fit``, ``residuals``, ``table``, ``temperature``."""
    covariance: FloatArray
    """(P, P), in the order of the primary parameters."""
    dof: float
    """Degrees of freedom it was estimated with; infinite for what a certificate states."""


@dataclass(frozen=True)
class AxisCalibration:
    """One sensor axis, solved."""

    axis: str
    model: str
    """Name of the model in ``ams.models``, such as ``pitch-roll``."""
    nominal_axis: str
    """``x``, ``y`` or ``z``: the package axis the sensor nominally lies along."""
    parameters: tuple[ParameterEstimate, ...]
    covariance: FloatArray
    """(L, L) in the order and units of ``parameters``; NaN rows where a parameter is null."""
    primary_names: tuple[str, ...]
    """Names of the primary (linear) parameters: ``offset_v, k_x_v_per_g, k_y_v_per_g, k_z_v_per_g`` and any further."""
    primary: FloatArray
    """(P,) primary estimates; predictions are made from these."""
    primary_covariance: FloatArray
    """(P, P) the reported (mixed-model) covariance."""
    tp_primary_covariance: FloatArray
    """(P, P) the pooled covariance."""
    primary_dof: FloatArray
    """(P,) effective degrees of freedom of each primary parameter."""
    standard_error_v: float
    """S_E of TP (48), volts."""
    degrees_of_freedom: int
    sensitive_axis_v_per_g: tuple[float, float, float]
    fitted_v: FloatArray
    """(N,) in the order of the observations' rows."""
    residuals_v: FloatArray
    """(N,) observed minus fitted."""
    replication: Replication | None
    warnings: tuple[str, ...] = ()
    """What somebody must read before the result is used."""
    remarks: tuple[str, ...] = ()
    """What a reader should know and nobody needs to act upon."""
    variance_components: tuple[VarianceComponent, ...] = ()
    """They add up to ``primary_covariance``; Welch-Satterthwaite for any combination is made from them."""
    centring: Centring = ()
    """Of the extended model's terms (:mod:`ams.models.extended`); empty for every other model."""
    findings: tuple[Finding, ...] = ()
    """What was tested on the data of this axis; the significant ones stand among the warnings too."""
    notes: Mapping[str, object] = field(default_factory=dict)
    """Further results for the report (extended model's F-test, convergence, temperature)."""


@dataclass(frozen=True)
class PackageCovariance:
    """Covariance of the primary parameters of all axes of a package together.

    The axes share the table's indices, and often what a replication or a plateau does to the package: an inferred angle
    takes from several axes, and its uncertainty needs what they have in common.
    """

    order: tuple[tuple[str, str], ...]
    """(Q) sensor axis and primary parameter."""
    components: tuple[VarianceComponent, ...]
    """(Q, Q) independent parts; the diagonal blocks are the axes' own."""

    @property
    def covariance(self) -> FloatArray:
        """The (Q, Q) covariance of all parts together."""
        return np.asarray(sum(part.covariance for part in self.components))


SensorVerdict = Literal["sound", "usable", "not usable"]


@dataclass(frozen=True)
class Calibration:
    """All axes of one package, solved together from the same rows."""

    axes: Mapping[str, AxisCalibration]
    model: str
    convention: str
    """``TP`` (pitch-roll), ``CR`` (pitch-yaw-roll, gyro) or ``SR`` (straight lines)."""
    warnings: tuple[str, ...] = ()
    """Of every axis."""
    remarks: tuple[str, ...] = ()
    """Of every axis; a remark is no reservation."""
    package: PackageCovariance | None = None
    """None where there is one axis only."""

    @property
    def unusable_axes(self) -> Mapping[str, str]:
        """The axes of which nothing may be made, each with its sentence.

        Their sensitivity is not told from zero, they sense along another direction than the declared one, or they are
        clipped.
        """
        return {
            label: finding.text
            for label, axis in self.axes.items()
            for finding in axis.findings
            if leaves_nothing(finding)
        }

    @property
    def turns(self) -> tuple[Finding, ...]:
        """The findings that the table turned while it was measured, each once: what was solved mixes two mountings."""
        every = (finding for axis in self.axes.values() for finding in axis.findings)
        return tuple({finding.text: finding for finding in turned_the_table(every)}.values())

    @property
    def verdict(self) -> SensorVerdict:
        """``sound`` where nobody needs to read anything, ``usable`` where the warnings must be read.

        ``not usable`` where a finding says that the stated uncertainties do not hold what it found.
        """
        beyond = beyond_the_stated(finding for axis in self.axes.values() for finding in axis.findings)
        if self.unusable_axes or self.turns or beyond or not self.axes:
            return "not usable"
        is_reserved = self.warnings or any(axis.warnings for axis in self.axes.values())
        return "usable" if is_reserved else "sound"


def with_findings(calibration: Calibration, findings: Sequence[Finding]) -> Calibration:
    """Return a calibration with findings on every axis, the significant ones among the warnings."""
    if not findings:
        return calibration
    sentences = significant_texts(findings)
    axes = {
        label: replace(axis, findings=(*axis.findings, *findings), warnings=(*axis.warnings, *sentences))
        for label, axis in calibration.axes.items()
    }
    return replace(calibration, axes=axes, warnings=(*calibration.warnings, *sentences))
