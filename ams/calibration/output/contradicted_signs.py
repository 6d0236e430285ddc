"""Whether other signs or another order of the angles, or other readings of a replication, are asked for at all.

And what they say of the axes of a package.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ams.analysis.diagnostics.declared.declared_signs import Package, judge_signs
from ams.analysis.diagnostics.declared.mistaken_replications import TRIED_FROM, mistaken_replications
from ams.calibration.solving.columns import SolvedColumns
from ams.calibration.solving.model_choice import base_model
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest, select_rows
from ams.observations import Observations
from ams.solve.layout import layout_of

_LEVEL: Final = 1e-3
"""Of the lack of fit of one output, beyond which other angles are tried."""
_LARGE: Final = 2e-5
"""Of the sensitivity: a lack of fit below four seconds of arc is of the table, and no sign explains it."""


def contradicted_signs(
    rows: Observations, solved: Sequence[SolvedColumns], labels: Sequence[str], request: CalibrationRequest
) -> Mapping[str, Sequence[Finding]]:
    """Return by axis what says that angles or outputs have another sign or order than declared.

    ``solved``: the groups of the package's axes.
    """
    found = judge_signs(_package(rows, labels, request), lacks_fit=any(map(_lacks_fit, solved)))
    return {label: (finding,) for label, finding in found.items()}


def with_readings_put_right(
    rows: Observations, solved: Sequence[SolvedColumns], labels: Sequence[str], request: CalibrationRequest
) -> tuple[Observations, Mapping[str, Sequence[Finding]]]:
    """Return the rows with readings that stand under another output or attitude put right, and by axis what says so."""
    if not any(map(_scatters_widely, solved)):
        return rows, {}
    found: dict[str, list[Finding]] = {}
    kept = np.ones(rows.rows, dtype=bool)
    for mistaken in mistaken_replications(_package(rows, labels, request)):
        rows, has_reading = mistaken.put_right(rows)
        kept &= has_reading
        for label in mistaken.labels:
            found.setdefault(label, []).append(mistaken.finding)
    return rows if kept.all() else select_rows(rows, kept), found


def _package(rows: Observations, labels: Sequence[str], request: CalibrationRequest) -> Package:
    models = [base_model(label, rows, request) for label in labels]
    declared = [request.declared_of(label, model.nominal_axis) for label, model in zip(labels, models, strict=True)]
    return Package(rows, layout_of(rows), labels, models, declared)


def _scatters_widely(solved: SolvedColumns) -> bool:
    """Return whether a dwell is so far from the fit that readings may stand under another output or attitude."""
    length = np.linalg.norm(solved.primary[:, 1:4], axis=1)
    return bool(np.any(solved.standard_error_v > TRIED_FROM * length))


def _lacks_fit(solved: SolvedColumns) -> bool:
    """Return whether an output repeats what its model does not have; one replication never tells."""
    if solved.replication is None:
        return True
    left = np.sqrt(solved.mixed.lack_of_fit_variance)
    length = np.linalg.norm(solved.primary[:, 1:4], axis=1)
    return bool(np.any((solved.replication.lack_of_fit.p_value < _LEVEL) & (left > _LARGE * length)))
