"""From primary parameters to those that the files name, with covariance, effective degrees of freedom and intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.calibration_result import ParameterEstimate
from ams.models.model import Model
from ams.solve.components import ComponentColumns
from ams.statistics.intervals import combined_dof, t_quantile

_AZIMUTH = "azimuth_"
_HALF_TURN_DEG = 180.0


@dataclass(frozen=True)
class DerivedParameters:
    """The L parameters of m sensor axes in their edge units; NaN where one is undetermined."""

    names: tuple[str, ...]
    values: FloatArray
    """(m, L)"""
    standard_uncertainties: FloatArray
    """(m, L)"""
    tp_standard_uncertainties: FloatArray
    """(m, L) of the pooled form, TP (50)."""
    dof: FloatArray
    """(m, L) effective degrees of freedom; NaN where the uncertainty is zero."""
    halfwidths_95: FloatArray
    """(m, L) of the 95 % intervals."""
    covariance: FloatArray
    """(m, L, L), NaN rows and columns where a parameter is undetermined."""
    undetermined: tuple[Mapping[str, str], ...]
    """(m) undetermined parameters with the reason."""
    directions: FloatArray
    """(m, L, P) derivatives by the primary parameters."""
    primary_covariance: FloatArray
    """(m, P, P)"""
    primary_dof: FloatArray
    """(m, P) effective degrees of freedom of the primary parameters."""

    def estimates(self, row: int) -> tuple[ParameterEstimate, ...]:
        """Return the parameters of one sensor axis."""
        arrays = (
            self.values, self.standard_uncertainties, self.tp_standard_uncertainties, self.dof, self.halfwidths_95
        )  # fmt: skip
        columns = zip(self.names, *(array[row].tolist() for array in arrays), strict=True)
        null = self.undetermined[row]
        return tuple(
            ParameterEstimate(name, None, None, None, None, None) if name in null else _estimate(name, *numbers)
            for name, *numbers in columns
        )


def derive(
    models: Sequence[Model], primary: FloatArray, components: Sequence[ComponentColumns], tp_covariance: FloatArray
) -> DerivedParameters:
    """Propagate (m, P) primary estimates to first order; what their models say is undetermined becomes NaN."""
    primary_covariance = np.asarray(sum(component.covariance for component in components))
    rows = list(zip(models, primary, primary_covariance, strict=True))
    undetermined = tuple(model.undetermined(primary, covariance) for model, primary, covariance in rows)
    directions = np.array([model.parameters_jacobian(primary) for model, primary, _ in rows])
    values, names = _parameters(models, primary), models[0].parameter_names
    if any(undetermined):
        null = np.array([[name in reasons for name in names] for reasons in undetermined])
        directions[null] = np.nan
        values = np.where(null, np.nan, values)
    turned = np.swapaxes(directions, -1, -2)
    covariance = directions @ primary_covariance @ turned
    uncertainty = _root_of_diagonal(covariance)
    parts = np.array([component.covariance for component in components])
    variances = np.concatenate([_diagonal(directions @ parts @ turned), _diagonal(parts)], axis=-1)
    every_dof = combined_dof(variances, np.array([component.dof for component in components])[:, :, None])
    dof = every_dof[:, : len(names)]
    return DerivedParameters(
        names=names,
        values=values,
        standard_uncertainties=uncertainty,
        tp_standard_uncertainties=_root_of_diagonal(directions @ tp_covariance @ turned),
        dof=dof,
        halfwidths_95=halfwidths_95(names, t_quantile(0.95, dof) * uncertainty),
        covariance=covariance,
        undetermined=undetermined,
        directions=directions,
        primary_covariance=primary_covariance,
        primary_dof=every_dof[:, len(names) :],
    )


def _parameters(models: Sequence[Model], primary: FloatArray) -> FloatArray:
    """Return the (m, L) parameters at one stroke for every model that several rows have."""
    rows_of: dict[int, list[int]] = {}
    for index, model in enumerate(models):
        rows_of.setdefault(id(model), []).append(index)
    values = np.empty((len(models), len(models[0].parameter_names)))
    for rows in rows_of.values():
        values[rows] = models[rows[0]].parameters(primary[rows])
    return values


def halfwidths_95(names: Sequence[str], propagated: FloatArray) -> FloatArray:
    """Return the (…, L) half-widths, Student's factor times the standard uncertainty.

    An azimuth's as it is, the others as to first order.

    A vector of length a across the axis turns by δ under an error h of its own that stands across it, a·sin δ = h
    (Fieller). At five standard uncertainties that is a twentieth more; to first order 94 % would hold the truth.
    """
    azimuths = [index for index, name in enumerate(names) if name.startswith(_AZIMUTH)]
    if not azimuths:
        return propagated
    halves, share = propagated.copy(), np.deg2rad(propagated[..., azimuths])
    halves[..., azimuths] = np.where(share >= 1.0, _HALF_TURN_DEG, np.rad2deg(np.arcsin(np.minimum(share, 1.0))))
    return halves


def _diagonal(covariance: FloatArray) -> FloatArray:
    return covariance.diagonal(axis1=-2, axis2=-1)


def _root_of_diagonal(covariance: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.maximum(_diagonal(covariance), 0.0)))


def _estimate(
    name: str, value: float, uncertainty: float, tp_uncertainty: float, dof: float, half: float
) -> ParameterEstimate:
    if uncertainty == 0.0:
        return ParameterEstimate(name, value, 0.0, tp_uncertainty, None, (value, value))
    return ParameterEstimate(name, value, uncertainty, tp_uncertainty, dof, (value - half, value + half))
