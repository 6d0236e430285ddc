"""The procedure of a chosen calibration, with the reasons for the choice as comments."""

from collections.abc import Iterator, Mapping, Sequence

from ams.units import ARCSEC_PER_DEG
from procedures.check.candidate import Candidate, Comparison, Target, half_in_words
from procedures.check.candidates import IN_HAND, REFERENCE_EVERY, model_for
from procedures.check.procedure_text import Written, procedure_text
from procedures.check.shares import explained, shares_in_words
from procedures.description.procedure_file import Order, Solve
from procedures.plan.channels import sensors_that_measure
from procedures.solution.foreseen import use_remarks
from rig.description.rig_file import RigDescription

_OF_HOURS = ("noise and drift", "lack of fit")
_FEW = 0.2
"""Of the calibration's variance: where less of it is left to hours, something else is what to mend."""
_ORDERS: Mapping[Order, str] = {
    "there-and-back": "out and back on alternate rows: a drift cannot pass for a sensitivity (TP recommendation 4)",
    "forward-reverse": "every attitude on the way out and back: a linear drift leaves no bias (TP recommendation 4)",
    "neighbours": "rows dealt over blocks by chance, the nearest next: a drift cannot pass for a sensitivity",
    "serpentine": "row by row: quickest, and a drift inside a replication passes for a sensitivity",
    "seeded": "by chance: a drift cannot pass for a parameter",
}


def chosen_procedure(comparison: Comparison, made_by: str = "") -> str:
    """Return the text of the file. ``made_by``: its first comment, where no ``calrig plan`` made it.

    Its title says nothing that whoever changes the file would have to change there too.
    """
    request, chosen = comparison.request, comparison.candidates[comparison.chosen]
    low, high = request.usage.pitch_deg
    noise = request.usage.noise_arcsec
    assert noise is not None
    design = {**chosen.design, "usage_noise_arcsec": float(f"{noise:.3g}")}
    reasons = {
        "": [made_by or _written_by_plan(comparison), *_why(comparison, chosen)],
        "design": [
            f"used at pitch {low:g} to {high:g} degrees, calibrated over half as much again (TP recommendation 1);",
            _ORDERS[chosen.order],
        ],
        "dwell": list(_other_readings(comparison, chosen)),
        "check": ["two attitudes that differ in pitch and roll: a slip of the table is told from a tilt of its base"],
    }
    return procedure_text(
        Written(
            title=f"calibration on {request.rig.rig.name}",
            design=design,
            replications=chosen.replications,
            samples=chosen.samples,
            model=model_for(request.rig),
            nplc=chosen.nplc,
            reference_every=REFERENCE_EVERY,
            reasons=reasons,
        )
    )


def hours_source(comparison: Comparison) -> str:
    """Return by what the hours of the candidates are foreseen."""
    times = comparison.request.learned
    return f"{times.runs} past runs of this rig" if times.is_known else "the files alone"


def _written_by_plan(comparison: Comparison) -> str:
    return (
        f"Written by calrig plan for {comparison.request.rig.rig.name}: {target_in_words(comparison.request.target)}."
    )


def _why(comparison: Comparison, chosen: Candidate) -> Iterator[str]:
    u95, calibration = (value * ARCSEC_PER_DEG for value in (chosen.half_width_deg, chosen.calibration_deg))
    yield (
        f"Expected: {chosen.hours:.2f} h (p50, by {hours_source(comparison)}); "
        f"U95 of an angle {u95:.3g} arc seconds, of the calibration {calibration:.3g}."
    )
    quicker = [index for index in comparison.front if index < comparison.chosen]
    slower = [index for index in comparison.front if index > comparison.chosen]
    for word, nearest in (("quicker", quicker[-1:]), ("slower", slower[:1])):
        for other in (comparison.candidates[number] for number in nearest):
            yield (
                f"The next {word} one: {other.points} points x {other.replications} x {other.samples} readings, "
                f"{other.order}, {other.hours:.2f} h, U95 {other.half_width_deg * ARCSEC_PER_DEG:.3g} arc seconds."
            )
    yield from cannot_see(chosen)
    yield from left_open(comparison.request.rig)


def _other_readings(comparison: Comparison, chosen: Candidate) -> Iterator[str]:
    """Yield what the same calibration would be with fewer and with more readings a dwell."""
    alike = (chosen.design, chosen.replications, chosen.nplc, chosen.sensors)
    for other in sorted(comparison.candidates, key=lambda candidate: candidate.samples):
        if other.samples != chosen.samples and (other.design, other.replications, other.nplc, other.sensors) == alike:
            u95 = other.half_width_deg * ARCSEC_PER_DEG
            yield f"{other.samples} readings would take {other.hours:.2f} h and leave U95 {u95:.3g} arc seconds"


def target_in_words(target: Target) -> str:
    """Return what was asked for."""
    if target.hours is not None:
        return f"the best that {target.hours:g} h allow"
    if target.parameter is not None:
        name, half = target.parameter
        return f"the shortest with a 95 % half-width of {name} of {half_in_words(name, half)} or less, a tenth in hand"
    return f"the shortest with U95 of {target.half_width_deg:g} degrees or less, {round((IN_HAND - 1) * 100)} % in hand"


def what_holds_it(comparison: Comparison, chosen: Candidate) -> Iterator[str]:
    """Yield what takes how much of U95, and what other than hours would make it smaller."""
    yield (
        f"of U95 {chosen.half_width_deg * ARCSEC_PER_DEG:.3g}″, squares add up: {shares_in_words(chosen.shares_deg)}"
    )
    yield from explained(chosen.shares_deg)
    of_hours = sum(chosen.shares_deg.get(source, 0.0) ** 2 for source in _OF_HOURS)
    rig = comparison.request.rig
    referred = () if rig.attitude_reference is None else rig.attitude_reference.channels
    unlisted = [
        name
        for name, axis in rig.axes.items()
        if axis.uncertainty_arcsec > 0.0 and axis.index_table is None and name not in referred
    ]
    if of_hours < _FEW * chosen.calibration_deg**2 and unlisted:
        yield (
            f"more hours make only {' and '.join(_OF_HOURS)} smaller; what would help is a certificate that lists the "
            f"errors of {' and '.join(unlisted)} at angles (index_table)"
            f"{_zero_of_pitch(rig, unlisted)}"
        )


def _zero_of_pitch(rig: RigDescription, unlisted: Sequence[str]) -> str:
    """Return what beside a list would help: levelled once at a known angle, a table's curve is known there."""
    if "pitch" not in unlisted or rig.axes["pitch"].index_zero_deg is not None:
        return ""
    return "; less, and at once, a zero of pitch that is set by a level and declared (index_zero_deg)"


def left_open(rig: RigDescription) -> Iterator[str]:
    """Yield what nobody asked the choice for, and a laboratory with such a rig may want."""
    for name in rig.environment:
        yield (
            f"Nothing here sets the temperature of {name}, which is recorded only: a table [environment] with "
            "plateaus_degc, band_degc and soak_s does, and takes the hours of its soaks."
        )
    sensors = sensors_that_measure(rig, "acceleration")
    yield from (f"Temperature of use: {remark}." for remark in use_remarks(rig, Solve(), sensors))


def cannot_see(chosen: Candidate) -> Iterator[str]:
    """Yield what the choice cannot see of the sensor."""
    yield (
        f"It cannot see: lack of fit below {chosen.sees_lack_of_fit_arcsec:.2g} arc seconds a point, a drift of the "
        f"offset below {chosen.sees_drift_arcsec:.2g} arc seconds between replications (found in half of the runs)."
    )
    if chosen.blind_to:
        yield f"Its points do not determine {' and '.join(chosen.blind_to)} terms of the sensor: they bend the offset."
