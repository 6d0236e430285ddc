"""What comes back with every replication and hides in the model: where the order of the points is always the same.

Of a wave over the dwells of a replication a part goes with the terms of the model. It is in offset and sensitivities,
alike in every replication, so that no residual shows it and no scatter holds it; of its size nothing is known, so that
no uncertainty does (:mod:`ams.calibration.together.in_step` asks for the rest of it). Source: decisions 105 and 133.
"""

from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.calibration.together.in_step_found import WAVES
from ams.observations import Observations
from ams.remembered import remembered
from ams.solve.dwell_order import attitudes_repeat, order_repeats, rows_in_time
from ams.solve.layout import Layout

SAME_ORDER: Final = "the order of the points is the same in every replication"
"""How the remark begins."""
PASSES_FOR_TERMS: Final = 0.5
"""Correlation from which on it is said."""
_ROUNDING: Final = 1e-9
"""Of the largest singular value: a term that the others span."""


@remembered(16)
def in_step_correlation(terms: FloatArray) -> float:
    """Return the largest correlation of what comes back in every replication with the terms of the model.

    Over all phases of one, two and three periods. ``terms``: (K, P) at the points, in the order in which every
    replication visits them.
    """
    left, sizes, _ = np.linalg.svd(terms / np.linalg.norm(terms, axis=0).clip(1e-300), full_matrices=False)
    spanned = left[:, sizes > _ROUNDING * sizes.max()]
    phase = 2.0 * np.pi * np.arange(len(terms)) / len(terms)
    waves = (np.linalg.qr(np.stack([np.cos(n * phase), np.sin(n * phase)], axis=1))[0] for n in range(1, WAVES + 1))
    return max(float(np.linalg.norm(spanned.T @ wave, 2)) for wave in waves)


def hidden_in_step(rows: Observations, layout: Layout, terms: FloatArray) -> tuple[str, ...]:
    """Return the remark on an order that repeats; nothing where it does not, or where no times tell the order.

    ``terms``: (N, P) of the linear sensor at every row.
    """
    if rows.time_s is None or layout.replications == 1 or rows.pitch_rad is None or rows.roll_rad is None:
        return ()
    order = rows_in_time(rows.time_s, layout.rows)
    if not (attitudes_repeat(layout, rows.pitch_rad, rows.roll_rad) and order_repeats(order, layout)):
        return ()
    share = in_step_correlation(terms[order[layout.replication[order] == 0]])
    if share < PASSES_FOR_TERMS:
        return ()
    return (
        f"{SAME_ORDER}: {hidden_in_words(share)}; another order in every replication makes noise of it "
        '(order = "neighbours")',
    )


def hidden_in_words(share: float) -> str:
    """Return what an order that repeats hides by such a correlation."""
    return (
        "what comes back with each (hum of the mains that beats with the readings, a chamber or an air conditioning "
        f"that cycles) can go with offset and sensitivities by {share:.2f}, and no test and no uncertainty has that "
        "part"
    )
