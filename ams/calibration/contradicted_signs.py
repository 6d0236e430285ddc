"""Whether signs or the order of the angles are asked for at all, and what they say of the axes of a package."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ams.analysis.diagnostics.declared_signs import Package, judge_signs
from ams.calibration.columns import SolvedColumns
from ams.calibration.model_choice import base_model
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.solve.layout import layout_of

_LEVEL: Final = 1e-3
"""Of the lack of fit of one output, beyond which other angles are tried."""
_LARGE: Final = 2e-5
"""Of the sensitivity: a lack of fit below four seconds of arc is of the table, and no sign explains it."""


def contradicted_signs(
    rows: Observations, solved: Sequence[SolvedColumns], labels: Sequence[str], request: CalibrationRequest
) -> Mapping[str, Finding]:
    """Return by axis what says that angles or outputs have another sign or order than declared.

    ``solved``: the groups of the package's axes.
    """
    models = [base_model(label, rows, request) for label in labels]
    declared = [request.declared_of(label, model.nominal_axis) for label, model in zip(labels, models, strict=True)]
    package = Package(rows, layout_of(rows), labels, models, declared)
    return judge_signs(package, lacks_fit=any(map(_lacks_fit, solved)))


def _lacks_fit(solved: SolvedColumns) -> bool:
    """Return whether an output repeats what its model does not have; one replication never tells."""
    if solved.replication is None:
        return True
    left = np.sqrt(solved.mixed.lack_of_fit_variance)
    length = np.linalg.norm(solved.primary[:, 1:4], axis=1)
    return bool(np.any((solved.replication.lack_of_fit.p_value < _LEVEL) & (left > _LARGE * length)))
