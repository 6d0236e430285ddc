"""Which replications can stand alone, and which are stubs of a run that was cut short."""

import numpy as np

from ams.arrays import BoolArray
from ams.inputs.request import select_rows
from ams.models.model import Model, Stimulus
from ams.observations import Observations
from ams.solve.layout import Layout


def standing_rows(observations: Observations, layout: Layout, model: Model) -> tuple[BoolArray, tuple[str, ...]]:
    """Return the (N,) rows of the replications that can be solved alone, and a warning for each that is left out.

    Where no replication stands alone every row is kept: then nothing is to be said about replication anyway.
    """
    labels = layout.replication_labels
    everything: BoolArray = np.ones(observations.rows, dtype=bool)
    if layout.is_complete or len(labels) == 1 or model.basis_key is None:
        return everything, ()
    largest = int(np.bincount(layout.replication).max())
    kept, warnings = everything.copy(), []
    for label in labels:
        here = observations.replication == label
        count = int(here.sum())
        if count < largest and not _stands(model, select_rows(observations, here)):
            kept &= ~here
            warnings.append(f"replication {label} has only {count} points, too few to stand alone: left out")
    return (kept, tuple(warnings)) if kept.any() else (everything, ())


def _stands(model: Model, stimulus: Stimulus) -> bool:
    basis = model.basis(stimulus)
    length = np.linalg.norm(basis, axis=0)
    if basis.shape[0] <= basis.shape[1] or not length.all():
        return False
    return bool(np.linalg.matrix_rank(basis / length, rtol=1e-6) == basis.shape[1])
