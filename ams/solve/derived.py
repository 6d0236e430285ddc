"""From primary parameters to those that the files name, with covariance, effective degrees of freedom and intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.models.model import Model
from ams.solve.result import ParameterEstimate, VarianceComponent
from ams.uncertainty.intervals import effective_dof, t_quantile

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class DerivedParameters:
    """The parameters of one sensor axis in their edge units."""

    estimates: tuple[ParameterEstimate, ...]
    covariance: FloatArray
    """(L, L), NaN rows and columns where a parameter is null."""
    undetermined: Mapping[str, str]
    """Null parameters with the reason."""
    directions: FloatArray
    """(L, P) derivatives by the primary parameters, NaN where a parameter is null."""


def derive(
    model: Model, primary: FloatArray, components: Sequence[VarianceComponent], tp_covariance: FloatArray
) -> DerivedParameters:
    """Propagate to first order; what the model says is undetermined becomes null."""
    primary_covariance = np.asarray(sum(component.covariance for component in components))
    undetermined = model.undetermined(primary, primary_covariance)
    directions = model.parameters_jacobian(primary)
    null = np.array([name in undetermined for name in model.parameter_names])
    directions[null] = np.nan
    covariance = directions @ primary_covariance @ directions.T
    known = np.nan_to_num(directions, nan=0.0)
    tp_uncertainty = np.sqrt(np.einsum("mi,ij,mj->m", known, tp_covariance, known))
    columns = zip(
        model.parameter_names,
        model.parameters(primary),
        np.sqrt(np.maximum(np.diag(covariance), 0.0)),
        tp_uncertainty,
        effective_dof(known, components),
        strict=True,
    )
    estimates = tuple(
        _null(name) if name in undetermined else _estimate(name, *map(float, values)) for name, *values in columns
    )
    return DerivedParameters(estimates, covariance, undetermined, directions)


def _null(name: str) -> ParameterEstimate:
    return ParameterEstimate(name, None, None, None, None, None)


def _estimate(name: str, value: float, uncertainty: float, tp_uncertainty: float, dof: float) -> ParameterEstimate:
    if uncertainty == 0.0:
        return ParameterEstimate(name, value, 0.0, tp_uncertainty, None, (value, value))
    half = float(t_quantile(0.95, dof)) * uncertainty
    return ParameterEstimate(name, value, uncertainty, tp_uncertainty, dof, (value - half, value + half))
