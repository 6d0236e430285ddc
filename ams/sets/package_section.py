"""What the axes of a package have in common, as the document's section ``package``.

An angle inferred from several axes needs their covariance together: the table's indices, a replication's disturbance
and the meter's zero are one and the same for all. Sets of one axis, and those written before 0.2, have no section;
there the axes count as independent. A drift with time is not in it: a set stands at its reference time.
"""

import numpy as np

from ams.calibration_result import PackageCovariance
from ams.models.drifting import DRIFT_NAME
from ams.sets.canonical import Document, Json, table

TEXT = (
    "order: axis.parameter; components: independent parts of the covariance of all primary parameters together, whose "
    "diagonal blocks are the axes' own"
)


def package_section(package: PackageCovariance) -> Document:
    """Return the section of a package of two axes or more."""
    kept = [index for index, (_, name) in enumerate(package.order) if name != DRIFT_NAME]
    square = np.ix_(kept, kept)
    return {
        "order": [".".join(package.order[index]) for index in kept],
        "components": {
            part.name: {
                "covariance": [[_number(value) for value in row] for row in part.covariance[square].tolist()],
                "degrees_of_freedom": _number(part.dof),
            }
            for part in package.components
        },
        "text": TEXT,
    }


def package_of(document: Document) -> Document | None:
    """Return the section ``package``, None where the set has none."""
    section = document.get("package")
    return None if section is None else table(section)


def _number(value: float) -> Json:
    return float(value) if np.isfinite(value) else None
