"""What a solution says whatever the moments of its dwells: an interrupted run has other ones than its brother."""

from collections.abc import Mapping
from typing import Any


def without_times(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sensors of a document without what is said of time and attitude: a pause parts the one from the other.

    Numbers, uncertainties, verdicts and all other findings stay.
    """
    return {
        name: {**sensor, "axes": {label: _axis(axis) for label, axis in sensor["axes"].items()}}
        for name, sensor in document.items()
    }


def _axis(axis: Mapping[str, Any]) -> dict[str, Any]:
    of_time = {found["text"] for found in axis["findings"] if found["kind"] == "time-confounded"}
    return {
        **axis,
        "findings": [found for found in axis["findings"] if found["text"] not in of_time],
        "warnings": [text for text in axis["warnings"] if text not in of_time],
    }
