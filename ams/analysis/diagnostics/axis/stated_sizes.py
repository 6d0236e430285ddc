"""How large what is told of an output is: beside all else that is told of it, and beside what the model has.

Each column is decided alone, and the first to be significant is known before the others are found. Its size at that
moment holds in part what they do: of a sensor with K_pp alone, K₂ and K_pp − K_oo are told, and the first of them was
off by half of the other. A term that is a parameter of the model is stated beside all of the model's terms, as the
parameters are.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import BeliefTest
from ams.analysis.diagnostics.low_order import TERMS
from ams.analysis.diagnostics.over_time.settling import Between
from ams.analysis.diagnostics.point_means import Elimination
from ams.analysis.diagnostics.replication_scatter import ReplicationScatter
from ams.analysis.diagnostics.tested_terms import tested_base
from ams.models.extended import ExtendedPitchRoll
from ams.models.gyro import GyroWithTerms
from ams.models.model import Model

_NAMES: Final = [name for name, *_ in TERMS]
_OF_ACCELEROMETERS: Final = tuple(map(_NAMES.index, ("K2", "Kpp", "Kip", "Kio", "Kpo", "K3")))
_OF_GYROS: Final = tuple(map(_NAMES.index, ("K2", "K3")))


def stated_sizes(
    made: Mapping[str, BeliefTest],
    names: Mapping[str, int],
    known: Sequence[str],
    scatter: ReplicationScatter,
    between: Between,
) -> dict[str, BeliefTest]:
    """Return the tests, of the ``known`` columns with sizes and uncertainties beside all others; chances as decided.

    ``names``: of the tests, to their columns.
    """
    modelled = _terms_of_model(scatter.evidence.models[scatter.output])
    found, known_columns = dict(made), [names[name] for name in known]
    for name in known:
        index = names[name]
        wanted = [*known_columns, *modelled] if index in modelled else known_columns
        beside = _independent(scatter.terms, [other for other in dict.fromkeys(wanted) if other != index])
        tested = scatter.terms.test(index, beside)
        if not np.isfinite(tested.p_value):
            continue
        size, uncertainty = tested.coefficient, tested.standard_uncertainty
        alone = made[name]._replace(size=size, uncertainty=uncertainty, dof=scatter.terms.dof)
        stated = between.with_means(scatter.referred(alone, index, beside))
        found[name] = stated._replace(p_value=made[name].p_value)
    return found


def _terms_of_model(model: Model) -> tuple[int, ...]:
    """Return the columns that stand in the model: quadratic terms before the cubic one, as it has them itself."""
    base = tested_base(model)
    if isinstance(base, ExtendedPitchRoll):
        return _OF_ACCELEROMETERS[: len(base.centring)]
    return _OF_GYROS[: len(base.centring)] if isinstance(base, GyroWithTerms) else ()


def _independent(terms: Elimination, columns: Sequence[int]) -> tuple[int, ...]:
    """Return the columns of which those before them leave something."""
    kept: tuple[int, ...] = ()
    for column in columns:
        if np.isfinite(terms.test(column, kept).p_value):
            kept = (*kept, column)
    return kept
