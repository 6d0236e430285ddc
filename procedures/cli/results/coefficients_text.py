"""Coefficients for a person: the parameters of a document (a set, a fit or a solved run) as lines of text."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any, Final

from ams.analysis.diagnostics.beliefs import DRIFT_OF, LACK_OF_FIT
from ams.exports.statement import kind_of_warning
from ams.parameter_words import words_of
from ams.rounding import two_digits, with_uncertainty
from ams.sets.instructions import mount_in_words
from ams.sets.stated_verdict import verdict_in_words
from ams.units import dof_words, printed
from procedures.cli.results.findings_text import findings_lines
from rig.local_time import at_both


def set_text(document: Mapping[str, Any], status: str, *, is_withdrawn: bool = False) -> str:
    """Return a coefficient set as text; ``status`` is the document's, or what the signatures have made of it.

    ``is_withdrawn``: whether that is its verdict, whatever its calibration said of itself.
    """
    stamp = f"{status}{', simulated' if document['simulated'] else ''}"
    sensor, provenance = document["sensor"], document["provenance"]
    calibrated = at_both(datetime.fromisoformat(provenance["created_utc"]))
    lines = [
        f"{sensor['name']}: {document['model']} ({document['convention']['name']}), {stamp}",
        f"calibrated {calibrated}, run {provenance['run_id'] or 'none'}, "
        f"checksum {document['checksum']['sha256'][:12]}",
        *(_withdrawn_lines(document) if is_withdrawn else verdict_lines(document)),
        *([] if (mount := mount_in_words(dict(document))) is None else [mount]),
        *axes_lines(document["axes"], document.get("remarks", ())),
        *(f"{kind_of_warning(document, text)}: {text}" for text in document["warnings"]),
    ]
    return "\n".join(lines)


def _withdrawn_lines(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the verdict of a set that must not be used, and what its calibration said of itself before."""
    before = verdict_in_words(dict(document))
    yield "verdict: withdrawn, not to be used" + (f" (the calibration had said {before})" if before else "")


def verdict_lines(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the verdict of a set or of a fit with its ground; nothing where it tells none."""
    verdict = verdict_in_words(dict(document))
    if verdict is not None:
        yield f"verdict of the calibration: {verdict}"


def axes_lines(axes: Mapping[str, Any], known_remarks: Sequence[str] = ()) -> Iterator[str]:
    """Yield the lines of every axis.

    Parameters with standard uncertainties, standard error, replication tests, warnings, remarks; what is remarked of
    every axis once, after the last. ``known_remarks``: of a set, whose axes have their remarks among the warnings.
    """
    of_every = _remarks_of_every(axes)
    for name, axis in axes.items():
        yield ""
        dof = axis["degrees_of_freedom"]
        yield f"axis {name}   ({_standard_error(axis)}{'' if dof is None else f', {dof_words(dof)}'})"
        yield from (f"  {line}" for line in _parameter_lines(axis["parameters"]))
        if axis["replication"] is not None:
            yield f"  {replication_line(axis['replication'], axis.get('findings', ()))}"
        yield from (f"  {line}" for line in findings_lines(axis))
        yield from (f"  {'remark' if text in known_remarks else 'warning'}: {text}" for text in axis["warnings"])
        yield from (f"  remark: {text}" for text in axis.get("remarks", ()) if text not in of_every)
    if of_every:
        yield from ("", f"axes {', '.join(axes)}", *(f"  remark: {text}" for text in of_every))
    yield from _key(axes)


_SMALLEST_PLAIN: Final = 1e-4
_FIVE_PERCENT: Final = 0.05
"""Above it a test says nothing by itself; a T beyond its limit is then what is known of table, meter and level."""


def _remarks_of_every(axes: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the remarks that all of several axes have, in the order of the first."""
    each = [axis.get("remarks", ()) for axis in axes.values()]
    return tuple(text for text in each[0] if all(text in others for others in each)) if len(each) > 1 else ()


def _standard_error(axis: Mapping[str, Any]) -> str:
    """Describe an axis' standard error, in volts or in the unit of the readings of a linear calibration."""
    key = next(key for key in axis if key.startswith("standard_error_"))
    unit = key.removeprefix("standard_error_")
    return f"standard error {axis[key]:.3g} {printed(unit)}" if axis[key] is not None else "no error"


def _parameter_lines(parameters: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """Yield ``offset  +0.0050012 V  u 1.1e-06  TP 9.0e-07`` of each, in columns; one that is not determined says so."""
    words = {name: words_of(name) for name in parameters}
    values = {
        name: _signed(with_uncertainty(estimate["value"], estimate["standard_uncertainty"])[0])
        for name, estimate in parameters.items()
        if estimate["value"] is not None
    }
    label_width = max((len(each.label) for each in words.values()), default=0)
    unit_width = max((len(words[name].unit) for name in values), default=0)
    value_width = max(map(len, values.values()), default=0)
    for name, estimate in parameters.items():
        label = f"{words[name].label:<{label_width}}"
        if name not in values:
            yield f"{label}  not determined"
            continue
        stated = [f"{label}  {values[name]:>{value_width}} {words[name].unit:<{unit_width}}"]
        if estimate["standard_uncertainty"]:
            stated.append(f"u {_two_digits(estimate['standard_uncertainty']):<7}")
        if estimate.get("tp_standard_uncertainty"):
            stated.append(f"TP {_two_digits(estimate['tp_standard_uncertainty'])}")
        yield "  ".join(stated).rstrip()


def _signed(text: str) -> str:
    return text if text.startswith("-") else f"+{text}"


def _two_digits(uncertainty: float) -> str:
    """Return an uncertainty for a narrow column: with an exponent where leading zeros would fill it."""
    return f"{uncertainty:.1e}" if uncertainty < _SMALLEST_PLAIN else two_digits(uncertainty)


def _key(axes: Mapping[str, Any]) -> Iterator[str]:
    """Yield what the short words of the parameters mean, where they stand."""
    estimates = [estimate for axis in axes.values() for estimate in axis["parameters"].values()]
    if any(estimate["standard_uncertainty"] for estimate in estimates):
        pooled = "; TP: the same from the scatter of dwells alone, pooled"
        has_pooled = any(estimate.get("tp_standard_uncertainty") for estimate in estimates)
        yield from ("", f"u: standard uncertainty{pooled if has_pooled else ''}")


def replication_line(replication: Mapping[str, Any], findings: Sequence[Mapping[str, Any]] = ()) -> str:
    """Describe the replication tests in one line, as the findings judge them among all tests of the run."""
    judged = {finding["test"]: finding for finding in findings if "test" in finding}
    fit = _test("lack of fit", replication["lack_of_fit"], judged.get(LACK_OF_FIT))
    drift = ", ".join(
        _test(words_of(name).label, test, judged.get(f"{DRIFT_OF}{name}"))
        for name, test in replication["drift"].items()
    )
    return f"{replication['n']} replications of {replication['points']} points: {fit}; drift: {drift}"


def _test(name: str, test: Mapping[str, Any] | None, judged: Mapping[str, Any] | None) -> str:
    if test is None or test["t"] is None:
        return f"{name} untested"
    if judged is None:  # a set of before the findings
        return f"{name} T {test['t']:.3g}"
    judgement = "significant" if judged["significant"] else "not significant"
    chance = "" if judged["p_value"] is None else f", p {judged['p_value']:.2g}"
    is_plain = test["f_95"] is not None and test["t"] > test["f_95"]
    if is_plain and not judged["significant"] and (judged["p_value"] or 0.0) > _FIVE_PERCENT:
        return f"{name} no larger than what is known explains (T {test['t']:.3g} against precision alone{chance})"
    return f"{name} {judgement} (T {test['t']:.3g}{chance})"
