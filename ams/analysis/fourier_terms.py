"""The largest Fourier terms in α and R of what repeats in the residuals: harmonics 1 and 2 of each, and their products.

The mean residuals of the points are searched forwards: the term that takes away most of their sum of squares, beside
the model's own parameters and the terms found before, is taken as long as it is significant among all that were tried.
Amplitudes are fitted together with the model's parameters, so a term that the model half imitates is given whole.
Source: TP 9.2, figures 37 to 41.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.statistics.intervals import f_test, t_quantile

_INDEPENDENT = 1e-6
"""Of a term's own length: what must be left of it beside the model for it to be told from the model."""
_TIE = 1e-9
"""Of a gain: equal but for rounding, and then the first term is taken."""


@dataclass(frozen=True)
class FourierTerm:
    """One term, amplitude times product of a function of α and a function of R."""

    name: str
    """Such as ``sin 2α`` or ``sin 2α·cos R``."""
    amplitude_v: float
    interval_95_v: tuple[float, float]


def fourier_basis(pitch_rad: FloatArray, roll_rad: FloatArray) -> Mapping[str, FloatArray]:
    """Return the values of every term at attitudes (K,), the simplest first; the constant is not among them."""
    of_pitch, of_roll = _harmonics(pitch_rad, "α"), _harmonics(roll_rad, "R")
    products = {
        "·".join(part for part in (first, second) if part): a * b
        for first, a in of_pitch.items()
        for second, b in of_roll.items()
        if first or second
    }
    return dict(sorted(products.items(), key=lambda item: item[0].count("·")))


def _harmonics(angle_rad: FloatArray, symbol: str) -> Mapping[str, FloatArray]:
    return {
        "": np.ones_like(angle_rad),
        f"sin {symbol}": np.sin(angle_rad),
        f"cos {symbol}": np.cos(angle_rad),
        f"sin 2{symbol}": np.sin(2.0 * angle_rad),
        f"cos 2{symbol}": np.cos(2.0 * angle_rad),
    }


def largest_terms(
    residuals_v: FloatArray, model_basis: FloatArray, candidates: Mapping[str, FloatArray], most: int
) -> tuple[FourierTerm, ...]:
    """Return at most ``most`` terms of (K,) residuals, largest first, beside a (K, P) basis of the model's parameters.

    A term is taken where its F test passes at 5 % divided by the number of terms tried (Bonferroni).
    """
    chosen: list[str] = []
    model_columns = _orthonormal(model_basis)
    while len(chosen) < most:
        left = residuals_v - model_columns @ (model_columns.T @ residuals_v)
        free = {
            name: column - model_columns @ (model_columns.T @ column)
            for name, column in candidates.items()
            if name not in chosen
        }
        name, gain = _best(free, candidates, left)
        dof = residuals_v.size - model_columns.shape[1] - 1
        rest = float(left @ left) - gain
        if not name or dof < 1 or rest <= 0.0:
            break
        if f_test(gain / (rest / dof), 1, dof).p_value * len(free) > 0.05:
            break
        chosen.append(name)
        column = free[name] / np.linalg.norm(free[name])
        model_columns = np.column_stack([model_columns, column - model_columns @ (model_columns.T @ column)])
    return _fitted(residuals_v, model_basis, {name: candidates[name] for name in chosen})


def _best(free: Mapping[str, FloatArray], candidates: Mapping[str, FloatArray], left: FloatArray) -> tuple[str, float]:
    """Return the term that takes away most; of several that take the same (few roll angles), the simplest."""
    best, most = "", 0.0
    for name, column in free.items():
        length = float(np.linalg.norm(column))
        if length <= _INDEPENDENT * float(np.linalg.norm(candidates[name])):
            continue
        gain = float(column @ left / length) ** 2
        if gain > most * (1.0 + _TIE):
            best, most = name, gain
    return best, most


def _fitted(
    residuals_v: FloatArray, model_basis: FloatArray, columns: Mapping[str, FloatArray]
) -> tuple[FourierTerm, ...]:
    if not columns:
        return ()
    model_columns = _orthonormal(model_basis)
    block = np.stack(list(columns.values()), axis=1)
    block = block - model_columns @ (model_columns.T @ block)
    left = residuals_v - model_columns @ (model_columns.T @ residuals_v)
    amplitudes = np.linalg.lstsq(block, left, rcond=None)[0]
    rest = left - block @ amplitudes
    dof = residuals_v.size - model_columns.shape[1] - len(columns)
    variance = float(rest @ rest) / dof * np.diag(np.linalg.inv(block.T @ block))
    halves = float(t_quantile(0.95, dof)) * np.sqrt(variance)
    terms = [
        FourierTerm(name, float(amplitude), (float(amplitude - half), float(amplitude + half)))
        for name, amplitude, half in zip(columns, amplitudes, halves, strict=True)
    ]
    return tuple(sorted(terms, key=lambda term: -abs(term.amplitude_v)))


def _orthonormal(basis: FloatArray) -> FloatArray:
    """Return the orthonormal columns that span those of the basis, as many as there are independent ones."""
    length = np.linalg.norm(basis, axis=0)
    u, singular, _ = np.linalg.svd(basis / np.where(length > 0.0, length, 1.0), full_matrices=False)
    return np.asarray(u[:, singular > 1e-9 * singular[0]])
