"""Sensor axes as y = basis·(free primary parameters): exactly, or at the solution of their own iteration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.errors import DesignError, SolveError
from ams.frames import Attitude
from ams.models.drifting import DRIFT_NAME
from ams.models.model import Model, Stimulus
from ams.models.remounted import is_of_a_mounting
from ams.models.thermal import SECOND_ORDER_NAMES, TEMPERATURE_NAMES
from ams.observations import Observations, Sampled
from ams.remembered import known, remembered
from ams.solve.gauss_newton import Convergence, gauss_newton
from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm, factor

SHARED = MappingProxyType(
    {
        **dict.fromkeys(TEMPERATURE_NAMES, ("temperature_degc", 1)),
        **dict.fromkeys(SECOND_ORDER_NAMES, ("temperature_degc", 2)),
        DRIFT_NAME: ("time_s", 1),
    }
)
"""Parameters that are seen across replications, not in each of them, with the column of the rows and its power that
they go with."""


_NEVER_ALIKE = ("time_s", "temperature_degc", "scanned_v")
_RATES = "euler_rate_rad_s"


def is_shared(name: str) -> bool:
    """Return whether a parameter is seen across replications only."""
    return name in SHARED or is_of_a_mounting(name)


@dataclass(frozen=True)
class Linearised:
    """m sensor axes of the same rows; their models differ at most in the nominal axis."""

    models: tuple[Model, ...]
    """(m)"""
    form: LinearForm
    alone: LinearForm
    """The part that a replication determines by itself; the same object as ``form`` where that is all."""
    outputs: FloatArray
    """(N, m) less what the fixed parameters do."""
    convergence: Convergence | None
    block: Attitude
    """What the rows were exposed to; the first rows only where the basis repeats."""
    time_s: FloatArray | None = None
    """(N,) when the rows were taken, or None."""
    sampled: Sequence[Sampled | None] = ()
    """(m) what the samples of every output show; empty, or None, where the outputs are single readings."""

    @property
    def model(self) -> Model:
        return self.models[0]

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Places of the free primary parameters."""
        return _free(self.model)

    def basis_at_points(self, layout: Layout) -> FloatArray:
        """Return (K, P) of what a replication determines by itself."""
        return self.alone.block if self.alone.repeats > 1 else layout.mean_by_point(self.alone.basis)

    def complete(self, free_values: FloatArray) -> FloatArray:
        """Return the (…, P) primary parameters from the free ones: the fixed ones put in their places."""
        return _complete(self.model, self.free, free_values)

    def placed(self, free_covariance: FloatArray) -> FloatArray:
        """Return (…, P, P) from (…, F, F): fixed parameters have none."""
        size = len(self.model.primary_names)
        if self.free.size == size:
            return free_covariance
        covariance = np.zeros((*free_covariance.shape[:-2], size, size))
        covariance[..., self.free[:, None], self.free] = free_covariance
        return covariance


def linearise(
    models: Sequence[Model],
    rows: Observations,
    layout: Layout,
    outputs: FloatArray,
    weights: FloatArray | None,
    sampled: Sequence[Sampled | None] = (),
) -> Linearised:
    """Linearise models alike but for the nominal axis and their (N, m) outputs.

    It is one axis at a time where there is no basis. ``sampled`` goes with the outputs: see :class:`Linearised`.

    Raises:
        DesignError: too few rows, or the points leave a direction of the parameters undetermined.
        SolveError: the iteration of a model that is not linear did not converge.
    """
    model, free = models[0], _free(models[0])
    if rows.rows == free.size:
        raise DesignError(
            f"{rows.source}: {rows.rows} observations determine {free.size} parameters and leave nothing to judge the "
            f"error by: allowed {free.size + 1} or more; nothing was solved; add points or replications"
        )
    names = [model.primary_names[i] for i in free]
    convergence, stimulus, times = None, _stimulus(rows), 1
    if model.basis_key is None:
        assert len(models) == 1
        basis, outputs, convergence = _at_solution(model, free, names, rows, outputs[:, 0], weights)
    else:
        first = _first(stimulus, layout) if weights is None else None
        block = None if first is None else _block(model, stimulus, first, layout)
        if first is not None and block is not None:
            stimulus, times = first, layout.replications
        basis = model.basis(stimulus) if block is None else known(block)
        if model.fixed:
            outputs = outputs - model.predict(_complete(model, free, np.zeros(free.size)), rows)[:, None]
    form = factor(basis, names, stimulus, weights, times)
    unshared = free.size - sum(is_shared(name) for name in names)
    alone = form if unshared == free.size else factor(basis[:, :unshared], names[:unshared], stimulus, weights, times)
    return Linearised(tuple(models), form, alone, outputs, convergence, stimulus, rows.time_s, sampled)


def _stimulus(rows: Observations) -> Attitude:
    return Attitude(**{entry.name: getattr(rows, entry.name) for entry in fields(Attitude)})


def _columns(stimulus: Attitude) -> dict[str, NDArray[Any]]:
    everything = {entry.name: getattr(stimulus, entry.name) for entry in fields(stimulus)}
    return {name: values for name, values in everything.items() if values is not None}


def _block(model: Model, stimulus: Attitude, first: Attitude, layout: Layout) -> FloatArray | None:
    """Return the basis of the points where it is the same in every replication."""
    if stimulus.time_s is None and stimulus.temperature_degc is None:
        return model.basis(first)
    return layout.block(model.basis(stimulus))


def _first(stimulus: Attitude, layout: Layout) -> Attitude | None:
    """Return the rows of the first replication, of what repeats as it is known.

    None where not every replication has the same points in order at exactly the same stimulus. Time and temperature
    never repeat; where they matter the basis does not either.
    """
    if not layout.is_complete or layout.order is not None:
        return None
    return _first_of(layout, **_columns(stimulus))


@remembered(16)
def _first_of(layout: Layout, **given: NDArray[Any]) -> Attitude | None:
    """Return the same of the columns that are given, replication below replication."""
    first = {}
    left_out = () if _RATES in given else _NEVER_ALIKE  # gyros stay on their rows, for their stored numbers
    for name, values in given.items():
        block = layout.block(values)
        if block is None and name not in left_out:
            return None
        first[name] = values[: layout.points].copy() if block is None else block
    return Attitude(**first)


def shared_regressors(model: Model, rows: Observations) -> tuple[FloatArray, ...]:
    """Return the (N,) columns of the rows for estimated parameters that no replication determines by itself."""
    columns = {SHARED[name] for name in model.primary_names if name in SHARED and name not in model.fixed}
    shared = [_about_its_mean(getattr(rows, column)) ** power for column, power in sorted(columns)]
    if rows.mounting is not None and any(map(is_of_a_mounting, model.primary_names)):
        shared += [(rows.mounting == label).astype(float) for label in np.unique(rows.mounting)[:-1]]
    return tuple(shared)


def _about_its_mean(column: FloatArray) -> FloatArray:
    return np.asarray(column - column.mean())


def _free(model: Model) -> NDArray[np.intp]:
    return np.array([i for i, name in enumerate(model.primary_names) if name not in model.fixed])


def _complete(model: Model, free: NDArray[np.intp], values: FloatArray) -> FloatArray:
    fixed: Mapping[str, tuple[float, float]] = model.fixed
    if not fixed:
        return values
    primary = np.empty((*values.shape[:-1], len(model.primary_names)))
    primary[..., free] = values
    for name, (value, _) in fixed.items():
        primary[..., model.primary_names.index(name)] = value
    return primary


def _at_solution(
    model: Model,
    free: NDArray[np.intp],
    names: list[str],
    rows: Stimulus,
    output_v: FloatArray,
    weights: FloatArray | None,
) -> tuple[FloatArray, FloatArray, Convergence]:
    """Iterate by Gauss-Newton, TP (43) to (50), from the model's own start.

    The rest of the story is told at its answer.
    """
    result = gauss_newton(
        lambda values: model.predict(_complete(model, free, values), rows),
        lambda values: model.jacobian(_complete(model, free, values), rows)[:, free],
        model.start(rows, output_v)[free],
        output_v,
        names,
        None if weights is None else 1.0 / weights,
    )
    if result.convergence.reason == "iterations":
        raise SolveError(
            f"Gauss-Newton: {model.name} with {', '.join(names)}: no convergence in {result.convergence.iterations} "
            f"iterations: last step {result.convergence.last_step_in_standard_uncertainties:.2g} "
            "standard uncertainties, allowed 1e-6; nothing is reported; look at the residuals for a wrong row"
        )
    basis = model.jacobian(_complete(model, free, result.estimate), rows)[:, free]
    return basis, (result.residuals + basis @ result.estimate)[:, None], result.convergence
