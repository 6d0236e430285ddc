"""What comes back with every replication, or every row, and hides in the model: where the order is always the same.

Of a wave over the dwells of a replication, or of each of its rows, a part goes with the terms of the model. It is in
offset and sensitivities, alike in every replication, so that no residual shows it and no scatter holds it; of its size
nothing is known, so that no uncertainty does (:mod:`ams.calibration.together.in_step` asks for the rest of it).
Source: decisions 105, 133 and 138.
"""

from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.calibration.together.in_step_found import WAVES
from ams.observations import Observations
from ams.remembered import remembered
from ams.solve.dwell_order import attitudes_repeat, moves_of_slower_axes, order_repeats, rows_in_time
from ams.solve.layout import Layout

SAME_ORDER: Final = "the order of the points is the same in every replication"
"""How the remark begins."""
PASSES_FOR_TERMS: Final = 0.5
"""Correlation from which on it is said."""
_SHORTEST_ROW: Final = 3.0
"""Dwells to a move of the slower axis, on average."""
_ROUNDING: Final = 1e-9
"""Of the largest singular value: a term that the others span."""


@remembered(16)
def in_step_correlation(terms: FloatArray) -> float:
    """Return the largest correlation of what comes back in every replication with the terms of the model.

    Over all phases of one, two and three periods. ``terms``: (K, P) at the points, in the order in which every
    replication visits them.
    """
    spanned = _spanned(terms)
    phase = 2.0 * np.pi * np.arange(len(terms)) / len(terms)
    waves = (np.linalg.qr(np.stack([np.cos(n * phase), np.sin(n * phase)], axis=1))[0] for n in range(1, WAVES + 1))
    return max(float(np.linalg.norm(spanned.T @ wave, 2)) for wave in waves)


@remembered(16)
def row_correlation(terms: FloatArray, pitch_rad: FloatArray, roll_rad: FloatArray) -> tuple[float, int]:
    """Return the largest correlation of what comes back with every row with the terms of the model; and its dwells.

    A row ends where the axis moves that moves less often. What comes back is a wave of one row's length at its worst
    phase, or an even course from its first dwell to its last. ``terms``: (K, P) at the points, ``pitch_rad`` and
    ``roll_rad`` (K,), all as every replication visits them. (0, 0) where an order has no rows.
    """
    row = np.concatenate([[0], np.cumsum(moves_of_slower_axes(pitch_rad, roll_rad))])
    lengths = np.bincount(row)
    longest = int(lengths.max())
    if len(terms) < _SHORTEST_ROW * lengths.size or lengths.size == 1:
        return 0.0, 0
    turn = np.arange(row.size) - (np.cumsum(lengths) - lengths)[row]
    phase = 2.0 * np.pi * turn / lengths[row]
    course = turn / np.maximum(lengths[row] - 1, 1) - 0.5
    spanned = _spanned(terms)
    wave = np.linalg.qr(np.stack([np.cos(phase), np.sin(phase)], axis=1))[0]
    even = float(np.linalg.norm(spanned.T @ course) / np.linalg.norm(course))
    return max(float(np.linalg.norm(spanned.T @ wave, 2)), even), longest


def _spanned(terms: FloatArray) -> FloatArray:
    left, sizes, _ = np.linalg.svd(terms / np.linalg.norm(terms, axis=0).clip(1e-300), full_matrices=False)
    return np.asarray(left[:, sizes > _ROUNDING * sizes.max()])


def hidden_in_step(rows: Observations, layout: Layout, terms: FloatArray) -> tuple[str, ...]:
    """Return the remark on an order that repeats; nothing where it does not, or where no times tell the order.

    ``terms``: (N, P) of the linear sensor at every row.
    """
    if rows.time_s is None or layout.replications == 1 or rows.pitch_rad is None or rows.roll_rad is None:
        return ()
    order = rows_in_time(rows.time_s, layout.rows)
    if not (attitudes_repeat(layout, rows.pitch_rad, rows.roll_rad) and order_repeats(order, layout)):
        return ()
    visited = order[layout.replication[order] == 0]
    hidden = hidden_in_words(terms[visited], rows.pitch_rad[visited], rows.roll_rad[visited])
    if not hidden:
        return ()
    return (f'{SAME_ORDER}: {hidden}; another order in every replication (order = "neighbours") turns it into noise',)


def hidden_in_words(terms: FloatArray, pitch_rad: FloatArray, roll_rad: FloatArray) -> str:
    """Return what an order that repeats hides: (K, P) terms and (K,) angles as it visits them; empty where little."""
    share, (row_share, dwells) = in_step_correlation(terms), row_correlation(terms, pitch_rad, roll_rad)
    hidden = []
    if share >= PASSES_FOR_TERMS:
        hidden.append(
            "what comes back with each (hum of the mains that beats with the readings, a chamber or an air "
            f"conditioning that cycles) can pass for offset and sensitivities (correlation up to {share:.2f})"
        )
    if row_share >= PASSES_FOR_TERMS:
        hidden.append(
            f"what comes back with every row of {dwells} dwells (a cable that winds up and is let go, a chamber that "
            f"cycles once a row) can pass for offset and sensitivities (correlation up to {row_share:.2f})"
        )
    if not hidden:
        return ""
    return f"{', '.join(hidden)}; no test shows that part, and no uncertainty counts it"
