"""What needs no test: what the attitudes and their order cannot tell."""

from collections.abc import Iterator

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.time_order import LARGEST_CORRELATION, confounding
from ams.arrays import FloatArray
from ams.findings import Finding
from ams.models.model import Model
from ams.models.thermal import TEMPERATURE_NAMES

_TOLD_APART = 2.0
"""Standard uncertainties: with two replications Student's factor would call every sensor undetermined."""
_LINEAR = 4
"""Columns of a linear sensor: offset and three sensitivities."""


def undetermined_axis(model: Model, primary: FloatArray, covariance: FloatArray) -> Iterator[Finding]:
    """Yield a finding where the sensitivity along the nominal axis is not told from zero."""
    name = next((one for one in model.primary_names if one.startswith(f"k_{model.nominal_axis}_")), None)
    if name is None:
        return
    place = model.primary_names.index(name)
    k, u = float(primary[place]), float(np.sqrt(max(covariance[place, place], 0.0)))
    if not abs(k) <= _TOLD_APART * u:
        return
    unit = "V/(°/s)" if name.endswith("_dps") else "V/g"
    text = (
        f"the sensitivity along the nominal axis {model.nominal_axis} is not told from zero: {k:.3g} {unit} with a "
        f"standard uncertainty of {u:.2g} {unit}: what was visited does not change what this axis senses, or the "
        "channel is dead; the result is not usable and there is no coefficient set; add attitudes that change it, or "
        "leave this axis out"
    )
    yield Finding("axis-undetermined", text, True, None, details={"sensitivity": k, "standard_uncertainty": u})


def time_confounded(evidence: Evidence) -> Iterator[Finding]:
    """Yield a finding on the order of the points, where times and enough points are there."""
    r = confounding(evidence, evidence.basis[:, :_LINEAR], evidence.rows.time_s)
    if r is None:
        return
    is_confounded = r > LARGEST_CORRELATION
    text = (
        f"time and attitude go together inside the replications (correlation {r:.2f}, allowed "
        f"{LARGEST_CORRELATION:g}): a drift within a replication would pass for offset and sensitivity and is not in "
        "the uncertainties; use an order such as there-and-back"
        if is_confounded
        else f"time and attitude: correlation {r:.2f} inside the replications, allowed {LARGEST_CORRELATION:g}"
    )
    yield Finding(
        "time-confounded", text, is_confounded, None, details={"test": "time with attitude", "correlation": r}
    )


def temperature_confounded(evidence: Evidence) -> Iterator[Finding]:
    """Yield a finding where the recorded temperature, which is not modelled, goes with the attitude."""
    if TEMPERATURE_NAMES[0] in evidence.models[0].primary_names:
        return
    r = confounding(evidence, evidence.basis[:, :_LINEAR], evidence.rows.temperature_degc)
    if r is None or not r > LARGEST_CORRELATION:
        return
    text = (
        f"the recorded temperature goes with the attitude inside the replications (correlation {r:.2f}, allowed "
        f"{LARGEST_CORRELATION:g}): what it does to the sensor passes for offset and sensitivity, and no temperature "
        "is modelled; hold the temperature, take another order of the points, or apply known temperature coefficients"
    )
    details: dict[str, float | str | None] = {"test": "temperature with attitude", "correlation": r}
    yield Finding("temperature-residual", text, True, None, details=details)
